//! Compares the pictures of the device's ray queries with those of our BVH and of the processor. Needs a Vulkan device.
//! Its driver need not have ray queries: most tests run themselves again in the root folder that `tests/xr/root`
//! builds, where a driver has ray queries in software. They are skipped, with a message, where there is no such folder.
#![cfg(feature = "gpu")]

use std::path::Path;
use std::process::{Command, Output};
use std::rc::Rc;
use std::sync::Arc;

use cyclopean::gpu::Gpu;
use cyclopean::picture::StereoPicture;
use cyclopean::render::{Ao, AoSettings, Method, Rendered, Renderer, Request, Settings, Trace};
use cyclopean::scene::{self, Fallback, Scene};

use crate::pictures::{self, deviations, gpu, lattices, settings};
use crate::xr::{is_there, repository};

fn render(gpu: &Rc<Gpu>, scene: &Arc<Scene>, method: &str, settings: &Settings) -> Rendered {
    let camera = scene.views[0].stereo_camera(settings.aspect());
    let method = Method::parse(method).expect("a method");
    let mut renderer = Renderer::new(gpu, Arc::clone(scene)).expect("uploaded");
    let request = Request { camera: &camera, method: &method, settings, frames: 1 };
    renderer.render(&request, &mut |_, _| Ok(())).expect("rendered without a message")
}

fn green(picture: &StereoPicture) -> impl Iterator<Item = f64> {
    picture.eyes.iter().flatten().map(|t| f64::from(t[1]))
}

/// The speed of the pass `name`, in millions of rays per second.
fn speed(r: &Rendered, name: &str) -> f64 {
    let ms: f64 = r.passes.iter().filter(|p| p.name == name).map(|p| p.ms).sum();
    r.counters.rays as f64 / ms / 1e3
}

