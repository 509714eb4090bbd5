//! Cases of scenes with almost nothing in them. Each must give the right picture.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec3};

use crate::render::RenderError;
use crate::scene::{Fallback, LightSource, View};

use super::bench::Bench;
use super::case::{Bound, Case, Worst};
use super::measure::{METHODS, farthest_from, most, unequal};
use super::shapes::{glowing, look, material, place, plane, primitive, scene, settings, sphere};

pub const CASES: &[Case] = &[
    Case {
        name: "empty-scene",
        hazard: "there is nothing to draw",
        checks: "a scene without triangles: distance from its environment",
        unit: "radiance, where 0.25 is right",
        bound: Bound::AtMost(0.0),
        run: empty,
    },
    Case {
        name: "no-light",
        hazard: "there is no light",
        checks: "a mirror in the dark: the most light in the picture",
        unit: "radiance",
        bound: Bound::AtMost(0.0),
        run: dark,
    },
    Case {
        name: "one-triangle",
        hazard: "the hierarchy has a single leaf",
        checks: "a single mirror triangle in a white world: distance from white",
        unit: "radiance, where 1 is white",
        // The table of albedos is fp16 and is read with bilinear filtering.
        bound: Bound::AtMost(2e-3),
        run: one_triangle,
    },
    Case {
        name: "singular-placement",
        hazard: "an instance that is scaled to a point or to a plane has no inverse",
        checks: "pixels that change when instances of zero size are added",
        unit: "pixels",
        bound: Bound::AtMost(0.0),
        run: singular,
    },
    Case {
        name: "light-in-a-surface",
        hazard: "1/d² is infinite at distance 0",
        checks: "point lights on a floor and in the eye: the most light in the picture after clamping to fp16",
        unit: "radiance",
        bound: Bound::AtMost(2.0 * 65504.0),
        run: light_in_a_surface,
    },
];

fn view() -> View {
    look(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO)
}

fn empty(bench: &mut Bench) -> Result<Worst, RenderError> {
    let empty = Arc::new(scene(Vec::new(), 0.25, view()));
    let mut worst = Worst::largest();
    for method in METHODS {
        let rendered = bench.render("empty", &empty, method, &settings(33, 17))?;
        worst.include(farthest_from(&rendered.linear, 0.25), method);
    }
    Ok(worst)
}

fn dark(bench: &mut Bench) -> Result<Worst, RenderError> {
    let dark = Arc::new(scene(vec![(plane(1), material(0.0), DAffine3::IDENTITY)], 0.0, view()));
    let mut worst = Worst::largest();
    for method in METHODS {
        let rendered = bench.render("dark", &dark, method, &settings(33, 17))?;
        worst.include(most(&rendered.linear), method);
    }
    Ok(worst)
}

fn one_triangle(bench: &mut Bench) -> Result<Worst, RenderError> {
    let corners = vec![Vec3::new(-0.5, 0.0, 0.5), Vec3::new(0.5, 0.0, 0.5), Vec3::new(0.0, 0.0, -0.5)];
    let triangle = primitive(corners, vec![Vec3::Y; 3], vec![0, 1, 2], false);
    let one = Arc::new(scene(vec![(triangle, material(0.0), DAffine3::IDENTITY)], 1.0, view()));
    let mut worst = Worst::largest();
    for method in METHODS {
        let settings = crate::render::Settings { fallback: Some(Fallback::Environment), ..settings(33, 17) };
        let rendered = bench.render("triangle", &one, method, &settings)?;
        worst.include(farthest_from(&rendered.linear, 1.0), method);
    }
    Ok(worst)
}

fn singular(bench: &mut Bench) -> Result<Worst, RenderError> {
    let parts = || {
        let flat = place([0.4, 0.0, 0.4], DQuat::IDENTITY, [0.0, 0.1, 0.0]);
        vec![(plane(2), material(0.2), DAffine3::IDENTITY), (sphere(6), glowing(Vec3::ONE), flat)]
    };
    let mut more = parts();
    for scale in [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1e-30, 1e-30, 1e-30]] {
        more.push((sphere(4), material(0.3), place(scale, DQuat::IDENTITY, [0.1, 0.2, 0.1])));
    }
    let (plain, with) = (Arc::new(scene(parts(), 0.5, view())), Arc::new(scene(more, 0.5, view())));
    let mut worst = Worst::largest();
    for method in METHODS {
        let a = bench.render("without", &plain, method, &settings(48, 27))?;
        let b = bench.render("with", &with, method, &settings(48, 27))?;
        for eye in 0..2 {
            worst.include(unequal(&a.linear.eyes[eye], &b.linear.eyes[eye]), format!("{method}, eye {eye}"));
        }
    }
    Ok(worst)
}

fn light_in_a_surface(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut lit = scene(vec![(plane(2), material(0.05), DAffine3::IDENTITY)], 0.1, view());
    for position in [DVec3::ZERO, view().position, DVec3::new(0.1, 1e-9, 0.1)] {
        lit.lights.push(LightSource::Point { position, intensity: Vec3::splat(1e6), range_m: f32::INFINITY }.into());
    }
    let lit = Arc::new(lit);
    let mut worst = Worst::largest();
    for method in METHODS {
        let rendered = bench.render("light", &lit, method, &settings(33, 17))?;
        worst.include(most(&rendered.linear), method);
    }
    Ok(worst)
}
