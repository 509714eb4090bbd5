//! The Hodges–Lehmann estimate of the shift, and its interval from the null distribution without ties.

use serde::Serialize;

use super::exact::Null;
use crate::special::normal_quantile;

/// Median of the Walsh averages, with an interval where the number of pairs allows one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shift {
    /// Median of (d_i + d_j)/2 over i ≤ j, zeros included.
    pub estimate: f64,
    /// Lower end; `None` when even the widest interval misses the level (2/2ⁿ > α).
    pub lo: Option<f64>,
    /// Upper end.
    pub hi: Option<f64>,
    /// The requested level.
    pub level: f64,
    /// The level that the order statistics give under the untied null; with ties it is at least this.
    pub achieved: Option<f64>,
}

/// Pairs up to which the null distribution without ties is computed exactly. Above, its normal approximation with
/// continuity correction is used, whose tail is then right to a few per cent of α (R changes over at 50).
const EXACT_UP_TO: usize = 200;

/// The Hodges–Lehmann estimate of `d` (finite, at least one) and its interval at `level`.
///
/// The ends come from the exact null distribution without ties up to 200 pairs, and from its normal approximation
/// above.
///
/// The sort takes O(n log n) time and each order statistic O(64·n). The Walsh averages are never listed: a million
/// pairs would have 5·10¹¹ of them.
///
/// ```
/// let s = cyclopean_analysis::wilcoxon::hodges_lehmann(&[1.0, 2.0, 4.0], 0.95);
/// assert_eq!((s.estimate, s.lo), (2.25, None)); // 2/2³ = 0.25 > 0.05: three pairs give no interval
/// ```
pub fn hodges_lehmann(d: &[f64], level: f64) -> Shift {
    let mut sorted = d.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let n = sorted.len() as u64;
    let all = n * (n + 1) / 2;
    let estimate = 0.5 * (walsh(&sorted, all.div_ceil(2)) + walsh(&sorted, all / 2 + 1));
    let (lo, hi, achieved) = match rank_of_end(sorted.len(), level) {
        Some((rank, achieved)) => (Some(walsh(&sorted, rank)), Some(walsh(&sorted, all + 1 - rank)), Some(achieved)),
        None => (None, None, None),
    };
    Shift { estimate, lo, hi, level, achieved }
}

/// The 1-based rank of the interval's lower end among the Walsh averages, and the level achieved.
fn rank_of_end(n: usize, level: f64) -> Option<(u64, f64)> {
    let alpha = 1.0 - level;
    if n < 1024 && 2.0 * 0.5f64.powi(n as i32) > alpha * (1.0 + 1e-12) {
        return None;
    }
    let (nf, half) = (n as f64, 0.5 * alpha);
    let mean = nf * (nf + 1.0) / 4.0;
    let sd = (nf * (nf + 1.0) * (2.0 * nf + 1.0) / 24.0).sqrt();
    let guess = mean + normal_quantile(half) * sd;
    if n > EXACT_UP_TO {
        let rank = (guess.round() as u64).max(1);
        let achieved = 1.0 - 2.0 * crate::special::normal_upper((mean - (rank as f64 - 1.0) - 0.5) / sd);
        return Some((rank, achieved));
    }
    // The null distribution is needed only a little beyond the normal guess; the lower end is never beyond the mean.
    let ranks: Vec<u64> = (1..=n as u64).collect();
    let mut high = ((guess + 0.1 * sd + 4.0).max(1.0).min(mean)) as u64;
    let null = Null::new(&ranks, high);
    // The largest rank C with P(T ≤ C − 1) ≤ α/2, with room for rounding at exact equality.
    let fits = |rank: u64| null.cumulative(rank - 1) <= half * (1.0 + 1e-12);
    let mut low = 1;
    if !fits(low) {
        return None;
    }
    while low < high {
        let middle = low + (high - low).div_ceil(2);
        if fits(middle) { low = middle } else { high = middle - 1 }
    }
    Some((low, 1.0 - 2.0 * null.cumulative(low - 1)))
}

/// The `rank`-th smallest Walsh average (1-based), by bisection over the bit patterns of f64.
fn walsh(sorted: &[f64], rank: u64) -> f64 {
    let (mut lo, mut hi) = (key(2.0 * sorted[0]), key(2.0 * sorted[sorted.len() - 1]));
    while lo < hi {
        let middle = lo + (hi - lo) / 2;
        if pairs_up_to(sorted, unkey(middle)) >= rank { hi = middle } else { lo = middle + 1 }
    }
    0.5 * unkey(lo)
}

/// Number of pairs i ≤ j with d_i + d_j ≤ limit, by one walk from both ends.
fn pairs_up_to(sorted: &[f64], limit: f64) -> u64 {
    let (mut count, mut j) = (0u64, sorted.len());
    for (i, low) in sorted.iter().enumerate() {
        while j > 0 && low + sorted[j - 1] > limit {
            j -= 1;
        }
        if j <= i {
            break;
        }
        count += (j - i) as u64;
    }
    count
}

/// Order-preserving map from f64 to u64.
fn key(x: f64) -> u64 {
    // −0 and 0 must be one value.
    let bits = (x + 0.0).to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

fn unkey(k: u64) -> f64 {
    f64::from_bits(if k >> 63 == 1 { k & !(1 << 63) } else { !k })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_order_statistic_agrees_with_listing(d in proptest::collection::vec(-20i32..20, 1..24)) {
            let mut sorted: Vec<f64> = d.into_iter().map(|v| f64::from(v) * 0.25).collect();
            sorted.sort_unstable_by(f64::total_cmp);
            let mut all = Vec::new();
            for i in 0..sorted.len() {
                all.extend((i..sorted.len()).map(|j| 0.5 * (sorted[i] + sorted[j])));
            }
            all.sort_unstable_by(f64::total_cmp);
            for (i, want) in all.iter().enumerate() {
                prop_assert_eq!(walsh(&sorted, i as u64 + 1), *want);
            }
        }
    }

    #[test]
    fn the_corn_data_agree_with_r() {
        let d = [6., 8., 14., 16., 23., 24., 28., 29., 41., -48., 49., 56., 60., -67., 75.];
        // R 4.2.2: qsignrank(0.025, 15) = 26, 1 − 2·psignrank(25, 15) = 0.9520874: the ends are the Walsh
        // averages of rank 26 and 95, counted here by listing them.
        let mut all = Vec::new();
        for i in 0..d.len() {
            all.extend((i..d.len()).map(|j| 0.5 * (d[i] + d[j])));
        }
        all.sort_unstable_by(f64::total_cmp);
        let s = hodges_lehmann(&d, 0.95);
        assert_eq!((s.estimate, s.lo, s.hi), (0.5 * (all[59] + all[60]), Some(all[25]), Some(all[94])));
        assert!((s.achieved.unwrap() - 0.952_087_4).abs() < 1e-7, "{:?}", s.achieved);
    }

    #[test]
    fn too_few_pairs_have_no_interval() {
        assert_eq!(hodges_lehmann(&[1.0; 5], 0.95).lo, None);
        assert_eq!(hodges_lehmann(&[1.0; 6], 0.95).lo, Some(1.0));
    }
}
