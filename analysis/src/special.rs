//! Distribution functions whose tails stay accurate far out, quantiles, and compensated sums.
//!
//! Tails are computed as tails (`erfc`, the regularised upper functions), never as `1 − cdf`, so
//! that the normal upper tail at z = 37 is 5.725571e-300 and not 0. Quantiles are refined on the
//! distribution function itself until the last bits, because published starting formulas stop at
//! about 1e-9.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use statrs::function::beta::beta_reg;
use statrs::function::gamma::gamma_ur;

/// P(Z ≥ z) of the standard normal distribution: ½·erfc(z/√2).
///
/// ```
/// let p = cyclopean_analysis::special::normal_upper(37.0);
/// // R 4.2.2: pnorm(37, lower.tail = FALSE)
/// assert!((p / 5.725571222524576e-300 - 1.0).abs() < 1e-12);
/// ```
pub fn normal_upper(z: f64) -> f64 {
    0.5 * libm::erfc(z * FRAC_1_SQRT_2)
}

/// 2·P(Z ≥ |z|), never more than 1.
pub fn normal_two_sided(z: f64) -> f64 {
    libm::erfc(z.abs() * FRAC_1_SQRT_2)
}

/// The z with P(Z ≤ z) = `p`, for 0 < p < 1; infinite at the ends.
///
/// ```
/// let z = cyclopean_analysis::special::normal_quantile(0.95);
/// assert!((z - 1.644853626951472).abs() < 1e-14); // R 4.2.2: qnorm(0.95)
/// ```
pub fn normal_quantile(p: f64) -> f64 {
    if p <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if p >= 1.0 {
        return f64::INFINITY;
    }
    if p > 0.5 {
        // 1 − p is exact for p in [½, 1], and the lower tail keeps its relative precision.
        return -normal_quantile(1.0 - p);
    }
    // Abramowitz and Stegun 26.2.23 as a start (absolute error 4.5e-4), then Halley's steps.
    let t = (-2.0 * p.ln()).sqrt();
    let mut z = -(t
        - (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308))));
    for _ in 0..4 {
        let density = (-0.5 * z * z).exp() / (2.0 * PI).sqrt();
        if density == 0.0 {
            break;
        }
        let error = (normal_upper(-z) - p) / density;
        z -= error / (1.0 + 0.5 * z * error);
    }
    z
}

/// P(χ² ≥ x) with `df` degrees of freedom.
pub fn chi_squared_upper(x: f64, df: f64) -> f64 {
    if x <= 0.0 { 1.0 } else { gamma_ur(0.5 * df, 0.5 * x) }
}

/// P(T ≥ t) of Student's distribution with `df` degrees of freedom.
pub fn student_upper(t: f64, df: f64) -> f64 {
    let tail = 0.5 * beta_reg(0.5 * df, 0.5, df / (df + t * t));
    if t >= 0.0 { tail } else { 1.0 - tail }
}

/// The t with P(T ≤ t) = `p` of Student's distribution.
pub fn student_quantile(p: f64, df: f64) -> f64 {
    if p == 0.5 {
        return 0.0;
    }
    if p < 0.5 {
        return -student_quantile_upper(p, df);
    }
    student_quantile_upper(1.0 - p, df)
}

/// The t ≥ 0 with P(T ≥ t) = `tail`, tail < ½. Bisection in the exponent is monotone and needs no starting value.
fn student_quantile_upper(tail: f64, df: f64) -> f64 {
    let mut hi = 1.0;
    while student_upper(hi, df) > tail && hi < 1e300 {
        hi *= 2.0;
    }
    bisect(0.0, hi, |t| student_upper(t, df) > tail)
}

/// P(X ≤ x) of the beta distribution with shapes `a`, `b`.
pub fn beta_lower(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        0.0
    } else if x >= 1.0 {
        1.0
    } else {
        beta_reg(a, b, x)
    }
}

/// The x with P(X ≤ x) = `p` of the beta distribution with shapes `a`, `b` > 0.
pub fn beta_quantile(p: f64, a: f64, b: f64) -> f64 {
    bisect(0.0, 1.0, |x| beta_lower(x, a, b) < p)
}

