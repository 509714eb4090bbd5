//! Renders every built-in scene, and the real scenes in `shared/scenes` beside the repository, by `sssr` and by path
//! tracing. There must be no message of the validation layer and no value that is not finite. Needs a Vulkan device.
//! The test of the real scenes is skipped, with a message, where they are absent.
#![cfg(feature = "gpu")]

use std::path::Path;
use std::sync::Arc;

use cyclopean::render::Settings;
use cyclopean::scene;

use crate::pictures::{gpu, render, settings};

fn look_at(source: &str, settings: &Settings) {
    let gpu = gpu();
    let scene = Arc::new(scene::load(source).unwrap_or_else(|error| panic!("{source}: {error}")));
    for method in ["sssr", "path-traced@1"] {
        let rendered = render(&gpu, &scene, method, settings);
        assert_eq!((rendered.counters.nan, rendered.counters.inf), (0, 0), "{source}, {method}");
        for eye in &rendered.linear.eyes {
            let mean = eye.iter().map(|t| f64::from(t[1])).sum::<f64>() / eye.len() as f64;
            assert!(
                (0.005..20.0).contains(&mean),
                "{source}, {method}: the picture is too dark or too bright, mean {mean}"
            );
        }
        assert!(rendered.counters.rays > 0 && rendered.counters.hits > 0, "{source}, {method}: nothing reflects");
    }
}

#[test]
fn built_in_scenes() {
    for name in scene::builtin::NAMES {
        look_at(name, &settings(96, 54));
    }
}

#[test]
fn real_scenes() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    if !folder.is_dir() {
        println!("skipped: there are no scenes at {}", folder.display());
        return;
    }
    for file in [
        "pica-mini-diorama/scene.gltf",
        "mitsuba-living-room/scene.gltf",
        "chess-board/chess-board.glb",
        "mitsuba-living-room-2/scene.gltf",
        "mitsuba-staircase/scene.gltf",
        "roughness-scale/scene.gltf",
    ] {
        look_at(&folder.join(file).display().to_string(), &settings(96, 54));
    }
}
