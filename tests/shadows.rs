//! Tests shadows by rays. The oracles are closed forms for a box, a plate and a disc, and sums over single lights. It
//! also tests what shadows must not change. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::f64::consts::PI;
use std::sync::Arc;

use cyclopean::render::{Settings, Trace};
use cyclopean::scene::{Alpha, Eye, Light, LightSource, Material, Scene, StereoCamera};
use glam::{DAffine3, DQuat, DVec3, Vec3};

use crate::pictures::{chalk, floating_box, gpu, look, material, plane, render, scene, settings, sphere, with_floor};

const WIDTH: u32 = 120;
const HEIGHT: u32 = 90;

/// For each pixel, the place where the ray through its centre meets the floor, and the width of its footprint there in
/// metres.
fn on_floor(camera: &StereoCamera, eye: Eye) -> Vec<Option<(DVec3, f64)>> {
    let e = camera.eye(eye);
    let [left, right, down, up] = [e.fov.left_rad, e.fov.right_rad, e.fov.down_rad, e.fov.up_rad].map(f64::tan);
    let hit = |x: f64, y: f64| {
        let view =
            DVec3::new(left + (right - left) * x / f64::from(WIDTH), up + (down - up) * y / f64::from(HEIGHT), -1.0);
        let d = e.world_from_view * view;
        (d.y < 0.0).then(|| e.position - d * (e.position.y / d.y))
    };
    let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)));
    pixels
        .map(|(x, y)| {
            let (center, next, below) = (hit(x, y)?, hit(x + 1.0, y)?, hit(x, y + 1.0)?);
            Some((center, center.distance(next).max(center.distance(below))))
        })
        .collect()
}

/// For each pixel, the light with shadows divided by that without shadows, or `None` where there is no light at all.
fn visibility(
    gpu: &std::rc::Rc<cyclopean::gpu::Gpu>,
    scene: &Arc<Scene>,
    soft_shadow_rays: u32,
) -> [Vec<Option<f64>>; 2] {
    let shadowed = Settings { soft_shadow_rays, ..settings(WIDTH, HEIGHT) };
    let lit = render(gpu, scene, "sssr", &Settings { shadows: false, ..shadowed.clone() });
    let dark = render(gpu, scene, "sssr", &shadowed);
    [0, 1].map(|eye| {
        let pairs = dark.linear.eyes[eye].iter().zip(&lit.linear.eyes[eye]);
        pairs.map(|(d, l)| (l[0] > 1e-6).then(|| f64::from(d[0]) / f64::from(l[0]))).collect()
    })
}

/// Whether the line from `from` to `from + to` meets the box of half side `a` in x and z between the heights `low` and
/// `high`.
fn meets_box(from: DVec3, to: DVec3, a: f64, low: f64, high: f64) -> bool {
    let (lower, upper) = (DVec3::new(-a, low, -a), DVec3::new(a, high, a));
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for c in 0..3 {
        let (t0, t1) = ((lower[c] - from[c]) / to[c], (upper[c] - from[c]) / to[c]);
        enter = enter.max(t0.min(t1));
        leave = leave.min(t0.max(t1));
    }
    enter <= leave
}

#[test]
fn a_boxs_umbra_ends_within_a_pixel_of_its_closed_form() {
    let gpu = gpu();
    let (a, low, high) = (0.4, 0.3, 0.5);
    let sun = DVec3::new(0.5, 1.0, -0.3);
    let lamp = DVec3::new(0.7, 2.0, -0.5);
    let directional =
        LightSource::Directional { direction: (-sun).normalize().as_vec3(), irradiance: Vec3::splat(2.0) };
    let point = LightSource::Point { position: lamp, intensity: Vec3::splat(4.0), range_m: f32::INFINITY };
    let spot = LightSource::Spot {
        position: lamp,
        direction: (-lamp).normalize().as_vec3(),
        intensity: Vec3::splat(4.0),
        range_m: 30.0,
        inner_rad: 0.9,
        outer_rad: 1.2,
    };
    for (what, light) in [("sun", directional), ("point", point), ("spot", spot)] {
        let scene = with_floor(floating_box(a, low, high), vec![light.into()]);
        let camera = scene.views[0].stereo_camera(f64::from(WIDTH) / f64::from(HEIGHT));
        let seen = visibility(&gpu, &scene, 16);
        let (mut dark, mut bright) = (0, 0);
        for eye in Eye::BOTH {
            let position = camera.eye(eye).position;
            for (i, (floor, share)) in on_floor(&camera, eye).into_iter().zip(&seen[eye.layer()]).enumerate() {
                let (Some((p, width)), Some(share)) = (floor, share) else { continue };
                // Pixels that show the box, or nothing of the floor, are left out.
                if p.x.abs() > 4.9
                    || p.z.abs() > 4.9
                    || meets_box(position, p - position, a + 0.05, low - 0.05, high + 0.05)
                {
                    continue;
                }
                let blocked = |offset: DVec3| {
                    let q = p + offset;
                    meets_box(q, if what == "sun" { 10.0 * sun } else { lamp - q }, a, low, high)
                };
                let around = [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z].map(|d| blocked(d * width));
                let expected = blocked(DVec3::ZERO);
                if around.iter().any(|b| *b != expected) {
                    continue;
                }
                *if expected { &mut dark } else { &mut bright } += 1;
                let found = if expected { 0.0 } else { 1.0 };
                assert!(
                    (share - found).abs() < 1e-3,
                    "{what}, {eye:?} eye, pixel {i}, {p}: {share} instead of {found}"
                );
            }
        }
        assert!(dark > 150 && bright > 3000, "{what}: {dark} dark and {bright} bright pixels were compared");
    }
}

