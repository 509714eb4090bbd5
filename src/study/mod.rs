//! Studies: what is shown to whom in which order, the session as a pure state machine, and its journal.
//!
//! Definition → plan → session → journal. Nothing here draws: the renderer and the displays are behind traits.

pub mod content;
pub mod definition;
pub mod disk;
pub mod freeze;
pub mod language;
pub mod observer;
pub mod order;
pub mod plan;
pub mod poses;
pub mod power;
pub mod prepare;
pub mod preview;
pub mod problem;
pub mod protocol;
pub mod questionnaire;
pub mod random;
pub mod recover;
pub mod schema;
pub mod session;
pub mod sessions;
pub mod show;
pub mod stereogram;
pub mod stimulus;
pub mod store;
pub mod validate;
pub mod writer;

#[cfg(test)]
pub mod testing;

pub use definition::Definition;
pub use plan::Plan;

/// Lower-case hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// SHA-256 of bytes, hex.
pub fn sha256_hex(bytes: &[u8]) -> String {
    use sha2::Digest;
    hex(&sha2::Sha256::digest(bytes))
}
