//! Options of every command that reads answers.

use std::collections::BTreeSet;
use std::path::PathBuf;

use anyhow::{Context as _, Result};
use clap::Args;
use cyclopean_analysis::data::{Columns, LoadedData, Selection, load};
use cyclopean_analysis::journal::Kind;
use cyclopean_analysis::{Error, interval, terminal};
use serde_json::Value;

/// The files that hold the answers, and which answers count.
#[derive(Args, Clone)]
pub struct Input {
    /// Journals (.jsonl), folders of journals, patterns with * and ?, tidy CSV files, or - for CSV on standard input
    #[arg(required = true, value_name = "PATH")]
    pub paths: Vec<PathBuf>,
    /// Analyse only this study
    #[arg(long, value_name = "ID")]
    pub study: Option<String>,
    /// Analyse only sessions of this kind
    #[arg(long, value_enum)]
    pub kind: Option<KindName>,
    /// Analyse sessions of these kinds together with real ones; without a value, of every kind. Tables are stamped then
    #[arg(long, value_enum, value_name = "KIND", num_args = 0..=1, require_equals = true,
          value_delimiter = ',', default_missing_value = "all")]
    pub allow_kind: Vec<KindName>,
    /// Leave these participants out
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    pub exclude: Vec<String>,
    /// Leave out the participants whom the study file's rule excludes (failed catch trials)
    #[arg(long)]
    pub exclude_failed: bool,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// A kind of session, or all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum KindName {
    /// Participants of the study
    Real,
    /// People who try the study out
    Pilot,
    /// Simulated observers
    Simulated,
    /// Every kind
    All,
}

impl KindName {
    fn kinds(self) -> Vec<Kind> {
        match self {
            Self::Real => vec![Kind::Real],
            Self::Pilot => vec![Kind::Pilot],
            Self::Simulated => vec![Kind::Simulated],
            Self::All => vec![Kind::Real, Kind::Pilot, Kind::Simulated],
        }
    }
}

impl Input {
    /// What the options say about reading; `columns` says which factors the command needs.
    pub fn selection(&self, columns: Columns) -> Selection {
        Selection {
            columns,
            kind: self.kind.and_then(|k| if k == KindName::All { None } else { k.kinds().first().copied() }),
            allow_kinds: self.allow_kind.iter().flat_map(|k| k.kinds()).collect(),
            study: self.study.clone(),
            exclude: self.exclude.iter().cloned().collect::<BTreeSet<_>>(),
        }
    }

    /// Reads the answers; `columns` says which factors the command needs.
    pub fn load(&self, columns: Columns) -> Result<LoadedData> {
        let mut selection = self.selection(columns);
        if self.exclude_failed && self.paths.iter().any(|p| p.as_os_str() == "-") {
            return Err(Error::usage("--exclude-failed reads twice and cannot read standard input").into());
        }
        let loaded = load(&self.paths, &selection)?;
        if !self.exclude_failed || loaded.excluded.is_empty() {
            return Ok(loaded);
        }
        selection.exclude.extend(loaded.excluded_ids());
        let mut kept = load(&self.paths, &selection)?;
        for (who, why) in &loaded.excluded {
            kept.data.notes.push(format!("participant {who} is left out: {why}"));
        }
        kept.excluded = loaded.excluded;
        Ok(kept)
    }
}

/// Parses the ends of a scale, `LOW,HIGH`.
pub fn scale(text: &str) -> Result<interval::Scale, String> {
    let (low, high) = text.split_once([',', ':']).ok_or("two numbers with a comma, such as 1,5")?;
    let number = |t: &str| t.trim().parse::<f64>().map_err(|_| format!("`{t}` is not a number"));
    let scale = interval::Scale { low: number(low)?, high: number(high)? };
    if scale.high > scale.low
        && scale.low.fract() == 0.0
        && scale.high.fract() == 0.0
        && scale.high - scale.low <= 1000.0
    {
        Ok(scale)
    } else {
        Err("whole numbers, the lower first, such as 1,5".into())
    }
}

/// Parses a level between 0 and 1, or a percentage.
pub fn level(text: &str) -> Result<f64, String> {
    let value: f64 = text.trim_end_matches('%').trim().parse().map_err(|_| format!("`{text}` is not a number"))?;
    let value = if value > 1.0 || text.ends_with('%') { value / 100.0 } else { value };
    if value > 0.0 && value < 1.0 { Ok(value) } else { Err("between 0 and 1, such as 0.9 or 90%".into()) }
}

/// Prints to standard output; a reader who has gone (a closed pipe) is no failure.
pub fn print(text: &str) -> Result<()> {
    terminal::print(text).context("cannot write to standard output")
}

/// Prints one object.
pub fn print_json(value: &Value) -> Result<()> {
    terminal::print_json(&format!("{value}\n")).context("cannot write to standard output")
}
