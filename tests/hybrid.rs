//! Tests the hybrid methods, whose lost rays ask the scene's geometry: what they must improve, what they must not
//! change, and that no geometry is built where no ray is lost. The oracle is the path-traced reference. Needs a Vulkan
//! device.
#![cfg(feature = "gpu")]

use std::sync::Arc;

use cyclopean::picture::StereoPicture;
use cyclopean::render::shared::Counts;
use cyclopean::render::{Method, Rendered, Renderer, Reuse, Settings};
use cyclopean::scene::{Fallback, Scene};
use glam::{DQuat, DVec3, Vec3};

use crate::pictures::{
    glowing, gpu, hall, look, material, plane, relative_squared_error, render, scene, settings as plain_settings,
};

fn small() -> Settings {
    Settings { edge_fade: 0.1, ..plain_settings(96, 64) }
}

/// The sum of the reflection's green channel over both eyes.
fn energy(picture: &StereoPicture) -> f64 {
    picture.eyes.iter().flatten().map(|c| f64::from(c[1])).sum()
}

/// The [`energy`] with each seed from 1 to `seeds`, and the counters of the last frame.
fn over_seeds(scene: &Arc<Scene>, method: &str, seeds: u32) -> (Vec<f64>, Counts) {
    let mut renderer = Renderer::new(&gpu(), Arc::clone(scene)).expect("uploaded");
    let camera = scene.views[0].stereo_camera(small().aspect());
    let method = Method::parse(method).expect("known");
    let mut prepared = renderer.prepare(&camera, &method, &small()).expect("it fits");
    let (mut energies, mut counts) = (Vec::new(), Counts::default());
    for seed in 1..=seeds {
        prepared.set_seed(seed, 0);
        counts = prepared.frame(&mut |_, _| Ok(())).expect("rendered").counters;
        energies.push(energy(&prepared.reflection().expect("readable")));
    }
    (energies, counts)
}

/// A floor that reflects a glowing surface. This is a wall in view, or a ceiling that is not in view because the eyes
/// look down.
fn floor_and_glow(roughness: f32, in_view: bool) -> Arc<Scene> {
    use cyclopean::stress::shapes::{place, upright};
    let floor = place([6.0, 1.0, 6.0], DQuat::IDENTITY, [0.0, 0.0, 0.0]);
    let glow = if in_view {
        place([40.0, 1.0, 40.0], upright(), [0.0, 0.0, -7.0])
    } else {
        place([40.0, 1.0, 40.0], DQuat::from_rotation_x(std::f64::consts::PI), [0.0, 4.0, 0.0])
    };
    let parts = vec![(plane(2), material(roughness), floor), (plane(2), glowing(Vec3::new(0.2, 0.5, 0.9)), glow)];
    let (from, to) = if in_view {
        (DVec3::new(0.0, 1.0, 4.0), DVec3::new(0.0, 1.0, -7.0))
    } else {
        (DVec3::new(0.0, 2.0, 0.0), DVec3::new(0.0, 0.0, -0.6))
    };
    Arc::new(scene(parts, 0.0, look(from, to)))
}

#[test]
fn no_ray_is_left_without_an_answer() {
    let (gpu, scene) = (gpu(), hall(0.25));
    let reference = render(&gpu, &scene, "path-traced@512", &small());
    let mask = |eye: usize, i: usize| reference.reflection.eyes[eye][i][0] > 0.0;
    let error = |r: &Rendered| relative_squared_error(&r.reflection, &reference.reflection, mask);
    for (method, without) in [("sssr-hybrid", "sssr"), ("stereo-hybrid", "stereo")] {
        let (hybrid, plain) = (render(&gpu, &scene, method, &small()), render(&gpu, &scene, without, &small()));
        assert_eq!((hybrid.counters.missed(), hybrid.counters.skipped), (0, 0), "{method}");
        assert_eq!(hybrid.counters.hits + hybrid.counters.sky, hybrid.counters.rays, "{method}");
        assert!(hybrid.counters.asked > plain.counters.missed(), "rays that hit near the border ask no geometry");
        let (with, before) = (error(&hybrid), error(&plain));
        println!("{method}: error {with:.3}, and {before:.3} without geometry");
        assert!(with < 0.5 * before, "{method}: error {with}, and {before} without geometry");
    }
}

