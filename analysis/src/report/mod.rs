//! Results for readers: a self-contained HTML page, Markdown, LaTeX, CSV, JSON and plain text.

mod document;
mod html;
mod input;
mod plain;
pub mod session;
mod svg;
pub mod text;

pub use document::{Block, document, scores};
pub use html::{html, page};
pub use input::{
    Figure, Metric, ReportInput, ReportOptions, Results, Screening, StudyReport, metrics_from_compare,
    planned_interval, spearman,
};
pub use plain::{csv, json, latex, markdown};
