//! Cases of the reflection lobe from mirror to matt: its energy, and its albedo against a quadrature that is computed
//! here.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use crate::render::{RenderError, Settings};
use crate::scene::{Fallback, Scene, View};

use super::bench::Bench;
use super::case::{Bound, Case, Worst};
use super::measure::{farthest_from, mean, most};
use super::shapes::{furnace, look, material, place, plane, scene, settings};

pub const CASES: &[Case] = &[
    Case {
        name: "mirror",
        hazard: "with α = 0 the density D is ∞·0",
        checks: "a mirror (roughness 0, 1e-30, 1e-4, 0.0299; n·v 1 to 0.05) in a white world: distance from white",
        unit: "radiance, where 1 is white",
        // The table of albedos is fp16 and is read with bilinear filtering.
        bound: Bound::AtMost(2e-3),
        run: mirror,
    },
    Case {
        name: "mirror-ball",
        hazard: "the normal of a facet is not that of the ball",
        checks: "a mirror ball in a white world: pixels that differ by more than 0.2 %",
        unit: "% of the pixels",
        // At the rim a reflection about the smooth normal may point below the facet, which then hides it.
        bound: Bound::AtMost(0.5),
        run: mirror_ball,
    },
    Case {
        name: "white-furnace",
        hazard: "a lobe reflects more light than arrives",
        checks: "the most that a white ball reflects of a white world, roughness 0 to 1 in 11 steps",
        unit: "radiance, where 1 is white",
        bound: Bound::AtMost(1.02),
        run: gain,
    },
    Case {
        name: "lobe-albedo",
        hazard: "samples do not have the density that they are weighed with",
        checks: "roughness 0.03 to 0.8, n·v 1 to 0.05: distance of the mean from the lobe's albedo by quadrature",
        unit: "relative to the albedo",
        bound: Bound::AtMost(0.02),
        run: lobe_albedo,
    },
    Case {
        name: "energy-lost",
        hazard: "single scattering loses the light that would be reflected again",
        checks: "the least that a white plane reflects, roughness 0 to 1, n·v 1 to 0.05 (0.307 by quadrature)",
        unit: "radiance, where 1 is white",
        bound: Bound::AtLeast(0.29),
        run: loss,
    },
];

/// The directional albedo of the GGX lobe with a Fresnel term of 1 and Smith's height-correlated masking (Heitz 2014).
/// It is computed by quadrature over half vectors, without random samples and without code of the renderer.
pub fn albedo(nv: f64, roughness: f64) -> f64 {
    let alpha = roughness * roughness;
    let v = [(1.0 - nv * nv).sqrt(), 0.0, nv];
    let lambda = |c: f64| (((1.0 - c * c) * alpha * alpha / (c * c) + 1.0).sqrt() - 1.0) / 2.0;
    let (steps, turns) = (400, 400);
    let mut sum = 0.0;
    for i in 0..steps {
        // With tan θ_h = α·√(u/(1 − u)) the half vectors are distributed as by D.
        let u = (f64::from(i) + 0.5) / f64::from(steps);
        let tan2 = alpha * alpha * u / (1.0 - u);
        let ch = 1.0 / (1.0 + tan2).sqrt();
        let sh = (1.0 - ch * ch).max(0.0).sqrt();
        for j in 0..turns {
            let phi = std::f64::consts::TAU * (f64::from(j) + 0.5) / f64::from(turns);
            let h = [sh * phi.cos(), sh * phi.sin(), ch];
            let vh = v[0] * h[0] + v[2] * h[2];
            let nl = 2.0 * vh * h[2] - v[2];
            if vh <= 0.0 || nl <= 0.0 {
                continue;
            }
            // This follows from f·cos θ_l dω_l = D G F/(4 nv) dω_l, dω_l = 4 vh dω_h and D·ch dω_h = du dφ/2π.
            let g2 = 1.0 / (1.0 + lambda(nv) + lambda(nl));
            sum += g2 * vh / (nv * ch);
        }
    }
    sum / f64::from(steps * turns)
}

fn white(width: u32, height: u32) -> Settings {
    Settings { fallback: Some(Fallback::Environment), ..settings(width, height) }
}

fn mirror(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for roughness in [0.0, 1e-30, 1e-4, 0.0299] {
        for nv in TILTS {
            let floor = tilted(roughness, nv);
            for method in ["sssr", "path-traced@1"] {
                let rendered = bench.render(&format!("r={roughness} nv={nv}"), &floor, method, &white(16, 16))?;
                worst.include(
                    farthest_from(&rendered.linear, 1.0),
                    format!("roughness {roughness}, n·v {nv}, {method}"),
                );
            }
        }
    }
    Ok(worst)
}

fn mirror_ball(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    let ball = Arc::new(furnace(0.0));
    for method in ["sssr", "stereo", "path-traced@1"] {
        let rendered = bench.render("ball", &ball, method, &white(96, 96))?;
        let off = |t: &&[f32; 3]| t.iter().any(|v| (v - 1.0).abs() > 2e-3);
        let count = rendered.linear.eyes.iter().flatten().filter(off).count();
        worst.include(100.0 * count as f64 / (2.0 * 96.0 * 96.0), method);
    }
    Ok(worst)
}

fn gain(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for step in 0..=10u8 {
        let roughness = f32::from(step) / 10.0;
        let ball = Arc::new(furnace(roughness));
        for method in ["sssr", "stereo", "path-traced@16"] {
            let rendered = bench.render(&format!("r={roughness}"), &ball, method, &white(33, 33))?;
            worst.include(most(&rendered.reflection), format!("roughness {roughness}, {method}"));
        }
    }
    Ok(worst)
}

/// A white plane that fills a narrow view and is seen with this n·v.
fn tilted(roughness: f32, nv: f64) -> Arc<Scene> {
    let turn = DQuat::from_rotation_x(nv.asin());
    let floor = place([1e3, 1.0, 1e3], turn, [0.0; 3]);
    let view = View { vertical_fov_rad: 0.002, ipd_m: 0.001, ..look(DVec3::new(0.0, 0.0, 1.0), DVec3::ZERO) };
    Arc::new(scene(vec![(plane(1), material(roughness), floor)], 1.0, view))
}

const TILTS: [f64; 4] = [1.0, 0.6, 0.25, 0.05];

fn lobe_albedo(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    for roughness in [0.03f32, 0.1, 0.35, 0.8] {
        for nv in TILTS {
            let floor = tilted(roughness, nv);
            // This is the albedo in the middle of the view. At its border, n·v differs by 0.001.
            let expected = albedo(nv.min(0.9999), f64::from(roughness));
            let rendered = bench.render(&format!("r={roughness} nv={nv}"), &floor, "path-traced@64", &white(16, 16))?;
            let off = (mean(&rendered.reflection) / expected - 1.0).abs();
            worst.include(
                off,
                format!("roughness {roughness}, n·v {nv}: {:.4} and {expected:.4}", mean(&rendered.reflection)),
            );
        }
    }
    Ok(worst)
}

fn loss(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::smallest();
    for roughness in [0.0f32, 0.5, 1.0] {
        for nv in TILTS {
            let rendered = bench.render(
                &format!("r={roughness} nv={nv}"),
                &tilted(roughness, nv),
                "path-traced@16",
                &white(16, 16),
            )?;
            worst.include(mean(&rendered.linear), format!("roughness {roughness}, n·v {nv}"));
        }
    }
    Ok(worst)
}
