//! Ratios of each method to the baseline with the same number of samples: of errors, of inconsistency, and of the times
//! by groups of passes. `run` calls it with a scene's rows. The other comparisons use its quartiles and geometric
//! means.

use cyclopean_analysis::interval::student_t;

use super::report::{MissingRatio, Overhead, Ratio, Row};
use crate::metrics::jackknife::{self, Figure};
use crate::metrics::lasting_contrast::JackknifeReplicates;
use crate::metrics::network;

/// The measures that have a value for each round, with the names of their ratios. The last two are similarities, so 1
/// minus the measure is compared.
const BY_ROUND: [(&str, &str); 13] = [
    ("mse", "mse"),
    ("rse", "rse"),
    ("relmse", "relmse"),
    ("tonemapped_mse", "tonemapped_mse"),
    ("composite_tonemapped_mse", "composite_tonemapped_mse"),
    ("flip", "flip"),
    ("reflection_flip", "reflection_flip"),
    ("lpips", "lpips"),
    ("dists", "dists"),
    ("reflection_lpips", "reflection_lpips"),
    ("reflection_dists", "reflection_dists"),
    ("ssim", "one_minus_ssim"),
    ("reflection_ssim", "one_minus_reflection_ssim"),
];

/// Every row but the baseline's, with the baseline's row of the same number of samples and the same fallback.
fn peers<'a>(rows: &'a [Row], baseline: &str) -> Vec<(&'a Row, &'a Row)> {
    let of_baseline = |row: &Row| rows.iter().find(|b| b.method == baseline && b.is_peer(row));
    rows.iter().filter(|r| r.method != baseline).filter_map(|r| Some((r, of_baseline(r)?))).collect()
}

/// One value divided by another, or why that ratio cannot be part of a geometric mean.
fn quotient(own: Option<f64>, base: Option<f64>) -> Result<f64, &'static str> {
    let (Some(own), Some(base)) = (own, base) else { return Err("a value is undefined") };
    match (own, base) {
        _ if !own.is_finite() || !base.is_finite() => Err("a value is not finite"),
        _ if own < 0.0 || base < 0.0 => Err("an estimate below 0 has no ratio"),
        (_, 0.0) => Err("the baseline's value is 0, so there is nothing to divide by"),
        (0.0, _) => Err("the method's value is 0, and 0 has no logarithm"),
        _ => Ok(own / base),
    }
}

impl MissingRatio {
    /// Says why a measure of this row has no ratio.
    pub fn of(row: &Row, measure: String, why: &str) -> MissingRatio {
        let (method, fallback) = (row.method.clone(), row.fallback.clone());
        MissingRatio { method, spp: row.spp, fallback, measure, why: why.to_owned() }
    }
}

/// The ratios of errors and of inconsistency. A measure without a ratio is added to `left_out`.
pub fn equal_sample(rows: &[Row], baseline: &str, left_out: &mut Vec<MissingRatio>) -> Vec<Ratio> {
    let mut ratios = Vec::new();
    for (row, base) in peers(rows, baseline) {
        let mut add = |measure: &str, own, theirs, interval: Option<[f64; 2]>| match quotient(own, theirs) {
            Ok(ratio) => {
                let (method, fallback) = (row.method.clone(), row.fallback.clone());
                ratios.push(Ratio { method, spp: row.spp, fallback, measure: measure.to_owned(), ratio, interval });
            }
            Err(why) => left_out.push(MissingRatio::of(row, measure.to_owned(), why)),
        };
        for (measure, name) in BY_ROUND {
            // A measure whose network was not named is not reported as left out.
            if network::measure_of(measure).is_some() && !row.left.means.contains_key(measure) {
                continue;
            }
            let error = |v: &f64| if name.starts_with("one_minus") { 1.0 - v } else { *v };
            let of =
                |r: &Row| -> Vec<f64> { r.rounds.measures.get(measure).into_iter().flatten().map(error).collect() };
            let (own, theirs) = (of(row), of(base));
            add(name, mean(&own), mean(&theirs), ratio_of_means(&own, &theirs).1);
        }
        let mut both = |measure: &str, f: fn(&Row) -> Option<f64>, without: Option<Replicates>| {
            let interval = without.and_then(|of| over_groups([(row, f(row)?), (base, f(base)?)], of));
            add(measure, f(row), f(base), interval);
        };
        both("bias2", |r| Some(r.left.bias2? + r.right.bias2?), None);
        both("variance", |r| Some(r.left.variance? + r.right.variance?), None);
        both("systematic_inconsistency", |r| r.systematic_inconsistency, Some(|w| &w.systematic_inconsistency));
        both("systematic_unbiased", |r| Some(r.systematic_unbiased?.squared), Some(|w| &w.systematic_unbiased));
        both("noise_variance", |r| r.noise_variance, Some(|w| &w.noise_variance));
    }
    ratios
}

/// Picks the values of one figure without each group of seeds.
type Replicates = fn(&JackknifeReplicates) -> &[f64];

/// The interval of a ratio by the jackknife, from the figures without each group of seeds.
fn over_groups([own, base]: [(&Row, f64); 2], of: Replicates) -> Option<[f64; 2]> {
    let (a, b) = (own.0.jackknife.as_ref()?, base.0.jackknife.as_ref()?);
    let (own, base) = (Figure { all: own.1, replicates: of(a) }, Figure { all: base.1, replicates: of(b) });
    (a.seeds == b.seeds).then(|| jackknife::ratio(own, base, &a.seeds))?
}

