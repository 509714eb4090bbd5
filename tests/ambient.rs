//! Tests the methods for ambient occlusion on scenes whose occlusion is known, and compares them with each other and
//! with the ray-traced one in a room. The oracle of the ray-traced method is an integral over the hemisphere. Needs a
//! Vulkan device.
#![cfg(feature = "gpu")]

use std::sync::Arc;

use cyclopean::metrics::ambient::{inconsistency, mean_absolute_error, places};
use cyclopean::metrics::pairs::EyeSurfaces;
use cyclopean::metrics::{Surfaces, mean};
use cyclopean::render::{Ao, AoSettings, Method, Prepared, Rendered, Renderer, Settings, Streams};
use cyclopean::scene::{self, Eye, LightSource, Scene, StereoCamera};
use cyclopean::stress::shapes::{place, upright};
use glam::{DQuat, DVec3, Vec3};

use crate::pictures::{self, gpu, hall, look, material, plane, render, render_from, settings, sphere};
use crate::program::cyclopean;

const ALL: [Ao; 5] = [Ao::Mono, Ao::Fsa, Ao::Variant1, Ao::Variant2, Ao::RayTraced];

fn with(ao: Ao, settings: Settings) -> Settings {
    Settings { ao: AoSettings { method: ao, rays: 64, ..AoSettings::default() }, ..settings }
}

fn small(ao: Ao) -> Settings {
    with(ao, settings(96, 64))
}

fn visibility(rendered: &Rendered) -> [Vec<f32>; 2] {
    let picture = rendered.ambient_visibility.as_ref().expect("ambient light is occluded");
    picture.eyes.each_ref().map(|eye| eye.iter().map(|t| t[0]).collect())
}

fn slices(eyes: &[Vec<f32>; 2]) -> [&[f32]; 2] {
    eyes.each_ref().map(Vec::as_slice)
}

/// A floor and a wall that meet at right angles, about two metres before the eyes. Both extend far beyond the view.
fn corner() -> Scene {
    let floor = place([40.0, 1.0, 20.0], DQuat::IDENTITY, [0.0, 0.0, 8.0]);
    let wall = place([40.0, 1.0, 40.0], upright(), [0.0, 20.0, -2.0]);
    let view = look(DVec3::new(0.0, 1.2, 0.3), DVec3::new(0.0, 0.2, -2.0));
    let white = || material(0.9);
    pictures::scene(vec![(plane(1), white(), floor), (plane(1), white(), wall)], 1.0, view)
}

#[test]
fn exchanged_eyes_exchange_the_pictures() {
    let (gpu, scene) = (gpu(), hall(0.3));
    for ao in ALL {
        let settings = Settings { streams: Streams::Shared, ..small(ao) };
        let camera = scene.views[0].stereo_camera(settings.aspect());
        let exchanged = StereoCamera { left: camera.right, right: camera.left };
        let [a, b] = [camera, exchanged].map(|c| visibility(&render_from(&gpu, &scene, "sssr", &settings, &c)));
        assert_ne!(a[0], a[1], "{}: both eyes see the same picture", ao.name());
        assert_eq!(a[0], b[1], "{}", ao.name());
        assert_eq!(a[1], b[0], "{}", ao.name());
    }
}

#[test]
fn eyes_in_one_place_have_the_value_of_one() {
    let gpu = gpu();
    let mut scene = (*hall(0.3)).clone();
    scene.views[0].ipd_m = 0.0;
    let scene = Arc::new(scene);
    for streams in [Streams::Shared, Streams::Independent] {
        let of = |ao| visibility(&render(&gpu, &scene, "sssr", &Settings { streams, ..small(ao) }));
        let mono = of(Ao::Mono);
        assert_eq!(mono[0] == mono[1], streams == Streams::Shared);
        for ao in [Ao::Fsa, Ao::Variant1, Ao::Variant2] {
            let found = of(ao);
            let off = mono.iter().flatten().zip(found.iter().flatten()).map(|(a, b)| (a - b).abs());
            let off = off.fold(0.0, f32::max);
            // An adaptive method repeats the same steps for some pixels. They may differ only where a value is stored
            // with 16 bits between two passes.
            assert!(off < 1e-4, "{} differs from mono by {off}, {streams:?}", ao.name());
        }
    }
}

