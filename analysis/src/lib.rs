//! Journals of Cyclopean's studies and what follows from them.
//!
//! No graphics dependency: this crate builds on any laptop in seconds.

#![warn(missing_docs)]

pub mod chance;
pub mod error;
pub mod files;
pub mod journal;
pub mod special;
pub mod wilcoxon;

pub use error::{Error, Result};
