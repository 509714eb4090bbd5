//! Draws a family of methods against the percentage in its names: the time that it takes and the errors that are left,
//! both over the baseline's. A reader can choose the percentage by this drawing.

use super::axis::Axis;
use super::draw::{Dash, LegendEntry, LegendMark, bar, level, line, mark, names, number, open, polyline, text};
use super::family::Family;
use crate::compare::report::{Row, SceneReport};

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 640.0;
const LEFT: f64 = 70.0;
/// Room for the names.
const RIGHT: f64 = 250.0;
/// Top and bottom of the two panels.
const TIMES: (f64, f64) = (104.0, 284.0);
const ERRORS: (f64, f64) = (330.0, 574.0);

/// The least distance between two numbers below the panels.
const TICK_STEP: f64 = 38.0;

/// The index of the mark and colour of the time. The errors have the indices from 0 on.
const TIME: usize = 3;
const MEASURES: [(&str, &str); 3] =
    [("systematic", "systematic_inconsistency"), ("noise", "noise_variance"), ("MSE", "mse")];

/// A value divided by the baseline's, with its interval where it has one.
type Value = (f64, Option<[f64; 2]>);

/// A method without a percentage, which is drawn as a level line.
struct Level {
    method: String,
    dash: Dash,
    value: f64,
}

/// A line of a panel.
struct Curve {
    index: usize,
    /// `None`: the panel has only this curve, which is named after the family.
    name: Option<&'static str>,
    /// The values by percentage.
    points: Vec<(f64, Value)>,
    /// The methods without a percentage with which the family is to be compared.
    levels: Vec<Level>,
}

/// The drawing of a family. `None` where nothing has a ratio to the baseline.
pub fn plot(scene: &SceneReport, family: &Family<'_>) -> Option<String> {
    let (_, first) = family.rows.first()?;
    let fallback = &first.fallback;
    let percents = || family.rows.iter().map(|(percent, _)| *percent);
    let (left, right) = (LEFT, WIDTH - RIGHT);
    // A percentage of 0 has no logarithm, so the axis is then linear.
    let x = match percents().all(|p| p > 0.0) {
        true => Axis::around(percents(), left, right)?,
        false => Axis::from_zero(percents(), left + 14.0, right)?,
    };
    let others: Vec<&Row> = scene
        .results
        .iter()
        .filter(|r| r.is_peer(first) && r.method != scene.baseline)
        .filter(|r| r.method == family.stem || r.method == "stereo")
        .collect();
    let curve = |index: usize, name: Option<&'static str>, of: &dyn Fn(&Row) -> Option<Value>| Curve {
        index,
        name,
        points: family.rows.iter().filter_map(|(percent, row)| Some((*percent, of(row)?))).collect(),
        levels: others.iter().filter_map(|r| of(r).map(|(value, _)| level_of(r, family.stem, value))).collect(),
    };
    let times = [curve(TIME, None, &|row| time(scene, row))];
    let errors: Vec<Curve> = MEASURES
        .iter()
        .enumerate()
        .map(|(i, (name, key))| curve(i, Some(name), &|row| measure(scene, row, key)))
        .collect();
    if times.iter().chain(&errors).all(|c| c.points.is_empty()) {
        return None;
    }

    let (stem, baseline) = (family.stem, &scene.baseline);
    let (name, baseline) = (format!("{stem}-N"), baseline.as_str());
    let seen = [name.as_str(), baseline];
    let mut out = open(&format!("{}: {stem}-N against its percentage N", scene.scene), WIDTH, HEIGHT, LEFT);
    let rays = if family.spp == 1 { "1 ray a pixel".to_owned() } else { format!("{} rays a pixel", family.spp) };
    let about = format!("unknown rays see: {fallback} · {rays} · {} seeds · everything over {baseline}", first.seeds);
    text(&mut out, "soft", LEFT, 46.0, &about);
    text(&mut out, "soft", LEFT, 64.0, "bars: quartiles of the times, 95 % intervals of the rest");
    let ticks = ticks(&x, &percents().collect::<Vec<_>>());
    panel(&mut out, &format!("Time of trace + resolve over that of {baseline}"), &times, seen, (&x, &ticks), TIMES);
    let title = format!("Inconsistency between the eyes and error over those of {baseline}");
    panel(&mut out, &title, &errors, seen, (&x, &ticks), ERRORS);
    for &tick in &ticks {
        text(&mut out, "soft middle", x.at(tick), ERRORS.1 + 20.0, &number_or_zero(tick));
    }
    text(&mut out, "middle", (left + right) / 2.0, ERRORS.1 + 46.0, &format!("N of {stem}-N, per cent"));
    out.push_str("</svg>\n");
    Some(out)
}