#[test]
fn a_penumbra_is_the_share_of_the_suns_disc_within_the_standard_error() {
    let gpu = gpu();
    let (height, angle) = (0.8, 0.35f32);
    // A plate over x < 0 hides a part of the sun, which is straight above.
    let plate =
        DAffine3::from_translation(DVec3::new(-4.0, height, 0.0)) * DAffine3::from_scale(DVec3::new(8.0, 1.0, 8.0));
    let sun = LightSource::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::ONE };
    let sun = Light { size: 0.5 * angle, ..sun.into() };
    let scene = with_floor(vec![(plane(1), chalk(), plate)], vec![sun]);
    let camera = scene.views[0].stereo_camera(f64::from(WIDTH) / f64::from(HEIGHT));
    let rays = 256;
    let seen = visibility(&gpu, &scene, rays);
    let radius = height * f64::from(0.5 * angle).tan();
    let (mut worst, mut sum, mut count) = (0.0f64, 0.0, 0);
    for eye in Eye::BOTH {
        let position = camera.eye(eye).position;
        for (floor, share) in on_floor(&camera, eye).into_iter().zip(&seen[eye.layer()]) {
            let (Some((p, _)), Some(share)) = (floor, share) else { continue };
            let through = position + (p - position) * ((position.y - height) / position.y);
            if through.x < 0.02 || p.x.abs() > radius || p.z.abs() > 3.0 {
                continue;
            }
            let s = (p.x / radius).clamp(-1.0, 1.0);
            let expected = 0.5 + (s * (1.0 - s * s).sqrt() + s.asin()) / PI;
            // This is the standard error of independent samples. The renderer's samples are stratified.
            let standard_error = (expected * (1.0 - expected) / f64::from(rays)).sqrt();
            worst = worst.max((share - expected).abs() - 3.0 * standard_error);
            sum += share - expected;
            count += 1;
        }
    }
    println!(
        "{count} pixels of the penumbra: mean difference {:.5}, largest excess over 3 standard errors {worst:.4}",
        sum / f64::from(count)
    );
    assert!(count > 300, "{count}");
    assert!((sum / f64::from(count)).abs() < 0.003, "the mean share is off by {}", sum / f64::from(count));
    // Near the edges of the penumbra the standard error is close to 0. A pixel may exceed three of them by 0.03.
    assert!(worst < 0.03, "a pixel is off by {worst} more than three standard errors");
}

/// A polished floor with a chalk ball, under these lights.
fn several(lights: Vec<Light>) -> Arc<Scene> {
    let parts = vec![
        (plane(2), material(0.2), DAffine3::from_scale(DVec3::new(6.0, 1.0, 6.0))),
        (
            sphere(24),
            chalk(),
            DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), DQuat::IDENTITY, DVec3::Y * 0.5),
        ),
    ];
    let mut made = scene(parts, 0.0, look(DVec3::new(0.3, 1.0, 2.5), DVec3::new(0.0, 0.3, 0.0)));
    made.lights = lights;
    Arc::new(made)
}

#[test]
fn the_reference_under_all_lights_is_the_sum_of_references_under_one() {
    let gpu = gpu();
    let at = |x: f64, y: f64, z: f64| LightSource::Point {
        position: DVec3::new(x, y, z),
        intensity: Vec3::new(1.0, 0.8, 0.5),
        range_m: f32::INFINITY,
    };
    let sun =
        LightSource::Directional { direction: Vec3::new(0.4, -1.0, -0.2).normalize(), irradiance: Vec3::splat(0.7) };
    let lights: Vec<Light> = vec![at(1.0, 1.5, 0.5).into(), at(-1.5, 1.0, 0.2).into(), sun.into()];
    let all = render(&gpu, &several(lights.clone()), "path-traced@8", &settings(48, 32));
    let single: Vec<_> =
        lights.iter().map(|l| render(&gpu, &several(vec![*l]), "path-traced@8", &settings(48, 32))).collect();
    for eye in 0..2 {
        for (i, texel) in all.linear.eyes[eye].iter().enumerate() {
            for (c, value) in texel.iter().enumerate() {
                let sum: f32 = single.iter().map(|s| s.linear.eyes[eye][i][c]).sum();
                // The tolerance allows for the lit view in fp16.
                assert!((value - sum).abs() <= 2e-3 * sum + 1e-4, "eye {eye}, pixel {i}: {value} and {sum}");
            }
        }
    }
}

