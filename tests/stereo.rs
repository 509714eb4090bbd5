//! Tests what the stereo-consistent method promises over the baseline `sssr`, in a small hall. The oracle is the
//! path-traced reference. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::sync::Arc;

use cyclopean::render::{Settings, Streams};
use cyclopean::scene::StereoCamera;

use crate::pictures::{gpu, hall, relative_squared_error, render, render_from, settings};

fn small() -> Settings {
    settings(96, 64)
}

#[test]
fn the_other_eye_answers_rays_that_the_baseline_misses() {
    let (gpu, scene) = (gpu(), hall(0.1));
    let baseline = render(&gpu, &scene, "sssr", &small());
    let stereo = render(&gpu, &scene, "stereo-no-reprojection", &small());
    let (missed, before) = (stereo.counters.missed(), baseline.counters.missed());
    assert_eq!(stereo.counters.rays, baseline.counters.rays);
    assert!(missed * 10 < before * 9, "{missed} rays were lost, and {before} by the baseline");
}

#[test]
fn it_comes_nearer_to_the_reference_than_the_baseline() {
    let gpu = gpu();
    // The eyes are parallel, or canted by five degrees each.
    for cant in [0.0, 5f64.to_radians()] {
        let mut scene = (*hall(0.25)).clone();
        scene.views[0].cant_rad = cant;
        let scene = Arc::new(scene);
        let settings = Settings { edge_fade: 0.1, ..small() };
        let reference = render(&gpu, &scene, "path-traced@512", &settings);
        let error = |method: &str| {
            let rendered = render(&gpu, &scene, method, &settings);
            let mask = |eye: usize, i: usize| reference.reflection.eyes[eye][i][0] > 0.0;
            relative_squared_error(&rendered.reflection, &reference.reflection, mask)
        };
        let (baseline, stereo) = (error("sssr@4"), error("stereo@4"));
        println!("cant {cant:.3}: {:.3} of the baseline's error", stereo / baseline);
        assert!(stereo < 0.95 * baseline, "cant {cant}: error {stereo}, and {baseline} by the baseline");
        assert!(stereo < error("stereo-no-fade@4"), "cant {cant}: the method is no better than without the fade");
        let (adaptive, hybrid) = (error("stereo-adaptive@4"), error("stereo-hybrid@4"));
        println!("cant {cant:.3}: adaptive {:.3}, hybrid {:.3}", adaptive / baseline, hybrid / baseline);
        assert!(adaptive < 0.97 * baseline, "cant {cant}: error {adaptive}, and {baseline} by the baseline");
        assert!(hybrid < 0.5 * baseline, "cant {cant}: error {hybrid}, and {baseline} by the baseline");
    }
}

#[test]
fn eyes_in_one_place_with_one_stream_see_the_same() {
    let gpu = gpu();
    let mut scene = (*hall(0.3)).clone();
    scene.views[0].ipd_m = 0.0;
    let scene = Arc::new(scene);
    let settings = Settings { streams: Streams::Shared, ..small() };
    let new = ["stereo-fixed-blend", "stereo-ratio", "stereo-hybrid", "stereo-hybrid-25", "stereo-adaptive"];
    for method in ["stereo", "stereo-no-traversal", "stereo-no-fade", "stereo-no-reprojection"].into_iter().chain(new) {
        let rendered = render(&gpu, &scene, method, &settings);
        assert_eq!(rendered.linear.eyes[0], rendered.linear.eyes[1], "{method}");
    }
    // Without reuse between the eyes the method may differ from the baseline only by the rounding of the world
    // fraction, where a ray went to the other eye's view and back.
    let (a, b) = (render(&gpu, &scene, "sssr", &settings), render(&gpu, &scene, "stereo-no-reprojection", &settings));
    let differing = a.linear.eyes[0].iter().zip(&b.linear.eyes[0]).filter(|(x, y)| x != y).count();
    assert!(differing * 100 < a.linear.eyes[0].len(), "{differing} pixels");
}

#[test]
fn exchanged_eyes_exchange_the_pictures() {
    let (gpu, scene) = (gpu(), hall(0.3));
    let settings = Settings { streams: Streams::Shared, edge_fade: 0.1, ..small() };
    let camera = scene.views[0].stereo_camera(settings.aspect());
    let exchanged = StereoCamera { left: camera.right, right: camera.left };
    for method in ["stereo", "stereo-ratio", "stereo-hybrid", "stereo-hybrid-25", "sssr-hybrid", "stereo-adaptive"] {
        let a = render_from(&gpu, &scene, method, &settings, &camera);
        let b = render_from(&gpu, &scene, method, &settings, &exchanged);
        assert_eq!(a.linear.eyes[0], b.linear.eyes[1], "{method}");
        assert_eq!(a.linear.eyes[1], b.linear.eyes[0], "{method}");
    }
}

#[test]
fn reuse_between_the_eyes_makes_their_noise_alike() {
    let gpu = gpu();
    let mut scene = (*hall(0.45)).clone();
    // The eyes are so close together that the same pixel shows the same in both. What differs is noise.
    scene.views[0].ipd_m = 1e-3;
    let scene = Arc::new(scene);
    let difference = |method: &str| {
        let rendered = render(&gpu, &scene, method, &small());
        let [left, right] = &rendered.reflection.eyes;
        left.iter().zip(right).map(|(l, r)| f64::from(l[1] - r[1]).powi(2)).sum::<f64>()
    };
    let (with, without) = (difference("stereo"), difference("stereo-no-reprojection"));
    assert!(with < 0.5 * without, "the eyes differ by {with} with reuse, and by {without} without");
}

#[test]
fn unrelated_reflections_are_exchanged_in_the_right_eye_alone() {
    let (gpu, scene) = (gpu(), hall(0.1));
    let plain = render(&gpu, &scene, "sssr", &small());
    let unrelated = render(&gpu, &scene, "unrelated", &small());
    assert_eq!(plain.linear.eyes[0], unrelated.linear.eyes[0]);
    let width = 96;
    let mut compared = 0;
    for (i, texel) in unrelated.reflection.eyes[1].iter().enumerate() {
        let mirrored = i / width * width + (width - 1 - i % width);
        if *texel != [0.0; 3] {
            assert_eq!(*texel, plain.reflection.eyes[1][mirrored]);
            compared += 1;
        }
    }
    assert!(compared > 500, "{compared}");
}

#[test]
fn a_probe_stands_in_for_what_no_eye_sees() {
    use cyclopean::scene::Fallback;
    let (gpu, scene) = (gpu(), hall(0.1));
    let reference = render(&gpu, &scene, "path-traced@256", &small());
    let error = |fallback| {
        let rendered = render(&gpu, &scene, "sssr@4", &Settings { fallback: Some(fallback), ..small() });
        let mask = |eye: usize, i: usize| reference.reflection.eyes[eye][i][0] > 0.0;
        relative_squared_error(&rendered.reflection, &reference.reflection, mask)
    };
    let (probe, black) = (error(Fallback::Probe), error(Fallback::Black));
    assert!(probe < 0.8 * black, "error {probe} with the probe, {black} with black");
}
