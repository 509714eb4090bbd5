//! Friedman's test: do more than two conditions differ, each scored by every participant?

use serde::Serialize;

use crate::error::{Error, Result};
use crate::special::chi_squared_upper;

/// The result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Friedman {
    /// Participants with every condition.
    pub n: usize,
    /// Conditions.
    pub k: usize,
    /// χ² with tie correction; `None` when every participant scores all conditions equally.
    pub chi_squared: Option<f64>,
    /// Degrees of freedom, k − 1.
    pub df: usize,
    /// P(χ² ≥ observed) by the χ² approximation; 1 when no scores differ.
    pub p: f64,
    /// Kendall's W = χ²/(n(k − 1)), from 0 (no agreement) to 1 (complete agreement).
    pub kendall_w: Option<f64>,
    /// Mean rank of each condition, in the order given.
    pub mean_ranks: Vec<f64>,
    /// Remarks that a reader of these numbers needs.
    pub notes: Vec<String>,
}

/// Tests `scores`: one row a participant, one column a condition, all finite.
///
/// χ² = \[12/(n·k(k+1))·Σ R_j² − 3n(k+1)\]/C with C = 1 − Σ(t³−t)/(n·k(k²−1)) over the tie groups of
/// every row (Friedman 1937; Hollander and Wolfe 1999, 7.1).
///
/// # Errors
/// [`Error::Data`] below two participants or two conditions, or with rows of different lengths.
///
/// ```
/// use cyclopean_analysis::friedman::friedman;
/// let rows = vec![vec![1.0, 2.0, 3.0], vec![1.0, 2.0, 3.0], vec![1.0, 3.0, 2.0]];
/// let f = friedman(&rows)?;
/// assert!((f.chi_squared.unwrap() - 14.0 / 3.0).abs() < 1e-12);
/// # Ok::<(), cyclopean_analysis::Error>(())
/// ```
pub fn friedman(scores: &[Vec<f64>]) -> Result<Friedman> {
    let n = scores.len();
    let k = scores.first().map_or(0, Vec::len);
    if n < 2 || k < 2 {
        return Err(Error::data(format!(
            "Friedman's test needs at least two complete participants and two conditions; here {n} and {k}"
        )));
    }
    if scores.iter().any(|r| r.len() != k || r.iter().any(|v| !v.is_finite())) {
        return Err(Error::data("Friedman's test needs one finite score of every participant for every condition"));
    }
    let mut sums = vec![0.0; k];
    let mut ties = 0.0;
    for row in scores {
        let mut order: Vec<usize> = (0..k).collect();
        order.sort_by(|a, b| row[*a].total_cmp(&row[*b]));
        let mut first = 0;
        while first < k {
            let mut end = first + 1;
            while end < k && row[order[end]] == row[order[first]] {
                end += 1;
            }
            let rank = (first + end + 1) as f64 / 2.0;
            order[first..end].iter().for_each(|c| sums[*c] += rank);
            let t = (end - first) as f64;
            ties += t * (t * t - 1.0);
            first = end;
        }
    }
    let (nf, kf) = (n as f64, k as f64);
    // The rank sums are centred first, so that no large numbers cancel.
    let middle = nf * (kf + 1.0) / 2.0;
    let spread: f64 = sums.iter().map(|s| (s - middle).powi(2)).sum();
    let correction = 1.0 - ties / (nf * kf * (kf * kf - 1.0));
    let chi = (correction > 0.0).then(|| 12.0 * spread / (nf * kf * (kf + 1.0)) / correction);
    let mut notes = Vec::new();
    if chi.is_none() {
        notes.push("no differences: every participant scores all conditions equally".to_owned());
    }
    if n < 10 {
        notes.push(format!("the chi-squared approximation is rough for {n} participants"));
    }
    Ok(Friedman {
        n,
        k,
        chi_squared: chi,
        df: k - 1,
        p: chi.map_or(1.0, |c| chi_squared_upper(c, kf - 1.0)),
        kendall_w: chi.map(|c| c / (nf * (kf - 1.0))),
        mean_ranks: sums.iter().map(|s| s / nf).collect(),
        notes,
    })
}
