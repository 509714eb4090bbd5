//! Methods over the baseline: at equal samples, at equal time, pass by pass, and over all scenes.

use cyclopean_analysis::interval::student_t;

use super::report::{EqualTime, Overhead, Ratio, Row, SceneReport, Summary};

/// Measures with a value a round; the last two are compared as what they lack of 1.
const BY_ROUND: [(&str, &str); 7] = [
    ("mse", "mse"),
    ("rse", "rse"),
    ("relmse", "relmse"),
    ("flip", "flip"),
    ("reflection_flip", "reflection_flip"),
    ("ssim", "one_minus_ssim"),
    ("reflection_ssim", "one_minus_reflection_ssim"),
];

/// Every method but the baseline, with the baseline's row of as many samples.
fn peers<'a>(rows: &'a [Row], baseline: &str) -> Vec<(&'a Row, &'a Row)> {
    let of_baseline = |row: &Row| rows.iter().find(|b| b.method == baseline && b.is_peer(row));
    rows.iter().filter(|r| r.method != baseline).filter_map(|r| Some((r, of_baseline(r)?))).collect()
}

/// Ratios of error and inconsistency.
pub fn equal_sample(rows: &[Row], baseline: &str) -> Vec<Ratio> {
    let mut ratios = Vec::new();
    for (row, base) in peers(rows, baseline) {
        let mut add = |measure: &'static str, ratio: Option<f64>, interval: Option<[f64; 2]>| {
            if let Some(ratio) = ratio.filter(|r| r.is_finite() && *r > 0.0) {
                let (method, fallback) = (row.method.clone(), row.fallback.clone());
                ratios.push(Ratio { method, spp: row.spp, fallback, measure, ratio, interval });
            }
        };
        for (measure, name) in BY_ROUND {
            let (Some(own), Some(theirs)) = (row.rounds.measures.get(measure), base.rounds.measures.get(measure))
            else {
                continue;
            };
            let error = |v: &f64| if name.starts_with("one_minus") { 1.0 - v } else { *v };
            let (own, theirs): (Vec<f64>, Vec<f64>) =
                (own.iter().map(error).collect(), theirs.iter().map(error).collect());
            let (ratio, interval) = ratio_of_means(&own, &theirs);
            add(name, ratio, interval);
        }
        let both = |f: &dyn Fn(&Row) -> Option<f64>| Some(f(row)? / f(base)?);
        add("bias2", both(&|r| Some(r.left.bias2? + r.right.bias2?)), None);
        add("variance", both(&|r| Some(r.left.variance? + r.right.variance?)), None);
        add("systematic_inconsistency", both(&|r| r.systematic_inconsistency), None);
        add("noise_variance", both(&|r| r.noise_variance), None);
    }
    ratios
}

/// The baseline's error where it takes as long as each method does; empty with fewer than two sample counts of it.
pub fn equal_time(rows: &[Row], baseline: &str) -> Vec<EqualTime> {
    let point = |row: &Row| Some((row.ms.get("total")?.ln(), row.both("mse")?.ln()));
    let mut found = Vec::new();
    for row in rows.iter().filter(|r| r.method != baseline) {
        let of_baseline = rows.iter().filter(|b| b.method == baseline && b.fallback == row.fallback);
        let mut curve: Vec<(f64, f64)> = of_baseline.filter_map(point).filter(finite).collect();
        curve.sort_by(|a, b| a.0.total_cmp(&b.0));
        curve.dedup_by(|a, b| a.0 == b.0);
        let Some(own) = point(row).filter(finite) else { continue };
        let Some((log_mse, extrapolated)) = along(&curve, own.0) else { continue };
        found.push(EqualTime {
            method: row.method.clone(),
            spp: row.spp,
            fallback: row.fallback.clone(),
            ms: own.0.exp(),
            mse: own.1.exp(),
            baseline_mse: log_mse.exp(),
            ratio: (own.1 - log_mse).exp(),
            extrapolated,
        });
    }
    found
}

fn finite(point: &(f64, f64)) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

/// y at x on the line through sorted points, and whether x lies outside them; `None` below two points.
fn along(curve: &[(f64, f64)], x: f64) -> Option<(f64, bool)> {
    let (first, last) = (curve.first()?, curve.last()?);
    let after = curve.iter().position(|p| p.0 >= x).unwrap_or(curve.len() - 1).max(1);
    let (a, b) = (curve.get(after - 1)?, curve.get(after)?);
    let y = a.1 + (x - a.0) * (b.1 - a.1) / (b.0 - a.0);
    Some((y, x < first.0 || x > last.0))
}