#[test]
fn the_fallback_is_never_seen() {
    let (gpu, scene) = (gpu(), hall(0.25));
    let with = |fallback| render(&gpu, &scene, "stereo-hybrid", &Settings { fallback: Some(fallback), ..small() });
    assert!(with(Fallback::Black).linear.eyes == with(Fallback::Environment).linear.eyes);
}

#[test]
fn a_hybrid_with_a_share_of_zero_equals_the_method_without_geometry() {
    let (gpu, scene) = (gpu(), hall(0.25));
    for (none, plain) in [("stereo-hybrid-0", "stereo"), ("sssr-hybrid-0", "sssr")] {
        let (a, b) = (render(&gpu, &scene, none, &small()), render(&gpu, &scene, plain, &small()));
        assert!(a.linear.eyes == b.linear.eyes, "{none}");
        assert_eq!(a.tracer, None);
    }
}

#[test]
fn a_smaller_share_asks_less_and_keeps_the_mean() {
    let scene = hall(0.35);
    let mean = |method: &str| {
        let (energies, counts) = over_seeds(&scene, method, 24);
        let mean = energies.iter().sum::<f64>() / 24.0;
        let variance = energies.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / 23.0;
        (mean, (variance / 24.0).sqrt(), counts)
    };
    let (all, all_error, all_counts) = mean("sssr-hybrid");
    for share in [25u32, 50] {
        let (part, error, counts) = mean(&format!("sssr-hybrid-{share}"));
        let lost = counts.asked + counts.skipped;
        println!("{share} %: {:.4} ± {:.4} of all", part / all, error.hypot(all_error) / all);
        assert_eq!(lost, all_counts.asked, "other rays were lost");
        assert!((counts.asked as f64 / lost as f64 - f64::from(share) / 100.0).abs() < 0.05);
        // The bound of bright taps removes a little more energy where taps weigh more. One per cent allows for that.
        assert!((part / all - 1.0).abs() < 0.01 + 4.0 * error.hypot(all_error) / all, "{part} and {all}");
    }
}

#[test]
fn where_every_ray_is_lost_a_hybrid_equals_filtered_paths() {
    let (gpu, scene) = (gpu(), floor_and_glow(0.4, false));
    let settings = plain_settings(96, 64);
    let paths = render(&gpu, &scene, "path-traced-resolved@1", &settings);
    for method in ["sssr-hybrid", "stereo-hybrid"] {
        let hybrid = render(&gpu, &scene, method, &settings);
        assert!(hybrid.counters.hits > 2000, "{:?}", hybrid.counters);
        if method == "sssr-hybrid" {
            // Both follow the same rays through the same geometry, and differ only by rounding.
            let error = relative_squared_error(&hybrid.reflection, &paths.reflection, |eye, i| {
                paths.reflection.eyes[eye][i][1] > 0.0
            });
            assert!(error < 1e-4, "{error}");
        }
        let ratio = energy(&hybrid.reflection) / energy(&paths.reflection);
        println!("{method}: {ratio:.4} of the paths' energy");
        assert!((ratio - 1.0).abs() < 0.01, "{method}: {ratio}");
    }
}

#[test]
fn nothing_lost_builds_no_geometry() {
    // The wall fills the view above the horizon, so that everything that the mirror reflects is in view.
    let (gpu, scene) = (gpu(), floor_and_glow(0.0, true));
    let settings = plain_settings(96, 64);
    let rendered = render(&gpu, &scene, "stereo-hybrid", &settings);
    assert!(rendered.counters.rays > 1000 && rendered.counters.asked == 0, "{:?}", rendered.counters);
    assert_eq!(rendered.tracer, None, "geometry was built, but no ray asked it");
    assert!(rendered.passes.iter().all(|p| p.name != "trace_geometry"));
    let lost = render(&gpu, &hall(0.25), "stereo-hybrid", &settings);
    assert!(lost.tracer.is_some() && lost.passes.iter().any(|p| p.name == "trace_geometry"));
}

