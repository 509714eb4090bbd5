//! Ambient occlusion that looks hardly anywhere, or everywhere.

use std::sync::Arc;

use crate::render::{Ao, AoSettings, RenderError, Settings};
use crate::scene::Scene;

use super::bench::Bench;
use super::case::{Bound, Case, Worst};
use super::shapes::{furnace, hall, settings};

pub const CASES: &[Case] = &[
    Case {
        name: "ao-tiny-radius",
        hazard: "a disk smaller than a pixel shows only the place itself, and 1/radius² is large",
        checks: "radius 1 mm, hall and sphere: how much any view hides of what is open",
        unit: "visibility",
        bound: Bound::AtMost(0.0),
        run: tiny,
    },
    Case {
        name: "ao-huge-radius",
        hazard: "a disk a thousand times as large as the scene: samples behind the eyes and beyond every border",
        checks: "radius 1 km, hall and sphere: how far the visibility lies outside 0 to 1",
        unit: "visibility",
        bound: Bound::AtMost(0.0),
        run: huge,
    },
    Case {
        name: "ao-odd-sizes",
        hazard: "a filter wider than the picture, lists of a few pixels",
        checks: "1×1 to 127×65, radius 0.5 m, hall: how far the visibility lies outside 0 to 1",
        unit: "visibility",
        bound: Bound::AtMost(0.0),
        run: odd_sizes,
    },
];

const ALL: [Ao; 5] = [Ao::Mono, Ao::Fsa, Ao::Variant1, Ao::Variant2, Ao::RayTraced];

fn scenes() -> [(&'static str, Arc<Scene>); 2] {
    [("hall", Arc::new(hall(0.3, 0.3))), ("sphere", Arc::new(furnace(0.9)))]
}

fn occluded(method: Ao, radius_m: f32, settings: Settings) -> Settings {
    Settings { ao: AoSettings { method, radius_m, rays: 4, ..AoSettings::default() }, ..settings }
}

/// As far as a value lies outside 0 to 1; NaN stays.
fn outside(value: f32) -> f64 {
    if value.is_nan() { f64::NAN } else { f64::from((value - 1.0).max(-value).max(0.0)) }
}

/// The largest of a picture's values after `of`; NaN stays.
fn look(
    bench: &mut Bench,
    (name, scene): &(&'static str, Arc<Scene>),
    settings: &Settings,
    worst: &mut Worst,
    of: impl Fn(f32) -> f64,
) -> Result<(), RenderError> {
    let ao = settings.ao.method.name();
    let shot = bench.render(&format!("{name} {ao}"), scene, "stereo", settings)?;
    let Some(seen) = &shot.ambient_visibility else {
        worst.see(f64::INFINITY, format!("{name}, {ao}: nothing was found"));
        return Ok(());
    };
    let at = format!("{name}, {ao}, {}×{}", settings.width, settings.height);
    seen.iter().flatten().for_each(|v| worst.see(of(*v), at.clone()));
    Ok(())
}

fn tiny(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for scene in &scenes() {
        // Rays find the contact of floor and wall within a millimetre; the views do not show it.
        for ao in Ao::OF_VIEWS {
            let settings = occluded(ao, *AoSettings::RADII_M.start(), settings(65, 33));
            look(bench, scene, &settings, &mut worst, |v| f64::from(1.0 - v).abs())?;
        }
    }
    Ok(worst)
}

fn huge(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for scene in &scenes() {
        for ao in ALL {
            let settings = occluded(ao, *AoSettings::RADII_M.end(), settings(65, 33));
            look(bench, scene, &settings, &mut worst, outside)?;
        }
    }
    Ok(worst)
}

fn odd_sizes(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    let hall = ("hall", Arc::new(hall(0.3, 0.3)));
    for (width, height) in [(1, 1), (1, 64), (64, 1), (7, 5), (127, 65)] {
        for ao in ALL {
            look(bench, &hall, &occluded(ao, 0.5, settings(width, height)), &mut worst, outside)?;
        }
    }
    Ok(worst)
}
