//! Intervals of a mean vote: Student t, normal, bootstrap, and two under a binomial model.

use serde::Serialize;

use crate::chance::Stream;
use crate::special::{beta_quantile, mean_sd, normal_quantile, normal_upper, student_quantile, sum};

/// How an interval is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// mean ± t(n − 1)·s/√n.
    #[default]
    T,
    /// mean ± z·s/√n.
    Normal,
    /// Percentile bootstrap over participants.
    #[value(alias = "percentile")]
    Bootstrap,
    /// Bias-corrected and accelerated bootstrap over participants.
    Bca,
    /// Clopper–Pearson under a binomial model of the votes.
    ClopperPearson,
    /// Jeffreys under a binomial model of the votes.
    Jeffreys,
}

impl Method {
    /// The method's name in words, for captions.
    pub fn words(self) -> &'static str {
        match self {
            Self::T => "Student t",
            Self::Normal => "normal",
            Self::Bootstrap => "percentile bootstrap over participants",
            Self::Bca => "BCa bootstrap over participants",
            Self::ClopperPearson => "Clopper-Pearson under a binomial model",
            Self::Jeffreys => "Jeffreys under a binomial model",
        }
    }
}

/// Lowest and highest value of a rating scale with steps of one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scale {
    /// The lowest rating.
    pub low: f64,
    /// The highest rating.
    pub high: f64,
}

/// Size and seed of a bootstrap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Bootstrap {
    /// Number of resamples B; 9,999 makes the usual ends whole order statistics.
    pub resamples: u32,
    /// Seed of the stream.
    pub seed: u64,
}

impl Default for Bootstrap {
    fn default() -> Self {
        Self { resamples: 9_999, seed: 1 }
    }
}

/// Both ends, or the reason why there are none, and what a reader must know.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end, in scale steps.
    pub lo: Option<f64>,
    /// Upper end, in scale steps.
    pub hi: Option<f64>,
    /// Why an end is missing, and warnings about these votes.
    pub notes: Vec<String>,
}

impl Interval {
    fn of(lo: f64, hi: f64) -> Self {
        Self { lo: Some(lo), hi: Some(hi), notes: Vec::new() }
    }

    fn none(why: impl Into<String>) -> Self {
        Self { notes: vec![why.into()], ..Self::default() }
    }
}

/// mean ± t·s/√n with t = the (1 + level)/2 quantile of Student's distribution, n − 1 degrees of freedom.
///
/// ```
/// use cyclopean_analysis::interval::student_t;
/// let votes = [2.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 1.0, 1.0, 1.0, 2.0];
/// let i = student_t(&votes, 0.95);
/// // scipy 1.17.1: stats.t.interval(0.95, 14, np.mean(v), stats.sem(v))
/// assert!((i.lo.unwrap() - 1.0631156099279804).abs() < 1e-12);
/// assert!((i.hi.unwrap() - 1.6035510567386861).abs() < 1e-12);
/// ```
pub fn student_t(x: &[f64], level: f64) -> Interval {
    around_mean(x, |df| student_quantile(0.5 + 0.5 * level, df))
}

/// mean ± z·s/√n, too narrow for few votes; for comparison with tools that print it.
pub fn normal(x: &[f64], level: f64) -> Interval {
    around_mean(x, |_| normal_quantile(0.5 + 0.5 * level))
}

fn around_mean(x: &[f64], quantile: impl Fn(f64) -> f64) -> Interval {
    let (mean, sd) = mean_sd(x);
    match sd {
        None => Interval::none("one vote: no interval"),
        Some(sd) => {
            let n = x.len() as f64;
            let reach = quantile(n - 1.0) * sd / n.sqrt();
            Interval::of(mean - reach, mean + reach)
        }
    }
}

/// Interval of the mean when all `n` votes stand at one end of the scale.
///
/// A t interval would have width zero, because s = 0. If a share π of all observers votes at this end, n of n votes
/// there have the probability πⁿ, which is α/2 or more only for π ≥ (α/2)^{1/n}. At worst all others vote K − 1 steps
/// away, so the mean is at least low + (K − 1)·(α/2)^{1/n} (mirrored at the bottom). This is 3.96 for ten fives at 90
/// %.
pub fn unanimous(at: f64, n: usize, scale: Scale, level: f64) -> Option<Interval> {
    let span = scale.high - scale.low;
    let bound = span * (0.5 * (1.0 - level)).powf(1.0 / n as f64);
    if at == scale.high {
        Some(Interval::of(scale.low + bound, scale.high))
    } else if at == scale.low {
        Some(Interval::of(scale.low, scale.high - bound))
    } else {
        None
    }
}

