//! Wilcoxon's signed-rank test of paired differences: exact with ties and zeros, asymptotic, mid-p.
//!
//! d_i = x_i − y_i; r are the mid-ranks of |d|; R₊ = Σ r\[d > 0\], R₋ = Σ r\[d < 0\]. Statistics programs follow
//! different conventions and so print different numbers; each result here states the convention that made it. Sources:
//! Wilcoxon 1945; Pratt 1959 (zeros); Streitberg and Röhmel 1986 (exact with ties); Hodges and Lehmann 1963; Kerby 2014
//! (rank-biserial).

mod asymptotic;
mod exact;
mod ranks;
mod shift;

use serde::Serialize;

pub use asymptotic::moments;
pub use exact::{Tails, tails};
pub use ranks::Ranks;
pub use shift::{Shift, hodges_lehmann};

use crate::error::{Error, Result};
use crate::special::{normal_quantile, p_text};

/// What happens to pairs without a difference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Zeros {
    /// Dropped before ranking (Wilcoxon 1945; R's and SciPy's default).
    #[default]
    Wilcox,
    /// Ranked with the others, then their ranks are left out (Pratt 1959).
    Pratt,
    /// Ranked, and half of their ranks goes to each side: SciPy's rule, which overstates the variance.
    Zsplit,
}

/// The hypothesis against which the null is tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Alternative {
    /// The differences are not symmetric about zero.
    #[default]
    TwoSided,
    /// x tends to exceed y.
    Greater,
    /// x tends to fall short of y.
    Less,
}

/// When the exact null is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Exact {
    /// Up to [`EXACT_UP_TO`] ranked differences.
    #[default]
    Auto,
    /// At any number of differences; takes O(n³) time.
    Always,
    /// Never.
    Never,
}

/// Ranked differences up to which [`Exact::Auto`] computes the exact null.
pub const EXACT_UP_TO: usize = 500;

/// Largest number of ranks for which the exact null is computed at all: its buffers take up to 12·n² bytes.
pub const EXACT_LIMIT: usize = 10_000;

/// Choices of the test; the default is exact where feasible, zeros dropped, no correction, two-sided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Rule for zero differences.
    pub zeros: Zeros,
    /// Continuity correction of the asymptotic z by half a rank.
    pub correction: bool,
    /// The alternative hypothesis.
    pub alternative: Alternative,
    /// When to compute the exact null.
    pub exact: Exact,
    /// Level of the intervals of the effect sizes, in (0, 1).
    pub level: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            zeros: Zeros::default(),
            correction: false,
            alternative: Alternative::default(),
            exact: Exact::default(),
            level: 0.95,
        }
    }
}

/// The result, with everything that exists and `None` for what does not.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SignedRank {
    /// Pairs.
    pub n: usize,
    /// Pairs without a difference.
    pub n_zero: usize,
    /// Number of ranks in the statistic.
    pub n_used: usize,
    /// Sum of the positive ranks (under `zsplit` with half of the zeros' ranks).
    pub r_plus: f64,
    /// Sum of the negative ranks.
    pub r_minus: f64,
    /// min(R₊, R₋) for a two-sided test and R₊ for a one-sided one, as SciPy reports it.
    pub statistic: f64,
    /// T = min(R₊, R₋), whatever the alternative.
    pub t: f64,
    /// The signed z: positive when R₊ is above its mean. `None` without differences.
    pub z: Option<f64>,
    /// p-value from the normal approximation; 1 without differences. No p-value here is 0: one that is too small for a
    /// number is given as the smallest normal number, 2.2e-308.
    pub p_asymptotic: Option<f64>,
    /// p-value from the conditional null distribution given |d|; `None` when not computed.
    pub p_exact: Option<f64>,
    /// Exact mid-p; `None` when not computed.
    pub p_mid: Option<f64>,
    /// (R₊ − R₋)/(R₊ + R₋) on `wilcox` ranks.
    pub rank_biserial: Option<f64>,
    /// Interval of the rank-biserial by Fisher's z with SE √((2n³+3n²+n)/6)/((n²+n)/2).
    pub rank_biserial_lo: Option<f64>,
    /// Its upper end.
    pub rank_biserial_hi: Option<f64>,
    /// z/√N.
    pub effect_r: Option<f64>,
    /// The N of `effect_r`: the ranks in the statistic.
    pub effect_r_n: usize,
    /// Hodges–Lehmann estimate of the shift.
    pub hodges_lehmann: Option<f64>,
    /// Lower end of its interval.
    pub hodges_lehmann_lo: Option<f64>,
    /// Upper end of its interval.
    pub hodges_lehmann_hi: Option<f64>,
    /// Requested level of the intervals.
    pub level: f64,
    /// Level that the Hodges–Lehmann interval achieves under the null distribution without ties.
    pub hodges_lehmann_level: Option<f64>,
    /// The alternative, zero rule, correction and null distribution in words.
    pub convention: String,
    /// Remarks on these data that a reader of the numbers needs.
    pub notes: Vec<String>,
}

