//! Plots as SVG that takes its colours from the page, so that the same drawing suits light and dark pages and paper.

use crate::escape::html as escape;
use crate::mos::Row;
use crate::svg::{self, ticks};

struct Canvas {
    body: String,
    width: f64,
    height: f64,
}

impl Canvas {
    fn new(width: f64, height: f64) -> Self {
        Self { body: String::new(), width, height }
    }

    fn line(&mut self, class: &str, x1: f64, y1: f64, x2: f64, y2: f64) {
        svg::line(&mut self.body, class, (x1, y1), (x2, y2));
    }

    fn text(&mut self, class: &str, x: f64, y: f64, text: &str) {
        svg::text(&mut self.body, class, x, y, text);
    }

    fn rect(&mut self, class: &str, x: f64, y: f64, w: f64, h: f64) {
        svg::rect(&mut self.body, class, (x, y), (w, h));
    }

    fn marker(&mut self, series: usize, x: f64, y: f64) {
        svg::mark(&mut self.body, &format!("s{}", series % 6), series, (x, y), 6.0);
    }

    fn finish(self, label: &str) -> String {
        format!(
            r#"<svg viewBox="0 0 {} {}" role="img" aria-label="{}" xmlns="http://www.w3.org/2000/svg">{}</svg>"#,
            self.width,
            self.height,
            escape(label),
            self.body
        )
    }
}

/// Distinct values in order of appearance.
fn distinct<'a>(values: impl Iterator<Item = &'a str>) -> Vec<String> {
    values.fold(Vec::new(), |mut all, v| {
        if !all.iter().any(|a| a == v) {
            all.push(v.to_owned());
        }
        all
    })
}

/// Width of a text of 13 px in a common sans-serif, for placing legends; right to a few per cent.
fn width_of(text: &str) -> f64 {
    text.chars().count() as f64 * 7.2
}

/// Means with intervals: one group of markers for each level of `group`, in it one marker for each level of `series`
/// (the paper's Fig. 19 has scenes and methods).
pub fn means(rows: &[&Row], group: Option<&str>, series: Option<&str>, label: &str, stamp: Option<&str>) -> String {
    let level = |r: &Row, f: Option<&str>| f.and_then(|f| r.level(f)).unwrap_or("").to_owned();
    let groups = distinct(rows.iter().map(|r| group.and_then(|g| r.level(g)).unwrap_or("")));
    let all_series = distinct(rows.iter().map(|r| series.and_then(|s| r.level(s)).unwrap_or("")));
    let (width, height) = (720.0, 360.0);
    let (left, right, top, bottom) = (46.0, 12.0, 44.0, 36.0);
    let mut low = rows.iter().filter_map(|r| r.scale.map(|s| s.low)).fold(f64::INFINITY, f64::min);
    let mut high = rows.iter().filter_map(|r| r.scale.map(|s| s.high)).fold(f64::NEG_INFINITY, f64::max);
    for r in rows {
        low = low.min(r.interval.lo.unwrap_or(r.mean)).min(r.mean);
        high = high.max(r.interval.hi.unwrap_or(r.mean)).max(r.mean);
    }
    let pad = 0.04 * (high - low).max(1e-9);
    let (low, high) = (low - pad, high + pad);
    let y = |v: f64| top + (high - v) / (high - low) * (height - top - bottom);
    let mut c = Canvas::new(width, height);
    let step = ((high - low) / 6.0).ceil().max(1.0);
    let mut tick = low.ceil();
    while tick <= high {
        c.line("grid", left, y(tick), width - right, y(tick));
        c.text("tick end", left - 8.0, y(tick) + 4.5, &format!("{tick}"));
        tick += step;
    }
    let slot = (width - left - right) / groups.len().max(1) as f64;
    let apart = (slot * 0.7 / all_series.len().max(1) as f64).min(80.0);
    for (g, name) in groups.iter().enumerate() {
        let middle = left + slot * (g as f64 + 0.5);
        c.text("label middle", middle, height - 12.0, name);
        if g > 0 {
            c.line("grid", left + slot * g as f64, top, left + slot * g as f64, height - bottom);
        }
        for (s, which) in all_series.iter().enumerate() {
            let Some(r) = rows.iter().find(|r| level(r, group) == *name && level(r, series) == *which) else {
                continue;
            };
            let x = middle + (s as f64 - (all_series.len() as f64 - 1.0) / 2.0) * apart;
            if let (Some(lo), Some(hi)) = (r.interval.lo, r.interval.hi) {
                let class = format!("bar l{}", s % 6);
                c.line(&class, x, y(lo), x, y(hi));
                c.line(&class, x - 6.0, y(lo), x + 6.0, y(lo));
                c.line(&class, x - 6.0, y(hi), x + 6.0, y(hi));
            }
            c.marker(s, x, y(r.mean));
            c.text("value", x + 11.0, y(r.mean) + 4.5, &format!("{:.2}", r.mean));
        }
    }
    legend(&mut c, left, 20.0, &all_series, stamp, |c, i, x, y| c.marker(i, x, y));
    c.finish(label)
}