/// The ticks: the percentages themselves where there is room for their numbers, otherwise round values.
fn ticks(x: &Axis, percents: &[f64]) -> Vec<f64> {
    let roomy = percents.windows(2).all(|w| x.at(w[1]) - x.at(w[0]) >= TICK_STEP);
    if roomy { percents.to_vec() } else { x.ticks() }
}

/// A level line. The method named like the family's stem has short dashes, and `stereo` has long ones.
fn level_of(row: &Row, stem: &str, value: f64) -> Level {
    let dash = if row.method == stem { Dash::Short } else { Dash::Long };
    Level { method: row.method.clone(), dash, value }
}

/// The time over the baseline's: the median of the rounds' ratios, and their quartiles.
fn time(scene: &SceneReport, row: &Row) -> Option<Value> {
    if row.method == scene.baseline {
        return Some((1.0, None));
    }
    let found = scene.overhead.iter().find(|o| {
        (&o.method, o.spp, &o.fallback, o.group.as_str()) == (&row.method, row.spp, &row.fallback, "trace_resolve")
    })?;
    Some((found.median, Some(found.quartiles)))
}

/// A measure over the baseline's. Unlike the report's ratios it may be 0.
fn measure(scene: &SceneReport, row: &Row, key: &str) -> Option<Value> {
    if row.method == scene.baseline {
        return Some((1.0, None));
    }
    let same = |m: &str, spp: u32, fallback: &str, k: &str| {
        (m, spp, fallback, k) == (row.method.as_str(), row.spp, row.fallback.as_str(), key)
    };
    let found = scene.equal_sample.iter().find(|r| same(&r.method, r.spp, &r.fallback, &r.measure));
    let zero = || {
        let of = |r: &Row| match key {
            "systematic_inconsistency" => r.systematic_inconsistency,
            "noise_variance" => r.noise_variance,
            _ => r.both(key),
        };
        let base = scene.results.iter().find(|b| b.method == scene.baseline && b.is_peer(row))?;
        (of(row)? == 0.0 && of(base)? > 0.0).then_some((0.0, None))
    };
    found.map(|r| (r.ratio, r.interval)).or_else(zero)
}

/// Draws a panel with its curves from `top` to `bottom`. `family` and `baseline` are the names that a reader sees.
fn panel(
    out: &mut String,
    title: &str,
    curves: &[Curve],
    [family, baseline]: [&str; 2],
    (x, ticks): (&Axis, &[f64]),
    (top, bottom): (f64, f64),
) {
    let right = WIDTH - RIGHT;
    let values = curves.iter().flat_map(|c| {
        let points = c.points.iter().flat_map(|(_, (value, ends))| ends.iter().flatten().copied().chain([*value]));
        points.chain(c.levels.iter().map(|l| l.value))
    });
    let Some(y) = Axis::from_zero(values.chain([1.0]), bottom, top) else { return };
    text(out, "", LEFT, top - 12.0, title);
    for &tick in ticks {
        line(out, "grid", (x.at(tick), top), (x.at(tick), bottom));
    }
    for tick in y.ticks() {
        line(out, "grid", (LEFT, y.at(tick)), (right, y.at(tick)));
        text(out, "soft end", LEFT - 9.0, y.at(tick) + 4.5, &number_or_zero(tick));
    }
    line(out, "axis", (LEFT, bottom), (right, bottom));
    line(out, "axis", (LEFT, top), (LEFT, bottom));
    line(out, "axis", (LEFT, y.at(1.0)), (right, y.at(1.0)));
    let mut all = vec![LegendEntry { from: (right, y.at(1.0)), sign: LegendMark::Plain, words: baseline.to_owned() }];
    for c in curves {
        for l in &c.levels {
            line(out, &level(c.index, l.dash), (LEFT, y.at(l.value)), (right, y.at(l.value)));
            let words = c.name.map_or_else(|| l.method.clone(), |name| format!("{name}, {}", l.method));
            all.push(LegendEntry { from: (right, y.at(l.value)), sign: LegendMark::Level(c.index, l.dash), words });
        }
    }
    for c in curves {
        let at = |(percent, (value, _)): &(f64, Value)| (x.at(*percent), y.at(*value));
        let points: Vec<(f64, f64)> = c.points.iter().map(at).collect();
        polyline(out, c.index, &points);
        for ((_, (_, ends)), (px, py)) in c.points.iter().zip(&points) {
            if let Some([lo, hi]) = ends {
                bar(out, c.index, *px, (y.at(*lo), y.at(*hi)));
            }
            mark(out, c.index, *px, *py);
        }
        if let Some(from) = points.last() {
            let words = c.name.map_or_else(|| family.to_owned(), str::to_owned);
            all.push(LegendEntry { from: *from, sign: LegendMark::Mark(c.index), words });
        }
    }
    names(out, all, right, top, bottom);
}