#[test]
fn where_everything_is_known_energy_is_kept() {
    let (gpu, scene) = (gpu(), hall(0.3));
    let reference = energy(&render(&gpu, &scene, "path-traced@512", &small()).reflection);
    for method in ["stereo-hybrid", "sssr-hybrid", "path-traced-resolved@1"] {
        let mean = over_seeds(&scene, method, 16).0.iter().sum::<f64>() / 16.0;
        println!("{method}: {:.4} of the reference's energy", mean / reference);
        assert!((mean / reference - 1.0).abs() < 0.01, "{method}: {}", mean / reference);
    }
}

#[test]
fn the_published_estimator_is_one_switch_away() {
    let (gpu, scene) = (gpu(), hall(0.3));
    let ratio = Settings { reuse: Reuse::Ratio, ..small() };
    for (method, named) in [("sssr", "sssr-ratio"), ("stereo", "stereo-ratio"), ("stereo-fixed-blend", "stereo-ratio")]
    {
        let (a, b) = (render(&gpu, &scene, method, &ratio), render(&gpu, &scene, named, &small()));
        assert!(a.linear.eyes == b.linear.eyes, "{method}");
        assert!(a.linear.eyes != render(&gpu, &scene, method, &small()).linear.eyes, "{method}");
    }
}

#[test]
fn the_recommended_method_says_what_it_is() {
    let (gpu, scene) = (gpu(), hall(0.25));
    let recommended = render(&gpu, &scene, "recommended", &small());
    let taken = Method::parse(&recommended.method).expect("a method");
    assert_ne!(recommended.method, "recommended");
    assert!(recommended.linear.eyes == render(&gpu, &scene, &taken.to_string(), &small()).linear.eyes);
}

#[test]
fn work_in_the_other_eye_follows_the_threshold() {
    let (gpu, scene) = (gpu(), hall(0.3));
    // No pixel exceeds a threshold of 100 %, so that each eye is filtered alone, without traversal of the other view,
    // but with both eyes' fade. With a threshold of 0 %, nearly every pixel is filtered with the other eye's rays.
    let never = render(&gpu, &scene, "stereo-adaptive-100", &small());
    let each = render(&gpu, &scene, "sssr", &small());
    let always = render(&gpu, &scene, "stereo-adaptive-0", &small());
    let both = render(&gpu, &scene, "stereo-no-traversal", &small());
    // A pixel whose taps are all alike is left out even then, because the other eye's rays would not change it.
    let mask = |eye: usize, i: usize| both.reflection.eyes[eye][i][1] > 0.0;
    let apart = relative_squared_error(&always.reflection, &both.reflection, mask);
    assert!(apart < 1e-3, "{apart}");
    let differing = |a: &Rendered, b: &Rendered| {
        let pixels = a.linear.eyes.iter().flatten().zip(b.linear.eyes.iter().flatten());
        pixels.filter(|(x, y)| x != y).count()
    };
    let middle = render(&gpu, &scene, "stereo-adaptive-2", &small());
    let (from_always, from_never) = (differing(&middle, &always), differing(&middle, &never));
    assert!(differing(&never, &always) > from_always && from_never > 0, "{from_always}, {from_never}");
    assert!(differing(&never, &each) * 2 < never.linear.eyes[0].len() * 2);
    let prepared = {
        let mut renderer = Renderer::new(&gpu, Arc::clone(&scene)).expect("uploaded");
        let camera = scene.views[0].stereo_camera(small().aspect());
        let method = Method::parse("stereo-adaptive").expect("known");
        renderer.prepare(&camera, &method, &small()).expect("it fits")
    };
    assert!(prepared.needs().decisions().iter().any(|p| p.name == "reproject" && p.why.contains("2 %")));
}