impl SignedRank {
    /// The p-value to judge by: exact where it exists, else asymptotic.
    pub fn p(&self) -> f64 {
        self.p_exact.or(self.p_asymptotic).unwrap_or(1.0)
    }
}

/// Tests the differences `d`.
///
/// # Errors
/// [`Error::Data`] when there is no pair at all, or a difference is not finite (its 1-based number is
/// named). [`Error::Usage`] when the level is outside (0, 1) or the exact null is demanded for more than
/// [`EXACT_LIMIT`] ranks.
///
/// ```
/// use cyclopean_analysis::wilcoxon::{Options, signed_rank};
/// // Wilcoxon's corn data, scipy 1.17.1: wilcoxon(d, method="exact") → statistic 24, p 0.041259765625
/// let d = [6., 8., 14., 16., 23., 24., 28., 29., 41., -48., 49., 56., 60., -67., 75.];
/// let r = signed_rank(&d, &Options::default())?;
/// assert_eq!((r.statistic, r.p_exact), (24.0, Some(0.041259765625)));
/// # Ok::<(), cyclopean_analysis::Error>(())
/// ```
pub fn signed_rank(d: &[f64], options: &Options) -> Result<SignedRank> {
    check(d, options)?;
    let ranks = Ranks::new(d, options.zeros);
    let half_zeros = if options.zeros == Zeros::Zsplit { 0.25 * ranks.zero_sum as f64 } else { 0.0 };
    let r_plus = 0.5 * ranks.plus() as f64 + half_zeros;
    let r_minus = 0.5 * ranks.minus() as f64 + half_zeros;
    let t = r_plus.min(r_minus);
    let nonzero = ranks.signed.len();
    let n_used = if options.zeros == Zeros::Zsplit { d.len() } else { nonzero };
    let mut notes = Vec::new();
    let (z, p_asymptotic) = if nonzero == 0 {
        notes.push("no differences: every pair is equal, so p = 1 and z is undefined".to_owned());
        (None, Some(1.0))
    } else {
        asymptotic::z_and_p(r_plus, moments(&ranks, options.zeros), options.correction, options.alternative).unzip()
    };
    let exact = exact_tails(&ranks, options)?;
    let pick = |lower: f64, upper: f64, two: f64| match options.alternative {
        Alternative::TwoSided => two,
        Alternative::Greater => upper,
        Alternative::Less => lower,
    };
    let p_exact = exact.map(|e| pick(e.lower, e.upper, e.two_sided()));
    // Without differences the whole distribution is one point, and mid-p would count half of it; p is 1.
    let p_mid = exact.map(|e| match nonzero {
        0 => 1.0,
        _ => pick(e.lower - 0.5 * e.point, e.upper - 0.5 * e.point, e.two_sided_mid()),
    });
    let biserial = rank_biserial(d, options.level);
    let shift = hodges_lehmann(d, options.level);
    if nonzero > 0 && exact.is_none() && options.exact == Exact::Auto {
        notes.push(format!(
            "exact p not computed: {nonzero} ranked differences are more than {EXACT_UP_TO}; --exact always computes it"
        ));
    }
    if shift.lo.is_none() && d.len() < 64 {
        notes.push(format!(
            "no interval for the shift: {} pairs cannot reach {}: the smallest two-sided p is {}",
            d.len(),
            percent(options.level),
            p_text(2.0 * 0.5f64.powi(d.len() as i32))
        ));
    } else if !ranks.ties.is_empty() || ranks.zeros > 0 {
        notes.push(
            "the shift's interval comes from the untied null: with ties it is conservative and may disagree with the test"
                .to_owned(),
        );
    }
    Ok(SignedRank {
        n: d.len(),
        n_zero: ranks.zeros as usize,
        n_used,
        r_plus,
        r_minus,
        statistic: if options.alternative == Alternative::TwoSided { t } else { r_plus },
        t,
        z,
        p_asymptotic,
        p_exact,
        p_mid,
        rank_biserial: biserial.map(|b| b.0),
        rank_biserial_lo: biserial.and_then(|b| b.1),
        rank_biserial_hi: biserial.and_then(|b| b.2),
        effect_r: z.map(|z| z / (n_used as f64).sqrt()),
        effect_r_n: n_used,
        hodges_lehmann: Some(shift.estimate),
        hodges_lehmann_lo: shift.lo,
        hodges_lehmann_hi: shift.hi,
        level: options.level,
        hodges_lehmann_level: shift.achieved,
        convention: convention(options),
        notes,
    })
}