/// The test below runs this one inside the root. By itself it needs a device with ray queries.
#[test]
#[ignore = "run by `ray_queries_and_the_bvh_make_one_picture` on a device with ray queries"]
fn inside() {
    let gpu = gpu();
    assert!(gpu.has_ray_query(), "{} has no ray queries", gpu.info().name);
    let room = scene::load("room").expect("a built-in scene");
    for (name, scene) in [("lattices", Arc::new(lattices())), ("room", Arc::new(room))] {
        let by = |trace: Trace, seed: u32, method: &str| {
            let settings = Settings { trace, seed, fallback: Some(Fallback::Probe), ..settings(96, 54) };
            render(&gpu, &scene, method, &settings)
        };
        // With the same rays the hits are the same, except where rounding puts one on the other side of an edge.
        let (bvh, query) = (by(Trace::Bvh, 1, "path-traced@32"), by(Trace::RayQuery, 1, "path-traced@32"));
        assert_eq!((bvh.tracer, query.tracer), (Some("bvh"), Some("ray-query")), "{name}");
        let (a, b) = (bvh.counters.hits as f64, query.counters.hits as f64);
        assert!(a > 1e3 && (a - b).abs() < 1e-4 * a, "{name}: {a} hits by the BVH, {b} by ray queries");
        let differs = |(x, y): &(f64, f64)| (x - y).abs() > 0.01 * x.max(*y);
        let pixels = green(&bvh.reflection).zip(green(&query.reflection));
        let apart = pixels.filter(differs).count() as f64 / (2.0 * 96.0 * 54.0);
        assert!(apart < 0.01, "{name}: {:.2} % of the pixels differ", 100.0 * apart);
        // With other rays the pictures agree within the standard errors of both.
        let other = by(Trace::RayQuery, 2, "path-traced@32");
        let (Some(ea), Some(eb)) = (&bvh.error, &other.error) else { panic!("the reference has a standard error") };
        let pairs = green(&bvh.reflection).zip(green(&other.reflection)).zip(green(ea).zip(green(eb)));
        // Pixels in which all paths agree (mirrors, black) are left out, because their estimated errors are only
        // rounding.
        let z: Vec<f64> = pairs
            .filter(|((x, _), (ex, ey))| ex.hypot(*ey) > 1e-3 * x.abs().max(1e-6))
            .map(|((x, y), (ex, ey))| (x - y) / ex.hypot(ey))
            .collect();
        let n = z.len() as f64;
        let mean = z.iter().sum::<f64>() / n;
        let beyond = z.iter().filter(|z| z.abs() > 3.0).count() as f64 / n;
        assert!(n > 500.0, "{name}: {n} pixels with noise");
        assert!(mean.abs() < 4.0 / n.sqrt(), "{name}: mean of Δ/σ is {mean} over {n} pixels");
        // A normal distribution has 0.27 % beyond 3 σ. Means over few paths have heavier tails.
        assert!(beyond < 0.03, "{name}: {:.2} % of {n} pixels lie beyond 3 σ", 100.0 * beyond);
        // The other shaders that ask the geometry must agree as well.
        for method in ["path-traced@2-resolved", "sssr", "stereo-hybrid"] {
            let (x, y) = (by(Trace::Bvh, 1, method), by(Trace::RayQuery, 1, method));
            let apart = green(&x.linear).zip(green(&y.linear)).filter(differs).count() as f64 / (2.0 * 96.0 * 54.0);
            let total = |r: &Rendered| green(&r.linear).sum::<f64>();
            let difference =
                green(&x.linear).zip(green(&y.linear)).map(|(a, b)| (a - b).abs()).sum::<f64>() / total(&x);
            println!("{name}, {method}: {:.2} % of the pixels differ, by {difference:.5} of the light", 100.0 * apart);
            // The filter spreads a ray that rounding takes past an edge, or past the edge of a shadow, over 25 pixels.
            assert!(
                apart < 0.02 && difference < 0.005,
                "{name}, {method}: {apart} of the pixels differ, by {difference} of the light"
            );
        }
        // So must the shader for ambient occlusion, which follows the same rays in every pixel.
        let ao = |trace: Trace| {
            let ao = AoSettings { method: Ao::RayTraced, rays: 64, ..AoSettings::default() };
            let settings = Settings { trace, ao, ..settings(96, 54) };
            let rendered = render(&gpu, &scene, "sssr", &settings);
            green(&rendered.ambient_visibility.expect("ambient light is occluded")).collect::<Vec<f64>>()
        };
        let (x, y) = (ao(Trace::Bvh), ao(Trace::RayQuery));
        let hidden = x.iter().filter(|v| **v < 0.9).count();
        let apart_by_ray = x.iter().zip(&y).filter(|(a, b)| (*a - *b).abs() > 1.5 / 64.0).count() as f64;
        let difference = x.iter().zip(&y).map(|(a, b)| (a - b).abs()).sum::<f64>() / x.len() as f64;
        println!(
            "{name}, ambient occlusion: {apart_by_ray} of {} pixels differ by more than a ray, by {difference:.6} in the mean",
            x.len()
        );
        assert!(hidden > 500, "{name}: ambient light is occluded in {hidden} pixels");
        assert!(
            apart_by_ray < 0.005 * x.len() as f64 && difference < 1e-3,
            "{name}: {apart_by_ray} pixels differ, on average {difference}"
        );
        println!(
            "{name}: {:.3} % of the pixels differ with the same rays; with others {:.2} % lie beyond 3 σ, and the \
             mean of Δ/σ is {mean:.4}; {:.2} million rays per second by the BVH, {:.2} by ray queries",
            100.0 * apart,
            100.0 * beyond,
            speed(&bvh, "path_trace"),
            speed(&query, "path_trace")
        );
    }
    println!("both ways agree");
}

