//! Reads a journal as a stream: one line is in memory at a time, and each is checked before it is used.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};

use super::codec::{self, Entry, LineError};
use super::record::{Kind, Record};
use crate::files;

/// The most bytes of a line. No record is longer; a longer "line" is another kind of file.
const LONGEST_LINE: u64 = 64 << 20;
const BUFFER: usize = 1 << 18;

/// A journal cannot be read any further. The message names the file, the line (from 1) and what to do.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The file cannot be opened or read.
    #[error("cannot read journal {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        #[source]
        source: io::Error,
    },
    /// There is no line, or the first line is no header.
    #[error("{}: not a journal: line 1 must be a `header` record; give a session's .jsonl file or a folder of them", path.display())]
    NoHeader {
        /// The file.
        path: PathBuf,
    },
    /// The file's format is newer than this program.
    #[error("{}: journal format {found}, but this program reads 1 to {}: use the newer version that wrote it", path.display(), super::FORMAT)]
    Version {
        /// The file.
        path: PathBuf,
        /// The format number in the header.
        found: u32,
    },
    /// The last line has no line feed: the program or the power ended while it was written.
    #[error("{}: line {line} is torn ({bytes} bytes without an end); `cyclopean run --resume` or `cyclopean study recover` sets it aside, all lines before it are whole", path.display())]
    Torn {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: u64,
        /// Length of the torn line.
        bytes: u64,
    },
    /// The line is longer than any record.
    #[error("{}: line {line} is longer than the {most} bytes that a record may have; this is no journal, or its end is not one. Restore the file from a copy", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: u64,
        /// The most bytes of a line that are read.
        most: u64,
    },
    /// A whole line whose check sum or content is wrong.
    #[error("{}: line {line} {source}; reading stops here. Restore the file from a copy, or let `cyclopean study recover` set this line and all after it aside", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: u64,
        /// What is wrong with the line.
        #[source]
        source: LineError,
    },
    /// A line is missing, doubled or out of order.
    #[error("{}: line {line} has sequence number {found}, expected {expected}: lines are missing, doubled or moved. Restore the file from a copy", path.display())]
    Sequence {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: u64,
        /// The sequence number in the line.
        found: u64,
        /// The sequence number of the line before, plus one.
        expected: u64,
    },
    /// The kind of participant changes within the file.
    #[error("{}: line {line} is marked {}, the lines before {}: two journals were mixed. Restore the file from a copy", path.display(), found.name(), expected.name())]
    Kind {
        /// The file.
        path: PathBuf,
        /// From 1.
        line: u64,
        /// In the line.
        found: Kind,
        /// The kind in the lines before.
        expected: Kind,
    },
}

/// Opens a journal for reading.
///
/// # Errors
/// [`JournalError::Read`] when it cannot be opened; all others come from the iterator.
pub fn read(path: &Path) -> Result<Reader<BufReader<File>>, JournalError> {
    let file = files::open(path).map_err(|source| JournalError::Read { path: path.to_owned(), source })?;
    Ok(read_from(path, BufReader::with_capacity(BUFFER, file)))
}

/// Reads a journal from any source; `path` is for messages.
pub fn read_from<R: BufRead>(path: &Path, source: R) -> Reader<R> {
    Reader { path: path.to_owned(), source, buffer: Vec::new(), line: 0, good_bytes: 0, kind: None, over: false }
}

/// The entries of a journal in order. It ends after the first error.
#[derive(Debug)]
pub struct Reader<R> {
    path: PathBuf,
    source: R,
    buffer: Vec<u8>,
    line: u64,
    good_bytes: u64,
    kind: Option<Kind>,
    over: bool,
}

impl<R: BufRead> Reader<R> {
    /// Number of the line last read, from 1; 0 before the first.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// Bytes of all whole lines so far that passed their checks.
    pub fn good_bytes(&self) -> u64 {
        self.good_bytes
    }

    fn next_entry(&mut self) -> Result<Option<Entry>, JournalError> {
        self.buffer.clear();
        let read = io::Read::take(&mut self.source, LONGEST_LINE).read_until(b'\n', &mut self.buffer);
        let bytes = read.map_err(|source| JournalError::Read { path: self.path.clone(), source })?;
        if bytes == 0 {
            return if self.line == 0 { Err(JournalError::NoHeader { path: self.path.clone() }) } else { Ok(None) };
        }
        self.line += 1;
        let (path, line) = (|| self.path.clone(), self.line);
        if self.buffer.pop() != Some(b'\n') {
            if bytes as u64 == LONGEST_LINE {
                return Err(JournalError::TooLong { path: path(), line, most: LONGEST_LINE });
            }
            return Err(JournalError::Torn { path: path(), line, bytes: bytes as u64 });
        }
        let entry = codec::decode(&self.buffer).map_err(|source| JournalError::Line { path: path(), line, source })?;
        if entry.seq != line - 1 {
            return Err(JournalError::Sequence { path: path(), line, found: entry.seq, expected: line - 1 });
        }
        let expected = *self.kind.get_or_insert(entry.kind);
        if entry.kind != expected {
            return Err(JournalError::Kind { path: path(), line, found: entry.kind, expected });
        }
        if line == 1 {
            match &entry.record {
                Record::Header(header) if (1..=super::FORMAT).contains(&header.format) => {}
                Record::Header(header) => return Err(JournalError::Version { path: path(), found: header.format }),
                _ => return Err(JournalError::NoHeader { path: path() }),
            }
        }
        self.good_bytes += bytes as u64;
        Ok(Some(entry))
    }
}

impl<R: BufRead> Iterator for Reader<R> {
    type Item = Result<Entry, JournalError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.over {
            return None;
        }
        let next = self.next_entry();
        self.over = !matches!(next, Ok(Some(_)));
        next.transpose()
    }
}
