//! Tests that each method does what its name says. The oracles are `stereo-one-loop`, which alternates between the
//! views for as long as a ray is lost, and the path-traced reference. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::sync::Arc;

use cyclopean::render::hits::{RayEnd, RayOutcome};
use cyclopean::render::{Method, Renderer, Settings};
use cyclopean::scene::Scene;

use crate::pictures::{gpu, hall, relative_squared_error, render, settings};

fn small() -> Settings {
    settings(96, 64)
}

fn ends(scene: &Arc<Scene>, method: &str, settings: &Settings) -> Vec<RayEnd> {
    let camera = scene.views[0].stereo_camera(settings.aspect());
    let mut renderer = Renderer::new(&gpu(), Arc::clone(scene)).expect("it fits");
    let prepared = renderer.prepare(&camera, &Method::parse(method).expect("known"), settings).expect("it fits");
    prepared.frame(&mut |_, _| Ok(())).expect("it renders");
    prepared.ray_ends().expect("readable").expect("the method filters hits").concat()
}

#[test]
fn two_stages_find_what_the_oracle_finds() {
    for cant in [0.0, 0.09] {
        let mut scene = (*hall(0.25)).clone();
        scene.views[0].cant_rad = cant;
        let scene = Arc::new(scene);
        let (ours, oracle) = (ends(&scene, "stereo", &small()), ends(&scene, "stereo-one-loop", &small()));
        let rays = oracle.iter().filter(|e| e.end != RayOutcome::Nothing).count();
        let known = |e: &RayEnd| e.end != RayOutcome::Unknown;
        let same = |a: &RayEnd, b: &RayEnd| match (a.end, b.end) {
            (RayOutcome::Hit, RayOutcome::Hit) => (a.distance_m / b.distance_m - 1.0).abs() < 0.02,
            (x, y) => x == y,
        };
        let differing = ours.iter().zip(&oracle).filter(|(a, b)| !same(a, b)).count();
        let lost = ours.iter().zip(&oracle).filter(|(a, b)| !known(a) && known(b)).count();
        let only = ours.iter().zip(&oracle).filter(|(a, b)| known(a) && !known(b)).count();
        println!(
            "cant {cant}: {differing} of {rays} rays differ; only the oracle answers {lost}, only ours answers {only}"
        );
        assert!(rays > 2000, "{rays}");
        // Unlike in the oracle, a ray that both eyes lose does not go on alternating between them (see
        // trace_other_eye.comp).
        assert!(differing * 1000 < 15 * rays, "{differing} of {rays}");
        assert!((differing - lost) * 1000 < 2 * rays, "{differing} of {rays}, {lost} lost");
    }
}

#[test]
fn traversal_in_two_stages_is_as_accurate_as_in_one_loop() {
    let (gpu, scene) = (gpu(), hall(0.25));
    let reference = render(&gpu, &scene, "path-traced@512", &small());
    let error = |method: &str| {
        let rendered = render(&gpu, &scene, method, &small());
        let mask = |eye: usize, i: usize| reference.reflection.eyes[eye][i][0] > 0.0;
        relative_squared_error(&rendered.reflection, &reference.reflection, mask)
    };
    let (ours, oracle) = (error("stereo@4"), error("stereo-one-loop@4"));
    let baseline = error("sssr@4");
    // The hall has much occlusion, so that rays which both eyes lose are a large part of the small remaining error.
    // Rays that pass behind matter by less than a pixel of disparity do not go on in the other eye either.
    println!("error {ours}; {oracle} with the oracle, {baseline} with the baseline");
    assert!(ours < 1.35 * oracle && ours - oracle < 0.2 * (baseline - oracle));
}