/// The test `the_three_tracers_agree_on_every_built_in_scene` runs this one inside the root.
#[test]
#[ignore = "run by `the_three_tracers_agree_on_every_built_in_scene` on a device with ray queries"]
fn inside_every_scene() {
    let gpu = gpu();
    assert!(gpu.has_ray_query(), "{} has no ray queries", gpu.info().name);
    for name in scene::builtin::NAMES {
        let scene = Arc::new(scene::load(name).expect("a built-in scene"));
        let by = |(trace, seed): (Trace, u32)| {
            render(&gpu, &scene, "path-traced@16", &Settings { trace, seed, ..settings(160, 90) })
        };
        // Each tracer has its own random numbers, so that the pictures may differ only by noise.
        let [bvh, query, cpu] = [(Trace::Bvh, 1), (Trace::RayQuery, 2), (Trace::Cpu, 3)].map(by);
        for (pair, a, b) in [("ray query, BVH", &query, &bvh), ("processor, ray query", &cpu, &query)] {
            let z = deviations(a, b);
            let mean = z.iter().sum::<f64>() / z.len() as f64;
            let beyond = z.iter().filter(|z| z.abs() > 5.0).count();
            println!("{name}, {pair}: mean of Δ/σ {mean:.4}, {beyond} of {} beyond 5 σ", z.len());
            assert!(mean.abs() < 0.05 && beyond as f64 <= 1e-3 * z.len() as f64, "{name}, {pair}");
        }
        let [bvh, query, cpu] = [bvh, query, cpu].map(|r| speed(&r, "path_trace"));
        println!(
            "{name}: {bvh:.3} million paths a second by the BVH, {query:.3} by ray queries, {cpu:.3} by the processor"
        );
    }
    println!("all three agree");
}

fn run_inside(program: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(repository().join("tests/xr/inside"));
    command.arg(program).args(arguments).current_dir(repository());
    command.env("CYCLOPEAN_VALIDATION", "1").env("CYCLOPEAN_XR_BIND", program.parent().expect("a folder"));
    command.output().expect("tests/xr/inside runs")
}

/// Runs an ignored test of this file inside the root, and prints what it prints. `last` is its last line.
fn passes_inside(test: &str, last: &str) {
    let this = std::env::current_exe().expect("a path");
    let done = run_inside(&this, &["--exact", &format!("ray_query::{test}"), "--ignored", "--nocapture"]);
    let (out, log) = (text(&done.stdout), text(&done.stderr));
    assert!(done.status.success() && out.contains(last), "{out}\n{log}");
    println!("{out}");
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn ray_queries_and_the_bvh_make_one_picture() {
    if !is_there() {
        return;
    }
    passes_inside("inside", "both ways agree");

    let folder = tempfile::tempdir().expect("a temporary folder");
    let to = folder.path().display().to_string();
    let render =
        ["render", "room", "-m", "path-traced@1", "--size", "32x18", "--trace", "ray-query", "--json", "-o", &to];
    let done = run_inside(Path::new(env!("CARGO_BIN_EXE_cyclopean")), &render);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let report: serde_json::Value = serde_json::from_slice(&done.stdout).expect("JSON");
    assert_eq!(report["trace"], "ray-query");
}

/// Takes minutes: `cargo test --profile traced --test all three_tracers -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn the_three_tracers_agree_on_every_built_in_scene() {
    if !is_there() {
        return;
    }
    passes_inside("inside_every_scene", "all three agree");
}

#[test]
fn a_device_without_ray_queries_says_so_and_takes_the_bvh() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = |more: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_cyclopean"))
            .args(["render", "room", "-m", "path-traced@1", "--size", "16x9", "--json", "-o"])
            .arg(folder.path())
            .args(more)
            .env("CYCLOPEAN_VALIDATION", "1")
            .output()
            .expect("the program starts")
    };
    let by = |done: &Output| serde_json::from_slice::<serde_json::Value>(&done.stdout).expect("JSON")["trace"].clone();
    assert_eq!(by(&run(&["--trace", "bvh"])), "bvh");
    assert_eq!(by(&run(&["--trace", "cpu"])), "cpu");
    // Without --trace, a software device leaves the reference's paths to the processor.
    let (auto, is_cpu) = (run(&[]), pictures::gpu().is_cpu());
    assert!(!is_cpu || by(&auto) == "cpu");
    let asked = run(&["--trace", "ray-query"]);
    if asked.status.success() {
        assert_eq!(by(&asked), "ray-query");
        assert!(is_cpu || by(&auto) == "ray-query");
    } else {
        assert_eq!(asked.status.code(), Some(1));
        let log = text(&asked.stderr);
        assert!(log.contains("lacks ray queries") && !log.contains("validation"), "{log}");
    }
}
