//! The errors of an analysis. Each is one sentence: what is wrong, where, and what would be right.

use std::io;
use std::path::PathBuf;

/// Every failure of this crate outside the journal's own reader.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The request cannot be carried out as worded; the `mos` command exits with 2.
    #[error("{0}")]
    Usage(String),
    /// A file or folder cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        #[source]
        source: io::Error,
    },
    /// A line of an input file is wrong.
    #[error("{}, line {line}: {what}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Counted from 1, the header line included.
        line: u64,
        /// What is wrong and what would be right.
        what: String,
    },
    /// The data do not allow the analysis asked for.
    #[error("{0}")]
    Data(String),
    /// Several kinds of session in one analysis.
    #[error(
        "sessions of different kinds ({found}) are never analysed together; \
         choose with --allow-kind, for example --allow-kind real"
    )]
    MixedKinds {
        /// The kinds found, with their numbers of responses.
        found: String,
    },
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] crate::files::WriteError),
}

/// The result of this crate's functions.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// A wrong request (exit status 2).
    pub fn usage(what: impl Into<String>) -> Self {
        Self::Usage(what.into())
    }

    /// Data that do not allow the analysis.
    pub fn data(what: impl Into<String>) -> Self {
        Self::Data(what.into())
    }
}
