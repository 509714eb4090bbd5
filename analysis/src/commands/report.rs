//! `mos report`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::Error;
use cyclopean_analysis::data::Columns;
use cyclopean_analysis::files::{self, write_bytes};
use cyclopean_analysis::interval::{Bootstrap, Method};
use cyclopean_analysis::report::{
    Figure, ReportInput, ReportOptions, csv, html, json, latex, markdown, metrics_from_compare,
};

use super::input::{self, Input, print, print_json};

/// The report's format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// One self-contained HTML page
    Html,
    /// Markdown
    Md,
    /// LaTeX
    Latex,
    /// The table of mean opinion scores
    Csv,
    /// Every number, as one JSON object
    Json,
}

/// `mos report PATH…`
#[derive(Args)]
pub struct Report {
    #[command(flatten)]
    input: Input,
    /// The format of the report
    #[arg(long, value_enum, default_value = "html")]
    format: Format,
    /// The file to write [default: report.html; other formats go to standard output]
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Title of the page
    #[arg(long, default_value = "Study report")]
    title: String,
    /// The kind of interval [default: the study file's, else t]
    #[arg(long, value_enum)]
    ci: Option<Method>,
    /// The confidence level of the interval [default: the study file's, else 0.9]
    #[arg(long, value_parser = input::level)]
    level: Option<f64>,
    /// Equivalence margin of stereo - path-traced, in scale steps [default: the study file's]
    #[arg(long, value_name = "MARGIN")]
    equivalence: Option<f64>,
    /// Seed of the bootstraps
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A compare.json of `cyclopean compare`: the mean opinion scores are plotted against the measured inconsistency
    #[arg(long, value_name = "FILE")]
    metrics: Option<PathBuf>,
    /// PNG files to embed; each file's name becomes its caption
    #[arg(long, value_name = "PNG", value_delimiter = ',')]
    figure: Vec<PathBuf>,
}

impl Report {
    /// Gathers and writes.
    pub fn run(self) -> Result<()> {
        let options = ReportOptions {
            title: self.title,
            method: self.ci,
            level: self.level,
            boot: Bootstrap { seed: self.seed, ..Bootstrap::default() },
            margin: self.equivalence,
        };
        let selection = self.input.selection(Columns::default());
        let mut report = ReportInput::gather(&self.input.paths, &selection, &options)?;
        if let Some(path) = &self.metrics {
            report.metrics = metrics_from_compare(path)?;
        }
        for path in &self.figure {
            let png =
                files::read(path, files::MOST_DATA).map_err(|source| Error::Read { path: path.clone(), source })?;
            if !png.starts_with(b"\x89PNG\r\n\x1a\n") {
                return Err(Error::data(format!("{}: not a PNG file", path.display())).into());
            }
            let caption = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            report.figures.push(Figure { caption, png });
        }
        let text = match self.format {
            Format::Html => html(&report),
            Format::Md => markdown(&report),
            Format::Latex => latex(&report),
            Format::Csv => csv(&report),
            Format::Json => format!("{}\n", json(&report)),
        };
        let out = self.out.or((self.format == Format::Html).then(|| "report.html".into()));
        match &out {
            Some(path) => write_bytes(path, text.as_bytes()).map_err(Error::from)?,
            None if self.input.json && self.format != Format::Json => {}
            None => return print(&text),
        }
        let written = out.as_ref().map(|p| p.display().to_string());
        if self.input.json {
            let mut object = json(&report);
            object["written"] = written.into();
            print_json(&object)
        } else {
            print(&format!("{}\n", written.unwrap_or_default()))
        }
    }
}
