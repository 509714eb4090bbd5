//! `mos table`.

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::data::Columns;
use cyclopean_analysis::interval::{Bootstrap, Method, Scale};
use cyclopean_analysis::mos::{TableOptions, table};
use cyclopean_analysis::report::text;

use super::input::{self, Input, print, print_json};

/// `mos table PATH…`
#[derive(Args)]
pub struct Table {
    #[command(flatten)]
    input: Input,
    /// Factors that make the rows, such as scene,method [default: all factors of the study]
    #[arg(long, value_delimiter = ',', value_name = "FACTOR")]
    by: Vec<String>,
    /// The interval
    #[arg(long, value_enum, default_value = "t")]
    ci: Method,
    /// Its level
    #[arg(long, default_value = "0.9", value_parser = input::level)]
    level: f64,
    /// Resamples of a bootstrap
    #[arg(long, default_value_t = 9_999, value_parser = clap::value_parser!(u32).range(99..=1_000_000))]
    resamples: u32,
    /// Seed of a bootstrap
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
        let loaded = self.input.load(columns)?;
        let boot = Bootstrap { resamples: self.resamples, seed: self.seed };
        let options = TableOptions { by: self.by, method: self.ci, level: self.level, boot, scale: self.scale };
        let table = table(&loaded.data, &options)?;
        if self.input.json { print_json(&table.to_json()) } else { print(&text::table(&table)) }
    }
}