/// Names along the top, each beside its marker.
///
/// The stamp stands after them at the left, so that a narrow screen shows it without scrolling.
fn legend(
    c: &mut Canvas,
    left: f64,
    y: f64,
    names: &[String],
    stamp: Option<&str>,
    mark: impl Fn(&mut Canvas, usize, f64, f64),
) {
    let mut x = left + 8.0;
    for (i, name) in names.iter().enumerate().filter(|n| !n.1.is_empty()) {
        mark(c, i, x, y);
        c.text("label", x + 12.0, y + 4.5, name);
        x += 34.0 + width_of(name);
    }
    // The stamp is part of the drawing, so that a plot cut out of the page keeps it.
    if let Some(stamp) = stamp {
        c.text("stamp", x + 4.0, y + 4.5, &stamp.to_uppercase());
    }
}

/// Stacked shares of the votes, one bar for each row, with the MOS at its end (the paper's Fig. 18).
///
/// `words` name the scale's steps, lowest first.
pub fn distributions(rows: &[&Row], names: &[String], words: &[String], label: &str, stamp: Option<&str>) -> String {
    let widest = names.iter().map(|n| width_of(n)).fold(0.0, f64::max).min(260.0);
    let (left, right, top, bar, gap) = (widest + 16.0, 138.0, 44.0, 26.0, 12.0);
    let width = 720.0;
    let height = top + rows.len() as f64 * (bar + gap) + 26.0;
    let mut c = Canvas::new(width, height);
    let span = width - left - right;
    for (i, (row, name)) in rows.iter().zip(names).enumerate() {
        let y = top + i as f64 * (bar + gap);
        let total: u64 = row.counts.values().sum();
        c.text("label end", left - 8.0, y + bar / 2.0 + 4.5, name);
        let mut x = left;
        for (step, (_, n)) in row.counts.iter().enumerate() {
            let share = *n as f64 / total.max(1) as f64;
            let w = share * span;
            if *n > 0 {
                let class = step_class(step, row.counts.len());
                c.rect(&format!("seg {class}"), x, y, w, bar);
                if w > 30.0 {
                    c.text(
                        &format!("share on-{class}"),
                        x + w / 2.0,
                        y + bar / 2.0 + 4.5,
                        &format!("{:.0} %", 100.0 * share),
                    );
                }
            }
            x += w;
        }
        let interval = match (row.interval.lo, row.interval.hi) {
            (Some(lo), Some(hi)) => format!(" [{lo:.2}, {hi:.2}]"),
            _ => String::new(),
        };
        c.text("value", left + span + 8.0, y + bar / 2.0 + 4.5, &format!("{:.2}{interval}", row.mean));
    }
    let axis = height - 8.0;
    for percent in [0, 25, 50, 75, 100] {
        let x = left + span * f64::from(percent) / 100.0;
        c.text("tick middle", x, axis, &format!("{percent} %"));
    }
    c.text("tick", left + span + 30.0, axis, "MOS");
    let steps = rows.iter().map(|r| r.counts.len()).max().unwrap_or(0);
    let shorter: Vec<String> = words.iter().take(steps).cloned().collect();
    let total: f64 = shorter.iter().map(|w| 34.0 + width_of(w)).sum();
    // Where the words of a scale are too long to stand beside each other, its numbers are shown instead.
    let room = width - 16.0 - stamp.map_or(0.0, |s| 9.5 * s.len() as f64 + 16.0);
    let shown: Vec<String> = if total > room { (1..=steps).map(|i| i.to_string()).collect() } else { shorter };
    legend(&mut c, 8.0, 20.0, &shown, stamp, |c, i, x, y| {
        c.rect(&format!("seg {}", step_class(i, steps)), x - 6.0, y - 7.0, 14.0, 14.0)
    });
    c.finish(label)
}