#[test]
fn the_oracle_is_the_integral_over_the_hemisphere() {
    let (gpu, scene) = (gpu(), Arc::new(corner()));
    let settings = Settings { ao: AoSettings { rays: 1024, ..small(Ao::RayTraced).ao }, ..small(Ao::RayTraced) };
    let (prepared, found) = prepared(&gpu, &scene, &settings);
    let geometry = prepared.geometry().expect("readable");
    let camera = prepared.camera().eye(Eye::Left);
    let (mut compared, mut worst) = (0, 0.0f64);
    for y in (32..64).step_by(3) {
        let i = y * 96 + 48;
        // The point on the floor that this pixel sees, and from it the distance to the wall.
        let fov = &camera.fov;
        let ray = DVec3::new(
            fov.left_rad.tan() + (fov.right_rad.tan() - fov.left_rad.tan()) * 48.5 / 96.0,
            fov.up_rad.tan() + (fov.down_rad.tan() - fov.up_rad.tan()) * (y as f64 + 0.5) / 64.0,
            -1.0,
        );
        let distance = camera.near_m / f64::from(geometry.eyes[0].depth[i]);
        let at = camera.position + camera.world_from_view * ray * distance;
        if at.y.abs() > 1e-3 || at.z < -1.98 {
            continue;
        }
        let expected = before_a_wall(at.z + 2.0, 0.5);
        worst = worst.max((f64::from(found[0][i]) - expected).abs());
        compared += 1;
    }
    println!("{compared} places were compared, the largest difference is {worst}");
    assert!(compared >= 5, "{compared}");
    assert!(worst < 0.01, "{worst}");
}

/// The ambient visibility of a place on the floor, `away` metres before an endless wall. It is 1 minus the
/// cosine-weighted mean of max(1 − t²/radius², 0), integrated by the midpoint rule over the unit disk of directions.
fn before_a_wall(away: f64, radius: f64) -> f64 {
    const N: i32 = 600;
    let (mut hidden, mut all) = (0.0, 0u32);
    for i in 0..N {
        for k in 0..N {
            let [x, y] = [i, k].map(|n| (2.0 * f64::from(n) + 1.0) / f64::from(N) - 1.0);
            if x * x + y * y < 1.0 {
                all += 1;
                if x > 0.0 {
                    hidden += (1.0 - (away / x / radius).powi(2)).max(0.0);
                }
            }
        }
    }
    1.0 - hidden / f64::from(all)
}

fn prepared(
    gpu: &std::rc::Rc<cyclopean::gpu::Gpu>,
    scene: &Arc<Scene>,
    settings: &Settings,
) -> (Prepared, [Vec<f32>; 2]) {
    let camera = scene.views[0].stereo_camera(settings.aspect());
    let mut renderer = Renderer::new(gpu, Arc::clone(scene)).expect("it fits");
    let method = Method::parse("sssr").expect("known");
    let prepared = renderer.prepare(&camera, &method, settings).expect("it fits");
    prepared.ambient_frame(&mut |_, _| Ok(())).expect("it renders");
    gpu.check_validation().expect("no message");
    let found = prepared.ambient_visibility().expect("readable").expect("occluded");
    (prepared, found)
}

#[test]
fn corners_are_darker_and_open_places_are_not_occluded() {
    let gpu = gpu();
    let floor = place([40.0, 1.0, 40.0], DQuat::from_rotation_y(0.3), [0.0; 3]);
    let view = look(DVec3::new(0.0, 1.0, 1.0), DVec3::ZERO);
    let open = Arc::new(pictures::scene(vec![(plane(3), material(0.9), floor)], 1.0, view));
    let corner = Arc::new(corner());
    for ao in ALL {
        let seen = visibility(&render(&gpu, &open, "sssr", &small(ao)));
        assert!(seen.iter().flatten().all(|v| *v == 1.0), "{}: a plane is occluded by itself", ao.name());
        let seen = visibility(&render(&gpu, &corner, "sssr", &small(ao)));
        for eye in &seen {
            // The middle column shows the wall above and the floor below. Its darkest pixel lies where they meet.
            let column: Vec<f32> = (0..64).map(|y| eye[y * 96 + 48]).collect();
            let (darkest, least) = column.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).expect("pixels");
            assert!(*least < 0.85 && (15..50).contains(&darkest), "{}: {least} at row {darkest}", ao.name());
            assert!(column[63] > 0.97, "{}: visibility {} close to the eyes", ao.name(), column[63]);
        }
    }
}

