//! Is a difference small enough not to matter? Two one-sided exact signed-rank tests.
//!
//! A test that does not reject equality cannot answer that. With a margin M fixed beforehand, both "the difference is
//! −M or less" and "it is M or more" must be rejected.

use serde::Serialize;

use crate::contrast::{Difference, Pairs, difference, pairs};
use crate::data::{Dataset, UNIT};
use crate::error::{Error, Result};
use crate::wilcoxon::{Alternative, Exact, Options, signed_rank};

/// The result of both one-sided tests.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Equivalence {
    /// Half width of the zone of equivalence, in scale steps: smaller differences do not matter.
    pub margin: f64,
    /// Level of each one-sided test, α.
    pub alpha: f64,
    /// Participants.
    pub n: usize,
    /// p-value of the test whose alternative is "the difference is above −M".
    pub p_lower: f64,
    /// p-value of the test whose alternative is "the difference is below +M".
    pub p_upper: f64,
    /// The larger of the two: the p-value of equivalence.
    pub p: f64,
    /// Whether p ≤ α.
    pub equivalent: bool,
    /// The mean paired difference with its (1 − 2α) t interval.
    pub difference: Difference,
    /// How it was computed.
    pub convention: String,
    /// Remarks that a reader of these numbers needs.
    pub notes: Vec<String>,
}

/// Tests equivalence within ±`margin` scale steps at level `alpha`, on sums shifted by ±margin × votes.
///
/// # Errors
/// [`Error::Usage`] for a margin that is not positive and finite or an α outside (0, ½);
/// [`Error::Data`] without pairs.
pub fn equivalence(pairs: &Pairs, margin: f64, alpha: f64) -> Result<Equivalence> {
    if !(margin > 0.0 && margin.is_finite()) {
        return Err(Error::usage(format!("margin {margin} must be above 0 scale steps, for example 0.5")));
    }
    if !(alpha > 0.0 && alpha < 0.5) {
        return Err(Error::usage(format!("alpha {alpha} is not between 0 and 0.5, for example 0.05")));
    }
    // All sums are doubled whole numbers, so that a margin of half a step per vote stays exact, and so do ties with it.
    let shift = (2.0 * margin * f64::from(pairs.votes) * UNIT as f64).round() as i64;
    let shifted = |by: i64| -> Vec<f64> { pairs.differences.iter().map(|d| (2 * d + by) as f64).collect() };
    let one_sided = |d: &[f64], alternative| {
        signed_rank(d, &Options { alternative, exact: Exact::Auto, ..Options::default() }).map(|r| r.p())
    };
    let p_lower = one_sided(&shifted(shift), Alternative::Greater)?;
    let p_upper = one_sided(&shifted(-shift), Alternative::Less)?;
    let p = p_lower.max(p_upper);
    let n = pairs.differences.len();
    let mut notes = Vec::new();
    if n < 15 {
        notes.push(format!(
            "{n} participants: with SD 0.6 and margin 0.5 the power is 56 % at 10, 85 % at 15, 97 % at 24"
        ));
    }
    Ok(Equivalence {
        margin,
        alpha,
        n,
        p_lower,
        p_upper,
        p,
        equivalent: p <= alpha,
        difference: difference(&pairs.steps(), 1.0 - 2.0 * alpha),
        convention: "two one-sided exact signed-rank tests on doubled sums shifted by the margin; zeros dropped".into(),
        notes,
    })
}

/// An equivalence test and the two levels that it compares.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedEquivalence {
    /// Study id; empty when the source has none.
    pub study: String,
    /// A level of `method`, or of the factor that was asked for.
    pub a: String,
    /// The other level.
    pub b: String,
    /// The result.
    #[serde(flatten)]
    pub result: Equivalence,
}

/// Runs the equivalence tests that the study files fixed; `margin`, where given, replaces their margins. With a
/// `margin`, stereo − path-traced is tested in each study that fixed no test. A study without a test and a margin gets
/// no result.
///
/// # Errors
/// As [`equivalence`]; [`Error::Data`] when no participant is complete.
pub fn planned_equivalences(data: &Dataset, margin: Option<f64>, alpha: f64) -> Result<Vec<NamedEquivalence>> {
    let mut out = Vec::new();
    for (s, study) in data.studies.iter().enumerate() {
        let planned = study.plan.as_ref().and_then(|p| p.equivalence.as_ref());
        let (a, b, m) = match (planned, margin) {
            (Some(p), m) => (p.a.as_str(), p.b.as_str(), m.unwrap_or(p.margin)),
            (None, Some(m)) => ("stereo", "path-traced", m),
            (None, None) => continue,
        };
        match pairs(data, &data.cells_of(s), "method", a, b) {
            Ok(p) if p.differences.is_empty() => {
                return Err(Error::data(format!("{a} - {b}: no participant has every cell of both")));
            }
            Ok(p) => out.push(NamedEquivalence {
                study: study.id.clone(),
                a: a.to_owned(),
                b: b.to_owned(),
                result: equivalence(&p, m, alpha)?,
            }),
            // The study does not show these methods, so it gets no result.
            Err(Error::Usage(_)) if planned.is_none() => {}
            Err(e) => return Err(e),
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(differences: &[f64]) -> Pairs {
        Pairs {
            participants: (0..differences.len()).map(|i| i.to_string()).collect(),
            differences: differences.iter().map(|d| (d * UNIT as f64) as i64).collect(),
            votes: 3,
            incomplete: Vec::new(),
            unmatched: Vec::new(),
        }
    }

    #[test]
    fn small_differences_are_equivalent_and_large_ones_not() {
        let small = equivalence(&pairs(&[0., 1., -1., 0., 1., 0., -1., 0., 0., 1., 0., -1.]), 0.5, 0.05).unwrap();
        // All twelve sums lie within ±1.5 votes: both one-sided p are 2⁻¹².
        assert_eq!((small.p, small.equivalent), (0.5f64.powi(12), true));
        let large = equivalence(&pairs(&[3., 2., 3., 4., 3., 2., 3., 3., 2., 3.]), 0.5, 0.05).unwrap();
        assert!(!large.equivalent && large.p > 0.9);
        // A difference of exactly the margin is a zero of the shifted test, never evidence.
        let at = equivalence(&pairs(&[1.5; 8]), 0.5, 0.05).unwrap();
        assert_eq!(at.p_upper, 1.0);
    }
}
