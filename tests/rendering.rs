//! Tests rendering on scenes whose pictures are known: furnaces, mirrors, and a room in which screen space must
//! converge to the path-traced reference. It also tests what must not change a picture, such as passes that were left
//! out. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::sync::Arc;

use cyclopean::render::{Settings, Streams};
use cyclopean::scene::{Fallback, Scene};
use cyclopean::stress::albedo;
use glam::{DAffine3, DQuat, DVec3, Vec3};

use crate::pictures::{
    constant_environment, glowing, gpu, look, material, plane, relative_squared_error, render, render_from, scene,
    settings, sphere,
};

fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

fn furnace(roughness: f32) -> Arc<Scene> {
    let view = look(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO);
    Arc::new(scene(vec![(sphere(48), material(roughness), at(0.0, 0.0, 0.0))], 1.0, view))
}

#[test]
fn a_mirror_under_a_constant_environment_shows_it() {
    let (gpu, scene) = (gpu(), furnace(0.0));
    for method in ["path-traced@4", "sssr"] {
        let settings = Settings { fallback: Some(Fallback::Environment), ..settings(64, 64) };
        let rendered = render(&gpu, &scene, method, &settings);
        for texel in rendered.linear.eyes.iter().flatten() {
            // In a white environment a perfect mirror is white as well. Reading the BRDF table has an error of about
            // 1e-3.
            assert!((texel[0] - 1.0).abs() < 2e-3, "{method}: {texel:?}");
        }
    }
}

#[test]
fn a_furnace_gives_back_the_lobes_albedo() {
    let gpu = gpu();
    for roughness in [0.2f32, 0.5, 0.8] {
        let scene = furnace(roughness);
        let rendered = render(&gpu, &scene, "path-traced@256", &settings(33, 33));
        // The middle pixel of the left eye sees the sphere almost head on.
        let center = rendered.reflection.eyes[0][16 * 33 + 16][0];
        let expected = albedo(0.9999, f64::from(roughness));
        assert!((f64::from(center) - expected).abs() < 0.01, "roughness {roughness}: {center} instead of {expected}");
        let most = rendered.reflection.eyes.iter().flatten().map(|t| t[0]).fold(0.0, f32::max);
        assert!(most < 1.02, "roughness {roughness}: a surface reflects {most} of the light");
    }
}

/// A floor before a striped, glowing wall. Everything that the floor reflects is in view.
fn everything_visible(roughness: f32) -> Arc<Scene> {
    let floor = DAffine3::from_scale_rotation_translation(
        DVec3::new(3.0, 1.0, 1.0),
        DQuat::IDENTITY,
        DVec3::new(0.0, 0.0, -1.2),
    );
    let mut parts = vec![(plane(4), material(roughness), floor)];
    // The wall consists of glowing stripes that face the viewer (+Z).
    for i in 0..10 {
        let color = if i % 2 == 0 { Vec3::new(1.0, 0.6, 0.2) } else { Vec3::new(0.05, 0.2, 0.6) };
        let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
        let place = DAffine3::from_scale_rotation_translation(
            DVec3::new(12.0, 1.0, 0.5),
            upright,
            DVec3::new(0.0, 0.25 + 0.5 * f64::from(i), -2.0),
        );
        parts.push((plane(2), glowing(color), place));
    }
    let view = look(DVec3::new(0.0, 0.8, 1.5), DVec3::new(0.0, 0.8, -2.0));
    Arc::new(scene(parts, 0.0, view))
}

