//! `mos friedman`.

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::adjust::Correction;
use cyclopean_analysis::contrast::{Contrast, TestOptions, scores, test};
use cyclopean_analysis::data::Columns;
use cyclopean_analysis::friedman::friedman;
use cyclopean_analysis::report::text;
use cyclopean_analysis::special::p_text;
use cyclopean_analysis::{Error, data::Dataset};
use serde_json::json;

use super::input::{Input, print, print_json};

/// `mos friedman PATH…`
#[derive(Args)]
pub struct Friedman {
    #[command(flatten)]
    input: Input,
    /// The factor whose levels are compared
    #[arg(long, default_value = "method")]
    factor: String,
    /// How the p-values of the pairwise tests that follow are adjusted
    #[arg(long, value_enum, default_value = "holm")]
    adjust: Correction,
}

impl Friedman {
    /// Reads, tests, prints.
    pub fn run(self) -> Result<()> {
        let loaded = self.input.load(Columns { extra: vec![self.factor.clone()], ..Columns::default() })?;
        let data = &loaded.data;
        let mut tests = Vec::new();
        let mut out = text::stamped(data.stamp().as_deref());
        for (s, study) in data.studies.iter().enumerate() {
            let cells = data.cells_of(s);
            let Some(f) = data.factor(&self.factor).filter(|f| data.levels(*f, &cells).len() > 1) else { continue };
            let levels: Vec<String> = data.levels(f, &cells).into_iter().map(str::to_owned).collect();
            let (rows, incomplete) = scores(data, &cells, f, &levels)?;
            let result = friedman(&rows)?;
            out += &text::line(&format!(
                "{}Friedman, {} over {}: n = {}, chi2 = {}, df = {}, p = {}, Kendall's W = {}",
                if study.id.is_empty() { String::new() } else { format!("{}: ", study.id) },
                self.factor,
                levels.join(", "),
                result.n,
                text::number(result.chi_squared),
                result.df,
                p_text(result.p),
                text::number(result.kendall_w)
            ));
            out +=
                "unit: the participant (sums over cells and repetitions); tie correction; chi-squared approximation\n";
            out.extend(result.notes.iter().map(|n| text::note(n)));
            if !incomplete.is_empty() {
                out += &text::note(&format!("left out, without every cell: {}", incomplete.join(", ")));
            }
            let mut o = serde_json::to_value(&result)?;
            o["study"] = study.id.clone().into();
            o["factor"] = self.factor.clone().into();
            o["levels"] = levels.into();
            o["incomplete"] = incomplete.into();
            tests.push(o);
        }
        if tests.is_empty() {
            let known = data.factors.join(", ");
            return Err(Error::usage(format!("no study has two levels of `{}`; factors: {known}", self.factor)).into());
        }
        let options = TestOptions { correction: self.adjust, ..TestOptions::default() };
        let pairwise = test(data, &all_pairs(data, &self.factor), &options)?;
        if self.input.json {
            return print_json(
                &json!({ "tests": tests, "contrasts": pairwise, "stamp": data.stamp(), "notes": data.notes }),
            );
        }
        out += &text::contrasts(&pairwise, None);
        out.extend(data.notes.iter().map(|n| text::note(n)));
        print(&out)
    }
}

fn all_pairs(data: &Dataset, factor: &str) -> Vec<Contrast> {
    let all: Vec<usize> = (0..data.cells.len()).collect();
    let Some(f) = data.factor(factor) else { return Vec::new() };
    let levels = data.levels(f, &all);
    let mut out = Vec::new();
    for (i, a) in levels.iter().enumerate() {
        out.extend(levels[i + 1..].iter().map(|b| Contrast {
            factor: factor.to_owned(),
            a: (*a).to_owned(),
            b: (*b).to_owned(),
            family: "pairwise after Friedman".to_owned(),
            per: None,
        }));
    }
    out
}
