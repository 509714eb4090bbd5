//! Sets the damaged end of a journal aside, so that the lines before it can be used again. `study recover` calls it.

use std::fs::OpenOptions;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use cyclopean_analysis::files::{self, MOST_DATA};
use cyclopean_analysis::journal::{self, JournalError, codec};

use super::disk::Disk;
use super::writer::{WriterError, lock, set_aside};

/// What was found and done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovery {
    pub journal: PathBuf,
    /// Lines that stay.
    pub whole_lines: u64,
    /// Bytes that were set aside in a file beside the journal; 0: nothing was damaged.
    pub cut_bytes: u64,
    /// Lines among these bytes whose check sums are right; they came after the damage.
    pub whole_lines_cut: u64,
    /// What was wrong.
    pub why: Option<String>,
}

impl Recovery {
    /// The result for people, line by line.
    pub fn lines(&self) -> Vec<String> {
        let name = self.journal.display();
        match &self.why {
            None => vec![format!("{name}: all {} lines are whole; nothing was changed", self.whole_lines)],
            Some(why) => vec![
                why.clone(),
                format!(
                    "{name}: {} lines stay; {} bytes were set aside beside it, among them {} whole lines",
                    self.whole_lines, self.cut_bytes, self.whole_lines_cut
                ),
            ],
        }
    }
}

/// Cuts a journal before its first line that fails a check; the rest is kept in a file beside it.
///
/// # Errors
/// It is no journal, it is in use, or the folder cannot be written; nothing is cut then.
pub fn recover(disk: &Disk, path: &Path) -> Result<Recovery, WriterError> {
    let io = |source| WriterError::Io { what: "repair", path: path.to_owned(), source };
    let file = files::open_with(OpenOptions::new().read(true).append(true), path).map_err(io)?;
    lock(&file, path)?;
    let source = BufReader::new(files::open(path).map_err(io)?);
    let mut reader = journal::read_from(path, source);
    let mut whole_lines = 0;
    let mut why = None;
    for entry in reader.by_ref() {
        match entry {
            Ok(_) => whole_lines += 1,
            // A newer program wrote it, or the disk cannot be read: cutting would destroy good lines.
            Err(error @ (JournalError::Read { .. } | JournalError::Version { .. })) => return Err(error.into()),
            Err(error) => why = Some(error.to_string()),
        }
    }
    let mut found = Recovery { journal: path.to_owned(), whole_lines, cut_bytes: 0, whole_lines_cut: 0, why };
    if found.why.is_some() {
        let keep = reader.good_bytes();
        let bytes = files::read(path, MOST_DATA).map_err(io)?;
        let rest = &bytes[usize::try_from(keep).unwrap_or(usize::MAX).min(bytes.len())..];
        found.whole_lines_cut = rest.split(|b| *b == b'\n').filter(|line| codec::check(line).is_ok()).count() as u64;
        if whole_lines == 0 && found.whole_lines_cut == 0 && !rest.starts_with(b"{\"seq\":0,") && !rest.is_empty() {
            return Err(JournalError::NoHeader { path: path.to_owned() }.into());
        }
        found.cut_bytes = set_aside(disk, &file, path, keep)?;
    }
    Ok(found)
}