#[test]
fn only_light_from_around_is_occluded() {
    let gpu = gpu();
    // The surfaces are so rough that no reflection is traced.
    let mut lit = corner();
    let light = LightSource::Directional { direction: Vec3::new(0.0, -1.0, -1.0).normalize(), irradiance: Vec3::ONE };
    lit.lights.push(light.into());
    let lit = Arc::new(lit);
    let [open, dimmed] = [Ao::None, Ao::Mono].map(|ao| render(&gpu, &lit, "sssr", &small(ao)));
    let seen = visibility(&dimmed);
    assert!(open.ambient_visibility.is_none() && !open.passes.iter().any(|p| p.name.starts_with("ao_")));
    let dark = Arc::new(Scene { lights: Vec::new(), ..(*lit).clone() });
    let around = render(&gpu, &dark, "sssr", &small(Ao::None));
    for (eye, seen) in seen.iter().enumerate() {
        for (i, visible) in seen.iter().enumerate() {
            // The light's own share stays, and the light from around is multiplied by the visibility. The tolerance
            // allows for images in fp16.
            let [open, dimmed, around] = [&open, &dimmed, &around].map(|r| f64::from(r.linear.eyes[eye][i][1]));
            let expected = open - around * (1.0 - f64::from(*visible));
            assert!((dimmed - expected).abs() < 4e-3 * open.max(0.1), "{dimmed} and {expected} at {i}");
        }
    }
}

/// The share of pixels that differ visibly between the eyes, with the surfaces of `prepared` and the visibility `seen`.
fn inconsistent(prepared: &Prepared, seen: &[Vec<f32>; 2]) -> f64 {
    let geometry = prepared.geometry().expect("readable");
    let eyes = geometry.eyes.each_ref().map(|eye| EyeSurfaces {
        traced: &eye.traced,
        depth: &eye.depth,
        instance: &eye.instance,
        normal: &eye.normal,
        face_normal: &eye.face_normal,
        roughness: &eye.roughness,
        inverse_hit_distance: &eye.inverse_hit_distance,
    });
    let (width, height) = (prepared.settings().width as usize, prepared.settings().height as usize);
    let surfaces = Surfaces { camera: prepared.camera(), width, height, delta_roughness: 0.03, eyes };
    inconsistency(&places(&surfaces), slices(seen)).expect("pairs")
}

#[test]
fn stereo_occlusion_is_as_consistent_between_the_eyes_as_seed_001_prints() {
    let gpu = gpu();
    let scene = Arc::new(scene::load("room").expect("built in"));
    let found = ALL.map(|ao| {
        let (prepared, seen) = prepared(&gpu, &scene, &with(ao, settings(240, 135)));
        (inconsistent(&prepared, &seen), seen)
    });
    let [mono, fsa, variant1, variant2, rays] = &found;
    let error = |of: &(f64, [Vec<f32>; 2]), to: &(f64, [Vec<f32>; 2])| {
        mean_absolute_error(slices(&of.1), slices(&to.1)).expect("pixels")
    };
    for (ao, of) in ALL.iter().zip(&found) {
        println!(
            "{:<10} {:.4} inconsistent, differs from fsa by {:.5} and from rays by {:.5}",
            ao.name(),
            of.0,
            error(of, fsa),
            error(of, rays)
        );
    }
    assert!(fsa.0 < 0.5 * mono.0, "inconsistency {} by fsa, {} by mono", fsa.0, mono.0);
    for adaptive in [variant1, variant2] {
        assert!(adaptive.0 < 1.2 * fsa.0, "inconsistency {} by an adaptive method, {} by fsa", adaptive.0, fsa.0);
    }
    assert!(error(variant2, fsa) < 0.2 * error(variant1, fsa));
    assert!(error(variant1, fsa) < 0.9 * error(mono, fsa));
    assert!(error(fsa, rays) < error(mono, rays));
    // On average the screen-space estimate is close to the ray-traced one.
    let means = [fsa, rays].map(|of| mean(of.1.iter().flatten().map(|v| f64::from(*v))).expect("pixels"));
    assert!((means[0] - means[1]).abs() < 0.05, "{means:?}");
}

#[test]
fn a_threshold_decides_how_much_is_done_again() {
    let gpu = gpu();
    let again = |threshold: f32| {
        let ao = AoSettings { threshold, ..small(Ao::Variant1).ao };
        let (prepared, _) = prepared(&gpu, &hall(0.3), &Settings { ao, ..small(Ao::Variant1) });
        prepared.ambient_pixels_again().expect("readable").expect("adaptive")
    };
    let counts = [0.0, 0.01, 0.02].map(again);
    assert!(counts.windows(2).all(|w| w[0] > w[1]), "{counts:?}");
    let (prepared, _) = prepared(&gpu, &hall(0.3), &small(Ao::Fsa));
    assert_eq!(prepared.ambient_pixels_again().expect("readable"), None);
}

#[test]
fn a_guard_band_shows_the_same_occlusion() {
    let (gpu, scene) = (gpu(), hall(0.1));
    for ao in ALL {
        let [plain, guarded] = ["stereo", "stereo-guardband"].map(|m| visibility(&render(&gpu, &scene, m, &small(ao))));
        assert_eq!(plain[0].len(), guarded[0].len());
        let off = mean_absolute_error(slices(&plain), slices(&guarded)).expect("pixels");
        // With a guard band the pixels and their random numbers are others, and more can be seen beyond the border.
        assert!(off < 0.03, "{}: {off}", ao.name());
    }
}

