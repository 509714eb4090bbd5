//! The power of a planned study: how often its tests find the effects that its `simulation` states.
//!
//! The study's own simulated observers answer its own orders, and the test that will judge real sessions judges their
//! votes. `study freeze` calls this.

use std::collections::BTreeMap;

use cyclopean_analysis::journal::plan::{Alternative, Test, Zeros};
use cyclopean_analysis::journal::record::Purpose;
use cyclopean_analysis::wilcoxon::{self, signed_rank};
use serde::Serialize;

use super::definition::Definition;
use super::observer::{ObserverError, SimulatedObserver};
use super::plan::Plan;

/// Level of each test by itself; corrections for several tests make the power smaller.
const ALPHA: f64 = 0.05;

/// The power for the planned number of participants.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Power {
    pub participants: u32,
    /// Number of simulated studies.
    pub studies: u32,
    pub alpha: f64,
    pub tests: Vec<TestPower>,
    /// What these numbers leave out.
    pub note: &'static str,
}

/// One planned test.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TestPower {
    /// `stereo - sssr`, or `vote - 2`.
    pub test: String,
    /// Share of studies with p ≤ α.
    pub power: f64,
    /// Its Monte Carlo standard error.
    pub standard_error: f64,
    /// Mean difference over all studies, scale steps.
    pub mean_difference: f64,
}

/// Simulates `studies` whole studies, each with its own simulated people.
///
/// # Errors
/// The study does not say how observers judge.
pub fn estimate(definition: &Definition, studies: u32) -> Result<Power, ObserverError> {
    let plans: Vec<Plan> = (0..u64::from(definition.participants)).map(|row| Plan::draw(definition, row)).collect();
    let analysis = &definition.analysis;
    let contrasts: Vec<_> = analysis.contrasts.iter().filter(|c| c.per.is_none()).collect();
    let names = contrasts.iter().map(|c| format!("{} - {}", c.a, c.b));
    let names: Vec<String> = names.chain(analysis.against.map(|value| format!("vote - {value}"))).collect();
    let mut found = vec![(0u32, 0.0f64); names.len()];
    for study in 0..studies {
        let mut differences = vec![Vec::new(); names.len()];
        for (i, plan) in plans.iter().enumerate() {
            let sums = answer(definition, plan, &format!("power-{study}-{i}"))?;
            let level = |factor: &str, level: &str| sums.get(&(factor.to_owned(), level.to_owned())).copied();
            for (contrast, out) in contrasts.iter().zip(&mut differences) {
                if let (Some(a), Some(b)) = (level(&contrast.factor, &contrast.a), level(&contrast.factor, &contrast.b))
                {
                    out.push((a.0 - b.0, a.1));
                }
            }
            if let (Some(value), Some(all), Some(out)) = (analysis.against, level("", ""), differences.last_mut()) {
                out.push((all.0 - f64::from(value) * all.1, all.1));
            }
        }
        for (found, differences) in found.iter_mut().zip(&differences) {
            let sums: Vec<f64> = differences.iter().map(|d| d.0).collect();
            found.0 += u32::from(is_significant(definition, &sums));
            found.1 += differences.iter().map(|d| d.0 / d.1).sum::<f64>() / differences.len().max(1) as f64;
        }
    }
    let n = f64::from(studies.max(1));
    let tests = names.into_iter().zip(found).map(|(test, (k, sum))| {
        let power = f64::from(k) / n;
        let standard_error = (power * (1.0 - power) / n).sqrt();
        TestPower { test, power, standard_error, mean_difference: sum / n }
    });
    let note = "each test alone, before any correction; observers as the study's `simulation` says; nobody is excluded";
    Ok(Power { participants: definition.participants, studies, alpha: ALPHA, tests: tests.collect(), note })
}

/// (factor, level) → sum and number of a participant's ratings; ("", "") stands for all of them.
type Sums = BTreeMap<(String, String), (f64, f64)>;