/// The ratios of times, taken in each round. A group of passes without a ratio is added to `left_out`.
pub fn overhead(rows: &[Row], baseline: &str, left_out: &mut Vec<MissingRatio>) -> Vec<Overhead> {
    let mut found = Vec::new();
    for (row, base) in peers(rows, baseline) {
        for group in row.ms.keys() {
            let rounds = row.rounds.ms.iter().zip(&base.rounds.ms);
            let mut ratios: Vec<f64> = rounds
                .filter_map(|(own, theirs)| Some(own.get(group)? / theirs.get(group)?))
                .filter(|r| r.is_finite() && *r > 0.0)
                .collect();
            if ratios.is_empty() {
                let medians = quotient(row.ms.get(group).copied(), base.ms.get(group).copied());
                let why = medians.err().unwrap_or("no round has both times");
                left_out.push(MissingRatio::of(row, format!("ms_{group}"), why));
                continue;
            }
            ratios.sort_by(f64::total_cmp);
            let [low, median, high] = quartiles(&ratios);
            found.push(Overhead {
                method: row.method.clone(),
                spp: row.spp,
                fallback: row.fallback.clone(),
                group: group.clone(),
                median,
                quartiles: [low, high],
            });
        }
    }
    found
}

/// The first quartile, the median and the third quartile of sorted values, linear between neighbours (R's type 7). They
/// are 0 where there are no values.
pub fn quartiles(sorted: &[f64]) -> [f64; 3] {
    [0.25, 0.5, 0.75].map(|p| {
        let at = p * sorted.len().saturating_sub(1) as f64;
        let (below, above) = (at.floor() as usize, at.ceil() as usize);
        match (sorted.get(below), sorted.get(above)) {
            (Some(a), Some(b)) => a + (at - at.floor()) * (b - a),
            _ => 0.0,
        }
    })
}

/// The ratio mean(a) / mean(b) of values that belong together in pairs, and its 95 % interval by Student's t on the
/// logarithm.
///
/// The logarithm is linearised: each pair moves ln(mean a / mean b) by (a_i/mean(a) − b_i/mean(b)) / n. So the spread
/// of these differences gives the interval, and the luck of a seed that both share cancels.
fn ratio_of_means(a: &[f64], b: &[f64]) -> (Option<f64>, Option<[f64; 2]>) {
    let (Some(mean_a), Some(mean_b)) = (mean(a), mean(b)) else { return (None, None) };
    let log = (mean_a / mean_b).ln();
    let influences: Vec<f64> = a.iter().zip(b).map(|(a, b)| log + a / mean_a - b / mean_b).collect();
    geometric(&influences)
}

fn mean(values: &[f64]) -> Option<f64> {
    crate::metrics::mean(values.iter().copied())
}

/// The geometric mean and its 95 % interval by Student's t, from logarithms. The interval needs at least two values.
pub fn geometric(logs: &[f64]) -> (Option<f64>, Option<[f64; 2]>) {
    let Some(mean) = mean(logs).filter(|m| m.is_finite()) else { return (None, None) };
    let i = student_t(logs, 0.95);
    (Some(mean.exp()), i.lo.zip(i.hi).map(|(lo, hi)| [lo.exp(), hi.exp()]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_rs_type_7() {
        // R: quantile(c(1, 2, 4, 8), c(.25, .5, .75))
        assert_eq!(quartiles(&[1.0, 2.0, 4.0, 8.0]), [1.75, 3.0, 5.0]);
        assert_eq!(quartiles(&[3.0]), [3.0; 3]);
    }

    #[test]
    fn a_ratio_of_means_knows_what_seeds_share() {
        // Where one value is half of the other with every seed, the interval has no width. Where they are unrelated it
        // is wide.
        let theirs = [1.0, 2.0, 9.0, 4.0];
        let (ratio, interval) = ratio_of_means(&theirs.map(|v| v / 2.0), &theirs);
        assert!((ratio.expect("four") - 0.5).abs() < 1e-12);
        let [lo, hi] = interval.expect("four");
        assert!((hi - lo).abs() < 1e-9);
        let (ratio, interval) = ratio_of_means(&[4.5, 1.0, 0.5, 2.0], &theirs);
        assert!((ratio.expect("four") - 0.5).abs() < 1e-12);
        let [lo, hi] = interval.expect("four");
        assert!(lo < 0.2 && hi > 1.0);
    }

    #[test]
    fn what_has_no_ratio_says_why() {
        assert_eq!(quotient(Some(1.0), Some(4.0)), Ok(0.25));
        for (own, base, why) in [
            (None, Some(1.0), "undefined"),
            (Some(1.0), Some(0.0), "nothing to divide by"),
            (Some(0.0), Some(0.0), "nothing to divide by"),
            (Some(0.0), Some(1.0), "no logarithm"),
            (Some(-1.0), Some(1.0), "below 0"),
            (Some(1.0), Some(-1.0), "below 0"),
            (Some(f64::INFINITY), Some(1.0), "not finite"),
        ] {
            let found = quotient(own, base).expect_err("no ratio");
            assert!(found.contains(why), "{own:?} / {base:?}: {found}");
        }
    }

    #[test]
    fn geometric_means_have_intervals_from_two_on() {
        let (mean, interval) = geometric(&[2.0f64.ln(), 8.0f64.ln()]);
        assert!((mean.expect("two") - 4.0).abs() < 1e-12);
        let [lo, hi] = interval.expect("two");
        assert!(lo < 1.0 && hi > 16.0);
        assert_eq!(geometric(&[0.0]), (Some(1.0), None));
        assert_eq!(geometric(&[f64::INFINITY]).0, None);
    }
}
