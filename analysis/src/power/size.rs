//! The exact rate at which the test rejects for independent votes with two given distributions.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::special::Sum;
use crate::wilcoxon::{Options, signed_rank};

/// Rejection rates over all possible samples, weighted by their probability, so without Monte Carlo error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rejection {
    /// Rate of rejections by the exact test.
    pub exact: f64,
    /// The same by exact mid-p.
    pub mid: f64,
    /// The same by the asymptotic test.
    pub asymptotic: f64,
    /// Mean of the first shape.
    pub mean_a: f64,
    /// Mean of the second.
    pub mean_b: f64,
}

/// How often the two-sided test at `alpha` rejects for `n` people who vote once for a and once for b,
/// independently, with the probabilities `a` and `b` of the ratings 1, 2, ….
///
/// The null hypothesis of the signed-rank test is that the differences are symmetric about 0. Two distributions with
/// the same mean can violate it. The test then rejects more often than α, and it is right to do so: "the mean opinion
/// scores are equal" is another null hypothesis.
///
/// # Errors
/// [`Error::Usage`] when the shapes are no distributions over the same scale, or the samples are too many
/// to enumerate (about 10⁷).
pub fn rejection_of_votes(a: &[f64], b: &[f64], n: u32, alpha: f64) -> Result<Rejection> {
    let proper = |p: &[f64]| p.iter().all(|v| *v >= 0.0) && (p.iter().sum::<f64>() - 1.0).abs() < 1e-9;
    if a.len() != b.len() || a.len() < 2 || !proper(a) || !proper(b) {
        return Err(Error::usage("both shapes need the same number of probabilities, not negative, with sum 1"));
    }
    let k = a.len() as i32;
    let mut differences: Vec<(f64, f64)> = Vec::new();
    for d in 1 - k..k {
        let p: f64 = (0..k).filter(|i| (0..k).contains(&(i - d))).map(|i| a[i as usize] * b[(i - d) as usize]).sum();
        if p > 0.0 {
            differences.push((f64::from(d), p));
        }
    }
    let samples = crate::special::ln_choose(u64::from(n) + differences.len() as u64 - 1, u64::from(n)).exp();
    if n == 0 || samples > 1e7 {
        return Err(Error::usage(format!(
            "{n} people on {k} points have {samples:.0} different samples; up to 1e7 are enumerated"
        )));
    }
    let mut walk = Walk { differences: &differences, alpha, sample: Vec::new(), sums: [Sum::default(); 3] };
    walk.from(0, n, 1.0)?;
    let mean = |p: &[f64]| p.iter().zip(1..).map(|(p, r)| p * f64::from(r)).sum();
    let [exact, mid, asymptotic] = walk.sums.map(Sum::value);
    Ok(Rejection { exact, mid, asymptotic, mean_a: mean(a), mean_b: mean(b) })
}

struct Walk<'a> {
    differences: &'a [(f64, f64)],
    alpha: f64,
    sample: Vec<f64>,
    sums: [Sum; 3],
}

impl Walk<'_> {
    /// Enumerates all ways to give the `left` remaining people differences from index `i` on.
    fn from(&mut self, i: usize, left: u32, weight: f64) -> Result<()> {
        let (d, p) = self.differences[i];
        if i + 1 == self.differences.len() {
            let before = self.sample.len();
            self.sample.resize(before + left as usize, d);
            let test = signed_rank(&self.sample, &Options::default())?;
            let weight = weight * p.powi(left as i32);
            for (sum, p) in self.sums.iter_mut().zip([test.p_exact, test.p_mid, test.p_asymptotic]) {
                if p.is_some_and(|p| p <= self.alpha) {
                    sum.add(weight);
                }
            }
            self.sample.truncate(before);
            return Ok(());
        }
        // `weight` carries the multinomial coefficient: "left choose j" for every j that takes this value.
        let (before, mut w) = (self.sample.len(), weight);
        for j in 0..=left {
            self.from(i + 1, left - j, w)?;
            self.sample.push(d);
            w *= p * f64::from(left - j) / f64::from(j + 1);
        }
        self.sample.truncate(before);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exchangeable_votes_keep_the_level_and_skewed_ones_of_equal_mean_do_not() {
        let p = [0.1, 0.2, 0.4, 0.2, 0.1];
        let same = rejection_of_votes(&p, &p, 8, 0.05).unwrap();
        assert!(same.exact <= 0.05 && same.mid > same.exact, "{same:?}");
        // For a everybody says 3; for b four in five say 3 and the others 5.
        let (a, b) = ([0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.8, 0.0, 0.2]);
        let moved = rejection_of_votes(&a, &b, 6, 0.05).unwrap();
        // All six differences are −2 or 0, and the test rejects only when all six are −2.
        assert!((moved.exact - 0.2f64.powi(6)).abs() < 1e-15, "{moved:?}");
        assert!(rejection_of_votes(&a, &b[..4], 6, 0.05).is_err());
    }
}