#[test]
fn lights_without_shadows_give_the_picture_of_no_shadows_to_the_bit() {
    let gpu = gpu();
    let light =
        LightSource::Point { position: DVec3::new(1.0, 1.5, 0.5), intensity: Vec3::ONE, range_m: f32::INFINITY };
    let casting = several(vec![light.into()]);
    let through = several(vec![Light { casts_shadow: false, ..light.into() }]);
    for method in ["sssr", "stereo-hybrid", "path-traced@4"] {
        let off = render(&gpu, &casting, method, &Settings { shadows: false, ..settings(48, 32) });
        let none = render(&gpu, &through, method, &settings(48, 32));
        let on = render(&gpu, &casting, method, &settings(48, 32));
        assert!(off.linear == none.linear, "{method}: lights that cast nothing changed the picture");
        assert!(off.linear != on.linear, "{method}: the ball casts no shadow");
        assert!(
            none.left_out.iter().any(|p| p.name == "shadows"),
            "{method}: the pass ran without a light that casts shadows"
        );
        assert!(!none.passes.iter().any(|p| p.name == "shadows"), "{method}");
        assert!(on.passes.iter().any(|p| p.name == "shadows"), "{method}");
    }
}

#[test]
fn shadows_are_the_same_under_every_method_and_seed() {
    let gpu = gpu();
    let light =
        LightSource::Point { position: DVec3::new(1.0, 1.5, 0.5), intensity: Vec3::ONE, range_m: f32::INFINITY };
    let scene = several(vec![Light { size: 0.2, ..light.into() }]);
    let without_reflection_by = |trace: Trace, method: &str, seed: u32| {
        let r = render(&gpu, &scene, method, &Settings { seed, trace, ..settings(48, 32) });
        let pixels = r.linear.eyes.iter().flatten().zip(r.reflection.eyes.iter().flatten());
        pixels.map(|(l, r)| l[0] - r[0]).collect::<Vec<f32>>()
    };
    let without_reflection = |method: &str, seed: u32| without_reflection_by(Trace::Auto, method, seed);
    let first = without_reflection("sssr", 1);
    for (method, seed) in [("sssr", 2), ("stereo", 1), ("path-traced@2", 3)] {
        let other = without_reflection(method, seed);
        let largest = first.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(largest < 2e-3, "{method}, seed {seed}: {largest}");
    }
    // A guard band moves every pixel in the drawn image. Soft shadows must not change by that. One value in a hundred
    // may differ, because the rasteriser may decide otherwise along silhouettes.
    for trace in [Trace::Cpu, Trace::Bvh] {
        let plain = without_reflection_by(trace, "sssr", 1);
        let banded = without_reflection_by(trace, "sssr-guardband", 1);
        let differing = plain.iter().zip(&banded).filter(|(a, b)| (*a - *b).abs() > 2e-3).count();
        assert!(differing * 100 <= plain.len(), "{trace:?}: {differing} of {} values", plain.len());
    }
}

#[test]
fn glass_lets_its_share_through_and_a_cut_out_is_open() {
    let gpu = gpu();
    let sun = LightSource::Directional { direction: Vec3::NEG_Y, irradiance: Vec3::ONE };
    let plate = DAffine3::from_translation(DVec3::new(0.0, 1.0, 0.0)) * DAffine3::from_scale(DVec3::new(2.0, 1.0, 2.0));
    let glass = Material { transmission: 0.5, base_color: Vec3::new(0.8, 0.8, 0.8).extend(1.0), ..chalk() };
    let open = Material { alpha: Alpha::Mask { cutoff: 0.5 }, base_color: Vec3::ONE.extend(0.2), ..chalk() };
    for (what, material, expected) in [("matter", chalk(), 0.0), ("glass", glass, 0.4), ("cut-out", open, 1.0)] {
        let scene = with_floor(vec![(plane(1), material, plate)], vec![sun.into()]);
        let camera = scene.views[0].stereo_camera(f64::from(WIDTH) / f64::from(HEIGHT));
        let seen = visibility(&gpu, &scene, 16);
        let position = camera.eye(Eye::Left).position;
        let mut count = 0;
        for (floor, share) in on_floor(&camera, Eye::Left).into_iter().zip(&seen[0]) {
            let (Some((p, _)), Some(share)) = (floor, share) else { continue };
            let through = position + (p - position) * ((position.y - 1.0) / position.y);
            if p.x.abs() > 0.95 || p.z.abs() > 0.95 || through.x.abs() < 1.05 && through.z.abs() < 1.05 {
                continue;
            }
            count += 1;
            assert!((share - expected).abs() < 2e-3, "{what} at {p}: {share} instead of {expected}");
        }
        assert!(count > 50, "{what}: {count}");
    }
}
