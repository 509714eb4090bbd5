//! `mos screen`.

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::data::Columns;
use cyclopean_analysis::report::text;
use cyclopean_analysis::screen::{P910Options, Sigma, bt500, krippendorff_ordinal, matrix, p910};
use serde_json::json;

use super::input::{Input, print, print_json};

/// `mos screen PATH…`
#[derive(Args)]
pub struct Screen {
    #[command(flatten)]
    input: Input,
    /// Divisor of the standard deviation per stimulus in BT.500: n (as sureal) or n-1 (as the ITU's text)
    #[arg(long, value_enum, default_value = "n")]
    sigma: Sigma,
    /// Compute P.910 as the reference implementation does, without a floor under the observers' inconsistency
    #[arg(long)]
    as_sureal: bool,
}

impl Screen {
    /// Reads, screens and prints. No observer is left out of anything.
    pub fn run(self) -> Result<()> {
        let loaded = self.input.load(Columns { by_repetition: true, ..Columns::default() })?;
        let data = &loaded.data;
        let mut objects = Vec::new();
        let mut out = text::stamped(data.stamp().as_deref());
        for (s, study) in data.studies.iter().enumerate() {
            let (stimuli, people, votes) = matrix(data, s);
            if people.is_empty() {
                continue;
            }
            let bt = bt500(&votes, self.sigma);
            let options = if self.as_sureal { P910Options { floor: None } } else { P910Options::default() };
            let annex = p910(&votes, options);
            let alpha = krippendorff_ordinal(&votes);
            if !study.id.is_empty() {
                out += &text::line(&study.id);
            }
            let mut rows = vec![
                ["participant", "votes", "high", "low", "share", "imbalance", "BT.500", "bias", "inconsistency"]
                    .map(str::to_owned)
                    .to_vec(),
            ];
            for (i, (who, o)) in people.iter().zip(&bt.observers).enumerate() {
                rows.push(vec![
                    who.clone(),
                    o.votes.to_string(),
                    o.high.to_string(),
                    o.low.to_string(),
                    format!("{:.3}", o.share),
                    text::number(o.imbalance),
                    if o.rejected { "flagged" } else { "kept" }.to_owned(),
                    format!("{:.3}", annex.bias[i]),
                    format!("{:.3}", annex.inconsistency[i]),
                ]);
            }
            out += &text::align(&rows);
            out +=
                &format!("Krippendorff's alpha (ordinal) {} over {} stimuli\n", text::number(alpha.alpha), alpha.units);
            out += &text::line(&format!(
                "P.910: {} rounds, largest weight {:.2} ({})",
                annex.rounds, annex.largest_weight, people[annex.heaviest]
            ));
            out.extend(bt.notes.iter().map(|n| text::note(&format!("BT.500: {n}"))));
            out.extend(annex.notes.iter().map(|n| text::note(&format!("P.910: {n}"))));
            objects.push(json!({
                "study": study.id, "participants": people, "stimuli": stimuli,
                "sigma": self.sigma, "bt500": bt, "p910": annex, "krippendorff": alpha,
            }));
        }
        for (who, why) in &loaded.excluded {
            out += &text::line(&format!("excluded by the study file's rule: {who}: {why}"));
        }
        out += "nothing is left out of any table by this; use --exclude or --exclude-failed for tables without\n";
        if self.input.json {
            let excluded: Vec<_> =
                loaded.excluded.iter().map(|(p, why)| json!({ "participant": p, "reason": why })).collect();
            return print_json(
                &json!({ "studies": objects, "excluded": excluded, "stamp": data.stamp(), "notes": data.notes }),
            );
        }
        print(&out)
    }
}
