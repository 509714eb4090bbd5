//! The elements that every drawing is made of, as SVG text: of the studies' reports and of the comparisons of methods.
//!
//! Coordinates are SVG user units with y downwards, written with one decimal. A class says how an element looks; the
//! page or the drawing's own style gives the class its colour.

use std::fmt::Write;

use crate::escape::html;

/// A line between two points.
pub fn line(out: &mut String, class: &str, (x1, y1): (f64, f64), (x2, y2): (f64, f64)) {
    let _ = write!(out, r#"<line class="{class}" x1="{x1:.1}" y1="{y1:.1}" x2="{x2:.1}" y2="{y2:.1}"/>"#);
}

/// A line through points.
pub fn polyline(out: &mut String, class: &str, points: &[(f64, f64)]) {
    let _ = write!(out, r#"<polyline class="{class}" points="{}"/>"#, list(points.iter().copied()));
}

/// A box with its upper left corner at (`x`, `y`).
pub fn rect(out: &mut String, class: &str, (x, y): (f64, f64), (width, height): (f64, f64)) {
    let _ = write!(out, r#"<rect class="{class}" x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}"/>"#);
}

/// Words on the baseline `y`; what they contain is escaped.
pub fn text(out: &mut String, class: &str, x: f64, y: f64, words: &str) {
    let _ = write!(out, r#"<text class="{class}" x="{x:.1}" y="{y:.1}">{}</text>"#, html(words));
}

/// The mark of a series around a point, told apart without colour: circle, square, diamond, triangle, then again.
/// `radius` is the circle's; the others look equally large.
pub fn mark(out: &mut String, class: &str, series: usize, (x, y): (f64, f64), radius: f64) {
    let corners: &[(f64, f64)] = match series % 4 {
        0 => {
            let _ = write!(out, r#"<circle class="{class}" cx="{x:.1}" cy="{y:.1}" r="{radius}"/>"#);
            return;
        }
        1 => &[(-0.92, -0.92), (0.92, -0.92), (0.92, 0.92), (-0.92, 0.92)],
        2 => &[(0.0, -1.26), (1.26, 0.0), (0.0, 1.26), (-1.26, 0.0)],
        _ => &[(0.0, -1.17), (1.1, 0.85), (-1.1, 0.85)],
    };
    let corners = corners.iter().map(|(dx, dy)| (x + radius * dx, y + radius * dy));
    let _ = write!(out, r#"<polygon class="{class}" points="{}"/>"#, list(corners));
}

fn list(points: impl Iterator<Item = (f64, f64)>) -> String {
    points.map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}

/// Round values from `low` to `high`, both finite: steps of 1, 2 or 5 times a power of ten, at most `most` steps.
pub fn ticks(low: f64, high: f64, most: f64) -> Vec<f64> {
    let least = (high - low) / most;
    let power = 10f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * power).find(|s| *s >= least).unwrap_or(least);
    // Counted in steps, so that no rounding adds up.
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|k| k as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(ticks(0.0, 4.0, 8.0), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0]);
        assert_eq!(ticks(-1.3, 4.2, 7.0), [-1.0, 0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(ticks(-2e9, 2.1e9, 7.0).len(), 5);
    }

    #[test]
    fn words_are_escaped_and_numbers_short() {
        let mut out = String::new();
        text(&mut out, "label", 1.0, 2.26, "<a>");
        line(&mut out, "grid", (0.0, 1.0 / 3.0), (2.0, 3.0));
        mark(&mut out, "s1", 5, (10.0, 10.0), 5.0);
        assert_eq!(
            out,
            "<text class=\"label\" x=\"1.0\" y=\"2.3\">&lt;a&gt;</text>\
             <line class=\"grid\" x1=\"0.0\" y1=\"0.3\" x2=\"2.0\" y2=\"3.0\"/>\
             <polygon class=\"s1\" points=\"5.4,5.4 14.6,5.4 14.6,14.6 5.4,14.6\"/>"
        );
    }
}
