//! Cases of rays in awkward directions: along the surface, along an axis of the screen or of the view, and towards the
//! eye.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec3};

use crate::render::{RenderError, Settings};
use crate::scene::{Fallback, Scene, View};

use super::bench::{Bench, CasePicture};
use super::case::{Bound, Case, Worst};
use super::measure::{differing_percent, most};
use super::shapes::{glowing, look, material, place, plane, scene, settings, upright};

pub const CASES: &[Case] = &[
    Case {
        name: "grazing-self-hit",
        hazard: "a ray hits the surface that it starts on",
        checks: "a lone floor, seen at 30° to 0.05°: rays of the reference that hit something",
        unit: "% of the rays",
        bound: Bound::AtMost(0.0),
        run: |bench| self_hits(bench, &["path-traced@4"]),
    },
    Case {
        name: "grazing-self-hit-on-screen",
        hazard: "a ray hits the pixels next to its own",
        checks: "the same as grazing-self-hit, for screen space: rays that hit something or went behind it",
        unit: "% of the rays",
        // The depth of a pixel is a step. A ray that rises by less than such a step may hit the next pixel.
        bound: Bound::AtMost(0.5),
        run: |bench| self_hits(bench, &["sssr", "stereo", "sssr-thickness"]),
    },
    Case {
        name: "grazing-view",
        hazard: "n·v is near 0",
        checks: "the most that a floor, seen at 0.05° to 1°, reflects of a white world, roughness 0 to 1",
        unit: "radiance, where 1 is white",
        bound: Bound::AtMost(1.02),
        run: grazing,
    },
    Case {
        name: "ray-along-screen-axis",
        hazard: "the march through the view divides by 0",
        checks: "mirrors that reflect the middle ray along x and along y: pixels that differ from the reference",
        unit: "% of the pixels",
        bound: Bound::AtMost(2.0),
        run: along_screen_axes,
    },
    Case {
        name: "ray-along-view-axis",
        hazard: "a ray is shorter than a pixel on the screen",
        checks: "a mirror before the eyes and a wall behind them: rays with an answer, although no view has one",
        unit: "% of the rays",
        bound: Bound::AtMost(0.0),
        run: along_view_axis,
    },
    Case {
        name: "ray-through-near-plane",
        hazard: "w changes its sign along a ray",
        checks: "a mirror that shows a floor all around the eyes: known pixels that differ from the reference",
        unit: "% of the pixels",
        bound: Bound::AtMost(2.0),
        run: through_near_plane,
    },
    Case {
        name: "near-plane-cuts-a-surface",
        hazard: "triangles cross the near plane",
        checks: "a mirror floor that crosses the near plane in a white world: pixels that differ from white",
        unit: "% of the pixels",
        // The far edge of the floor is seen edge-on to within a 256th of a pixel. There neither side of the floor is
        // seen, and a part of that row of pixels may be black.
        bound: Bound::AtMost(1.0),
        run: cut_by_near_plane,
    },
];

/// A floor of 20 m in a white world, seen at this angle above it.
fn floor(roughness: f32, degrees: f64) -> Scene {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let view = View { vertical_fov_rad: 0.02, ..look(DVec3::new(0.0, sin, cos) * 2.0, DVec3::ZERO) };
    let place = place([20.0, 1.0, 20.0], DQuat::IDENTITY, [0.0; 3]);
    scene(vec![(plane(5), material(roughness), place)], 1.0, view)
}

fn self_hits(bench: &mut Bench, methods: &[&str]) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for degrees in [30.0, 1.0, 0.05] {
        for roughness in [0.0, 0.3] {
            let floor = Arc::new(floor(roughness, degrees));
            for &method in methods {
                let label = format!("{degrees}° r={roughness}");
                let rendered = bench.render(&label, &floor, method, &settings(65, 33))?;
                let c = rendered.counters;
                let hits = 100.0 * (c.hits + c.behind + c.back_facing) as f64 / c.rays as f64;
                worst.include(hits, format!("{label}, {method}: {} rays", c.rays));
            }
        }
    }
    Ok(worst)
}

fn grazing(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for degrees in [1.0, 0.05] {
        for roughness in [0.0, 0.04, 0.3, 1.0] {
            let floor = Arc::new(floor(roughness, degrees));
            for method in ["sssr", "path-traced@16"] {
                let white = Settings { fallback: Some(Fallback::Environment), ..settings(33, 17) };
                let label = format!("{degrees}° r={roughness}");
                let rendered = bench.render(&label, &floor, method, &white)?;
                worst.include(most(&rendered.linear), format!("{label}, {method}"));
            }
        }
    }
    Ok(worst)
}

/// A mirror in the middle that reflects the view's axis towards `towards`, where there is a wall of two colours.
fn corner(towards: DVec3) -> Arc<Scene> {
    let half = (DVec3::Z + towards).normalize();
    let turn = DQuat::from_rotation_arc(DVec3::Y, half);
    let mut parts = vec![(plane(2), material(0.0), place([0.5, 1.0, 0.5], turn, [0.0; 3]))];
    // The wall faces the mirror. Its two halves have different colours, so that an error of depth along it shows too.
    let facing = DQuat::from_rotation_arc(DVec3::Y, -towards);
    for (z, color) in [(-1.0, Vec3::new(0.2, 0.9, 0.3)), (1.0, Vec3::new(0.9, 0.5, 0.1))] {
        let at = towards + DVec3::new(0.0, 0.0, z);
        parts.push((plane(2), glowing(color), place([2.0, 1.0, 2.0], facing, at.to_array())));
    }
    let view = View { ipd_m: 0.0, vertical_fov_rad: 1.3, ..look(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO) };
    Arc::new(scene(parts, 0.0, view))
}

