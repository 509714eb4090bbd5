//! Journals of Cyclopean's studies and what follows from them.
//!
//! No graphics dependency: this crate builds on any laptop in seconds.

#![warn(missing_docs)]

pub mod files;
pub mod journal;