fn number_or_zero(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { number(value) }
}

#[cfg(test)]
mod tests {
    use super::super::family::families;
    use super::*;
    use crate::compare::report::Overhead;
    use crate::compare::sample::{ratio, row, scene};

    fn made_up(percents: &[f64]) -> SceneReport {
        let mut rows = vec![row("sssr", 1, 4.0, &[]), row("stereo", 1, 9.0, &[]), row("stereo-adaptive", 1, 6.5, &[])];
        rows.extend(percents.iter().map(|p| row(&format!("stereo-adaptive-{p}"), 1, 8.0 - p.sqrt(), &[])));
        let mut scene = scene("room", rows);
        for r in &scene.results[1..] {
            let gain = (r.ms["total"] - 4.0) / 5.0;
            let ms = r.ms["total"] / 4.0;
            for (measure, value) in [
                ("systematic_inconsistency", 1.0 - 0.8 * gain),
                ("noise_variance", 1.0 - 0.55 * gain),
                ("mse", 1.02 - 0.3 * gain),
            ] {
                scene.equal_sample.push(ratio(r, measure, value));
            }
            let (method, fallback, group) = (r.method.clone(), r.fallback.clone(), "trace_resolve".to_owned());
            let quartiles = [0.97 * ms, 1.04 * ms];
            scene.overhead.push(Overhead { method, spp: 1, fallback, group, median: ms, quartiles });
        }
        scene
    }

    #[test]
    fn a_family_is_drawn_beside_what_it_is_read_against() {
        for percents in [[0.5, 1.0, 2.0, 4.0, 8.0], [0.0, 1.0, 2.0, 5.0, 10.0]] {
            let scene = made_up(&percents);
            let families = families(&scene.results, "black");
            let [family] = families.as_slice() else { panic!("one family") };
            let svg = plot(&scene, family).expect("ratios");
            for words in ["N of stereo-adaptive-N, per cent", "systematic, stereo", "MSE, stereo-adaptive", ">sssr<"] {
                assert!(svg.contains(words), "{words}: {svg}");
            }
            // There are level lines for `stereo` and for `stereo-adaptive` in four measures, and eight samples of these
            // lines beside the panels.
            assert_eq!(svg.matches("class=\"dashed").count(), 16, "{svg}");
            assert_eq!(svg.matches("<polyline").count(), 4);
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }

    #[test]
    fn a_share_of_zero_is_drawn_and_nothing_is_drawn_without_a_baseline() {
        let mut scene = made_up(&[1.0, 2.0]);
        scene.equal_sample.clear();
        (scene.results[0].systematic_inconsistency, scene.results[3].systematic_inconsistency) = (Some(0.1), Some(0.0));
        assert_eq!(measure(&scene, &scene.results[3], "systematic_inconsistency"), Some((0.0, None)));
        assert_eq!(measure(&scene, &scene.results[4], "systematic_inconsistency"), None);
        assert_eq!(measure(&scene, &scene.results[0], "mse"), Some((1.0, None)));
        scene.overhead.clear();
        scene.results[3].systematic_inconsistency = None;
        let families = families(&scene.results, "black");
        assert!(plot(&scene, &families[0]).is_none());
    }
}
