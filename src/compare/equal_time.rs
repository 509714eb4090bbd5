//! Errors at equal time: the error of each method beside the error that the baseline would have in the same time. The
//! baseline's error at that time is read from a curve through its measured sample counts. `run` calls it with a scene's
//! rows, and `sequence` uses the [`Curve`].

use super::report::{EqualTime, MissingRatio, Row};

/// The measures that are compared at equal time, in this order.
const MEASURES: [&str; 3] = ["mse", "relmse", "tonemapped_mse"];

/// The errors of each method and of the baseline at the time that the method takes. There is nothing for a fallback
/// with fewer than two sample counts of the baseline. A measure that has no ratio although there are enough sample
/// counts is added to `left_out`.
pub fn equal_time(rows: &[Row], baseline: &str, left_out: &mut Vec<MissingRatio>) -> Vec<EqualTime> {
    let mut found = Vec::new();
    for row in rows.iter().filter(|r| r.method != baseline) {
        let of_baseline = |r: &&Row| r.method == baseline && r.fallback == row.fallback;
        let of_baseline: Vec<&Row> = rows.iter().filter(of_baseline).collect();
        if of_baseline.len() < 2 {
            continue;
        }
        let [mse, relmse, tonemapped_mse] = MEASURES.map(|measure| {
            let both = at_equal_time(row, &of_baseline, measure);
            both.map_err(|why| left_out.push(MissingRatio::of(row, format!("equal_time_{measure}"), why))).ok()
        });
        let Some(mse) = mse else { continue };
        found.push(EqualTime {
            method: row.method.clone(),
            spp: row.spp,
            fallback: row.fallback.clone(),
            ms: mse.ms,
            mse: mse.own,
            baseline_mse: mse.baseline,
            ratio: mse.ratio(),
            relmse: relmse.map(|e| e.own),
            baseline_relmse: relmse.map(|e| e.baseline),
            relmse_ratio: relmse.map(|e| e.ratio()),
            tonemapped_mse: tonemapped_mse.map(|e| e.own),
            baseline_tonemapped_mse: tonemapped_mse.map(|e| e.baseline),
            tonemapped_mse_ratio: tonemapped_mse.map(|e| e.ratio()),
            extrapolated: mse.extrapolated,
        });
    }
    found
}

/// A method's error and the baseline's at the method's time.
#[derive(Debug, Clone, Copy)]
struct ErrorsAtEqualTime {
    ms: f64,
    own: f64,
    baseline: f64,
    extrapolated: bool,
}

impl ErrorsAtEqualTime {
    fn ratio(self) -> f64 {
        self.own / self.baseline
    }
}

/// One measure of one row, or why it cannot be compared.
fn at_equal_time(row: &Row, of_baseline: &[&Row], measure: &str) -> Result<ErrorsAtEqualTime, &'static str> {
    let own = point(row, measure).ok_or("the method's error is 0 or undefined")?;
    let (log_error, extrapolated) = Curve::of(of_baseline, measure)
        .at(own.0)
        .ok_or("the baseline has fewer than two measured points with an error above 0")?;
    Ok(ErrorsAtEqualTime { ms: own.0.exp(), own: own.1.exp(), baseline: log_error.exp(), extrapolated })
}

/// The logarithms of a row's median time for reflections and of its error, which is the mean of the eyes.
fn point(row: &Row, measure: &str) -> Option<(f64, f64)> {
    let point = (row.ms.get("total")?.ln(), row.both(measure)?.ln());
    (point.0.is_finite() && point.1.is_finite()).then_some(point)
}

/// A curve of log error over log time. The points are in order of time.
pub(super) struct Curve(Vec<(f64, f64)>);

impl Curve {
    fn of(rows: &[&Row], measure: &str) -> Curve {
        Curve::new(rows.iter().filter_map(|row| point(row, measure)).collect())
    }

    /// Makes the curve of points (log time, log error) in any order.
    pub(super) fn new(mut points: Vec<(f64, f64)>) -> Curve {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| a.0 == b.0);
        Curve(points)
    }

    /// The log error at a log time, on straight lines between the points. Outside the points the nearest line is
    /// prolonged, and the second value is true. `None` with fewer than two points.
    pub(super) fn at(&self, x: f64) -> Option<(f64, bool)> {
        let (first, last) = (self.0.first()?, self.0.last()?);
        let after = self.0.iter().position(|p| p.0 >= x).unwrap_or(self.0.len() - 1).max(1);
        let (a, b) = (self.0.get(after - 1)?, self.0.get(after)?);
        let y = a.1 + (x - a.0) * (b.1 - a.1) / (b.0 - a.0);
        Some((y, x < first.0 || x > last.0))
    }
}

#[cfg(test)]
mod tests {
    use super::super::sample::row;
    use super::*;

    #[test]
    fn a_line_in_logarithms_is_followed_and_prolonged() {
        // error = 1 / time, measured at 1, 2 and 8 ms.
        let curve = Curve([1.0f64, 2.0, 8.0].map(|t| (t.ln(), -t.ln())).to_vec());
        for (t, outside) in [(1.0, false), (1.5, false), (4.0, false), (8.0, false), (0.5, true), (16.0, true)] {
            let (y, extrapolated) = curve.at(f64::ln(t)).expect("a curve");
            assert!((y + f64::ln(t)).abs() < 1e-12, "at {t}: {y}");
            assert_eq!(extrapolated, outside, "at {t}");
        }
        assert_eq!(Curve(curve.0[..1].to_vec()).at(0.0), None);
    }

    #[test]
    fn every_error_has_its_own_curve() {
        // As the baseline's time doubles, its MSE halves and its relMSE falls to a quarter. The method takes √2 times
        // the baseline's first time.
        let base = |spp: u32, ms: f64, mse: f64, relmse: f64| {
            row("sssr", spp, ms, &[("mse", mse), ("relmse", relmse), ("tonemapped_mse", 0.0)])
        };
        let own = [("mse", 1.0), ("relmse", 1.0), ("tonemapped_mse", 1.0)];
        let rows = [base(1, 1.0, 4.0, 16.0), base(2, 2.0, 2.0, 4.0), row("stereo", 1, 2f64.sqrt(), &own)];
        let mut left_out = Vec::new();
        let found = equal_time(&rows, "sssr", &mut left_out);
        let [e] = found.as_slice() else { panic!("{found:?}") };
        assert!((e.baseline_mse - 8f64.sqrt()).abs() < 1e-12 && (e.ratio - 1.0 / 8f64.sqrt()).abs() < 1e-12, "{e:?}");
        assert!((e.relmse_ratio.expect("a curve") - 1.0 / 8.0).abs() < 1e-12, "{e:?}");
        assert_eq!((e.tonemapped_mse, e.tonemapped_mse_ratio, e.extrapolated), (None, None, false));
        let [left] = left_out.as_slice() else { panic!("{left_out:?}") };
        assert_eq!((left.method.as_str(), left.measure.as_str()), ("stereo", "equal_time_tonemapped_mse"));
        // With one sample count of the baseline there is no curve.
        left_out.clear();
        assert!(equal_time(&rows[1..], "sssr", &mut left_out).is_empty() && left_out.is_empty());
    }
}
