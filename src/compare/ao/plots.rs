//! Drawings of a scene as SVG: time and inconsistency against the threshold (the seed's figure 11), and inconsistency and
//! error along the path (its figure 10).

use super::report::{AoRow, AoScene};
use crate::compare::plot::axis::Axis;
use crate::compare::plot::draw::{Dash, Name, Sign, level, line, mark, names, number, open, polyline, text};
use crate::render::Ao;

const WIDTH: f64 = 820.0;
const HEIGHT: f64 = 600.0;
const LEFT: f64 = 78.0;
/// Room for the names.
const RIGHT: f64 = 150.0;
/// Top and bottom of the two panels.
const PANELS: [(f64, f64); 2] = [(86.0, 276.0), (322.0, 532.0)];
/// Few enough points are marked.
const MOST_MARKS: usize = 20;

/// One line of a panel, or one value for all.
struct Curve {
    method: Ao,
    points: Vec<(f64, f64)>,
    is_level: bool,
}

/// Time over `mono` and inconsistency of the adaptive methods against their threshold; `None` where there is nothing to
/// draw.
pub fn threshold(scene: &AoScene) -> Option<String> {
    let percent = |row: &AoRow| 100.0 * f64::from(row.threshold);
    let x = Axis::around(scene.thresholds.iter().map(percent), LEFT, WIDTH - RIGHT)?;
    let curves = |of: &dyn Fn(&AoRow) -> Option<f64>| -> Vec<Curve> {
        let curve = |method: Ao| {
            let (rows, is_level) =
                if method.is_adaptive() { (&scene.thresholds, false) } else { (&scene.methods, true) };
            let rows = rows.iter().filter(|r| r.method == method);
            let points = rows.filter_map(|r| Some((percent(r), of(r)?))).collect();
            Curve { method, points, is_level }
        };
        Ao::OF_VIEWS.into_iter().map(curve).filter(|c| !c.points.is_empty()).collect()
    };
    let title = format!("{}: ambient occlusion against its threshold", scene.scene);
    let panels = [
        ("Time over that of mono", curves(&|r| Some(r.ratio[1]))),
        ("Pixels that differ visibly between the eyes, per cent", curves(&|r| Some(100.0 * r.inconsistency?))),
    ];
    drawing(&title, &panels, &x, "threshold, per cent of the pixel's own value")
}

/// Inconsistency and error against `fsa` along the path.
pub fn path(scene: &AoScene) -> Option<String> {
    let path = scene.path.as_ref()?;
    let x = Axis::from_zero([f64::from(path.poses)].into_iter(), LEFT, WIDTH - RIGHT)?;
    let points = |values: &[Option<f64>], scale: f64| -> Vec<(f64, f64)> {
        values.iter().enumerate().filter_map(|(i, v)| Some((i as f64, scale * (*v)?))).collect()
    };
    let curves = |of: &dyn Fn(&super::report::AoAlong) -> Vec<(f64, f64)>| -> Vec<Curve> {
        path.methods.iter().map(|a| Curve { method: a.method, points: of(a), is_level: false }).collect()
    };
    // Its own error is no curve.
    let errors = curves(&|a| points(&a.mae_fsa, 1.0)).into_iter().filter(|c| c.method != Ao::Fsa).collect();
    let panels = [
        ("Pixels that differ visibly between the eyes, per cent", curves(&|a| points(&a.inconsistency, 100.0))),
        ("Mean absolute error against fsa", errors),
    ];
    let title = format!("{}: ambient occlusion along a path of {} poses", scene.scene, path.poses);
    drawing(&title, &panels, &x, "pose")
}

fn drawing(title: &str, panels: &[(&str, Vec<Curve>); 2], x: &Axis, below: &str) -> Option<String> {
    let mut out = open(title, WIDTH, HEIGHT, LEFT);
    for ((title, curves), place) in panels.iter().zip(PANELS) {
        panel(&mut out, title, curves, x, place)?;
    }
    let bottom = PANELS[1].1;
    for tick in x.ticks() {
        text(&mut out, "soft middle", x.at(tick), bottom + 20.0, &number_or_zero(tick));
    }
    text(&mut out, "middle", (LEFT + WIDTH - RIGHT) / 2.0, bottom + 46.0, below);
    out.push_str("</svg>\n");
    Some(out)
}

fn panel(out: &mut String, title: &str, curves: &[Curve], x: &Axis, (top, bottom): (f64, f64)) -> Option<()> {
    let right = WIDTH - RIGHT;
    let y = Axis::from_zero(curves.iter().flat_map(|c| &c.points).map(|p| p.1), bottom, top)?;
    text(out, "", LEFT, top - 12.0, title);
    for tick in x.ticks() {
        line(out, "grid", (x.at(tick), top), (x.at(tick), bottom));
    }
    for tick in y.ticks() {
        line(out, "grid", (LEFT, y.at(tick)), (right, y.at(tick)));
        text(out, "soft end", LEFT - 9.0, y.at(tick) + 4.5, &number_or_zero(tick));
    }
    line(out, "axis", (LEFT, bottom), (right, bottom));
    line(out, "axis", (LEFT, top), (LEFT, bottom));
    let mut all = Vec::new();
    for curve in curves {
        let index = Ao::OF_VIEWS.iter().position(|m| *m == curve.method).unwrap_or(0);
        let places: Vec<(f64, f64)> = curve.points.iter().map(|(px, py)| (x.at(*px), y.at(*py))).collect();
        let Some(last) = places.last() else { continue };
        let words = curve.method.name().to_owned();
        if curve.is_level {
            line(out, &level(index, Dash::Long), (LEFT, last.1), (right, last.1));
            all.push(Name { from: (right, last.1), sign: Sign::Level(index, Dash::Long), words });
        } else {
            polyline(out, index, &places);
            if places.len() <= MOST_MARKS {
                places.iter().for_each(|(px, py)| mark(out, index, *px, *py));
            }
            all.push(Name { from: *last, sign: Sign::Mark(index), words });
        }
    }
    names(out, all, right, top, bottom);
    Some(())
}

fn number_or_zero(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { number(value) }
}
