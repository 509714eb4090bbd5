//! Cases of ambient occlusion with a very small and a very large radius, and in pictures of odd sizes.

use std::sync::Arc;

use crate::render::{Ao, AoSettings, RenderError, Settings};
use crate::scene::Scene;

use super::bench::Bench;
use super::case::{Bound, Case, Worst};
use super::shapes::{furnace, hall, settings};

pub const CASES: &[Case] = &[
    Case {
        name: "ao-tiny-radius",
        hazard: "samples within less than a pixel show only the place itself, and 1/radius² is large",
        checks: "radius 1 mm in a hall and on a sphere: the most that the views hide, where nothing is hidden",
        unit: "visibility",
        bound: Bound::AtMost(0.0),
        run: tiny,
    },
    Case {
        name: "ao-huge-radius",
        hazard: "samples reach a thousand times as far as the scene, behind the eyes and beyond every border",
        checks: "radius 1 km in a hall and on a sphere: how far the visibility is outside 0 to 1",
        unit: "visibility",
        bound: Bound::AtMost(0.0),
        run: huge,
    },
    Case {
        name: "ao-odd-sizes",
        hazard: "the filter is wider than the picture, and lists have only a few pixels",
        checks: "radius 0.5 m in a hall, sizes from 1×1 to 127×65: how far the visibility is outside 0 to 1",
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

/// How far a value is outside 0 to 1. NaN gives NaN.
fn outside(value: f32) -> f64 {
    if value.is_nan() { f64::NAN } else { f64::from((value - 1.0).max(-value).max(0.0)) }
}

/// Renders a picture and takes the visibility of every pixel into account, as `of` measures it.
fn look(
    bench: &mut Bench,
    (name, scene): &(&'static str, Arc<Scene>),
    settings: &Settings,
    worst: &mut Worst,
    of: impl Fn(f32) -> f64,
) -> Result<(), RenderError> {
    let ao = settings.ao.method.name();
    let rendered = bench.render(&format!("{name} {ao}"), scene, "stereo", settings)?;
    let Some(seen) = &rendered.ambient_visibility else {
        worst.include(f64::INFINITY, format!("{name}, {ao}: there is no visibility"));
        return Ok(());
    };
    let at = format!("{name}, {ao}, {}×{}", settings.width, settings.height);
    seen.iter().flatten().for_each(|v| worst.include(of(*v), at.clone()));
    Ok(())
}

fn tiny(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for scene in &scenes() {
        // The method by rays is left out. Its rays find where floor and wall meet within a millimetre, which the views
        // do not show.
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