/// Clopper–Pearson or Jeffreys for N = (K − 1)·n trials with k = Σ(y − low) successes (Hoßfeld et al. 2016).
///
/// This is a model. It takes every vote for a binomial draw of K − 1 trials, so it fits only votes that spread no
/// wider; see [`dispersion`].
pub fn binomial_model(x: &[f64], scale: Scale, level: f64, jeffreys: bool) -> Interval {
    let span = scale.high - scale.low;
    let trials = span * x.len() as f64;
    let k = sum(x.iter().map(|v| v - scale.low));
    if x.iter().any(|v| *v < scale.low || *v > scale.high) {
        return Interval::none(format!("votes outside the scale {} to {}: no binomial model", scale.low, scale.high));
    }
    let (lo, hi) = share(k, trials, level, jeffreys);
    Interval::of(scale.low + span * lo, scale.low + span * hi)
}

/// Interval of a share of `k` in `n`, as quantiles of beta distributions.
///
/// Clopper–Pearson: Beta(k, n−k+1) and Beta(k+1, n−k); Jeffreys: both of Beta(k+½, n−k+½), with the lower
/// end 0 at k = 0 and the upper 1 at k = n.
pub fn share(k: f64, n: f64, level: f64, jeffreys: bool) -> (f64, f64) {
    let tail = 0.5 * (1.0 - level);
    let half = if jeffreys { 0.5 } else { 0.0 };
    let lo = if k <= 0.0 { 0.0 } else { beta_quantile(tail, k + half, n - k + 1.0 - half) };
    // The upper end comes from the lower end of the share of failures, whose tail keeps its precision.
    let hi = if k >= n { 1.0 } else { 1.0 - beta_quantile(tail, n - k + half, k + 1.0 - half) };
    (lo, hi)
}

/// Wilson's interval of a share of `k` in `n` with continuity correction (Newcombe 1998, method 4).
pub fn share_wilson(k: f64, n: f64, level: f64) -> (f64, f64) {
    let z = normal_quantile(0.5 + 0.5 * level);
    let (p, q) = (k / n, 1.0 - k / n);
    let denominator = 2.0 * (n + z * z);
    let root = |sign: f64| (z * z - sign * 2.0 - 1.0 / n + 4.0 * p * (n * q + sign)).sqrt();
    let lo = (2.0 * n * p + z * z - 1.0 - z * root(1.0)) / denominator;
    let hi = (2.0 * n * p + z * z + 1.0 + z * root(-1.0)) / denominator;
    (if k == 0.0 { 0.0 } else { lo.max(0.0) }, if k == n { 1.0 } else { hi.min(1.0) })
}

/// s² divided by the variance (K − 1)·p̂·(1 − p̂) of the binomial model. Above 1 the model's interval is too narrow.
pub fn dispersion(x: &[f64], scale: Scale) -> Option<f64> {
    let (mean, sd) = mean_sd(x);
    let span = scale.high - scale.low;
    let p = (mean - scale.low) / span;
    let model = span * p * (1.0 - p);
    (model > 0.0).then(|| sd.map(|s| s * s / model)).flatten()
}

/// Means of `boot.resamples` resamples of whole participants, sorted.
fn resampled(x: &[f64], boot: Bootstrap, purpose: u64) -> Vec<f64> {
    let mut stream = Stream::new(boot.seed, purpose);
    let n = x.len() as u32;
    // The first value is subtracted, so that the means of equal votes are equal to the last bit.
    let shift = x[0];
    let shifted: Vec<f64> = x.iter().map(|v| v - shift).collect();
    let mut means: Vec<f64> = (0..boot.resamples)
        .map(|_| shift + (0..n).map(|_| shifted[stream.index(n) as usize]).sum::<f64>() / f64::from(n))
        .collect();
    means.sort_unstable_by(f64::total_cmp);
    means
}

/// The order statistic (B + 1)·p of sorted resamples, with linear interpolation between neighbours.
fn order_statistic(sorted: &[f64], p: f64) -> f64 {
    let at = ((sorted.len() as f64 + 1.0) * p).clamp(1.0, sorted.len() as f64);
    let below = (at + 1e-9).floor();
    let i = below as usize - 1;
    let next = sorted[(i + 1).min(sorted.len() - 1)];
    sorted[i] + (at - below).max(0.0) * (next - sorted[i])
}

