//! The normal approximation of the signed-rank statistic under three zero rules.

use super::ranks::{Ranks, cube_less};
use super::{Alternative, Zeros};
use crate::special::{normal_two_sided, normal_upper};

/// Mean and variance of R₊ under the null, in ranks (not doubled).
pub fn moments(ranks: &Ranks, rule: Zeros) -> (f64, f64) {
    let k = ranks.zeros as f64;
    let used = ranks.signed.len() as f64;
    match rule {
        Zeros::Wilcox => {
            let n = used;
            (n * (n + 1.0) / 4.0, n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - ranks.tie_sum() / 48.0)
        }
        Zeros::Pratt => {
            let n = used + k;
            let cubic = |n: f64| n * (n + 1.0) * (2.0 * n + 1.0);
            ((n * (n + 1.0) - k * (k + 1.0)) / 4.0, (cubic(n) - cubic(k) - 0.5 * ranks.tie_sum()) / 24.0)
        }
        Zeros::Zsplit => {
            let n = used + k;
            let ties = ranks.tie_sum() + cube_less(ranks.zeros);
            (n * (n + 1.0) / 4.0, (n * (n + 1.0) * (2.0 * n + 1.0) - 0.5 * ties) / 24.0)
        }
    }
}

/// Signed z of `r_plus` and its p; `None` when the variance is zero (no differences).
pub fn z_and_p(
    r_plus: f64,
    (mean, variance): (f64, f64),
    correction: bool,
    alternative: Alternative,
) -> Option<(f64, f64)> {
    if variance.is_nan() || variance <= 0.0 {
        return None;
    }
    let off = r_plus - mean;
    let c = match (correction, alternative) {
        (false, _) => 0.0,
        // signum(0.0) is 1 in Rust; at the mean there is nothing to correct.
        (true, Alternative::TwoSided) if off == 0.0 => 0.0,
        (true, Alternative::TwoSided) => 0.5 * off.signum(),
        (true, Alternative::Greater) => 0.5,
        (true, Alternative::Less) => -0.5,
    };
    let z = (off - c) / variance.sqrt();
    let p = match alternative {
        Alternative::TwoSided => normal_two_sided(z),
        Alternative::Greater => normal_upper(z),
        Alternative::Less => normal_upper(-z),
    };
    // Beyond z = 37.5 the tail underflows, although it is not 0.
    Some((z, p.max(f64::MIN_POSITIVE)))
}
