//! How often each kind of interval covers the expected vote, simulated for stated distributions of votes.

use std::collections::HashMap;

use serde::Serialize;

use super::Rate;
use crate::chance::Stream;
use crate::error::{Error, Result};
use crate::interval::{
    Bootstrap, Interval, Method, Scale, bca, binomial_model, normal, percentile, student_t, unanimous,
};

/// A distribution of votes over the observers, for one fixed cell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct VoteShape {
    /// Its name.
    pub name: &'static str,
    /// Probabilities of the ratings 1, 2, ….
    pub p: &'static [f64],
}

/// The shapes of the documented table.
pub fn shapes() -> [VoteShape; 4] {
    [
        VoteShape { name: "middle", p: &[0.05, 0.2, 0.4, 0.25, 0.1] },
        VoteShape { name: "ceiling", p: &[0.0, 0.0, 0.05, 0.2, 0.75] },
        VoteShape { name: "polarised", p: &[0.4, 0.1, 0.0, 0.1, 0.4] },
        VoteShape { name: "K=3", p: &[0.15, 0.25, 0.6] },
    ]
}

/// Coverage of one kind of interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Coverage {
    /// The distribution's name.
    pub shape: &'static str,
    /// Votes per study.
    pub n: u32,
    /// The kind; t and bootstrap use the bound for a unanimous end as tables do.
    pub method: Method,
    /// Share of studies whose interval holds the expected vote; an undefined interval does not.
    pub coverage: Rate,
    /// Mean width of the defined intervals, scale steps.
    pub width: f64,
    /// Share of studies in which all votes are equal.
    pub unanimous: f64,
    /// Share of studies without an interval.
    pub undefined: f64,
}

/// Simulates `studies` studies of `n` single votes from `shape` for every kind of interval.
///
/// # Errors
/// [`Error::Usage`] for fewer than 2 votes or 10 studies.
pub fn coverage(shape: VoteShape, n: u32, studies: u32, level: f64, boot: Bootstrap) -> Result<Vec<Coverage>> {
    if n < 2 || studies < 10 {
        return Err(Error::usage("coverage needs at least 2 votes and 10 studies"));
    }
    let scale = Scale { low: 1.0, high: shape.p.len() as f64 };
    let truth: f64 = shape.p.iter().zip(1..).map(|(p, r)| p * f64::from(r)).sum();
    // Only the counts of a sample matter, and few different counts occur. Intervals are computed once for each.
    let mut samples: HashMap<Vec<u32>, u32> = HashMap::new();
    let mut stream = Stream::new(boot.seed, u64::from(n));
    for _ in 0..studies {
        let mut counts = vec![0; shape.p.len()];
        (0..n).for_each(|_| counts[stream.weighted(shape.p)] += 1);
        *samples.entry(counts).or_default() += 1;
    }
    let methods = [Method::T, Method::Normal, Method::Bootstrap, Method::Bca, Method::ClopperPearson, Method::Jeffreys];
    let mut all_equal = 0;
    let mut covered = [0u32; 6];
    let mut undefined = [0u32; 6];
    let mut width = [0.0; 6];
    for (counts, times) in &samples {
        let x: Vec<f64> =
            counts.iter().zip(1..).flat_map(|(c, r)| std::iter::repeat_n(f64::from(r), *c as usize)).collect();
        let equal = counts.iter().filter(|c| **c > 0).count() == 1;
        all_equal += if equal { *times } else { 0 };
        for (m, method) in methods.iter().enumerate() {
            match interval(*method, &x, equal, scale, level, boot) {
                Interval { lo: Some(lo), hi: Some(hi), .. } => {
                    // Ends that meet the true value up to rounding cover it.
                    covered[m] += if lo <= truth + 1e-9 && truth <= hi + 1e-9 { *times } else { 0 };
                    width[m] += (hi - lo) * f64::from(*times);
                }
                _ => undefined[m] += times,
            }
        }
    }
    Ok(methods
        .iter()
        .enumerate()
        .map(|(m, method)| Coverage {
            shape: shape.name,
            n,
            method: *method,
            coverage: Rate::of(covered[m], studies),
            width: width[m] / f64::from(studies - undefined[m]),
            unanimous: f64::from(all_equal) / f64::from(studies),
            undefined: f64::from(undefined[m]) / f64::from(studies),
        })
        .collect())
}

fn interval(method: Method, x: &[f64], equal: bool, scale: Scale, level: f64, boot: Bootstrap) -> Interval {
    let model = matches!(method, Method::ClopperPearson | Method::Jeffreys);
    if equal
        && !model
        && let Some(bound) = unanimous(x[0], x.len(), scale, level)
    {
        return bound;
    }
    match method {
        Method::T => student_t(x, level),
        Method::Normal => normal(x, level),
        Method::Bootstrap => percentile(x, level, boot, 0),
        Method::Bca => bca(x, level, boot, 0),
        Method::ClopperPearson => binomial_model(x, scale, level, false),
        Method::Jeffreys => binomial_model(x, scale, level, true),
    }
}
