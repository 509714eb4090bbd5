//! Cases of the range of radiance: beyond fp16, very small, and both at once.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};

use crate::render::{Firefly, RenderError, Settings};
use crate::scene::{Fallback, LightSource};

use super::bench::Bench;
use super::case::{Bound, Case, Worst};
use super::measure::{METHODS, differing_percent, most, relative_bias};
use super::shapes::{constant_environment, look, material, plane, scene, settings, stripes};

pub const CASES: &[Case] = &[
    Case {
        name: "fp16-overflow",
        hazard: "radiance is beyond 65504, where fp16 ends",
        checks: "emitters, lights and environments of 1e5 to 3e38: the most light in a picture",
        unit: "radiance",
        // Direct light and reflection are each at most 65504.
        bound: Bound::AtMost(2.0 * 65504.0),
        run: overflow,
    },
    Case {
        name: "fp16-overflow-counted",
        hazard: "light is clamped without being counted",
        checks: "the same emitters and lights: the least number of values that were counted as clamped",
        unit: "values",
        bound: Bound::AtLeast(1.0),
        run: counted,
    },
    Case {
        name: "dim-light",
        hazard: "fp16 has no numbers below 6e-8",
        checks: "everything 1e-3 times as bright: pixels that differ by more than 2 % from that",
        unit: "% of the pixels",
        bound: Bound::AtMost(1.0),
        run: dim,
    },
    Case {
        name: "stiff-contrast",
        hazard: "one stripe is 1e5 times as bright as the next",
        checks: "bias of the mean reflection with 16 rays against the reference with 256, all of it in view",
        unit: "relative to the reference",
        bound: Bound::AtMost(0.05),
        run: stiff,
    },
];

/// Scenes with stripes or lights beyond fp16, with their labels.
fn too_bright() -> Vec<(String, Arc<crate::scene::Scene>)> {
    let view = || look(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO);
    let mut out = Vec::new();
    for bright in [1e5, 1e20, 3e38] {
        out.push((format!("emitter {bright:e}"), Arc::new(stripes(0.2, bright))));
        let mut lit = scene(vec![(plane(2), material(0.3), DAffine3::IDENTITY)], 0.1, view());
        let (intensity, range_m) = (Vec3::splat(bright), f32::INFINITY);
        lit.lights.push(LightSource::Point { position: DVec3::new(0.0, 0.5, 0.0), intensity, range_m }.into());
        lit.lights.push(LightSource::Directional { direction: Vec3::NEG_Y, irradiance: intensity }.into());
        out.push((format!("lights {bright:e}"), Arc::new(lit)));
    }
    out
}

fn overflow(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    let mut scenes = too_bright();
    let mut sky = stripes(0.2, 1.0);
    sky.environment = constant_environment(f32::MAX);
    scenes.push(("sky 3e38".to_owned(), Arc::new(sky)));
    for (label, scene) in scenes {
        for method in METHODS {
            let white = Settings { fallback: Some(Fallback::Environment), ..settings(48, 32) };
            let rendered = bench.render(&label, &scene, method, &white)?;
            worst.include(most(&rendered.linear), format!("{label}, {method}"));
        }
    }
    Ok(worst)
}

fn counted(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::smallest();
    for (label, scene) in too_bright() {
        for method in METHODS {
            let rendered = bench.render(&label, &scene, method, &settings(48, 32))?;
            worst.include(rendered.counters.clamped as f64, format!("{label}, {method}"));
        }
    }
    Ok(worst)
}

fn dim(bench: &mut Bench) -> Result<Worst, RenderError> {
    let (bright, mut dim) = (stripes(0.3, 1.0), stripes(0.3, 1.0));
    dim.materials.iter_mut().for_each(|m| m.emissive *= 1e-3);
    let (bright, dim) = (Arc::new(bright), Arc::new(dim));
    let mut worst = Worst::largest();
    for method in METHODS {
        // The bound of bright taps is left out. It depends on what a display shows, so at another brightness it would
        // bound other taps.
        let unbounded = Settings { firefly: Some(Firefly::None), ..settings(48, 32) };
        let a = bench.render("bright", &bright, method, &unbounded)?;
        let b = bench.render("dim", &dim, method, &unbounded)?;
        let mut again = b.linear.clone();
        again.eyes.iter_mut().flatten().flatten().for_each(|v| *v *= 1e3);
        worst.include(differing_percent(&a.linear, &again, 0.02), method);
    }
    Ok(worst)
}

fn stiff(bench: &mut Bench) -> Result<Worst, RenderError> {
    // The dim stripes get 1e-3 of their light, so that the bright ones stay within fp16.
    let mut contrast = stripes(0.35, 100.0);
    for m in contrast.materials.iter_mut().filter(|m| m.emissive.x < 1.0) {
        m.emissive *= 1e-3;
    }
    let contrast = Arc::new(contrast);
    let reference = bench.render("stiff", &contrast, "path-traced@256", &settings(96, 64))?;
    let mut worst = Worst::largest();
    for method in ["sssr@16", "stereo@16"] {
        // The bound of bright taps is left out, because it is biased on purpose (docs/rendering.md). This case is about
        // the arithmetic.
        let unbounded = Settings { firefly: Some(Firefly::None), ..settings(96, 64) };
        let rendered = bench.render("stiff", &contrast, method, &unbounded)?;
        worst.include(relative_bias(&rendered.reflection, &reference.reflection).abs(), method);
    }
    Ok(worst)
}
