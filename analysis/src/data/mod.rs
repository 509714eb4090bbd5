//! Reads journals or tidy CSV from files, folders or patterns, as a stream, into tallies.

mod dataset;
mod journals;
mod paths;
mod response;
mod score;
pub mod tidy;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

pub use dataset::{Builder, Cell, Dataset, Participant, Study, Tally, kind_name, level_key};
pub use journals::{Session, SessionSummary, sessions};
pub(crate) use journals::{outcome_name, sessions_in_parallel};
pub use paths::{Source, expand};
pub use response::Response;
pub use score::{Score, UNIT};
pub use tidy::Columns;

use crate::error::{Error, Result};
use crate::journal::Kind;

/// What to read and what to leave out.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Which columns are factors, and what a cell is.
    pub columns: Columns,
    /// Only sessions of this kind.
    pub kind: Option<Kind>,
    /// Kinds that may be analysed together with real sessions; empty: none.
    pub allow_kinds: BTreeSet<Kind>,
    /// Only this study.
    pub study: Option<String>,
    /// Participants left out on request.
    pub exclude: BTreeSet<String>,
}

/// The data, and what their sources say besides the answers.
#[derive(Clone, Debug, Default)]
pub struct LoadedData {
    /// The tallies.
    pub data: Dataset,
    /// One summary for each journal; empty for CSV.
    pub sessions: Vec<SessionSummary>,
    /// The files read.
    pub sources: Vec<PathBuf>,
    /// Participants whom a rule in the study file excludes, with the reason. They are still in the data.
    pub excluded: Vec<(String, String)>,
}

impl LoadedData {
    /// Ids of [`LoadedData::excluded`].
    pub fn excluded_ids(&self) -> BTreeSet<String> {
        self.excluded.iter().map(|e| e.0.clone()).collect()
    }
}

/// Reads journals and tidy CSV files from files, folders and patterns.
///
/// # Errors
/// [`Error::Read`], [`Error::Line`], [`Error::Data`] for a damaged journal or when nothing is found, and
/// [`Error::MixedKinds`] when kinds of sessions are mixed that [`Selection::allow_kinds`] does not allow.
pub fn load(paths: &[PathBuf], selection: &Selection) -> Result<LoadedData> {
    let mut builder = Builder::new(selection);
    let mut loaded = LoadedData::default();
    for source in expand(paths)? {
        match source {
            Source::Csv(path) => {
                if path == Path::new("-") {
                    tidy::read_from(&path, std::io::stdin().lock(), &selection.columns, &mut builder)?;
                } else {
                    tidy::read(&path, &selection.columns, &mut builder)?;
                }
                loaded.sources.push(path);
            }
            Source::Journals(files) => {
                journals::load(&files, selection, &mut builder, &mut loaded)?;
                loaded.sources.extend(files);
            }
        }
    }
    let data = builder.finish();
    check_kinds(&data, selection)?;
    if data.responses() == 0 {
        return Err(Error::data(format!(
            "no answers in {}; nothing to analyse",
            paths.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ")
        )));
    }
    loaded.data = data;
    Ok(loaded)
}

fn check_kinds(data: &Dataset, selection: &Selection) -> Result<()> {
    let strange = |k: &Option<Kind>| match k {
        Some(Kind::Real) | None => false,
        Some(k) => !selection.allow_kinds.contains(k),
    };
    if data.kinds.len() > 1 && data.kinds.keys().any(strange) {
        let found = data.kinds.iter().map(|(k, n)| format!("{} {n}", kind_name(*k))).collect::<Vec<_>>().join(", ");
        return Err(Error::MixedKinds { found });
    }
    Ok(())
}