#[test]
fn the_publications_settings_err_more_and_no_change_of_ours_harms() {
    let (gpu, scene) = (gpu(), hall(0.25));
    let settings = Settings { edge_fade: 0.1, ..small() };
    let reference = render(&gpu, &scene, "path-traced@512", &settings);
    let error = |method: &str| {
        let rendered = render(&gpu, &scene, method, &settings);
        let mask = |eye: usize, i: usize| reference.reflection.eyes[eye][i][0] > 0.0;
        relative_squared_error(&rendered.reflection, &reference.reflection, mask)
    };
    let (ours, paper) = (error("stereo"), error("stereo-paper"));
    assert!(ours < paper, "error {ours}, but {paper} with the publication's settings");
    for change in ["stereo-fixed-tolerance", "stereo-no-filling", "stereo-no-back-check", "stereo-no-camera-rays"] {
        let without = error(change);
        println!("{change}: error {without} instead of {ours}; {paper} with all four changes");
        assert!(without > 0.98 * ours, "{change} is better than our method: error {without} instead of {ours}");
    }
}

#[test]
fn a_guard_band_shows_the_same_view_and_misses_less() {
    let (gpu, scene) = (gpu(), hall(0.1));
    let (plain, guarded) = (render(&gpu, &scene, "sssr", &small()), render(&gpu, &scene, "sssr-guardband", &small()));
    assert_eq!((guarded.linear.width, guarded.linear.height), (96, 64));
    // In the wider frustum rounding may decide otherwise whether a triangle covers a pixel.
    let rays = guarded.counters.rays.abs_diff(plain.counters.rays);
    assert!(rays * 200 < plain.counters.rays, "{rays} more or fewer rays with the guard band");
    assert!(guarded.counters.left_view * 10 < plain.counters.left_view * 9);
    for eye in 0..2 {
        let direct =
            |r: &cyclopean::render::Rendered, i: usize| r.linear.eyes[eye][i][1] - r.reflection.eyes[eye][i][1];
        let near = |i: &usize| (direct(&plain, *i) - direct(&guarded, *i)).abs() < 1e-2 * (1.0 + direct(&plain, *i));
        let same = (0..96 * 64).filter(near).count();
        assert!(same * 100 > 98 * 96 * 64, "{same} pixels");
    }
}

#[test]
fn shared_noise_is_the_same_noise() {
    let gpu = gpu();
    let mut scene = (*hall(0.3)).clone();
    scene.views[0].ipd_m = 0.0;
    let scene = Arc::new(scene);
    let eyes = |method: &str| render(&gpu, &scene, method, &small()).linear.eyes;
    let [left, right] = eyes("sssr-shared-noise");
    assert_eq!(left, right);
    let [left, right] = eyes("sssr");
    assert_ne!(left, right);
}

#[test]
fn one_eye_traces_and_the_other_is_reprojected() {
    let (gpu, scene) = (gpu(), hall(0.3));
    let (both, one) = (render(&gpu, &scene, "sssr", &small()), render(&gpu, &scene, "one-eye", &small()));
    // With `one-eye` the light passes through one more image and is rounded once more.
    let near = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).all(|c| (a[c] - b[c]).abs() <= 2e-3 * a[c].max(0.01));
    assert!(both.linear.eyes[0].iter().zip(&one.linear.eyes[0]).all(near));
    assert!(one.counters.rays * 3 < both.counters.rays * 2, "{} of {}", one.counters.rays, both.counters.rays);
    let lit = |r: &cyclopean::render::Rendered| r.reflection.eyes[1].iter().filter(|c| c[1] > 0.0).count();
    assert!(lit(&one) * 2 > lit(&both), "{} of {}", lit(&one), lit(&both));
}

#[test]
fn a_wider_filter_is_calmer() {
    let (gpu, scene) = (gpu(), hall(0.4));
    let reference = render(&gpu, &scene, "path-traced@512", &small());
    let error = |method: &str| {
        let rendered = render(&gpu, &scene, method, &small());
        let both_see = |eye: usize, i: usize| reference.reflection.eyes[eye][i][0] > 0.0;
        relative_squared_error(&rendered.reflection, &reference.reflection, both_see)
    };
    assert!(error("sssr-wide") < error("sssr"));
    // Path-traced rays find more than the views show, and the filter reduces the noise of few rays.
    let (few, filtered) = (error("path-traced@2"), error("path-traced@2-resolved"));
    assert!(filtered < 0.5 * few, "error {filtered}, and {few} without the filter");
    assert!(filtered < error("sssr@2"));
}
