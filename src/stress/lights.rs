//! Cases of lights in places where their shadows are hard to find, and of unusual lights.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec3};

use crate::render::{RenderError, Settings};
use crate::scene::{Light, LightSource, Material, Scene};

use super::bench::Bench;
use super::case::{Bound, Case, Worst};
use super::measure::{METHODS, farthest_from, mean, most};
use super::shapes::{look, material, place, plane, scene, settings, sphere, upright};

pub const CASES: &[Case] = &[
    Case {
        name: "light-inside-matter",
        hazard: "a light is inside a closed mesh, or below the floor",
        checks: "the most light in the picture by any method, although none may come out",
        unit: "radiance",
        bound: Bound::AtMost(1e-4),
        run: inside,
    },
    Case {
        name: "light-behind-wall",
        hazard: "light leaks in at the seams of a closed room",
        checks: "the most light by any method in a closed room whose lights are all outside",
        unit: "radiance",
        bound: Bound::AtMost(1e-4),
        run: outside,
    },
    Case {
        name: "coplanar-light",
        hazard: "a light is in the plane of a surface, which every ray then grazes",
        checks: "the most light on the plane that the light is in",
        unit: "radiance",
        bound: Bound::AtMost(1e-3),
        run: coplanar,
    },
    Case {
        name: "grazing-sun",
        hazard: "a sun 0.01 to 1 degree above the floor makes shadow acne",
        checks: "the largest change by shadows on an empty floor, over its brightest value",
        unit: "relative to the light",
        bound: Bound::AtMost(1e-4),
        run: grazing,
    },
    Case {
        name: "many-lights",
        hazard: "64 lights at once",
        checks: "the mean light of 64 lights against that of one light with their sum, all in one place",
        unit: "relative to the one light",
        bound: Bound::AtMost(1e-3),
        run: many,
    },
    Case {
        name: "light-sizes",
        hazard: "a light is 1e-6 m or 1000 m large, or is behind the camera",
        checks: "the largest change by shadows, where nothing is in the way of the light",
        unit: "radiance",
        bound: Bound::AtMost(1e-3),
        run: sizes,
    },
];

fn point(position: DVec3, intensity: f32) -> Light {
    LightSource::Point { position, intensity: Vec3::splat(intensity), range_m: f32::INFINITY }.into()
}

/// A material for white matt surfaces.
fn chalk() -> Material {
    Material { metallic: 0.0, ..material(1.0) }
}

/// A chalk ball and a polished ball on a polished floor. There is no light but `lights`.
fn dark(lights: Vec<Light>) -> Scene {
    let parts = vec![
        (plane(4), material(0.2), place([6.0, 1.0, 6.0], DQuat::IDENTITY, [0.0, 0.0, 0.0])),
        (sphere(32), chalk(), place([0.5; 3], DQuat::IDENTITY, [-0.6, 0.5, 0.0])),
        (sphere(32), material(0.1), place([0.5; 3], DQuat::IDENTITY, [0.6, 0.5, 0.0])),
    ];
    let mut made = scene(parts, 0.0, look(DVec3::new(0.0, 1.0, 3.0), DVec3::new(0.0, 0.4, 0.0)));
    made.lights = lights;
    made
}

fn every_method(bench: &mut Bench, label: &str, scene: Scene, worst: &mut Worst) -> Result<(), RenderError> {
    let scene = Arc::new(scene);
    for method in METHODS {
        let rendered = bench.render(label, &scene, method, &settings(48, 32))?;
        worst.include(most(&rendered.linear), format!("{label}, {method}"));
    }
    Ok(())
}

fn inside(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    every_method(bench, "within a ball", dark(vec![point(DVec3::new(-0.6, 0.5, 0.0), 10.0)]), &mut worst)?;
    every_method(bench, "below the floor", dark(vec![point(DVec3::new(0.0, -0.5, 0.0), 10.0)]), &mut worst)?;
    Ok(worst)
}

fn outside(bench: &mut Bench) -> Result<Worst, RenderError> {
    let back_to_front = upright();
    let side = |turn: DQuat, at: [f64; 3]| (plane(3), chalk(), place([4.0, 1.0, 4.0], turn, at));
    let half_turn = DQuat::from_rotation_x(std::f64::consts::PI);
    let quarter = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
    let mut parts = vec![
        side(half_turn, [0.0, 2.0, 0.0]),
        side(back_to_front, [0.0, 0.0, -2.0]),
        side(half_turn * back_to_front, [0.0, 0.0, 2.0]),
        side(quarter.inverse(), [-2.0, 0.0, 0.0]),
        side(quarter, [2.0, 0.0, 0.0]),
    ];
    parts.push((plane(3), material(0.2), place([4.0, 1.0, 4.0], DQuat::IDENTITY, [0.0, -2.0, 0.0])));
    let mut room = scene(parts, 0.0, look(DVec3::new(0.3, 0.0, 1.7), DVec3::new(0.0, -0.8, -1.0)));
    let sun =
        LightSource::Directional { direction: Vec3::new(0.3, -0.8, 0.5).normalize(), irradiance: Vec3::splat(10.0) };
    let soft = Light { size: 0.01, ..sun.into() };
    room.lights = vec![point(DVec3::new(2.5, 2.5, 0.0), 10.0), soft, point(DVec3::new(0.0, -2.05, 0.0), 10.0)];
    let mut worst = Worst::largest();
    every_method(bench, "closed room", room, &mut worst)?;
    Ok(worst)
}

