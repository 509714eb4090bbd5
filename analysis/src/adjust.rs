//! P-values adjusted for the number of tests in a family.

use serde::Serialize;

/// How p-values of one family are adjusted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Correction {
    /// Holm 1979: keeps the family-wise error.
    #[default]
    Holm,
    /// Benjamini and Hochberg 1995: keeps the false discovery rate.
    #[value(name = "bh", alias = "benjamini-hochberg")]
    BenjaminiHochberg,
    /// None.
    None,
}

impl Correction {
    /// The name printed beside the numbers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Holm => "Holm",
            Self::BenjaminiHochberg => "Benjamini-Hochberg",
            Self::None => "no adjustment",
        }
    }
}

/// Adjusted p-values in the order of `p`.
///
/// Holm: max over smaller p of min(1, (m − rank + 1)·p); Benjamini–Hochberg: min over larger p of
/// min(1, m·p/rank).
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
        Correction::BenjaminiHochberg => {
            let mut best = 1f64;
            for (rank, i) in order.into_iter().enumerate().rev() {
                best = best.min(m as f64 / (rank + 1) as f64 * p[i]);
                adjusted[i] = best;
            }
        }
    }
    adjusted
}
