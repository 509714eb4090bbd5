//! Sweeps: how errors grow towards the extremes of one parameter, while everything else stays. A [`Sweep`] goes into
//! [`run`] and an [`SweepResult`] comes out. The command `stress` calls it.

use std::sync::Arc;

use glam::DVec3;

use crate::render::{RenderError, Settings};
use crate::scene::Scene;

use super::bench::Bench;
use super::case::Bound;
use super::measure::{relative_bias, relative_mse, relative_squared_error};
use super::shapes::{hall, moved, scaled, settings, stripes};

/// A parameter, and the scene that it changes.
#[derive(Debug, Clone, Copy)]
pub struct Sweep {
    pub name: &'static str,
    pub about: &'static str,
    /// The unit of the values.
    pub unit: &'static str,
    pub values: &'static [f64],
    pub scene: fn(f64) -> Arc<Scene>,
    /// The bound of the relative squared error of every method at every value.
    pub bound: Bound,
}

/// The methods that are compared with the reference.
const COMPARED: [&str; 2] = ["sssr@4", "stereo@4"];
const REFERENCE: &str = "path-traced@128";

/// All sweeps.
pub const SWEEPS: &[Sweep] = &[
    Sweep {
        name: "roughness",
        about: "a floor that reflects stripes, which are all in view as long as the lobe is narrow",
        unit: "perceptual roughness",
        values: &[0.02, 0.05, 0.1, 0.2, 0.4, 0.8],
        scene: |r| Arc::new(stripes(r as f32, 1.0)),
        // At 0.8 half of the rays leave the view, and black is used for them.
        bound: Bound::AtMost(2.5),
    },
    Sweep {
        name: "contrast",
        about: "a floor that reflects stripes, of which every second one is so many times as bright as the others",
        unit: "ratio",
        values: &[1.0, 10.0, 1e3, 1e5],
        scene: contrast,
        bound: Bound::AtMost(0.5),
    },
    Sweep {
        name: "ipd",
        about: "a hall with a column, in which one eye may see what the other does not",
        unit: "m",
        values: &[0.0, 0.03, 0.064, 0.2],
        scene: |ipd_m| Arc::new(hall(0.2, ipd_m)),
        bound: Bound::AtMost(1.0),
    },
    Sweep {
        name: "size",
        about: "stripes and viewer so many times as large",
        unit: "ratio",
        values: &[1e-3, 1.0, 1e5],
        scene: |factor| scaled(&stripes(0.2, 1.0), factor),
        bound: Bound::AtMost(0.5),
    },
    Sweep {
        name: "place",
        about: "stripes and viewer so far from the world's origin",
        unit: "m",
        values: &[0.0, 1e6, 1e9],
        scene: |m| moved(&stripes(0.2, 1.0), DVec3::splat(m)),
        bound: Bound::AtMost(0.5),
    },
];

/// Stripes with this contrast. The bright ones are multiplied by 1000 at most and the others are made darker, so that
/// fp16 can hold both.
fn contrast(ratio: f64) -> Arc<Scene> {
    let bright = ratio.min(1e3) as f32;
    let mut scene = stripes(0.35, bright);
    let dim = (f64::from(bright) / ratio) as f32;
    for m in scene.materials.iter_mut().filter(|m| m.emissive.z > m.emissive.x) {
        m.emissive *= dim;
    }
    Arc::new(scene)
}

/// The results of a method at one value.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Row {
    pub value: f64,
    pub method: &'static str,
    /// Σ(x − y)²/Σ(y − ȳ)² of the reflection against the reference.
    pub relative_squared_error: f64,
    /// The mean of (x − y)²/(y² + ε) with ε = (mean y/100)². Dark places count as much as bright ones.
    pub relative_mse: f64,
    /// Σx/Σy − 1.
    pub relative_bias: f64,
    /// The per cent of the rays that have no answer.
    pub unknown_percent: f64,
}

/// The results of a sweep.
#[derive(Debug, Clone, serde::Serialize)]
pub struct SweepResult {
    pub name: &'static str,
    pub about: &'static str,
    pub unit: &'static str,
    pub reference: &'static str,
    pub rows: Vec<Row>,
    /// The largest relative squared error, then the largest |bias|.
    pub worst_error: f64,
    pub worst_bias: f64,
    pub bound: Bound,
    pub passed: bool,
}

/// Runs a sweep. Its pictures stay on the bench.
///
/// # Errors
/// When a Vulkan call fails, or on Ctrl-C.
pub fn run(sweep: &Sweep, bench: &mut Bench) -> Result<SweepResult, RenderError> {
    bench.forget();
    let mut rows = Vec::new();
    for &value in sweep.values {
        let scene = (sweep.scene)(value);
        let settings = Settings { edge_fade: 0.1, ..settings(96, 64) };
        let label = format!("{}={value}", sweep.name);
        let reference = bench.render(&label, &scene, REFERENCE, &settings)?;
        for method in COMPARED {
            let rendered = bench.render(&label, &scene, method, &settings)?;
            let c = rendered.counters;
            rows.push(Row {
                value,
                method,
                relative_squared_error: relative_squared_error(&rendered.reflection, &reference.reflection),
                relative_mse: relative_mse(&rendered.reflection, &reference.reflection),
                relative_bias: relative_bias(&rendered.reflection, &reference.reflection),
                unknown_percent: 100.0 * c.missed() as f64 / c.rays.max(1) as f64,
            });
        }
    }
    let worst = |of: fn(&Row) -> f64| rows.iter().map(of).fold(0.0f64, |a, b| if a.is_nan() || a > b { a } else { b });
    let (worst_error, worst_bias) = (worst(|r| r.relative_squared_error), worst(|r| r.relative_bias.abs()));
    let passed = sweep.bound.holds(worst_error) && bench.not_finite().is_none();
    Ok(SweepResult {
        name: sweep.name,
        about: sweep.about,
        unit: sweep.unit,
        reference: REFERENCE,
        rows,
        worst_error,
        worst_bias,
        bound: sweep.bound,
        passed,
    })
}
