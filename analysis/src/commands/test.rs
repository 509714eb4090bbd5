//! `mos test`.

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::Error;
use cyclopean_analysis::adjust::Correction;
use cyclopean_analysis::contrast::{Contrast, against, default_contrasts, pairs, planned_options, test};
use cyclopean_analysis::data::{Columns, Dataset};
use cyclopean_analysis::equivalence::{NamedEquivalence, equivalence, planned_equivalences};
use cyclopean_analysis::report::text;
use cyclopean_analysis::wilcoxon::{Alternative, Exact, Zeros};
use serde_json::json;

use super::input::{self, Input, print, print_json};

/// `mos test PATH…`
#[derive(Args)]
pub struct Test {
    #[command(flatten)]
    input: Input,
    /// A contrast FACTOR=A,B (the difference A - B); may be given more than once [default: the study file's]
    #[arg(long, value_name = "FACTOR=A,B", value_parser = contrast)]
    contrast: Vec<(String, String, String)>,
    /// Test each participant's mean vote against this value [default: the study file's, for forced choices]
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    against: Option<i32>,
    /// Test every contrast separately for each level of this factor
    #[arg(long, value_name = "FACTOR")]
    per: Option<String>,
    /// What happens to zero differences [default: the study file's, else wilcox]
    #[arg(long, value_enum)]
    zeros: Option<Zeros>,
    /// Apply the continuity correction to the asymptotic z
    #[arg(long)]
    correction: bool,
    /// Alternative hypothesis [default: the study file's, else two-sided]
    #[arg(long, value_enum)]
    alternative: Option<Alternative>,
    /// When to compute the exact null distribution
    #[arg(long, value_enum)]
    exact: Option<Exact>,
    /// How p-values are adjusted within a family of contrasts [default: the study file's, else holm]
    #[arg(long, value_enum)]
    adjust: Option<Correction>,
    /// Confidence level of the intervals of effect sizes
    #[arg(long, default_value = "0.95", value_parser = input::level)]
    level: f64,
    /// Confidence level of the interval of the mean paired difference
    #[arg(long, default_value = "0.9", value_parser = input::level)]
    difference_level: f64,
    /// Also test equivalence within this margin, in scale steps, by two one-sided tests [default: the study file's]
    #[arg(long, value_name = "MARGIN")]
    equivalence: Option<f64>,
    /// Significance level of each one-sided test of equivalence
    #[arg(long, default_value_t = 0.05)]
    alpha: f64,
    /// Also test all participant x cell pairs as if they were independent, as the paper may have done
    #[arg(long)]
    pooled: bool,
}

/// Parses `FACTOR=A,B`.
pub fn contrast(text: &str) -> Result<(String, String, String), String> {
    let form = || format!("`{text}` is not FACTOR=A,B, such as method=stereo,sssr");
    let (factor, levels) = text.split_once('=').ok_or_else(form)?;
    let (a, b) = levels.split_once(',').ok_or_else(form)?;
    if [factor, a, b].iter().any(|t| t.is_empty()) || b.contains(',') || a == b {
        return Err(form());
    }
    Ok((factor.to_lowercase(), a.to_owned(), b.to_owned()))
}

impl Test {
    /// Reads, computes, prints.
    pub fn run(self) -> Result<()> {
        let extra = self.contrast.iter().map(|c| c.0.clone()).chain(self.per.clone()).collect();
        let loaded = self.input.load(Columns { extra, ..Columns::default() })?;
        let data = &loaded.data;
        let mut options = planned_options(data);
        options.test.correction = self.correction;
        options.test.level = self.level;
        options.test.zeros = self.zeros.unwrap_or(options.test.zeros);
        options.test.alternative = self.alternative.unwrap_or(options.test.alternative);
        options.test.exact = self.exact.unwrap_or(options.test.exact);
        options.correction = self.adjust.unwrap_or(options.correction);
        options.difference_level = self.difference_level;
        options.pooled = self.pooled;
        let contrasts = if self.contrast.is_empty() { default_contrasts(data) } else { self.contrasts() };
        let mut results = if contrasts.is_empty() { Vec::new() } else { test(data, &contrasts, &options)? };
        if self.contrast.is_empty() || self.against.is_some() {
            results.extend(against(data, self.against, &options)?);
        }
        if results.is_empty() {
            return Err(Error::data("no factor to contrast; name one with --contrast FACTOR=A,B").into());
        }
        let equivalences = self.equivalences(data)?;
        if self.input.json {
            print_json(
                &json!({ "contrasts": results, "equivalence": equivalences, "stamp": data.stamp(), "notes": data.notes }),
            )
        } else {
            let mut out = text::contrasts(&results, data.stamp().as_deref());
            out += &text::equivalences(&equivalences);
            out.extend(data.notes.iter().map(|n| text::note(n)));
            print(&out)
        }
    }

    /// Tests equivalence for the contrasts that were asked for; else for the study file's pair; else for stereo −
    /// path-traced.
    fn equivalences(&self, data: &Dataset) -> Result<Vec<NamedEquivalence>, Error> {
        let mut out = planned_equivalences(data, self.equivalence, self.alpha)?;
        if let (Some(margin), false) = (self.equivalence, self.contrast.is_empty()) {
            out.clear();
            for (s, study) in data.studies.iter().enumerate() {
                for (factor, a, b) in &self.contrast {
                    match pairs(data, &data.cells_of(s), factor, a, b) {
                        Ok(p) => out.push(NamedEquivalence {
                            study: study.id.clone(),
                            a: a.clone(),
                            b: b.clone(),
                            result: equivalence(&p, margin, self.alpha)?,
                        }),
                        Err(Error::Usage(_)) if data.studies.len() > 1 => {}
                        Err(e) => return Err(e),
                    }
                }
            }
        }
        if self.equivalence.is_some() && out.is_empty() {
            return Err(Error::usage("--equivalence needs a pair: name it with --contrast FACTOR=A,B"));
        }
        Ok(out)
    }

    fn contrasts(&self) -> Vec<Contrast> {
        let named = |(factor, a, b): &(String, String, String)| Contrast {
            factor: factor.clone(),
            a: a.clone(),
            b: b.clone(),
            family: "as asked".to_owned(),
            per: self.per.clone(),
        };
        self.contrast.iter().map(named).collect()
    }
}
