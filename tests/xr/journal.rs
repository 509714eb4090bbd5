//! Reads a journal while a session writes it.

use std::path::{Path, PathBuf};
use std::time::Duration;

use cyclopean_analysis::journal::Entry;
use cyclopean_analysis::journal::record::Record;

use super::wait_for;

/// A reader of a growing journal.
pub struct Tail {
    path: PathBuf,
    seen: usize,
}

impl Tail {
    pub fn of(path: &Path) -> Tail {
        Tail { path: path.to_owned(), seen: 0 }
    }

    /// The entries of all complete lines so far.
    pub fn all(&self) -> Vec<Entry> {
        let text = std::fs::read_to_string(&self.path).unwrap_or_default();
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let copy = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(copy.path(), if whole.is_empty() { String::new() } else { format!("{whole}\n") }).unwrap();
        if whole.is_empty() {
            return Vec::new();
        }
        cyclopean_analysis::journal::read(copy.path()).unwrap().map(|e| e.unwrap()).collect()
    }

    /// Waits for the next record that `wanted` accepts, after the last one that was returned.
    pub fn next<T>(&mut self, what: &str, within: Duration, mut wanted: impl FnMut(&Record) -> Option<T>) -> T {
        wait_for(what, within, || {
            let all = self.all();
            let found = all.iter().enumerate().skip(self.seen).find_map(|(at, e)| Some((at, wanted(&e.record)?)));
            found.map(|(at, value)| {
                self.seen = at + 1;
                value
            })
        })
    }

    /// All records that were not returned yet.
    pub fn rest(&mut self) -> Vec<Record> {
        let all = self.all();
        let rest = all.into_iter().skip(self.seen).map(|e| e.record).collect::<Vec<_>>();
        self.seen += rest.len();
        rest
    }
}
