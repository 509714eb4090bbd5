//! The journal: one append-only JSON Lines file a session, and the only thing that analysis knows of a study.
//!
//! A line is one JSON object, `{"seq":…,"t_ns":…,"wall":"…","kind":"…","record":{…},"crc":"…"}`, and its
//! check sum covers every byte before `,"crc":"` ([`codec`]). `docs/journal.md` is the table of fields.
//!
//! [`read`] streams the lines and checks their form; [`verify::Verifier`] checks what they say together;
//! [`votes::collect`] turns a session into ratings by the study's fixed mapping.

pub mod codec;
pub mod plan;
pub mod reader;
pub mod record;
pub mod verify;
pub mod votes;

#[cfg(test)]
pub(crate) mod tests;

pub use codec::{Entry, LineError, encode};
pub use plan::AnalysisPlan;
pub use reader::{JournalError, Reader, read, read_from};
pub use record::{Kind, Record};
pub use verify::{Verifier, VerifyError};
pub use votes::{SessionVotes, Vote, collect};

/// The format version that this program writes. It reads this one and all before it.
pub const FORMAT: u32 = 1;