#[test]
fn screen_space_converges_to_the_reference_where_everything_is_visible() {
    let (gpu, scene) = (gpu(), everything_visible(0.35));
    let settings = settings(96, 64);
    let reference = render(&gpu, &scene, "path-traced@1024", &settings);
    let error = |spp: u32| {
        let rendered = render(&gpu, &scene, &format!("sssr@{spp}"), &settings);
        let mask = |eye: usize, i: usize| reference.reflection.eyes[eye][i][0] > 0.0;
        relative_squared_error(&rendered.reflection, &reference.reflection, mask)
    };
    let errors = [error(1), error(4), error(16)];
    println!("relative squared error at 1, 4 and 16 samples: {errors:.4?}");
    // The squared error of noise falls as 1/samples. What remains with 16 samples is an upper bound of the bias.
    assert!(errors[0] > 3.0 * errors[1] && errors[1] > 2.0 * errors[2], "{errors:?}");
    assert!(errors[2] < 0.04, "{errors:?}");
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_seed_others() {
    let (gpu, scene) = (gpu(), everything_visible(0.4));
    for method in ["sssr", "path-traced@4"] {
        let one = settings(48, 32);
        let (a, b) = (render(&gpu, &scene, method, &one), render(&gpu, &scene, method, &one));
        assert_eq!(a.linear, b.linear, "{method}");
        assert_eq!(a.display, b.display, "{method}");
        let other = render(&gpu, &scene, method, &Settings { seed: 2, ..one });
        assert_ne!(a.linear, other.linear, "{method}");
    }
}

#[test]
fn passes_that_were_left_out_would_not_have_changed_the_picture() {
    let gpu = gpu();
    for (what, scene) in [("open", everything_visible(0.4)), ("closed", furnace(0.3)), ("rough", furnace(0.95))] {
        for method in ["sssr", "sssr-thickness", "path-traced@2"] {
            let needed = render(&gpu, &scene, method, &settings(48, 32));
            let all = render(&gpu, &scene, method, &Settings { all_passes: true, ..settings(48, 32) });
            assert!(all.left_out.len() < needed.left_out.len(), "{what}, {method}: no pass was left out");
            assert_eq!(needed.linear, all.linear, "{what}, {method}");
            assert_eq!(needed.display, all.display, "{what}, {method}");
        }
    }
}

#[test]
fn eyes_in_one_place_with_one_stream_see_the_same() {
    let gpu = gpu();
    let mut scene = (*everything_visible(0.4)).clone();
    scene.views[0].ipd_m = 0.0;
    let scene = Arc::new(scene);
    for method in ["sssr", "path-traced@2"] {
        let shared = Settings { streams: Streams::Shared, ..settings(48, 32) };
        let rendered = render(&gpu, &scene, method, &shared);
        assert_eq!(rendered.linear.eyes[0], rendered.linear.eyes[1], "{method}");
    }
}

#[test]
fn exchanged_eyes_exchange_the_pictures() {
    let (gpu, scene) = (gpu(), everything_visible(0.4));
    let settings = Settings { streams: Streams::Shared, ..settings(48, 32) };
    let camera = scene.views[0].stereo_camera(settings.aspect());
    let exchanged = cyclopean::scene::StereoCamera { left: camera.right, right: camera.left };
    for method in ["sssr", "path-traced@2"] {
        let a = render_from(&gpu, &scene, method, &settings, &camera);
        let b = render_from(&gpu, &scene, method, &settings, &exchanged);
        assert_eq!(a.linear.eyes[0], b.linear.eyes[1], "{method}");
        assert_eq!(a.linear.eyes[1], b.linear.eyes[0], "{method}");
    }
}

#[test]
fn canted_and_asymmetric_eyes_agree_with_the_reference() {
    let gpu = gpu();
    let mut scene = (*everything_visible(0.2)).clone();
    scene.views[0].cant_rad = 0.05;
    let scene = Arc::new(scene);
    let settings = settings(96, 64);
    let mut camera = scene.views[0].stereo_camera(settings.aspect());
    camera.left.fov.left_rad -= 0.1;
    camera.right.fov.up_rad += 0.1;
    let reference = render_from(&gpu, &scene, "path-traced@256", &settings, &camera);
    let rendered = render_from(&gpu, &scene, "sssr@16", &settings, &camera);
    let mask = |eye: usize, i: usize| reference.reflection.eyes[eye][i][0] > 0.0;
    let error = relative_squared_error(&rendered.reflection, &reference.reflection, mask);
    assert!(error < 0.05, "{error}");
}

#[test]
fn poor_scenes_give_a_picture() {
    let gpu = gpu();
    let view = || look(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO);
    let mut dark = scene(vec![(plane(1), material(0.3), at(0.0, 0.0, 0.0))], 0.0, view());
    dark.lights.clear();
    let tiny = DAffine3::from_scale_rotation_translation(DVec3::splat(1e-3), DQuat::IDENTITY, DVec3::ZERO);
    let mut small = look(DVec3::new(0.0, 1e-3, 2e-3), DVec3::ZERO);
    (small.near_m, small.ipd_m) = (1e-5, 6e-5);
    let far = 1e6;
    let away = look(DVec3::new(far, 1.0, 2.0), DVec3::new(far, 0.0, 0.0));
    for (what, scene) in [
        ("an empty scene", scene(Vec::new(), 0.5, view())),
        ("no light", dark),
        ("a scene of a millimetre", scene(vec![(plane(1), material(0.3), tiny)], 0.5, small)),
        ("a thousand kilometres away", scene(vec![(plane(1), material(0.3), at(far, 0.0, 0.0))], 0.5, away)),
    ] {
        let scene = Arc::new(scene);
        for method in ["sssr", "path-traced@2"] {
            // `render` panics on any value that is not finite.
            let rendered = render(&gpu, &scene, method, &settings(33, 17));
            assert_eq!(rendered.linear.eyes[0].len(), 33 * 17, "{what}, {method}");
        }
    }
}

#[test]
fn a_far_place_looks_like_a_near_one() {
    let gpu = gpu();
    let near = everything_visible(0.2);
    let mut far = (*near).clone();
    let offset = DVec3::new(1e6, -2e6, 3e6);
    for instance in &mut far.instances {
        instance.world_from_object.translation += offset;
    }
    far.views[0].position += offset;
    let far = Arc::new(far);
    let (a, b) = (render(&gpu, &near, "sssr", &settings(48, 32)), render(&gpu, &far, "sssr", &settings(48, 32)));
    let most = a.linear.eyes.iter().flatten().zip(b.linear.eyes.iter().flatten());
    let differing = most.filter(|(x, y)| (x[0] - y[0]).abs() > 1e-3).count();
    // At that distance f64 is precise to about 1e-10 m. One ray in a hundred may still fall on the other side of an
    // edge.
    assert!(differing < 48 * 32 * 2 / 100, "{differing}");
}

#[test]
fn the_environment_is_seen_where_nothing_stands() {
    let gpu = gpu();
    let mut empty = scene(Vec::new(), 0.0, look(DVec3::ZERO, DVec3::NEG_Z));
    empty.environment = constant_environment(0.25);
    let rendered = render(&gpu, &Arc::new(empty), "sssr", &settings(16, 16));
    assert!(rendered.linear.eyes.iter().flatten().all(|t| *t == [0.25; 3]));
}
