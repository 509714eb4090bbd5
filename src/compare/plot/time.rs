//! Draws the error of all methods over their time, with both axes logarithmic.

use std::fmt::Write as _;

use cyclopean_analysis::interval::student_t;

use super::axis::Axis;
use super::draw::{LegendEntry, LegendMark, METHODS, bar, line, mark, names, number, open, polyline, text};
use super::family::{Family, families};
use crate::compare::report::{Row, SceneReport};

const WIDTH: f64 = 820.0;
const HEIGHT: f64 = 520.0;
const LEFT: f64 = 88.0;
/// Room for the methods' names at the ends of their lines.
const RIGHT: f64 = 172.0;
const TOP: f64 = 78.0;
const BOTTOM: f64 = 64.0;
/// A measured point.
struct Point {
    /// The number of rays a pixel, or the percentage in a family.
    label: String,
    ms: f64,
    mse: f64,
    /// The 95 % interval of the mean over the seeds.
    interval: Option<[f64; 2]>,
}

/// A line of the drawing: a method at its sample counts, or a family of methods at its percentages.
struct Series {
    name: String,
    points: Vec<Point>,
}

/// The drawing of one fallback. `None` where there is nothing to draw.
pub fn plot(scene: &SceneReport, fallback: &str) -> Option<String> {
    let families = families(&scene.results, fallback);
    let series = series(scene, fallback, &families);
    let points = || series.iter().flat_map(|s| &s.points);
    let x = Axis::around(points().map(|p| p.ms), LEFT, WIDTH - RIGHT)?;
    let errors = points().flat_map(|p| [p.mse].into_iter().chain(p.interval.into_iter().flatten()));
    let y = Axis::around(errors.filter(|e| *e > 0.0), HEIGHT - BOTTOM, TOP)?;

    let title = format!("{}: error of the reflection over its time", scene.scene);
    let mut out = open(&title, WIDTH, HEIGHT, LEFT);
    let seeds = scene.results.first().map_or(0, |r| r.seeds);
    let about = format!("unknown rays see: {fallback} · {seeds} seeds, bars: 95 % interval of the mean");
    text(&mut out, "soft", LEFT, 45.0, &about);
    let percent = if families.is_empty() { "" } else { ", or the percentage N in the method's name" };
    text(&mut out, "soft", LEFT, 63.0, &format!("numbers at the points: rays a pixel{percent}"));
    axes(&mut out, &x, &y);
    let floor = scene.reference.variance.iter().sum::<f64>() / 2.0;
    if y.holds(floor) {
        line(&mut out, "floor", (LEFT, y.at(floor)), (WIDTH - RIGHT, y.at(floor)));
        text(&mut out, "soft small", LEFT + 6.0, y.at(floor) - 5.0, "the reference's own variance");
    }
    for (i, s) in series.iter().enumerate() {
        draw(&mut out, i, s, &x, &y);
    }
    labels(&mut out, &series, &x, &y);
    names(&mut out, ends(&series, &x, &y), WIDTH - RIGHT, TOP, HEIGHT - BOTTOM);
    out.push_str("</svg>\n");
    Some(out)
}

/// The lines of the drawing: the methods in the order of the report, and each family as one line. The points of a line
/// are in order of time.
fn series(scene: &SceneReport, fallback: &str, families: &[Family<'_>]) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for row in scene.results.iter().filter(|r| r.fallback == fallback) {
        let of_row = |(_, other): &&(f64, &Row)| other.method == row.method && other.spp == row.spp;
        let member = families.iter().find_map(|f| Some((f, f.rows.iter().find(of_row)?.0)));
        let (name, label) = match member {
            Some((family, percent)) => (family_name(family, families), format!("{percent} %")),
            None => (row.method.clone(), row.spp.to_string()),
        };
        let Some(point) = point(row, label) else { continue };
        match all.iter_mut().find(|s| s.name == name) {
            Some(s) => s.points.push(point),
            None => all.push(Series { name, points: vec![point] }),
        }
    }
    // More samples take more time, but a larger percentage may take more time or less.
    all.iter_mut().for_each(|s| s.points.sort_by(|a, b| a.ms.total_cmp(&b.ms)));
    all
}

/// The name of a family, such as `stereo-adaptive-N`, with its number of samples where the family has several.
fn family_name(family: &Family<'_>, all: &[Family<'_>]) -> String {
    family.name(all).replacen(family.stem, &format!("{}-N", family.stem), 1)
}

fn point(row: &Row, label: String) -> Option<Point> {
    let (ms, mse) = (*row.ms.get("total")?, row.both("mse")?);
    let values = row.rounds.measures.get("mse")?;
    let i = student_t(values, 0.95);
    let interval = i.lo.zip(i.hi).map(|(lo, hi)| [lo, hi]).filter(|[lo, _]| *lo > 0.0);
    (ms > 0.0 && mse > 0.0).then_some(Point { label, ms, mse, interval })
}