fn along_screen_axes(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for (name, towards) in [("+x", DVec3::X), ("-x", DVec3::NEG_X), ("+y", DVec3::Y), ("-y", DVec3::NEG_Y)] {
        let corner = corner(towards);
        // The size is odd, so that the ray of the middle pixel is along the axis.
        let reference = bench.render(name, &corner, "path-traced@1", &settings(97, 97))?;
        for method in ["sssr", "stereo", "sssr-thickness"] {
            let rendered = bench.render(name, &corner, method, &settings(97, 97))?;
            worst.include(differing_percent(&rendered.linear, &reference.linear, 0.02), format!("{name}, {method}"));
        }
    }
    Ok(worst)
}

fn along_view_axis(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mirror = (plane(2), material(0.0), place([1.0, 1.0, 1.0], upright(), [0.0; 3]));
    let wall = (plane(2), glowing(Vec3::ONE), place([50.0, 1.0, 50.0], upright().inverse(), [0.0, 0.0, 9.0]));
    let mut worst = Worst::largest();
    for (ipd_m, distance) in [(0.0, 1.0), (0.064, 1.0), (0.064, 0.06), (0.0, 100.0)] {
        let view = View { ipd_m, ..look(DVec3::new(0.0, 0.0, distance), DVec3::ZERO) };
        let held = Arc::new(scene(vec![mirror.clone(), wall.clone()], 0.0, view));
        for method in ["sssr", "stereo", "sssr-thickness"] {
            let label = format!("{distance} m, {ipd_m} m between the eyes");
            let rendered = bench.render(&label, &held, method, &settings(65, 65))?;
            let c = rendered.counters;
            let answered = 100.0 * (c.hits + c.sky) as f64 / c.rays as f64;
            worst.include(answered, format!("{label}, {method}: {} rays", c.rays));
        }
    }
    Ok(worst)
}

fn through_near_plane(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut parts = Vec::new();
    for i in 0..24 {
        let color = if i % 2 == 0 { Vec3::new(1.0, 0.6, 0.2) } else { Vec3::new(0.1, 0.3, 0.7) };
        parts.push((
            plane(2),
            glowing(color),
            place([20.0, 1.0, 0.5], DQuat::IDENTITY, [0.0, 0.0, 0.5 * f64::from(i) - 2.0]),
        ));
    }
    // A mirror that is tipped forward reflects rays down to the floor in front of, beside and behind the viewer.
    let tipped = DQuat::from_rotation_x(1.25);
    let mut worst = Worst::largest();
    for turn in [upright(), tipped] {
        let mut parts = parts.clone();
        parts.push((plane(2), material(0.0), place([4.0, 1.0, 2.0], turn, [0.0, 1.0, -1.0])));
        let view = look(DVec3::new(0.0, 0.7, 1.2), DVec3::new(0.0, 0.5, -1.0));
        let floor = Arc::new(scene(parts, 0.0, view));
        let reference = bench.render("floor", &floor, "path-traced@1", &settings(97, 65))?;
        for method in ["sssr", "stereo", "sssr-thickness"] {
            let rendered = bench.render("floor", &floor, method, &settings(97, 65))?;
            worst.include(differing_percent(&known(&rendered, &reference), &reference.linear, 0.02), method);
        }
    }
    Ok(worst)
}

/// The picture, with the reference's pixels where the reflection is unknown.
fn known(rendered: &CasePicture, reference: &CasePicture) -> crate::picture::StereoPicture {
    let mut out = rendered.linear.clone();
    for eye in 0..2 {
        for (i, texel) in out.eyes[eye].iter_mut().enumerate() {
            if rendered.reflection.eyes[eye][i] == [0.0; 3] && reference.reflection.eyes[eye][i] != [0.0; 3] {
                *texel = reference.linear.eyes[eye][i];
            }
        }
    }
    out
}

fn cut_by_near_plane(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for height in [0.04, 1e-3, 1e-6] {
        let view = View { vertical_fov_rad: 2.0, ..look(DVec3::new(0.0, height, 0.0), DVec3::new(0.0, height, -1.0)) };
        let wide = DAffine3::from_scale(DVec3::new(30.0, 1.0, 30.0));
        let cut = Arc::new(scene(vec![(plane(3), material(0.0), wide)], 1.0, view));
        for method in ["sssr", "stereo", "path-traced@1"] {
            let white = Settings { fallback: Some(Fallback::Environment), ..settings(65, 49) };
            let label = format!("{height} m above");
            let rendered = bench.render(&label, &cut, method, &white)?;
            let mut flat = rendered.linear.clone();
            flat.eyes.iter_mut().flatten().for_each(|t| *t = [1.0; 3]);
            worst.include(differing_percent(&rendered.linear, &flat, 2e-3), format!("{label}, {method}"));
        }
    }
    Ok(worst)
}