fn check(d: &[f64], options: &Options) -> Result<()> {
    if d.is_empty() {
        return Err(Error::data("no pairs: the signed-rank test needs at least one difference"));
    }
    if let Some(i) = d.iter().position(|v| !v.is_finite()) {
        return Err(Error::data(format!(
            "difference {} of {} is {}: scores must be finite numbers",
            i + 1,
            d.len(),
            d[i]
        )));
    }
    if !(options.level > 0.0 && options.level < 1.0) {
        return Err(Error::usage(format!("level {} is not between 0 and 1, for example 0.95", options.level)));
    }
    Ok(())
}

fn exact_tails(ranks: &Ranks, options: &Options) -> Result<Option<Tails>> {
    let n = ranks.signed.len();
    let wanted = match options.exact {
        Exact::Never => false,
        Exact::Auto => n <= EXACT_UP_TO,
        Exact::Always if n > EXACT_LIMIT => {
            return Err(Error::usage(format!(
                "the exact null of {n} ranks would take {:.1} GiB; up to {EXACT_LIMIT} ranks can be had, use --exact auto",
                (n as f64).powi(2) * 12.0 / (1u64 << 30) as f64
            )));
        }
        Exact::Always => true,
    };
    Ok(wanted.then(|| {
        let doubled: Vec<u64> = ranks.signed.iter().map(|r| r.0).collect();
        tails(&doubled, ranks.plus())
    }))
}

/// Rank-biserial on `wilcox` ranks with its interval; `None` without differences.
fn rank_biserial(d: &[f64], level: f64) -> Option<(f64, Option<f64>, Option<f64>)> {
    let ranks = Ranks::new(d, Zeros::Wilcox);
    let (plus, minus) = (ranks.plus() as f64, ranks.minus() as f64);
    if plus + minus == 0.0 {
        return None;
    }
    let r = (plus - minus) / (plus + minus);
    let n = ranks.signed.len() as f64;
    let se = ((2.0 * n.powi(3) + 3.0 * n * n + n) / 6.0).sqrt() / ((n * n + n) / 2.0);
    let reach = normal_quantile(0.5 + 0.5 * level) * se;
    // Fisher's z is infinite at ±1. An interval of width zero would claim certainty, so there is none.
    let ends = (r.abs() < 1.0).then(|| ((r.atanh() - reach).tanh(), (r.atanh() + reach).tanh()));
    Some((r, ends.map(|e| e.0), ends.map(|e| e.1)))
}

/// The choices in words.
pub fn convention(options: &Options) -> String {
    let zeros = match options.zeros {
        Zeros::Wilcox => "zeros dropped before ranking (wilcox)",
        Zeros::Pratt => "zeros ranked, their ranks left out (pratt)",
        Zeros::Zsplit => {
            "zeros ranked, their ranks split between the sides (zsplit: overstates the variance; its exact p is pratt's)"
        }
    };
    let alternative = match options.alternative {
        Alternative::TwoSided => "two-sided; statistic = min(R+, R-)",
        Alternative::Greater => "alternative greater; statistic = R+",
        Alternative::Less => "alternative less; statistic = R+",
    };
    let exact = match options.exact {
        Exact::Never => "exact null not computed",
        _ => "exact p conditional on |d| with mid-ranks",
    };
    let correction = if options.correction { "continuity correction 1/2" } else { "no continuity correction" };
    format!("{alternative}; {zeros}; {exact}; z signed as R+ minus its mean, tie-corrected variance, {correction}")
}

/// "90 %" for 0.9.
pub fn percent(level: f64) -> String {
    let p = (level * 1e6).round() / 1e4;
    format!("{p} %")
}
