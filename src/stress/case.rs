//! A hazard as data, and how it is judged. A [`Case`] says what is measured, in which unit, and by which bound. [`run`]
//! takes a case and gives its [`Outcome`]; the command `stress` calls it.

use std::time::Instant;

use crate::render::RenderError;

use super::bench::Bench;

/// The bound of a measured value. NaN is never within it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    AtMost(f64),
    AtLeast(f64),
}

impl Bound {
    /// Whether a value is within the bound.
    pub fn holds(self, value: f64) -> bool {
        match self {
            Bound::AtMost(most) => value <= most,
            Bound::AtLeast(least) => value >= least,
        }
    }

    /// The number of the bound.
    pub fn limit(self) -> f64 {
        match self {
            Bound::AtMost(limit) | Bound::AtLeast(limit) => limit,
        }
    }

    /// A bound of the same kind with another number.
    pub fn with_limit(self, limit: f64) -> Bound {
        match self {
            Bound::AtMost(_) => Bound::AtMost(limit),
            Bound::AtLeast(_) => Bound::AtLeast(limit),
        }
    }
}

impl std::fmt::Display for Bound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let sign = if matches!(self, Bound::AtMost(_)) { '≤' } else { '≥' };
        write!(f, "{sign} {}", self.limit())
    }
}

/// A hazard, and how it is checked.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// A short name that no other case has: words joined by `-`.
    pub name: &'static str,
    /// What could go wrong.
    pub hazard: &'static str,
    /// What is measured.
    pub checks: &'static str,
    /// The unit of the measured value.
    pub unit: &'static str,
    pub bound: Bound,
    /// Renders and measures, and returns the worst value of all.
    pub run: fn(&mut Bench) -> Result<Worst, RenderError>,
}

/// The worst value so far, and where it was.
#[derive(Debug, Clone, PartialEq)]
pub struct Worst {
    pub value: f64,
    pub at: String,
    larger_is_worse: bool,
}

impl Worst {
    /// For values that must stay small.
    pub fn largest() -> Worst {
        Worst { value: f64::NEG_INFINITY, at: "nothing was measured".to_owned(), larger_is_worse: true }
    }

    /// For values that must stay large.
    pub fn smallest() -> Worst {
        Worst { value: f64::INFINITY, larger_is_worse: false, ..Worst::largest() }
    }

    /// Takes a value into account. NaN is worse than any number.
    pub fn include(&mut self, value: f64, at: impl Into<String>) {
        let at = at.into();
        tracing::debug!("{value:.4} at {at}");
        let worse = if self.larger_is_worse { value > self.value } else { value < self.value };
        if worse || value.is_nan() && !self.value.is_nan() {
            self.value = value;
            self.at = at;
        }
    }

    /// Whether nothing was measured. Such a case has not passed.
    fn is_empty(&self) -> bool {
        self.value == if self.larger_is_worse { f64::NEG_INFINITY } else { f64::INFINITY }
    }
}

/// The outcome of a case.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Outcome {
    pub name: &'static str,
    pub hazard: &'static str,
    pub checks: &'static str,
    pub passed: bool,
    /// The worst value. Null where nothing could be measured or where it is not finite.
    pub worst: Option<f64>,
    pub bound: Bound,
    pub unit: &'static str,
    /// Where the worst value was.
    pub at: String,
    /// Why the case failed, if it is not because of its bound.
    pub error: Option<String>,
    pub seconds: f64,
}

/// Runs a case. To pass, its worst value must be within the bound, its pictures must be finite, and the validation
/// layer must have given no message.
///
/// # Errors
/// Ctrl-C only. Any other error makes a failed outcome.
pub fn run(case: &Case, bench: &mut Bench) -> Result<Outcome, RenderError> {
    let start = Instant::now();
    bench.forget();
    let measured = match (case.run)(bench) {
        Err(stop @ RenderError::Interrupted(_)) => return Err(stop),
        measured => measured.and_then(|worst| Ok(bench.gpu().check_validation().map(|()| worst)?)),
    };
    let not_finite = bench.not_finite();
    let (worst, at, error) = match measured {
        Err(error) => (None, String::new(), Some(error.to_string())),
        Ok(worst) => {
            let error = match &not_finite {
                Some(rendered) => {
                    Some(format!("{} values of `{}` are not finite", rendered.not_finite, rendered.label))
                }
                None => worst.is_empty().then(|| "the case measured nothing".to_owned()),
            };
            (Some(worst.value), worst.at, error)
        }
    };
    Ok(Outcome {
        name: case.name,
        hazard: case.hazard,
        checks: case.checks,
        passed: error.is_none() && worst.is_some_and(|w| case.bound.holds(w)),
        worst: worst.filter(|w| w.is_finite()),
        bound: case.bound,
        unit: case.unit,
        at,
        error,
        seconds: start.elapsed().as_secs_f64(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_or_not_and_never_for_nan() {
        assert!(Bound::AtMost(1.0).holds(1.0) && !Bound::AtMost(1.0).holds(1.1));
        assert!(Bound::AtLeast(1.0).holds(1.0) && !Bound::AtLeast(1.0).holds(0.9));
        assert!(!Bound::AtMost(1.0).holds(f64::NAN) && !Bound::AtLeast(1.0).holds(f64::NAN));
        assert_eq!(Bound::AtLeast(1.0).with_limit(2.0).to_string(), "≥ 2");
    }

    #[test]
    fn the_worst_is_kept_and_nan_is_worst() {
        let mut worst = Worst::largest();
        assert!(worst.is_empty());
        for (value, at) in [(1.0, "a"), (3.0, "b"), (2.0, "c")] {
            worst.include(value, at);
        }
        assert_eq!((worst.value, worst.at.as_str(), worst.is_empty()), (3.0, "b", false));
        worst.include(f64::NAN, "d");
        worst.include(9.0, "e");
        assert!(worst.value.is_nan() && worst.at == "d");
        let mut least = Worst::smallest();
        least.include(1.0, "a");
        least.include(2.0, "b");
        assert_eq!(least.at, "a");
    }
}
