//! Reflections over time: what a still view converges to, what is forgotten, and where the history is looked for.
#![cfg(feature = "gpu")]

mod pictures;

use std::sync::Arc;

use cyclopean::picture::StereoPicture;
use cyclopean::render::{Method, Prepared, Renderer, Settings};
use cyclopean::scene::Scene;
use pictures::{gpu, hall, settings as plain_settings};

fn small() -> Settings {
    Settings { edge_fade: 0.1, ..plain_settings(96, 64) }
}

fn prepare(renderer: &mut Renderer, method: &str, settings: &Settings) -> Prepared {
    let camera = renderer.scene().views[0].stereo_camera(settings.aspect());
    renderer.prepare(&camera, &Method::parse(method).expect("known"), settings).expect("it fits")
}

fn frame(prepared: &mut Prepared, seed: u32, frame: u32) -> StereoPicture {
    prepared.set_seed(seed, frame);
    let report = prepared.frame(&mut |_, _| Ok(())).expect("rendered");
    assert_eq!((report.counters.nan, report.counters.inf), (0, 0));
    prepared.reflection().expect("readable")
}

/// Mean over pixels and channels of the variance over `seeds` sequences, after each of these numbers of frames.
fn variances(scene: &Arc<Scene>, method: &str, seeds: u32, after: &[u32]) -> Vec<f64> {
    let mut renderer = Renderer::new(&gpu(), Arc::clone(scene)).expect("uploaded");
    let mut prepared = prepare(&mut renderer, method, &small());
    let mut sums: Vec<(Vec<f64>, Vec<f64>)> = vec![(Vec::new(), Vec::new()); after.len()];
    for seed in 1..=seeds {
        prepared.forget();
        for number in 1..=*after.last().expect("asked") {
            let picture = frame(&mut prepared, seed, number);
            let Some(at) = after.iter().position(|n| *n == number) else { continue };
            let values: Vec<f64> = picture.eyes.iter().flatten().flatten().map(|v| f64::from(*v)).collect();
            let (sum, squares) = &mut sums[at];
            sum.resize(values.len(), 0.0);
            squares.resize(values.len(), 0.0);
            for (i, v) in values.iter().enumerate() {
                sum[i] += v;
                squares[i] += v * v;
            }
        }
    }
    let n = f64::from(seeds);
    let mean = |sum: &[f64], squares: &[f64]| {
        let of = sum.iter().zip(squares).map(|(s, q)| (q - s * s / n) / (n - 1.0));
        of.sum::<f64>() / sum.len() as f64
    };
    sums.iter().map(|(sum, squares)| mean(sum, squares)).collect()
}

#[test]
fn a_still_view_converges_as_the_mean_of_its_frames() {
    let after = [1, 2, 4, 8, 16, 32, 64];
    for method in ["sssr-temporal", "stereo-temporal"] {
        let found = variances(&hall(0.35), method, 12, &after);
        let times: Vec<f64> = found.iter().zip(after).map(|(v, n)| v * f64::from(n) / found[0]).collect();
        println!("{method}: variance times frames, over that of one frame: {times:.3?}");
        assert!(times.iter().all(|t| (0.9..=1.1).contains(t)), "{method}: {times:?}");
    }
}

/// For tuning: a scene's curve, `CYCLOPEAN_SCENE=room cargo test --test temporal -- --ignored --nocapture`.
#[test]
#[ignore = "prints figures of a scene; nothing is asserted"]
fn curve_of_a_scene() {
    let name = std::env::var("CYCLOPEAN_SCENE").unwrap_or_else(|_| "room".to_owned());
    let scene = Arc::new(cyclopean::scene::load(&name).expect("loads"));
    let after = [1, 2, 4, 8, 16, 32];
    for method in ["sssr-temporal"] {
        let found = variances(&scene, method, 8, &after);
        let times: Vec<f64> = found.iter().zip(after).map(|(v, n)| v * f64::from(n) / found[0]).collect();
        println!("{name} {method}: {times:.3?}");
    }
}
