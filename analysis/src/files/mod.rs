//! The one way to read a file, and the one way to write one.
//!
//! Reading: only regular files are opened, and no more of one is read than its reader can use. A device can be endless,
//! and a named pipe can make its reader wait for ever. Neither is opened, whatever its name is and whatever link leads
//! to it. Writing: a file appears whole under its final name, or not at all.

mod read;
mod write;

pub use read::{lines, open, open_with, read, read_at_most, read_text};
pub use write::{WriteError, sync_directory, write_bytes, write_folder, write_whole};

/// The most bytes that are read of a file that people write (study, manifest, language) or that describes another file
/// (side-car, rows).
pub const MOST_TEXT: u64 = 16 << 20;

/// The most bytes that are read of a file of results or numbers, of a picture or of a font.
pub const MOST_DATA: u64 = 1 << 30;
