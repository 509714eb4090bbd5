//! `mos wilcoxon`.

use std::io;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::Error;
use cyclopean_analysis::files;
use cyclopean_analysis::numbers::differences;
use cyclopean_analysis::report::text;
use cyclopean_analysis::wilcoxon::{Alternative, Exact, Options, Zeros, signed_rank};

use super::input::{self, print, print_json};

/// The most bytes of a list of numbers, which the test sorts in memory.
const MOST_NUMBERS: u64 = 64 << 20;

/// `mos wilcoxon [FILE|-]`
#[derive(Args)]
pub struct Wilcoxon {
    /// File of numbers: one column of differences, or two columns x and y; a header line is allowed; - reads standard
    /// input
    #[arg(default_value = "-")]
    file: PathBuf,
    /// What happens to zero differences
    #[arg(long, value_enum, default_value = "wilcox")]
    zeros: Zeros,
    /// Apply the continuity correction to the asymptotic z
    #[arg(long)]
    correction: bool,
    /// Alternative hypothesis
    #[arg(long, value_enum, default_value = "two-sided")]
    alternative: Alternative,
    /// When to compute the exact null distribution
    #[arg(long, value_enum, default_value = "auto")]
    exact: Exact,
    /// Confidence level of the intervals of effect sizes
    #[arg(long, default_value = "0.95", value_parser = input::level)]
    level: f64,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl Wilcoxon {
    /// Reads, tests, prints.
    pub fn run(self) -> Result<()> {
        let mut content = Vec::new();
        let error = |source| Error::Read { path: self.file.clone(), source };
        if self.file == Path::new("-") {
            files::read_at_most(io::stdin().lock(), MOST_NUMBERS, &mut content).map_err(error)?;
        } else {
            content = files::read(&self.file, MOST_NUMBERS).map_err(error)?;
        }
        let d = differences(&content, &self.file)?;
        let options = Options {
            zeros: self.zeros,
            correction: self.correction,
            alternative: self.alternative,
            exact: self.exact,
            level: self.level,
        };
        let result = signed_rank(&d, &options)?;
        if self.json { print_json(&serde_json::to_value(&result)?) } else { print(&text::signed_rank(&result)) }
    }
}
