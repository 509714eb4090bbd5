//! Journals of Cyclopean's studies and what follows from them.
//!
//! No graphics dependency: this crate builds on any laptop in seconds.
//!
//! | module | holds |
//! |---|---|
//! | [`journal`] | the record types, the line codec, the reader: the format of a session |
//! | [`data`] | journals and tidy CSV, reduced to one tally a participant and cell |
//! | [`mos`], [`interval`] | mean opinion scores and their intervals |
//! | [`wilcoxon`], [`contrast`], [`adjust`] | the signed-rank family, paired contrasts, families |
//! | [`equivalence`], [`friedman`], [`preference`] | two one-sided tests, several conditions, forced choices |
//! | [`screen`], [`power`] | observers, planning and coverage |
//! | [`report`], [`export`], [`inspect`] | pages and tables, other people's formats, a journal's health |
//! | [`files`], [`parts`] | the one way to read a file, and the one way to write one; what killed writers leave |
//! | [`escape`], [`terminal`] | what may not reach a terminal, a table or a page as it stands; printing |
//! | [`manual`] | shell completions and manual pages of a program |
//!
//! ```
//! use cyclopean_analysis::data::{Builder, Columns, Selection, tidy};
//! use cyclopean_analysis::mos::{TableOptions, table};
//!
//! let csv = "participant,scene,method,rating\np1,pica,stereo,4\np2,pica,stereo,5\np3,pica,stereo,4\n";
//! let mut builder = Builder::new(&Selection::default());
//! tidy::read_from("votes.csv".as_ref(), csv.as_bytes(), &Columns::default(), &mut builder)?;
//! let table = table(&builder.finish(), &TableOptions::default())?;
//! assert_eq!((table.rows[0].n, table.rows[0].level("method")), (3, Some("stereo")));
//! # Ok::<(), cyclopean_analysis::Error>(())
//! ```

#![warn(missing_docs)]

pub mod adjust;
pub mod chance;
pub mod contrast;
pub mod data;
pub mod equivalence;
pub mod error;
pub mod escape;
pub mod export;
pub mod files;
pub mod friedman;
pub mod inspect;
pub mod interval;
pub mod journal;
pub mod manual;
pub mod mos;
pub mod numbers;
pub mod parts;
pub mod power;
pub mod preference;
pub mod report;
pub mod screen;
pub mod special;
pub mod svg;
pub mod terminal;
pub mod wilcoxon;

pub use error::{Error, Result};

/// The worked example of a statistic is compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../docs/contributing.md")]
struct Contributing;
