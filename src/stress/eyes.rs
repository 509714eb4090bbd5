//! Cases of unusual pairs of eyes: in one place, exchanged, turned against each other, and far apart.

use std::sync::Arc;

use crate::console::check_interrupted;
use crate::render::{RenderError, Settings, Streams};
use crate::scene::{Scene, StereoCamera};

use super::bench::Bench;
use super::case::{Bound, Case, Worst};
use super::measure::{relative_squared_error, unequal};
use super::shapes::{hall, settings, stripes};

pub const CASES: &[Case] = &[
    Case {
        name: "ipd-0",
        hazard: "both eyes are in one place, so that there is no line between them",
        checks: "shared streams: pixels in which the eyes differ in any bit",
        unit: "pixels",
        bound: Bound::AtMost(0.0),
        run: one_place,
    },
    Case {
        name: "ipd-0-baseline",
        hazard: "the other eye answers rays that the own eye has lost, although it sees the same",
        checks: "eyes in one place, shared streams: pixels of stereo-no-reprojection that differ from sssr in any bit",
        unit: "% of the pixels",
        bound: Bound::AtMost(1.0),
        run: baseline,
    },
    Case {
        name: "ipd-0-seeds",
        hazard: "one eye is brighter than the other",
        checks: "eyes in one place, independent streams: mean of left − right over 64 seeds",
        unit: "standard errors",
        bound: Bound::AtMost(4.0),
        run: seeds,
    },
    Case {
        name: "swapped-eyes",
        hazard: "a method treats the left eye differently from the right one",
        checks: "eyes exchanged: pixels in which the exchanged pictures differ in any bit",
        unit: "pixels",
        bound: Bound::AtMost(0.0),
        run: exchanged,
    },
    Case {
        name: "canted-eyes",
        hazard: "the same place is at different fractions of the two views",
        checks: "eyes turned by 5°, with asymmetric frusta: error with 16 rays, where everything reflected is in view",
        unit: "relative squared error",
        bound: Bound::AtMost(0.05),
        run: canted,
    },
    Case {
        name: "eyes-far-apart",
        hazard: "a pixel's partner is outside the other view",
        checks: "1 m between the eyes: relative squared error of stereo over that of sssr, with 4 rays",
        unit: "ratio",
        bound: Bound::AtMost(1.0),
        run: far_apart,
    },
];

/// Methods that ask the views in different ways, and the reference.
const ALL: [&str; 12] = [
    "sssr",
    "stereo",
    "stereo-fixed-blend",
    "stereo-ratio",
    "stereo-hybrid",
    "stereo-hybrid-25",
    "stereo-adaptive",
    "stereo-no-traversal",
    "stereo-no-fade",
    "stereo-no-reprojection",
    "sssr-thickness",
    "path-traced@2",
];

fn shared(edge_fade: f32) -> Settings {
    Settings { streams: Streams::Shared, edge_fade, ..settings(96, 64) }
}

fn one_place(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for roughness in [0.0, 0.3] {
        let hall = Arc::new(hall(roughness, 0.0));
        for method in ALL {
            let rendered = bench.render(&format!("r={roughness}"), &hall, method, &shared(0.1))?;
            let [left, right] = &rendered.linear.eyes;
            worst.include(unequal(left, right), format!("roughness {roughness}, {method}"));
        }
    }
    Ok(worst)
}

fn baseline(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for roughness in [0.0, 0.1, 0.3] {
        let hall = Arc::new(hall(roughness, 0.0));
        let label = format!("r={roughness}");
        let a = bench.render(&label, &hall, "sssr", &shared(0.1))?;
        let b = bench.render(&label, &hall, "stereo-no-reprojection", &shared(0.1))?;
        let pixels = a.linear.eyes[0].len() as f64;
        worst.include(100.0 * unequal(&a.linear.eyes[0], &b.linear.eyes[0]) / pixels, format!("roughness {roughness}"));
    }
    Ok(worst)
}

fn seeds(bench: &mut Bench) -> Result<Worst, RenderError> {
    let hall = Arc::new(hall(0.3, 0.0));
    let settings = Settings { edge_fade: 0.1, ..settings(48, 32) };
    let camera = hall.views[0].stereo_camera(settings.aspect());
    let mut worst = Worst::largest();
    for method in ["sssr", "stereo", "path-traced@2"] {
        let mut prepared = bench.prepare(&hall, method, &settings, &camera)?;
        let mut differences = Vec::new();
        for seed in 1..=64 {
            prepared.set_seed(seed, 0);
            prepared.frame(&mut |_, _| check_interrupted())?;
            let [left, right] = prepared.reflection()?.eyes;
            let sum = left.iter().zip(&right).map(|(l, r)| f64::from(l[1]) - f64::from(r[1])).sum::<f64>();
            differences.push(sum / left.len() as f64);
        }
        let n = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / n;
        let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
        worst.include(mean.abs() / (variance / n).sqrt(), method);
    }
    Ok(worst)
}

fn exchanged(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for (cant_rad, roughness) in [(0.0, 0.3), (0.05, 0.0)] {
        let mut scene: Scene = hall(roughness, 0.3);
        scene.views[0].cant_rad = cant_rad;
        let scene = Arc::new(scene);
        let settings = shared(0.1);
        let camera = scene.views[0].stereo_camera(settings.aspect());
        let swapped = StereoCamera { left: camera.right, right: camera.left };
        for method in ["sssr", "stereo", "stereo-no-fade", "path-traced@2"] {
            let a = bench.render_from("eyes", &scene, method, &settings, &camera)?;
            let b = bench.render_from("exchanged", &scene, method, &settings, &swapped)?;
            for eye in 0..2 {
                let pixels = unequal(&a.linear.eyes[eye], &b.linear.eyes[1 - eye]);
                worst.include(pixels, format!("turned by {cant_rad}, roughness {roughness}, {method}"));
            }
        }
    }
    Ok(worst)
}

fn canted(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut scene = stripes(0.2, 1.0);
    scene.views[0].cant_rad = 5f64.to_radians();
    let scene = Arc::new(scene);
    let settings = settings(96, 64);
    let mut camera = scene.views[0].stereo_camera(settings.aspect());
    camera.left.fov.left_rad -= 0.1;
    camera.right.fov.up_rad += 0.1;
    let reference = bench.render_from("canted", &scene, "path-traced@256", &settings, &camera)?;
    let mut worst = Worst::largest();
    for method in ["sssr@16", "stereo@16"] {
        let rendered = bench.render_from("canted", &scene, method, &settings, &camera)?;
        worst.include(relative_squared_error(&rendered.reflection, &reference.reflection), method);
    }
    Ok(worst)
}

fn far_apart(bench: &mut Bench) -> Result<Worst, RenderError> {
    let hall = Arc::new(hall(0.25, 1.0));
    let settings = Settings { edge_fade: 0.1, ..settings(96, 64) };
    let reference = bench.render("apart", &hall, "path-traced@256", &settings)?;
    let mut error = |method: &str| -> Result<f64, RenderError> {
        let rendered = bench.render("apart", &hall, method, &settings)?;
        Ok(relative_squared_error(&rendered.reflection, &reference.reflection))
    };
    let (baseline, stereo) = (error("sssr@4")?, error("stereo@4")?);
    let mut worst = Worst::largest();
    worst.include(stereo / baseline, format!("stereo {stereo:.4}, sssr {baseline:.4}"));
    Ok(worst)
}
