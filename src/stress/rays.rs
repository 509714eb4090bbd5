//! Rays in awkward directions: along the surface, along an axis of the screen or of the view, towards the eye.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec3};

use crate::render::{RenderError, Settings};
use crate::scene::{Fallback, Scene, View};

use super::bench::{Bench, Shot};
use super::case::{Bound, Case, Worst};
use super::measure::{differing_percent, most};
use super::shapes::{glowing, look, material, place, plane, scene, settings, upright};

pub const CASES: &[Case] = &[
    Case {
        name: "grazing-self-hit",
        hazard: "a ray meets the surface it starts on",
        checks: "a lone floor seen from 30° down to 0.05°: rays of the reference that hit something",
        unit: "% of the rays",
        bound: Bound::AtMost(0.0),
        run: |bench| self_hits(bench, &["path-traced@4"]),
    },
    Case {
        name: "grazing-self-hit-on-screen",
        hazard: "a ray meets the pixels next to its own",
        checks: "as grazing-self-hit, for screen space: rays that hit something or went behind it",
        unit: "% of the rays",
        // A pixel's depth is a step; a ray that stays within a pixel's rise of the floor may meet the next one.
        bound: Bound::AtMost(0.5),
        run: |bench| self_hits(bench, &["sssr", "stereo", "sssr-thickness"]),
    },
    Case {
        name: "grazing-view",
        hazard: "n·v near 0",
        checks: "the most that a floor seen at 0.05° to 1° returns of a white world, roughness 0 to 1",
        unit: "radiance, of 1",
        bound: Bound::AtMost(1.02),
        run: grazing,
    },
    Case {
        name: "ray-along-screen-axis",
        hazard: "1/0 in the march",
        checks: "a mirror that sends the middle ray along x, and one along y: pixels that differ from the reference",
        unit: "% of the pixels",
        bound: Bound::AtMost(2.0),
        run: along_screen_axes,
    },
    Case {
        name: "ray-along-view-axis",
        hazard: "a ray shorter than a pixel",
        checks: "a mirror held before the eyes, a wall behind them: rays that claim to know what no view shows",
        unit: "% of the rays",
        bound: Bound::AtMost(0.0),
        run: along_view_axis,
    },
    Case {
        name: "ray-through-near-plane",
        hazard: "w changes its sign",
        checks: "a mirror that shows a floor before, beside and behind the eyes: known pixels that differ from the reference",
        unit: "% of the pixels",
        bound: Bound::AtMost(2.0),
        run: through_near_plane,
    },
    Case {
        name: "near-plane-cuts-a-surface",
        hazard: "triangles that cross the near plane",
        checks: "a mirror floor through the eyes' near plane in a white world cannot be seen",
        unit: "% of the pixels",
        // A floor whose far edge is seen edge-on to a 256th of a pixel has no side: a part of that row may be black.
        bound: Bound::AtMost(1.0),
        run: cut_by_near_plane,
    },
];

/// A floor of 20 m in a white world, seen at so many degrees.
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
                let shot = bench.render(&label, &floor, method, &settings(65, 33))?;
                let c = shot.counters;
                let hits = 100.0 * (c.hits + c.behind + c.back_facing) as f64 / c.rays as f64;
                worst.see(hits, format!("{label}, {method}: {} rays", c.rays));
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
                let shot = bench.render(&label, &floor, method, &white)?;
                worst.see(most(&shot.linear), format!("{label}, {method}"));
            }
        }
    }
    Ok(worst)
}

/// A mirror in the middle that sends the view's axis to `towards`, where a wall of two colours is.
fn corner(towards: DVec3) -> Arc<Scene> {
    let half = (DVec3::Z + towards).normalize();
    let turn = DQuat::from_rotation_arc(DVec3::Y, half);
    let mut parts = vec![(plane(2), material(0.0), place([0.5, 1.0, 0.5], turn, [0.0; 3]))];
    // Its face towards the mirror; its far half another colour, so that depth along the wall counts too.
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
        // Odd, so that the middle pixel's ray lies in the axis.
        let reference = bench.render(name, &corner, "path-traced@1", &settings(97, 97))?;
        for method in ["sssr", "stereo", "sssr-thickness"] {
            let shot = bench.render(name, &corner, method, &settings(97, 97))?;
            worst.see(differing_percent(&shot.linear, &reference.linear, 0.02), format!("{name}, {method}"));
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
            let shot = bench.render(&label, &held, method, &settings(65, 65))?;
            let c = shot.counters;
            let answered = 100.0 * (c.hits + c.sky) as f64 / c.rays as f64;
            worst.see(answered, format!("{label}, {method}: {} rays", c.rays));
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
    // Tipped forward: its rays come down before, beside and behind the viewer.
    let tipped = DQuat::from_rotation_x(1.25);
    let mut worst = Worst::largest();
    for turn in [upright(), tipped] {
        let mut parts = parts.clone();
        parts.push((plane(2), material(0.0), place([4.0, 1.0, 2.0], turn, [0.0, 1.0, -1.0])));
        let view = look(DVec3::new(0.0, 0.7, 1.2), DVec3::new(0.0, 0.5, -1.0));
        let floor = Arc::new(scene(parts, 0.0, view));
        let reference = bench.render("floor", &floor, "path-traced@1", &settings(97, 65))?;
        for method in ["sssr", "stereo", "sssr-thickness"] {
            let shot = bench.render("floor", &floor, method, &settings(97, 65))?;
            worst.see(differing_percent(&known(&shot, &reference), &reference.linear, 0.02), method);
        }
    }
    Ok(worst)
}

/// The picture with the reference's pixels where nothing is known.
fn known(shot: &Shot, reference: &Shot) -> crate::picture::StereoPicture {
    let mut out = shot.linear.clone();
    for eye in 0..2 {
        for (i, texel) in out.eyes[eye].iter_mut().enumerate() {
            if shot.reflection.eyes[eye][i] == [0.0; 3] && reference.reflection.eyes[eye][i] != [0.0; 3] {
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
            let shot = bench.render(&label, &cut, method, &white)?;
            let mut flat = shot.linear.clone();
            flat.eyes.iter_mut().flatten().for_each(|t| *t = [1.0; 3]);
            worst.see(differing_percent(&shot.linear, &flat, 2e-3), format!("{label}, {method}"));
        }
    }
    Ok(worst)
}