fn axes(out: &mut String, x: &Axis, y: &Axis) {
    for tick in x.ticks() {
        line(out, "grid", (x.at(tick), TOP), (x.at(tick), HEIGHT - BOTTOM));
        text(out, "soft middle", x.at(tick), HEIGHT - BOTTOM + 20.0, &number(tick));
    }
    for tick in y.ticks() {
        line(out, "grid", (LEFT, y.at(tick)), (WIDTH - RIGHT, y.at(tick)));
        text(out, "soft end", LEFT - 9.0, y.at(tick) + 4.5, &number(tick));
    }
    line(out, "axis", (LEFT, HEIGHT - BOTTOM), (WIDTH - RIGHT, HEIGHT - BOTTOM));
    line(out, "axis", (LEFT, TOP), (LEFT, HEIGHT - BOTTOM));
    let middle = (LEFT + WIDTH - RIGHT) / 2.0;
    text(out, "middle", middle, HEIGHT - 18.0, "all reflection passes, both eyes, ms (median over rounds)");
    let middle = (TOP + HEIGHT - BOTTOM) / 2.0;
    let _ = write!(
        out,
        "<text class=\"middle\" transform=\"translate(22 {middle:.1}) rotate(-90)\">mean squared error, radiance²</text>"
    );
}

fn draw(out: &mut String, index: usize, series: &Series, x: &Axis, y: &Axis) {
    let at = |p: &Point| (x.at(p.ms), y.at(p.mse));
    polyline(out, index, &series.points.iter().map(at).collect::<Vec<_>>());
    for p in &series.points {
        if let Some([lo, hi]) = p.interval {
            bar(out, index, x.at(p.ms), (y.at(lo), y.at(hi)));
        }
        mark(out, index, x.at(p.ms), y.at(p.mse));
    }
}

/// Writes the label of every point beside it, in the colour of its line. Of eight places around the point, the one is
/// taken that has the most room to lines, bars, points and other labels.
fn labels(out: &mut String, series: &[Series], x: &Axis, y: &Axis) {
    let at = |p: &Point| (x.at(p.ms), y.at(p.mse));
    let mut taken: Vec<(f64, f64)> = series.iter().flat_map(|s| &s.points).map(at).collect();
    for p in series.iter().flat_map(|s| &s.points) {
        let [low, high] = p.interval.map_or([p.mse; 2], |i| i).map(|e| y.at(e));
        let steps = ((low - high) / 8.0).ceil().max(1.0);
        taken.extend((0..=steps as u32).map(|k| (x.at(p.ms), high + (low - high) * f64::from(k) / steps)));
    }
    for pair in series.iter().flat_map(|s| s.points.windows(2)) {
        let ((ax, ay), (bx, by)) = (at(&pair[0]), at(&pair[1]));
        let steps = ((bx - ax).hypot(by - ay) / 6.0).ceil().max(1.0);
        let between = |k: u32| (ax + (bx - ax) * f64::from(k) / steps, ay + (by - ay) * f64::from(k) / steps);
        taken.extend((1..steps as u32).map(between));
    }
    for (i, s) in series.iter().enumerate() {
        for p in &s.points {
            let (px, py) = at(p);
            let half = 3.2 * p.label.chars().count() as f64;
            let beside = [
                (0.0, -13.0),
                (0.0, 13.0),
                (half + 9.0, -9.0),
                (-half - 9.0, -9.0),
                (half + 9.0, 9.0),
                (-half - 9.0, 9.0),
                (half + 12.0, 0.0),
                (-half - 12.0, 0.0),
            ];
            // The distance to the nearest thing that is already there. More than the height of a number makes no
            // difference.
            let room = |(dx, dy): &(f64, f64)| {
                let distance = |t: &(f64, f64)| ((px + dx - t.0) / (half + 6.0)).hypot((py + dy - t.1) / 11.0).min(1.0);
                taken.iter().map(distance).fold(1.0, f64::min)
            };
            let best = beside
                .iter()
                .map(room)
                .enumerate()
                .fold((0, -1.0), |best, (k, r)| if r > best.1 { (k, r) } else { best });
            let (cx, cy) = (px + beside[best.0].0, py + beside[best.0].1);
            taken.push((cx, cy));
            text(out, &format!("small middle f{}", i % METHODS), cx, cy + 4.0, &p.label);
        }
    }
}

/// The names of the lines, each with the end of its line.
fn ends(series: &[Series], x: &Axis, y: &Axis) -> Vec<LegendEntry> {
    let end = |(i, s): (usize, &Series)| {
        let last = s.points.iter().max_by(|a, b| a.ms.total_cmp(&b.ms))?;
        Some(LegendEntry { from: (x.at(last.ms), y.at(last.mse)), sign: LegendMark::Mark(i), words: s.name.clone() })
    };
    series.iter().enumerate().filter_map(end).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::sample::{row, scene};

    #[test]
    fn a_family_is_one_line_in_order_of_time() {
        let rows = [
            row("sssr", 1, 4.0, &[("mse", 4e-3)]),
            row("sssr", 2, 7.0, &[("mse", 2e-3)]),
            row("stereo-adaptive-0.5", 1, 9.0, &[("mse", 1e-3)]),
            row("stereo-adaptive-8", 1, 5.0, &[("mse", 3e-3)]),
            row("stereo-adaptive", 1, 7.0, &[("mse", 2e-3)]),
        ];
        let scene = scene("room", rows.to_vec());
        let all = series(&scene, "black", &families(&scene.results, "black"));
        let seen: Vec<(&str, Vec<&str>)> =
            all.iter().map(|s| (s.name.as_str(), s.points.iter().map(|p| p.label.as_str()).collect())).collect();
        assert_eq!(
            seen,
            [("sssr", vec!["1", "2"]), ("stereo-adaptive-N", vec!["8 %", "0.5 %"]), ("stereo-adaptive", vec!["1"])]
        );
        let svg = plot(&scene, "black").expect("points");
        assert!(svg.contains(">stereo-adaptive-N</text>") && svg.contains(">0.5 %</text>"), "{svg}");
        assert!(plot(&scene, "probe").is_none());
    }
}