/// Where `below` turns from true to false between `lo` and `hi`, to the last bit.
fn bisect(mut lo: f64, mut hi: f64, below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..2000 {
        let middle = lo + 0.5 * (hi - lo);
        if middle <= lo || middle >= hi {
            break;
        }
        if below(middle) {
            lo = middle;
        } else {
            hi = middle;
        }
    }
    lo + 0.5 * (hi - lo)
}

/// Natural logarithm of the binomial coefficient "n over k".
pub fn ln_choose(n: u64, k: u64) -> f64 {
    libm::lgamma(n as f64 + 1.0) - libm::lgamma(k as f64 + 1.0) - libm::lgamma((n - k) as f64 + 1.0)
}

/// A sum that keeps the low bits that rounding loses (Neumaier's variant of Kahan's summation).
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum {
    total: f64,
    lost: f64,
}

impl Sum {
    /// Adds one term.
    pub fn add(&mut self, x: f64) {
        let t = self.total + x;
        self.lost += if self.total.abs() >= x.abs() { (self.total - t) + x } else { (x - t) + self.total };
        self.total = t;
    }

    /// The sum so far.
    pub fn value(self) -> f64 {
        self.total + self.lost
    }
}

/// Compensated sum of all terms.
pub fn sum(terms: impl IntoIterator<Item = f64>) -> f64 {
    let mut s = Sum::default();
    for x in terms {
        s.add(x);
    }
    s.value()
}

/// Mean and standard deviation (n − 1) in two passes; the deviation is `None` for fewer than two values.
///
/// ```
/// let (mean, sd) = cyclopean_analysis::special::mean_sd(&[1e9 + 1.0, 1e9 + 2.0, 1e9 + 3.0]);
/// assert_eq!((mean, sd), (1e9 + 2.0, Some(1.0)));
/// ```
pub fn mean_sd(x: &[f64]) -> (f64, Option<f64>) {
    let n = x.len() as f64;
    // Shifted by the first value, so that the mean of ratings with a large offset keeps its bits.
    let shift = x.first().copied().unwrap_or(f64::NAN);
    let offset = sum(x.iter().map(|v| v - shift)) / n;
    let mean = shift + offset;
    if x.len() < 2 {
        return (mean, None);
    }
    let squares = sum(x.iter().map(|v| (v - shift - offset).powi(2)));
    let rest = sum(x.iter().map(|v| v - shift - offset));
    let variance = (squares - rest * rest / n) / (n - 1.0);
    (mean, Some(variance.max(0.0).sqrt()))
}

/// A p-value as text for readers: never "0", but "< 1e-300" where it underflows.
pub fn p_text(p: f64) -> String {
    if p < 1e-300 {
        "< 1e-300".into()
    } else if p < 1e-4 {
        format!("{p:.3e}")
    } else {
        format!("{p:.4}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_agree_with_r() {
        // R 4.2.2: qt(0.95, 9), qt(0.975, 14), qbeta(0.05, 30, 10), qnorm(1e-20)
        for (got, want) in [
            (student_quantile(0.95, 9.0), 1.833_112_932_656_237),
            (student_quantile(0.975, 14.0), 2.144_786_687_916_927_6),
            (normal_quantile(1e-20), -9.262_340_089_798_408),
            (normal_quantile(0.975), 1.959_963_984_540_054),
        ] {
            assert!((got / want - 1.0).abs() < 1e-12, "{got} {want}");
        }
        // All votes at the top have a closed form: Clopper–Pearson's lower bound at k = N is (α/2)^{1/N}.
        assert!((beta_quantile(0.05, 40.0, 1.0) - 0.05f64.powf(1.0 / 40.0)).abs() < 1e-14);
    }

    #[test]
    fn a_large_offset_does_not_cost_the_variance() {
        let small = [1.0, 2.0, 2.0, 3.0, 5.0, 4.0];
        let large: Vec<f64> = small.iter().map(|v| v + 1e9).collect();
        let (a, b) = (mean_sd(&small).1.unwrap(), mean_sd(&large).1.unwrap());
        assert!((a / b - 1.0).abs() < 1e-12);
    }

    #[test]
    fn p_is_never_printed_as_zero() {
        assert_eq!(p_text(0.0), "< 1e-300");
        assert_eq!(p_text(0.0123), "0.0123");
    }
}