/// Paired differences with their intervals around zero, one line for each; a margin of equivalence is drawn as a band.
pub fn differences(
    lines: &[(String, f64, Option<f64>, Option<f64>)],
    margin: Option<f64>,
    label: &str,
    stamp: Option<&str>,
) -> String {
    let widest = lines.iter().map(|l| width_of(&l.0)).fold(0.0, f64::max).min(300.0);
    let (left, right, top, row) = (widest + 16.0, 148.0, 40.0, 30.0);
    let (width, height) = (720.0, top + lines.len() as f64 * row + 26.0);
    let ends = lines
        .iter()
        .flat_map(|l| [Some(l.1), l.2, l.3])
        .flatten()
        .chain(margin.iter().flat_map(|m| [-m, *m]))
        .chain([0.0]);
    let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let pad = 0.05 * (high - low).max(0.5);
    let (low, high) = (low - pad, high + pad);
    let x = |v: f64| left + (v - low) / (high - low) * (width - left - right);
    let mut c = Canvas::new(width, height);
    let bottom = top + lines.len() as f64 * row;
    if let Some(m) = margin {
        c.rect("band", x(-m), top, x(m) - x(-m), bottom - top);
    }
    // Marks at quarters, halves or whole steps suit rating scales; a wider range gets the marks that `ticks` gives.
    let step = [0.25, 0.5, 1.0, 2.0, 5.0, 10.0].into_iter().find(|s| (high - low) / s <= 9.0);
    let marks = match step {
        Some(step) => {
            let whole = |v: f64| (v / step) as i64;
            (whole(low) - 1..=whole(high) + 1).map(|i| i as f64 * step).filter(|v| (low..=high).contains(v)).collect()
        }
        None => ticks(low, high, 7.0),
    };
    for tick in marks {
        c.line(if tick == 0.0 { "zero" } else { "grid" }, x(tick), top, x(tick), bottom);
        c.text("tick middle", x(tick), bottom + 18.0, &format!("{}", tick + 0.0));
    }
    for (i, (name, mean, lo, hi)) in lines.iter().enumerate() {
        let y = top + (i as f64 + 0.5) * row;
        c.text("label end", left - 8.0, y + 4.5, name);
        let mut value = format!("{mean:.2}");
        if let (Some(lo), Some(hi)) = (lo, hi) {
            c.line("bar l1", x(*lo), y, x(*hi), y);
            c.line("bar l1", x(*lo), y - 5.0, x(*lo), y + 5.0);
            c.line("bar l1", x(*hi), y - 5.0, x(*hi), y + 5.0);
            value += &format!(" [{lo:.2}, {hi:.2}]");
        }
        c.marker(1, x(*mean), y);
        c.text("value", width - right + 8.0, y + 4.5, &value);
    }
    let names = margin.map(|m| vec![format!("zone of equivalence, ±{m}")]).unwrap_or_default();
    legend(&mut c, 8.0, 18.0, &names, stamp, |c, _, x, y| c.rect("band", x - 6.0, y - 7.0, 14.0, 14.0));
    c.finish(label)
}

