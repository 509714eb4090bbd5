//! The one way to read a file, and the one way to write one.
//!
//! Read: regular files only, and no more of one than its reader has use for. A device can be endless and a named pipe
//! can make its reader wait for ever; neither is opened, whatever its name or the link that leads to it. Written: whole
//! under its final name, or not at all.

mod read;
mod write;

pub use read::{lines, open, open_with, read, read_at_most, read_text};
pub use write::{WriteError, sync_directory, write_bytes, write_folder, write_whole};

/// The most bytes of a file that people write (study, manifest, language) or that describes another (side-car, rows).
pub const MOST_TEXT: u64 = 16 << 20;

/// The most bytes of a file of results or numbers, of a picture or a font.
pub const MOST_DATA: u64 = 1 << 30;