#[test]
fn forced_passes_change_nothing() {
    let gpu = gpu();
    let mut parts = vec![(plane(4), material(0.9), place([4.0, 1.0, 4.0], DQuat::IDENTITY, [0.0; 3]))];
    parts.push((sphere(12), material(0.9), place([0.4; 3], DQuat::IDENTITY, [0.0, 0.3, 0.0])));
    let view = look(DVec3::new(0.0, 1.0, 2.0), DVec3::ZERO);
    let scene = Arc::new(pictures::scene(parts, 1.0, view));
    for ao in [Ao::None, Ao::Mono, Ao::Fsa] {
        let [lean, all] =
            [false, true].map(|all_passes| render(&gpu, &scene, "sssr", &Settings { all_passes, ..small(ao) }));
        assert_eq!(lean.linear, all.linear, "{}", ao.name());
        assert_eq!(lean.ambient_visibility, all.ambient_visibility, "{}", ao.name());
    }
}

#[test]
fn the_program_compares_the_ways_and_writes_what_it_found() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = ["compare", "room", "no-such-scene", "--effect", "ao", "--size", "64x36", "--seeds", "2"];
    let more = ["--ao-rays", "2", "--poses", "3", "-o", "c", "--json"];
    let done = cyclopean(folder.path(), &[&arguments[..], &more[..]].concat());
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.contains("unknown scene `no-such-scene`"), "{said}");
    let out = folder.path().join("c");
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("ao.json")).expect("written")).expect("JSON");
    assert_eq!(report, serde_json::from_slice::<serde_json::Value>(&done.stdout).expect("one object"));
    let scene = &report["scenes"][0];
    let methods = scene["methods"].as_array().expect("a list");
    let names: Vec<&str> = methods.iter().filter_map(|m| m["method"].as_str()).collect();
    assert_eq!(names, ["mono", "fsa", "variant1", "variant2"]);
    assert_eq!((methods[0]["ratio"][1].as_f64(), methods[1]["mae_fsa"].as_f64()), (Some(1.0), Some(0.0)));
    for method in methods {
        let passes = method["passes"].as_object().expect("passes");
        assert!(passes.contains_key("ao_filter") && passes.values().all(|ms| ms.as_f64() > Some(0.0)), "{method}");
        assert!(method["inconsistency"].is_number() && method["mae_ray_traced"].is_number(), "{method}");
    }
    assert_eq!(scene["thresholds"].as_array().map(Vec::len), Some(12));
    assert_eq!(scene["path"]["methods"][2]["inconsistency"].as_array().map(Vec::len), Some(3));
    let words = std::fs::read_to_string(out.join("ao.md")).expect("written");
    assert!(words.contains("| `variant2` |") && words.contains("Means over 3 poses"), "{words}");
    for drawing in ["room_ao_threshold.svg", "room_ao_path.svg"] {
        let svg = std::fs::read_to_string(out.join(drawing)).expect("written");
        assert!(svg.contains(">variant1</text>") && !svg.contains("NaN"), "{drawing}");
    }
}

#[test]
fn wrong_numbers_are_one_sentence_and_two() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let render = ["render", "room", "--method", "sssr", "--ao", "fsa"];
    let compare = ["compare", "room", "--effect", "ao"];
    for (command, wrong, said) in [
        (&render[..], ["--ao-radius", "0"], "--ao-radius 0 is outside 0.001 to 1000 metres"),
        (&render[..], ["--ao-radius", "1e9"], "--ao-radius 1000000000 is outside 0.001 to 1000 metres"),
        (&render[..], ["--ao-radius", "NaN"], "--ao-radius NaN is outside"),
        (&render[..], ["--ao-threshold", "2"], "--ao-threshold 2 is outside 0 to 1"),
        (&render[..], ["--ao-rays", "0"], "1..=65536"),
        (&render[..], ["--ao", "magic"], "possible values: none, mono, fsa, variant1, variant2, ray-traced"),
        (&compare[..], ["--ao-radius", "0"], "--ao-radius 0 is outside 0.001 to 1000 metres"),
        (&compare[..], ["--ao-radius", "1e9"], "--ao-radius 1000000000 is outside 0.001 to 1000 metres"),
    ] {
        let arguments: Vec<&str> = match wrong[0] {
            "--ao" => [&command[..4], &wrong[..]].concat(),
            _ => [command, &wrong[..]].concat(),
        };
        let done = cyclopean(folder.path(), &arguments);
        let stderr = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(said), "{arguments:?}: {stderr}");
        assert!(!folder.path().join("out").exists(), "{arguments:?} wrote something");
    }
}
