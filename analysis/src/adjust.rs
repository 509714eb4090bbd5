//! P-values adjusted for the number of tests in a family.

use serde::Serialize;

/// How p-values of one family are adjusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Correction {
    /// Holm 1979: controls the family-wise error rate.
    #[default]
    Holm,
    /// Benjamini and Hochberg 1995: controls the false discovery rate.
    #[value(name = "bh", alias = "benjamini-hochberg")]
    BenjaminiHochberg,
    /// Bonferroni: every p-value times the number of tests.
    Bonferroni,
    /// Hommel 1988: controls the family-wise error rate for tests that depend positively on each other.
    Hommel,
    /// Benjamini and Yekutieli 2001: controls the false discovery rate under any dependence.
    #[value(name = "by", alias = "benjamini-yekutieli")]
    BenjaminiYekutieli,
    /// No adjustment.
    None,
}

impl Correction {
    /// The name printed beside the numbers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Holm => "Holm",
            Self::BenjaminiHochberg => "Benjamini-Hochberg",
            Self::Bonferroni => "Bonferroni",
            Self::Hommel => "Hommel",
            Self::BenjaminiYekutieli => "Benjamini-Yekutieli",
            Self::None => "no adjustment",
        }
    }
}

/// Adjusted p-values in the order of `p`.
///
/// Holm: max over smaller p of min(1, (m − rank + 1)·p); Benjamini–Hochberg: min over larger p of
/// min(1, m·p/rank); Benjamini–Yekutieli: the same times Σ 1/i; Bonferroni: min(1, m·p); Hommel: by his
/// closed procedure.
///
/// ```
/// use cyclopean_analysis::adjust::{Correction, adjust};
/// // R 4.2.2: p.adjust(c(.01, .04, .03, .005, .2), "holm")
/// let p = adjust(&[0.01, 0.04, 0.03, 0.005, 0.2], Correction::Holm);
/// assert_eq!(p, [0.04, 0.09, 0.09, 0.025, 0.2]);
/// ```
pub fn adjust(p: &[f64], correction: Correction) -> Vec<f64> {
    let m = p.len();
    let mut order: Vec<usize> = (0..m).collect();
    order.sort_by(|a, b| p[*a].total_cmp(&p[*b]));
    let mut adjusted = p.to_vec();
    match correction {
        Correction::None => {}
        Correction::Holm => {
            let mut worst = 0f64;
            for (rank, i) in order.into_iter().enumerate() {
                worst = worst.max(((m - rank) as f64 * p[i]).min(1.0));
                adjusted[i] = worst;
            }
        }
        Correction::Bonferroni => adjusted.iter_mut().for_each(|p| *p = (m as f64 * *p).min(1.0)),
        Correction::Hommel => {
            let sorted: Vec<f64> = order.iter().map(|i| p[*i]).collect();
            for (i, p) in order.into_iter().zip(hommel(&sorted)) {
                adjusted[i] = p;
            }
        }
        Correction::BenjaminiHochberg | Correction::BenjaminiYekutieli => {
            let dependent = correction == Correction::BenjaminiYekutieli;
            let factor = if dependent { (1..=m).map(|i| 1.0 / i as f64).sum() } else { 1.0 };
            let mut best = 1f64;
            for (rank, i) in order.into_iter().enumerate().rev() {
                best = best.min(factor * m as f64 / (rank + 1) as f64 * p[i]);
                adjusted[i] = best;
            }
        }
    }
    adjusted
}

/// Hommel's adjusted p-values of ascending `p`: for each hypothesis, the largest Simes p-value over all sets of
/// hypotheses that contain it.
fn hommel(p: &[f64]) -> Vec<f64> {
    let n = p.len();
    let simes = |of: &[f64], m: usize, from: usize| {
        of.iter().zip(from..).map(|(p, rank)| m as f64 * p / rank as f64).fold(f64::INFINITY, f64::min)
    };
    let mut adjusted = vec![simes(p, n, 1); n];
    for m in (2..n).rev() {
        // Of all sets of m hypotheses that contain a given one, the set with the m − 1 largest p-values has the largest
        // Simes p-value.
        let (small, large) = p.split_at(n - m + 1);
        let joined = simes(large, m, 2);
        let q: Vec<f64> = small.iter().map(|p| (m as f64 * p).min(joined)).collect();
        let last = q[n - m];
        let all = q.into_iter().chain(std::iter::repeat_n(last, m - 1));
        adjusted.iter_mut().zip(all).for_each(|(a, q)| *a = a.max(q));
    }
    adjusted.iter().zip(p).map(|(a, p)| a.max(*p).min(1.0)).collect()
}
