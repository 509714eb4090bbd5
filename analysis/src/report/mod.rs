//! Results for readers.

pub mod text;