fn coplanar(bench: &mut Bench) -> Result<Worst, RenderError> {
    let parts = || vec![(plane(4), chalk(), place([6.0, 1.0, 6.0], DQuat::IDENTITY, [0.0, 0.0, 0.0]))];
    let mut worst = Worst::largest();
    for height in [0.0, 1e-7] {
        let mut floor = scene(parts(), 0.0, look(DVec3::new(0.0, 1.0, 3.0), DVec3::ZERO));
        floor.lights = vec![point(DVec3::new(0.0, height, 0.0), 1.0)];
        every_method(bench, &format!("{height:e} m above the floor"), floor, &mut worst)?;
    }
    Ok(worst)
}

fn grazing(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for degrees in [0.01f32, 0.1, 1.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        // So bright that the floor has the same light at every height of the sun.
        let sun = LightSource::Directional {
            direction: Vec3::new(cosine, -sine, 0.0),
            irradiance: Vec3::splat(std::f32::consts::PI / sine),
        };
        let parts = vec![(plane(16), chalk(), place([30.0, 1.0, 30.0], DQuat::IDENTITY, [0.0, 0.0, 0.0]))];
        let mut floor = scene(parts, 0.0, look(DVec3::new(0.0, 1.5, 3.0), DVec3::ZERO));
        floor.lights = vec![sun.into()];
        let floor = Arc::new(floor);
        let lit = bench.render("no shadows", &floor, "sssr", &Settings { shadows: false, ..settings(96, 64) })?;
        let rendered = bench.render("shadows", &floor, "sssr", &settings(96, 64))?;
        let differences = rendered.linear.eyes.iter().flatten().zip(lit.linear.eyes.iter().flatten());
        let largest = differences.map(|(a, b)| f64::from((a[0] - b[0]).abs())).fold(0.0, f64::max);
        worst.include(largest / most(&lit.linear).max(1e-9), format!("{degrees} degrees"));
    }
    Ok(worst)
}

fn many(bench: &mut Bench) -> Result<Worst, RenderError> {
    let place = DVec3::new(0.4, 2.0, 1.0);
    let one = Arc::new(dark(vec![point(place, 6.4)]));
    let many = Arc::new(dark((0..64).map(|_| point(place, 0.1)).collect()));
    let mut worst = Worst::largest();
    for method in METHODS {
        let a = bench.render("one light", &one, method, &settings(48, 32))?;
        let b = bench.render("64 lights", &many, method, &settings(48, 32))?;
        worst.include((mean(&b.linear) / mean(&a.linear) - 1.0).abs(), method);
    }
    Ok(worst)
}

fn sizes(bench: &mut Bench) -> Result<Worst, RenderError> {
    let parts = || vec![(plane(4), chalk(), DAffine3::from_scale(DVec3::new(3.0, 1.0, 3.0)))];
    let mut worst = Worst::largest();
    for (label, position, size) in [
        ("1e-6 m", DVec3::new(0.0, 1.0, 0.0), 1e-6),
        ("1000 m", DVec3::new(0.0, 1.0, 0.0), 1000.0),
        ("behind the camera", DVec3::new(0.0, 1.2, 4.0), 0.05),
    ] {
        let mut floor = scene(parts(), 0.0, look(DVec3::new(0.0, 1.0, 3.0), DVec3::ZERO));
        floor.lights = vec![Light { size, ..point(position, 1.0) }];
        let floor = Arc::new(floor);
        for method in METHODS {
            let lit = bench.render(label, &floor, method, &Settings { shadows: false, ..settings(48, 32) })?;
            let rendered = bench.render(label, &floor, method, &settings(48, 32))?;
            let mut difference = rendered.linear.clone();
            for (d, l) in difference.eyes.iter_mut().flatten().zip(lit.linear.eyes.iter().flatten()) {
                *d = [0, 1, 2].map(|c| d[c] - l[c]);
            }
            worst.include(farthest_from(&difference, 0.0), format!("{label}, {method}"));
        }
    }
    Ok(worst)
}