/// Percentile bootstrap of the mean.
pub fn percentile(x: &[f64], level: f64, boot: Bootstrap, purpose: u64) -> Interval {
    if x.len() < 2 {
        return Interval::none("one vote: no interval");
    }
    let means = resampled(x, boot, purpose);
    let tail = 0.5 * (1.0 - level);
    Interval::of(order_statistic(&means, tail), order_statistic(&means, 1.0 - tail))
}

/// BCa bootstrap of the mean (Efron 1987). z₀ counts ties half, and the acceleration comes from the jackknife.
pub fn bca(x: &[f64], level: f64, boot: Bootstrap, purpose: u64) -> Interval {
    if x.len() < 2 {
        return Interval::none("one vote: no interval");
    }
    let (mean, sd) = mean_sd(x);
    if sd == Some(0.0) {
        return Interval::none("BCa undefined: all votes are equal");
    }
    let means = resampled(x, boot, purpose);
    // Means of discrete votes that are equal can differ in their last bits.
    let same = 1e-12 * (1.0 + mean.abs());
    let below = means.partition_point(|m| *m < mean - same) as f64;
    let upto = means.partition_point(|m| *m <= mean + same) as f64;
    let z0 = normal_quantile((below + 0.5 * (upto - below)) / means.len() as f64);
    if !z0.is_finite() {
        return Interval::none("BCa undefined: every resample lies on one side of the mean");
    }
    let (second, third) = (sum(x.iter().map(|v| (v - mean).powi(2))), sum(x.iter().map(|v| (v - mean).powi(3))));
    let acceleration = third / (6.0 * second.powf(1.5));
    let end = |p: f64| {
        let z = z0 + normal_quantile(p);
        let adjusted = z0 + z / (1.0 - acceleration * z);
        (1.0 - acceleration * z > 0.0).then(|| order_statistic(&means, normal_upper(-adjusted)))
    };
    let tail = 0.5 * (1.0 - level);
    match (end(tail), end(1.0 - tail)) {
        (Some(lo), Some(hi)) => Interval::of(lo, hi),
        _ => Interval::none("BCa undefined: the acceleration is too large for this level"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIVE: Scale = Scale { low: 1.0, high: 5.0 };

    #[test]
    fn ten_fives_have_the_honest_bound() {
        let i = unanimous(5.0, 10, FIVE, 0.9).unwrap();
        assert!((i.lo.unwrap() - 3.9645).abs() < 1e-4);
        let bottom = unanimous(1.0, 10, FIVE, 0.9).unwrap();
        assert!((bottom.hi.unwrap() + i.lo.unwrap() - 6.0).abs() < 1e-12);
        assert_eq!(unanimous(3.0, 10, FIVE, 0.9), None);
    }

    #[test]
    fn bootstraps_are_seeded_and_say_when_they_are_undefined() {
        let x = [1.0, 2.0, 2.0, 3.0, 5.0, 4.0, 2.0, 1.0];
        let boot = Bootstrap::default();
        assert_eq!(percentile(&x, 0.9, boot, 0), percentile(&x, 0.9, boot, 0));
        // Means of whole votes are so discrete that two seeds often agree; these are not.
        let y = [1.03, 2.71, 0.33, 4.19, 2.2, 3.1];
        assert_ne!(percentile(&y, 0.9, boot, 0), percentile(&y, 0.9, Bootstrap { seed: 2, ..boot }, 0));
        let (p, b) = (percentile(&x, 0.9, boot, 0), bca(&x, 0.9, boot, 0));
        // The votes lean to the right, so BCa moves both ends up.
        assert!(b.hi.unwrap() > p.hi.unwrap() - 1e-12 && b.lo.unwrap() >= p.lo.unwrap() - 1e-12);
        assert_eq!(bca(&[2.0; 5], 0.9, boot, 0).lo, None);
        assert_eq!(student_t(&[2.0], 0.9).notes, ["one vote: no interval"]);
    }

    #[test]
    fn polarised_votes_are_flagged() {
        let x = [1.0, 1.0, 1.0, 1.0, 2.0, 4.0, 5.0, 5.0, 5.0, 5.0];
        assert!(dispersion(&x, FIVE).unwrap() > 3.0);
        assert!(dispersion(&[2.0, 3.0, 3.0, 4.0], FIVE).unwrap() < 1.0);
    }
}
