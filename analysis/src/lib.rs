//! Reads the journals of Cyclopean's studies and analyses them. The program `mos` and the application `cyclopean` call
//! it.
//!
//! No graphics dependency: this crate builds on any laptop in seconds.
//!
//! | module | holds |
//! |---|---|
//! | [`journal`] | the record types, the line codec, the reader: the format of a session |
//! | [`data`] | journals and tidy CSV, reduced to one tally for each participant and cell |
//! | [`mos`], [`interval`] | mean opinion scores and their intervals |
//! | [`wilcoxon`], [`contrast`], [`adjust`] | signed-rank tests, paired contrasts, corrections within a family |
//! | [`equivalence`], [`friedman`], [`preference`] | equivalence by two one-sided tests, several conditions, forced choices |
//! | [`screen`], [`power`] | screening of observers; planning of studies, coverage of intervals |
//! | [`report`], [`export`], [`inspect`] | pages and tables, formats of other programs, checks of a journal |
//! | [`files`], [`parts`] | the one way to read a file, and the one way to write one; removal of what killed writers leave |
//! | [`escape`], [`terminal`] | names made harmless for terminals, tables and pages; printing |
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

/// Compiles and runs the worked example of a statistic in docs/contributing.md.
#[cfg(doctest)]
#[doc = include_str!("../../docs/contributing.md")]
struct Contributing;
