//! Drawings of a scene as SVG: time and inconsistency against the threshold (figure 11 of seed 001), and inconsistency
//! and error along the path (its figure 10). A scene's results go in; [`super::drawings`] calls it.

use super::report::{AoRow, AoScene};
use crate::compare::plot::axis::Axis;
use crate::compare::plot::panels::{Curve, LEFT, RIGHT, panels};
use crate::render::Ao;

/// A method's line, in its own colour.
fn curve(method: Ao, points: Vec<(f64, f64)>, is_level: bool) -> Curve {
    let index = Ao::OF_VIEWS.iter().position(|m| *m == method).unwrap_or(0);
    Curve { name: method.name().to_owned(), index, points, is_level }
}

/// Draws the time over that of `mono` and the inconsistency of the adaptive methods against their threshold. The other
/// methods are level lines. `None` where there is nothing to draw.
pub fn threshold(scene: &AoScene) -> Option<String> {
    let percent = |row: &AoRow| 100.0 * f64::from(row.threshold);
    let x = Axis::around(scene.thresholds.iter().map(percent), LEFT, RIGHT)?;
    let curves = |of: &dyn Fn(&AoRow) -> Option<f64>| -> Vec<Curve> {
        let of_method = |method: Ao| {
            let (rows, is_level) =
                if method.is_adaptive() { (&scene.thresholds, false) } else { (&scene.methods, true) };
            let rows = rows.iter().filter(|r| r.method == method);
            let points = rows.filter_map(|r| Some((percent(r), of(r)?))).collect();
            curve(method, points, is_level)
        };
        Ao::OF_VIEWS.into_iter().map(of_method).filter(|c| !c.points.is_empty()).collect()
    };
    let title = format!("{}: ambient occlusion against its threshold", scene.scene);
    let both = [
        ("Time over that of mono", curves(&|r| Some(r.ratio[1]))),
        ("Pixels that differ visibly between the eyes, per cent", curves(&|r| Some(100.0 * r.inconsistency?))),
    ];
    panels(&title, &both, &x, "threshold, per cent of the pixel's own value")
}

/// Draws inconsistency and error against `fsa` along the path. `None` where there is nothing to draw.
pub fn path(scene: &AoScene) -> Option<String> {
    let path = scene.path.as_ref()?;
    let x = Axis::from_zero([f64::from(path.poses)].into_iter(), LEFT, RIGHT)?;
    let points = |values: &[Option<f64>], scale: f64| -> Vec<(f64, f64)> {
        values.iter().enumerate().filter_map(|(i, v)| Some((i as f64, scale * (*v)?))).collect()
    };
    let curves = |of: &dyn Fn(&super::report::AoPathRow) -> Vec<(f64, f64)>| -> Vec<Curve> {
        path.methods.iter().map(|a| curve(a.method, of(a), false)).collect()
    };
    // The error of `fsa` against itself is not drawn.
    let errors = curves(&|a| points(&a.mae_fsa, 1.0)).into_iter().filter(|c| c.name != Ao::Fsa.name()).collect();
    let both = [
        ("Pixels that differ visibly between the eyes, per cent", curves(&|a| points(&a.inconsistency, 100.0))),
        ("Mean absolute error against fsa", errors),
    ];
    let title = format!("{}: ambient occlusion along a path of {} poses", scene.scene, path.poses);
    panels(&title, &both, &x, "pose")
}
