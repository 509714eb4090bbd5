//! Draws two panels, one above the other, with a common axis below both. The drawings of `ao` and `sequence` call it.

use super::axis::Axis;
use super::draw::{Dash, LegendEntry, LegendMark, level, line, mark, names, number, open, polyline, text};

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 600.0;
pub const LEFT: f64 = 78.0;
/// The right end of the panels. The names are to the right of it.
pub const RIGHT: f64 = 670.0;
/// Top and bottom of the two panels.
const PANELS: [(f64, f64); 2] = [(86.0, 276.0), (322.0, 532.0)];
/// The points of a curve are marked where there are at most so many.
const MOST_MARKS: usize = 20;

/// One line of a panel.
pub struct Curve {
    pub name: String,
    /// The index of its colour and mark, the same in both panels.
    pub index: usize,
    pub points: Vec<(f64, f64)>,
    pub is_level: bool,
}

/// The drawing, with a title for each panel. `below` names the common axis. `None` where a panel has nothing above 0.
pub fn panels(title: &str, panels: &[(&str, Vec<Curve>); 2], x: &Axis, below: &str) -> Option<String> {
    let mut out = open(title, WIDTH, HEIGHT, LEFT);
    for ((title, curves), place) in panels.iter().zip(PANELS) {
        panel(&mut out, title, curves, x, place)?;
    }
    let bottom = PANELS[1].1;
    for tick in x.ticks() {
        text(&mut out, "soft middle", x.at(tick), bottom + 20.0, &number_or_zero(tick));
    }
    text(&mut out, "middle", (LEFT + RIGHT) / 2.0, bottom + 46.0, below);
    out.push_str("</svg>\n");
    Some(out)
}

fn panel(out: &mut String, title: &str, curves: &[Curve], x: &Axis, (top, bottom): (f64, f64)) -> Option<()> {
    let y = Axis::from_zero(curves.iter().flat_map(|c| &c.points).map(|p| p.1), bottom, top)?;
    text(out, "", LEFT, top - 12.0, title);
    for tick in x.ticks() {
        line(out, "grid", (x.at(tick), top), (x.at(tick), bottom));
    }
    for tick in y.ticks() {
        line(out, "grid", (LEFT, y.at(tick)), (RIGHT, y.at(tick)));
        text(out, "soft end", LEFT - 9.0, y.at(tick) + 4.5, &number_or_zero(tick));
    }
    line(out, "axis", (LEFT, bottom), (RIGHT, bottom));
    line(out, "axis", (LEFT, top), (LEFT, bottom));
    let mut all = Vec::new();
    for curve in curves {
        let index = curve.index;
        let places: Vec<(f64, f64)> = curve.points.iter().map(|(px, py)| (x.at(*px), y.at(*py))).collect();
        let Some(last) = places.last() else { continue };
        let words = curve.name.clone();
        if curve.is_level {
            line(out, &level(index, Dash::Long), (LEFT, last.1), (RIGHT, last.1));
            all.push(LegendEntry { from: (RIGHT, last.1), sign: LegendMark::Level(index, Dash::Long), words });
        } else {
            polyline(out, index, &places);
            if places.len() <= MOST_MARKS {
                places.iter().for_each(|(px, py)| mark(out, index, *px, *py));
            }
            all.push(LegendEntry { from: *last, sign: LegendMark::Mark(index), words });
        }
    }
    names(out, all, RIGHT, top, bottom);
    Some(())
}

fn number_or_zero(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { number(value) }
}
