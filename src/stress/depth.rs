//! Cases of depth, size, place and direction: changes that must not change a picture.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::{DQuat, DVec3};

use crate::render::RenderError;
use crate::scene::Scene;

use super::bench::Bench;
use super::case::{Bound, Case, Worst};
use super::measure::differing_percent;
use super::shapes::{moved, scaled, settings, stripes, turned};

/// One ray in a hundred may fall on the other side of an edge, because its numbers are rounded differently.
const EDGES: Bound = Bound::AtMost(1.0);
const UNIT: &str = "% of the pixels";

pub const CASES: &[Case] = &[
    Case {
        name: "hyperbolic-depth",
        hazard: "depth has large steps near the eye and tiny ones far from it",
        checks: "pixels that change by more than 1 % when the near plane moves from 5 cm to 10 µm or to 1 m",
        unit: UNIT,
        bound: EDGES,
        run: near_planes,
    },
    Case {
        name: "tiny-scene",
        hazard: "squares of millimetres underflow",
        checks: "pixels that change by more than 1 % when everything is 1e-3 times as large",
        unit: UNIT,
        bound: EDGES,
        run: |bench| compare(bench, |s| scaled(s, 1e-3)),
    },
    Case {
        name: "huge-scene",
        hazard: "metres are lost in sums with squares of 100 km",
        checks: "pixels that change by more than 1 % when everything is 1e5 times as large",
        unit: UNIT,
        bound: EDGES,
        run: |bench| compare(bench, |s| scaled(s, 1e5)),
    },
    Case {
        name: "far-from-origin",
        hazard: "an f32 has steps of 6 cm at 1e6 m from the origin",
        checks: "pixels that change by more than 1 % when everything is moved by 1e6 m along each axis",
        unit: UNIT,
        bound: EDGES,
        run: |bench| compare(bench, |s| moved(s, DVec3::new(1e6, -1e6, 1e6))),
    },
    Case {
        name: "views-along-axes",
        hazard: "a view that looks along an axis has zeros in its matrix",
        checks: "pixels that change by more than 1 % when everything is turned by quarter turns, and by odd angles",
        unit: UNIT,
        bound: EDGES,
        run: turns,
    },
];

/// The scene that is changed. Its floor counts as a mirror, so that the picture does not depend on random numbers, and
/// equal geometry gives equal pixels.
fn plain() -> Scene {
    stripes(0.02, 1.0)
}

fn compare(bench: &mut Bench, change: impl Fn(&Scene) -> Arc<Scene>) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    see_change(bench, &mut worst, "changed", change)?;
    Ok(worst)
}

fn see_change(
    bench: &mut Bench,
    worst: &mut Worst,
    label: &str,
    change: impl Fn(&Scene) -> Arc<Scene>,
) -> Result<(), RenderError> {
    let (plain, changed) = (Arc::new(plain()), change(&plain()));
    for method in ["sssr", "stereo", "path-traced@1"] {
        let a = bench.render("plain", &plain, method, &settings(96, 64))?;
        let b = bench.render(label, &changed, method, &settings(96, 64))?;
        worst.include(differing_percent(&a.linear, &b.linear, 0.01), format!("{label}, {method}"));
    }
    Ok(())
}

fn near_planes(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for near_m in [1e-5, 1.0] {
        see_change(bench, &mut worst, &format!("near {near_m} m"), |s| {
            let mut s = s.clone();
            s.views[0].near_m = near_m;
            Arc::new(s)
        })?;
    }
    Ok(worst)
}

fn turns(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for (label, by) in [
        ("to +x", DQuat::from_rotation_y(-FRAC_PI_2)),
        ("up", DQuat::from_rotation_x(FRAC_PI_2)),
        ("down", DQuat::from_rotation_x(-FRAC_PI_2)),
        ("askew", DQuat::from_euler(glam::EulerRot::XYZ, 0.7, -2.1, 1.3)),
    ] {
        see_change(bench, &mut worst, label, |s| turned(s, by))?;
    }
    Ok(worst)
}
