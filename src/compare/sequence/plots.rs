//! Draws a scene's results as SVG: the error and the noise part of the flicker, frame by frame. [`super::compare`]
//! calls it.

use super::report::{SequenceRow, SequenceScene};
use crate::compare::plot::axis::Axis;
use crate::compare::plot::panels::{Curve, LEFT, RIGHT, panels};

/// Draws the roots of the squared error and of the noise part of the flicker. `None` where there is nothing to draw.
pub fn over_time(scene: &SequenceScene, path: &str) -> Option<String> {
    let x = Axis::from_zero([f64::from(scene.frames)].into_iter(), LEFT, RIGHT)?;
    let curves = |measure: &str| -> Vec<Curve> {
        let curve = |(index, row): (usize, &SequenceRow)| {
            let values = row.by_frame.get(measure).map_or(&[][..], Vec::as_slice);
            // The first frame has no value. The estimates may be negative by chance, because the noise of the
            // references does not count in them.
            let root = |(i, v): (usize, &Option<f64>)| Some((i as f64 + 1.0, (*v)?.max(0.0).sqrt()));
            let points = values.iter().enumerate().filter_map(root).collect();
            Curve { name: format!("{}@{}", row.method, row.spp), index, points, is_level: false }
        };
        scene.results.iter().enumerate().map(curve).collect()
    };
    let both = [
        ("Root of the mean squared error of the reflection, linear radiance", curves("mse")),
        ("Root of the noise part of the flicker, linear radiance", curves("noise_flicker")),
    ];
    panels(&format!("{}: reflections along the path {path}", scene.scene), &both, &x, "frame")
}
