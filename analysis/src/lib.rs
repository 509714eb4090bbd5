//! Journals of Cyclopean's studies and what follows from them.
//!
//! No graphics dependency: this crate builds on any laptop in seconds.

#![warn(missing_docs)]

pub mod adjust;
pub mod chance;
pub mod contrast;
pub mod data;
pub mod equivalence;
pub mod error;
pub mod files;
pub mod friedman;
pub mod inspect;
pub mod interval;
pub mod journal;
pub mod mos;
pub mod numbers;
pub mod power;
pub mod preference;
pub mod report;
pub mod screen;
pub mod special;
pub mod wilcoxon;

pub use error::{Error, Result};
