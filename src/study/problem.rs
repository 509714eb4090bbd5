//! What is wrong with a study file.

use std::fmt;

/// One problem of a study file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// The JSON path, such as `conditions.cross.method[1]`; empty: the whole file.
    pub path: String,
    /// The value there, and what is allowed.
    pub what: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = if self.path.is_empty() { "the file" } else { &self.path };
        write!(f, "{place}: {}", self.what)
    }
}
