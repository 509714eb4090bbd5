//! Ratings as exact decimals, so that equal differences are equal.

use std::fmt;

/// A rating in millionths of a scale step: sums and differences are exact, and so are ties.
///
/// 0.825 − 0.775 and 0.5 − 0.45 differ in floating point, and the tie between them is lost: SciPy's
/// own documentation shows p = 0.5625 where 0.5 is right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Score(pub i64);

/// Millionths in a step.
pub const UNIT: i64 = 1_000_000;
/// Largest magnitude of a rating, in steps.
pub const LARGEST: i64 = 2_000_000_000;

impl Score {
    /// Reads a decimal number such as `4`, `-1`, `3.25` or `1e-2`; digits beyond the sixth decimal are rounded.
    ///
    /// # Errors
    /// A sentence: not a number, not finite, or beyond ±2·10⁹.
    ///
    /// ```
    /// use cyclopean_analysis::data::Score;
    /// assert_eq!(Score::parse(b"3.25").unwrap(), Score(3_250_000));
    /// assert!(Score::parse(b"inf").unwrap_err().contains("finite"));
    /// ```
    pub fn parse(text: &[u8]) -> Result<Self, String> {
        // One digit is what nearly every rating is.
        if let [d @ b'0'..=b'9'] = text {
            return Ok(Self(i64::from(d - b'0') * UNIT));
        }
        let shown = || String::from_utf8_lossy(text).into_owned();
        let value: f64 = std::str::from_utf8(text)
            .ok()
            .and_then(|t| t.trim().parse().ok())
            .ok_or_else(|| format!("`{}` is not a number, such as 4 or 3.5", shown()))?;
        if !value.is_finite() {
            return Err(format!("`{}` is not a finite number", shown()));
        }
        if value.abs() > LARGEST as f64 {
            return Err(format!("`{}` is beyond ±2·10⁹", shown()));
        }
        Ok(Self((value * UNIT as f64).round() as i64))
    }

    /// A whole number of steps.
    pub fn whole(steps: i32) -> Self {
        Self(i64::from(steps) * UNIT)
    }

    /// In steps.
    pub fn value(self) -> f64 {
        self.0 as f64 / UNIT as f64
    }
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.value())
    }
}