/// Ratios of times, round by round.
pub fn overhead(rows: &[Row], baseline: &str) -> Vec<Overhead> {
    let mut found = Vec::new();
    for (row, base) in peers(rows, baseline) {
        for group in row.ms.keys() {
            let rounds = row.rounds.ms.iter().zip(&base.rounds.ms);
            let mut ratios: Vec<f64> = rounds
                .filter_map(|(own, theirs)| Some(own.get(group)? / theirs.get(group)?))
                .filter(|r| r.is_finite() && *r > 0.0)
                .collect();
            if ratios.is_empty() {
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

/// First quartile, median, third quartile of sorted values, linear between neighbours (R's type 7); 0 of none.
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

/// mean(a) / mean(b) of values that belong together in pairs, and the 95 % Student t interval of its logarithm.
///
/// Linearised: ln(mean a / mean b) moves by a_i/mean(a) − b_i/mean(b) over n with each pair, so those differences have
/// its spread, and what both share of a seed's luck cancels.
fn ratio_of_means(a: &[f64], b: &[f64]) -> (Option<f64>, Option<[f64; 2]>) {
    let means = |v: &[f64]| crate::metrics::mean(v.iter().copied());
    let (Some(mean_a), Some(mean_b)) = (means(a), means(b)) else { return (None, None) };
    let log = (mean_a / mean_b).ln();
    let influences: Vec<f64> = a.iter().zip(b).map(|(a, b)| log + a / mean_a - b / mean_b).collect();
    geometric(&influences)
}

/// Geometric mean and the 95 % Student t interval about it, from logarithms; the interval takes two.
fn geometric(logs: &[f64]) -> (Option<f64>, Option<[f64; 2]>) {
    let Some(mean) = crate::metrics::mean(logs.iter().copied()).filter(|m| m.is_finite()) else { return (None, None) };
    let i = student_t(logs, 0.95);
    (Some(mean.exp()), i.lo.zip(i.hi).map(|(lo, hi)| [lo.exp(), hi.exp()]))
}

/// Geometric means over the scenes, each scene one vote.
pub fn over_scenes(scenes: &[SceneReport]) -> Vec<Summary> {
    let mut groups: Vec<(Summary, Vec<f64>)> = Vec::new();
    let mut add = |method: &str, spp: u32, fallback: &str, measure: String, ratio: f64| {
        let same = |s: &Summary| (s.method.as_str(), s.spp, s.fallback.as_str()) == (method, spp, fallback);
        if let Some((summary, logs)) = groups.iter_mut().find(|(s, _)| same(s) && s.measure == measure) {
            summary.worst = summary.worst.max(ratio);
            logs.push(ratio.ln());
            return;
        }
        let (method, fallback) = (method.to_owned(), fallback.to_owned());
        let summary =
            Summary { method, spp, fallback, measure, geomean: ratio, interval: None, worst: ratio, scenes: 0 };
        groups.push((summary, vec![ratio.ln()]));
    };
    for scene in scenes {
        for r in &scene.overhead {
            add(&r.method, r.spp, &r.fallback, format!("ms_{}", r.group), r.median);
        }
        for r in &scene.equal_sample {
            add(&r.method, r.spp, &r.fallback, r.measure.to_owned(), r.ratio);
        }
        for r in &scene.equal_time {
            add(&r.method, r.spp, &r.fallback, "equal_time_mse".to_owned(), r.ratio);
        }
    }
    let finish = |(summary, logs): (Summary, Vec<f64>)| {
        let (mean, interval) = geometric(&logs);
        Summary { geomean: mean.unwrap_or(summary.geomean), interval, scenes: logs.len(), ..summary }
    };
    groups.into_iter().map(finish).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_in_logarithms_is_followed_and_prolonged() {
        // error = 1 / time, measured at 1, 2 and 8 ms.
        let curve: Vec<(f64, f64)> = [1.0f64, 2.0, 8.0].map(|t| (t.ln(), -t.ln())).to_vec();
        for (t, outside) in [(1.0, false), (1.5, false), (4.0, false), (8.0, false), (0.5, true), (16.0, true)] {
            let (y, extrapolated) = along(&curve, f64::ln(t)).expect("a curve");
            assert!((y + f64::ln(t)).abs() < 1e-12, "at {t}: {y}");
            assert_eq!(extrapolated, outside, "at {t}");
        }
        assert_eq!(along(&curve[..1], 0.0), None);
    }

    #[test]
    fn quartiles_are_rs_type_7() {
        // R: quantile(c(1, 2, 4, 8), c(.25, .5, .75))
        assert_eq!(quartiles(&[1.0, 2.0, 4.0, 8.0]), [1.75, 3.0, 5.0]);
        assert_eq!(quartiles(&[3.0]), [3.0; 3]);
    }

    #[test]
    fn a_ratio_of_means_knows_what_seeds_share() {
        // Half of it each time, whatever the seed: no doubt. Unrelated: much.
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
    fn geometric_means_have_intervals_from_two_on() {
        let (mean, interval) = geometric(&[2.0f64.ln(), 8.0f64.ln()]);
        assert!((mean.expect("two") - 4.0).abs() < 1e-12);
        let [lo, hi] = interval.expect("two");
        assert!(lo < 1.0 && hi > 16.0);
        assert_eq!(geometric(&[0.0]), (Some(1.0), None));
        assert_eq!(geometric(&[f64::INFINITY]).0, None);
    }
}
