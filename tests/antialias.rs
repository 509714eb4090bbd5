//! Tests antialiasing: an edge pixel must be the mean of the same view drawn more finely, and the reflections must stay
//! the same. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::sync::Arc;

use cyclopean::render::Settings;
use cyclopean::scene::Scene;
use glam::{DAffine3, DQuat, DVec3, Vec3};

use crate::pictures::{glowing, gpu, hall, look, plane, render, scene, settings};

/// A glowing square before a black ground, turned about the axis of the view.
fn square() -> Arc<Scene> {
    let turn = DQuat::from_rotation_z(0.3) * DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let place = DAffine3::from_scale_rotation_translation(DVec3::splat(1.3), turn, DVec3::ZERO);
    let view = look(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO);
    Arc::new(scene(vec![(plane(1), glowing(Vec3::ONE), place)], 0.0, view))
}

#[test]
fn an_edge_pixel_has_the_share_of_its_fine_samples() {
    let (gpu, scene) = (gpu(), square());
    let (width, height) = (48u32, 32u32);
    for finer in [2u32, 4] {
        let smooth = render(&gpu, &scene, "sssr", &Settings { antialias: finer, ..settings(width, height) });
        // The oracle is the same view, drawn at the finer resolution without antialiasing.
        let fine = render(&gpu, &scene, "sssr", &settings(width * finer, height * finer));
        let mut partial = 0;
        for eye in 0..2 {
            for y in 0..height {
                for x in 0..width {
                    let mut sum = 0.0;
                    for k in 0..finer * finer {
                        let (i, j) = (x * finer + k % finer, y * finer + k / finer);
                        sum += fine.linear.eyes[eye][(j * width * finer + i) as usize][1];
                    }
                    let expected = sum / (finer * finer) as f32;
                    let found = smooth.linear.eyes[eye][(y * width + x) as usize][1];
                    assert!((found - expected).abs() < 1e-5, "{finer}: eye {eye}, pixel {x}, {y}: {found}, {expected}");
                    partial += u32::from(expected > 0.0 && expected < 1.0);
                }
            }
        }
        assert!(partial > 60, "{finer}: only {partial} pixels lie on an edge");
    }
}

#[test]
fn reflections_keep_their_bits_and_their_place() {
    let (gpu, scene) = (gpu(), hall(0.3));
    for method in ["sssr", "stereo-guardband", "path-traced@2"] {
        let plain = render(&gpu, &scene, method, &settings(64, 48));
        let smooth = render(&gpu, &scene, method, &Settings { antialias: 2, ..settings(64, 48) });
        assert!(plain.reflection == smooth.reflection, "{method}: antialiasing changed the reflections");
        assert!(plain.linear != smooth.linear, "{method}: nothing was antialiased");
        let mean = |p: &cyclopean::picture::StereoPicture| {
            p.eyes.iter().flatten().map(|t| f64::from(t[0] + t[1] + t[2])).sum::<f64>()
        };
        let ratio = mean(&smooth.linear) / mean(&plain.linear);
        assert!((ratio - 1.0).abs() < 0.03, "{method}: antialiasing changed the mean light by {ratio}");
    }
}

#[test]
fn without_antialiasing_nothing_is_drawn_twice() {
    let gpu = gpu();
    let plain = render(&gpu, &square(), "sssr", &settings(48, 32));
    assert!(plain.left_out.iter().any(|p| p.name == "antialias"));
}
