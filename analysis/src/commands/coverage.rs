//! `mos coverage`: makes the coverage table of the documentation.

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::interval::Bootstrap;
use cyclopean_analysis::power::{coverage, shapes};
use cyclopean_analysis::report::text;
use serde_json::json;

use super::input::{self, print, print_json};

/// `mos coverage`
#[derive(Args)]
pub struct Coverage {
    /// Numbers of votes per study
    #[arg(long, value_delimiter = ',', default_values_t = [10, 30])]
    n: Vec<u32>,
    /// Number of simulated studies
    #[arg(long, default_value_t = 10_000)]
    studies: u32,
    /// Confidence level of the intervals
    #[arg(long, default_value = "0.9", value_parser = input::level)]
    level: f64,
    /// Number of resamples of each bootstrap
    #[arg(long, default_value_t = 999, value_parser = clap::value_parser!(u32).range(99..=100_000))]
    resamples: u32,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl Coverage {
    /// Simulates and prints.
    pub fn run(self) -> Result<()> {
        let boot = Bootstrap { resamples: self.resamples, seed: self.seed };
        let mut all = Vec::new();
        for shape in shapes() {
            for n in &self.n {
                all.extend(coverage(shape, *n, self.studies, self.level, boot)?);
            }
        }
        if self.json {
            return print_json(&json!({
                "level": self.level, "studies": self.studies, "bootstrap": boot, "shapes": shapes(), "rows": all,
            }));
        }
        let mut rows = vec![
            ["votes", "n", "interval", "coverage", "±", "width", "unanimous", "undefined"].map(str::to_owned).to_vec(),
        ];
        for c in &all {
            rows.push(vec![
                c.shape.to_owned(),
                c.n.to_string(),
                c.method.words().to_owned(),
                format!("{:.3}", c.coverage.rate),
                format!("{:.3}", c.coverage.se),
                format!("{:.2}", c.width),
                format!("{:.4}", c.unanimous),
                format!("{:.4}", c.undefined),
            ]);
        }
        print(&format!(
            "{}\ncoverage of the expected vote over observers, level {}, {} studies, seed {}, B = {}\n",
            text::align(&rows),
            self.level,
            self.studies,
            self.seed,
            self.resamples
        ))
    }
}
