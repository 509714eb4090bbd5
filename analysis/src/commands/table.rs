//! `mos table`.

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::data::Columns;
use cyclopean_analysis::interval::{Bootstrap, Method, Scale};
use cyclopean_analysis::mos::{TableOptions, table};
use cyclopean_analysis::preference::preference;
use cyclopean_analysis::report::text;
use serde_json::json;

use super::input::{self, Input, print, print_json};

/// The ratings that mean other, no difference and method, for studies that do not say it.
const PAPER_VALUES: [i32; 3] = [1, 2, 3];
/// Bootstrap resamples for Davidson's strengths in the JSON object; `mos preference` has the same default.
const RESAMPLES: u32 = 1_999;

/// `mos table PATH…`: mean opinion scores, and for comparisons which method was preferred.
#[derive(Args)]
pub struct Table {
    #[command(flatten)]
    input: Input,
    /// Factors whose combinations make the rows, such as scene,method [default: all factors of the study]
    #[arg(long, value_delimiter = ',', value_name = "FACTOR")]
    by: Vec<String>,
    /// The kind of interval
    #[arg(long, value_enum, default_value = "t")]
    ci: Method,
    /// The confidence level of the interval
    #[arg(long, default_value = "0.9", value_parser = input::level)]
    level: f64,
    /// Number of resamples of a bootstrap interval
    #[arg(long, default_value_t = 9_999, value_parser = clap::value_parser!(u32).range(99..=1_000_000))]
    resamples: u32,
    /// Seed of a bootstrap interval
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Lowest and highest rating [default: the study's; else 1,5 where the ratings fit]
    #[arg(long, value_parser = input::scale, value_name = "LOW,HIGH")]
    scale: Option<Scale>,
}

impl Table {
    /// Reads, computes, prints.
    pub fn run(self) -> Result<()> {
        let columns = Columns { extra: self.by.clone(), ..Columns::default() };
        let loaded = self.input.load(columns.clone())?;
        let boot = Bootstrap { resamples: self.resamples, seed: self.seed };
        let options = TableOptions { by: self.by, method: self.ci, level: self.level, boot, scale: self.scale };
        let table = table(&loaded.data, &options)?;
        let preferences = match loaded.data.studies.iter().any(|study| study.forced_choice) {
            true => {
                let votes = self.input.load(Columns { by_rating: true, ..columns })?;
                preference(&votes.data, PAPER_VALUES, options.level, RESAMPLES, options.boot.seed)?
            }
            false => Vec::new(),
        };
        if self.input.json {
            let mut object = table.to_json();
            if !preferences.is_empty() {
                object["preferences"] = json!(preferences);
            }
            return print_json(&object);
        }
        let mut out = text::table(&table);
        out.extend(preferences.iter().map(|p| format!("\n{}", text::winners(p))));
        print(&out)
    }
}