/// A number without the rounding errors of binary fractions: 0.3, not 0.30000000000000004.
fn plain(v: f64) -> String {
    let text = format!("{:.6}", v + 0.0);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Colour of a step: five classes from the low end to the high end, whatever the number of steps.
fn step_class(step: usize, steps: usize) -> String {
    let at = if steps < 2 { 2.0 } else { step as f64 * 4.0 / (steps as f64 - 1.0) };
    format!("v{}", at.round() as u32 + 1)
}

/// One condition of a scatter plot.
pub struct Point {
    /// Scene, written beside the marker.
    pub scene: String,
    /// Method, told by the marker.
    pub method: String,
    /// Measured inconsistency.
    pub x: f64,
    /// MOS.
    pub y: f64,
}

/// A scatter plot of MOS over measured inconsistency, with the scene beside each point and one marker for each method.
pub fn scatter(points: &[Point], label: &str, stamp: Option<&str>) -> String {
    let (width, height, left, right, top, bottom) = (720.0, 360.0, 52.0, 76.0, 44.0, 48.0);
    let methods = distinct(points.iter().map(|p| p.method.as_str()));
    let range = |f: &dyn Fn(&Point) -> f64| {
        let lo = points.iter().map(f).fold(f64::INFINITY, f64::min);
        let hi = points.iter().map(f).fold(f64::NEG_INFINITY, f64::max);
        let pad = 0.06 * (hi - lo).max(1e-9);
        (lo - pad, hi + pad)
    };
    let ((x0, x1), (y0, y1)) = (range(&|p| p.x), range(&|p| p.y));
    let x = |v: f64| left + (v - x0) / (x1 - x0) * (width - left - right);
    let y = |v: f64| top + (y1 - v) / (y1 - y0) * (height - top - bottom);
    let mut c = Canvas::new(width, height);
    for v in ticks(y0, y1, 7.0) {
        c.line("grid", left, y(v), width - right, y(v));
        c.text("tick end", left - 8.0, y(v) + 4.5, &plain(v));
    }
    for v in ticks(x0, x1, 7.0) {
        c.text("tick middle", x(v), height - bottom + 18.0, &plain(v));
    }
    c.text("label middle", (left + width - right) / 2.0, height - 8.0, "measured systematic inconsistency");
    for Point { scene, method, x: vx, y: vy } in points {
        let s = methods.iter().position(|m| m == method).unwrap_or(0);
        c.marker(s, x(*vx), y(*vy));
        c.text("value", x(*vx) + 11.0, y(*vy) + 4.5, scene);
    }
    legend(&mut c, left, 20.0, &methods, stamp, |c, i, x, y| c.marker(i, x, y));
    c.finish(label)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_differences_are_few_whatever_the_scale() {
        let marks = |mean: f64, low: f64, high: f64| {
            let svg = differences(&[("a − b".to_owned(), mean, Some(low), Some(high))], None, "differences", None);
            let marks = svg.split("tick middle").skip(1);
            marks.map(|m| m.split_once('>').map_or("", |m| m.1).split('<').next().unwrap_or("").to_owned()).collect()
        };
        let usual: Vec<String> = marks(0.3, -0.1, 0.7);
        assert_eq!(usual, ["0", "0.25", "0.5"]);
        let wide: Vec<String> = marks(3.0, -1.2, 4.0);
        assert_eq!(wide, ["-1", "0", "1", "2", "3", "4"]);
        let vast: Vec<String> = marks(2e9, -2e9, 2e9);
        assert_eq!(vast, ["-2000000000", "-1000000000", "0", "1000000000", "2000000000"]);
    }
}
