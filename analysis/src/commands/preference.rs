//! `mos preference`.

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::Error;
use cyclopean_analysis::data::Columns;
use cyclopean_analysis::preference::preference;
use cyclopean_analysis::report::text;
use serde_json::json;

use super::input::{self, Input, print, print_json};

/// `mos preference PATH…`
#[derive(Args)]
pub struct Preference {
    #[command(flatten)]
    input: Input,
    /// Factors whose combinations are the conditions, such as scene,eye [default: all factors of the study]
    #[arg(long, value_delimiter = ',', value_name = "FACTOR")]
    by: Vec<String>,
    /// The three ratings, in this order: other better, no difference seen, method better
    #[arg(long, value_delimiter = ',', num_args = 1, default_values_t = [1, 2, 3], allow_hyphen_values = true)]
    values: Vec<i32>,
    /// Confidence level of the intervals
    #[arg(long, default_value = "0.9", value_parser = input::level)]
    level: f64,
    /// Number of bootstrap resamples for the intervals of Davidson's strengths
    #[arg(long, default_value_t = 1_999, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    resamples: u32,
    /// Seed of the bootstrap
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

impl Preference {
    /// Reads, computes, prints.
    pub fn run(self) -> Result<()> {
        let Ok(values) = <[i32; 3]>::try_from(self.values.clone()) else {
            return Err(Error::usage("--values needs three ratings, such as 1,2,3").into());
        };
        let loaded = self.input.load(Columns { extra: self.by.clone(), by_rating: true, ..Columns::default() })?;
        let data = &loaded.data;
        let all = preference(data, values, self.level, self.resamples, self.seed)?;
        if self.input.json {
            return print_json(
                &json!({ "preferences": all, "level": self.level, "stamp": data.stamp(), "notes": data.notes }),
            );
        }
        let mut out = text::stamped(data.stamp().as_deref());
        for p in &all {
            out += &text::preference(p);
        }
        out.extend(data.notes.iter().map(|n| text::note(n)));
        print(&out)
    }
}