/// The answers of one simulated person to a whole plan.
fn answer(definition: &Definition, plan: &Plan, person: &str) -> Result<Sums, ObserverError> {
    let question = definition.journal_question();
    let observer = SimulatedObserver::new(definition, plan, &[], person, &vec![None; plan.stimuli.len()])?;
    let mut sums = Sums::new();
    for planned in plan.presentations.iter().filter(|p| p.purpose == Purpose::Trial) {
        let choice = observer.choice(planned.presentation);
        let Some(rating) = question.rating(choice, planned.a_is) else { continue };
        let factors = plan.conditions.get(planned.condition as usize).into_iter().flat_map(|c| &c.factors);
        let levels = factors.map(|(factor, level)| (factor.clone(), level.clone()));
        for level in levels.chain([(String::new(), String::new())]) {
            let sum = sums.entry(level).or_default();
            *sum = (sum.0 + f64::from(rating), sum.1 + 1.0);
        }
    }
    Ok(sums)
}

fn is_significant(definition: &Definition, differences: &[f64]) -> bool {
    let plan = &definition.analysis;
    let options = wilcoxon::Options {
        zeros: match plan.zeros {
            Zeros::Wilcox => wilcoxon::Zeros::Wilcox,
            Zeros::Pratt => wilcoxon::Zeros::Pratt,
            Zeros::Zsplit => wilcoxon::Zeros::Zsplit,
        },
        alternative: match plan.alternative {
            Alternative::TwoSided => wilcoxon::Alternative::TwoSided,
            Alternative::Greater => wilcoxon::Alternative::Greater,
            Alternative::Less => wilcoxon::Alternative::Less,
        },
        ..wilcoxon::Options::default()
    };
    let Ok(result) = signed_rank(differences, &options) else { return false };
    let p = match plan.test {
        Test::SignedRankExact => result.p_exact.or(result.p_asymptotic),
        Test::SignedRankAsymptotic => result.p_asymptotic,
    };
    p.is_some_and(|p| p <= ALPHA)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::testing;

    fn two_methods(latent: [f64; 2], participants: u32) -> Definition {
        let mut d = testing::rate(3, 1);
        d.participants = participants;
        let cross = d.conditions.cross.as_mut().unwrap();
        cross.method = vec!["sssr".to_owned(), "path-traced".to_owned()];
        let simulation = d.simulation.as_mut().unwrap();
        simulation.latent = [("sssr".to_owned(), latent[0]), ("path-traced".to_owned(), latent[1])].into();
        d.analysis.contrasts = serde_json::from_str(r#"[{"a": "path-traced", "b": "sssr"}]"#).unwrap();
        d
    }

    #[test]
    fn without_an_effect_the_exact_test_keeps_its_level_and_a_large_effect_is_found() {
        let none = estimate(&two_methods([3.0, 3.0], 10), 600).unwrap();
        // At most 0.05, with four standard errors of 600 studies.
        assert!(none.tests[0].power <= 0.05 + 0.036, "{none:?}");
        assert!(none.tests[0].mean_difference.abs() < 0.1, "{none:?}");
        let large = estimate(&two_methods([2.5, 4.0], 10), 100).unwrap();
        assert!(large.tests[0].power > 0.95 && large.tests[0].test == "path-traced - sssr", "{large:?}");
        let small = estimate(&two_methods([2.9, 3.1], 10), 200).unwrap();
        assert!(small.tests[0].power < large.tests[0].power);
    }

    #[test]
    fn a_comparison_is_tested_against_its_middle() {
        let mut d = testing::compare(6, 1);
        d.participants = 12;
        d.analysis.against = Some(2);
        let power = estimate(&d, 100).unwrap();
        // The other method is better by one step, so votes are below 2.
        assert!(power.tests[0].mean_difference < -0.3 && power.tests[0].power > 0.9, "{power:?}");
        assert_eq!(power.tests[0].test, "vote - 2");
    }
}
