//! Tests shading that the eyes share against full shading, which is the oracle: its errors, also at edges, how much it
//! reuses, and what it must not change. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::rc::Rc;
use std::sync::Arc;

use cyclopean::gpu::Gpu;
use cyclopean::picture::StereoPicture;
use cyclopean::render::{Method, Prepared, Renderer, Settings, ShadingReuse, Trace};
use cyclopean::scene::{self, Light, LightSource, Material, Scene, StereoCamera, View};
use glam::{DQuat, DVec3, Vec3};

use crate::pictures::{gpu, look, material, plane, scene as make_scene, settings, sphere};

/// The names of the passes that light the surfaces.
const LIGHTING: [&str; 5] = ["shadows", "lights", "indirect", "shading_reuse", "lighting"];

/// A dielectric material with this roughness and colour.
fn paint(roughness: f32, color: [f32; 3]) -> Material {
    Material { metallic: 0.0, base_color: Vec3::from(color).extend(1.0), ..material(roughness) }
}

/// `n` point lights, spread evenly (R3, Roberts 2018) over a box before the view. Their total strength does not depend
/// on `n`.
fn lights_before(view: &View, n: usize) -> Vec<Light> {
    let axis = |v: DVec3| view.world_from_view * v;
    (0..n)
        .map(|i| {
            let u = [0.819_172_513, 0.671_043_607, 0.549_700_478].map(|a: f64| (0.5 + a * (i + 1) as f64).fract());
            let across = axis(DVec3::X) * (4.0 * u[0] - 2.0);
            let up = DVec3::Y * (1.6 * u[1] - 0.2);
            let along = axis(DVec3::NEG_Z) * (0.3 + 3.7 * u[2]);
            let intensity = Vec3::new(1.0, 0.9, 0.8) * (12.0 / n as f32);
            LightSource::Point { position: view.position + across + up + along, intensity, range_m: f32::INFINITY }
                .into()
        })
        .collect()
}

/// A hall with a floor, a back wall, a side wall, columns, and balls with different roughnesses.
fn hall(lights: usize) -> Scene {
    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let side = DQuat::from_rotation_z(-std::f64::consts::FRAC_PI_2);
    let place = cyclopean::stress::shapes::place;
    let mut parts = vec![
        (plane(8), paint(0.4, [0.5, 0.4, 0.3]), place([8.0, 1.0, 8.0], DQuat::IDENTITY, [0.0, 0.0, -2.0])),
        (plane(8), paint(0.9, [0.7, 0.7, 0.65]), place([8.0, 1.0, 4.0], upright, [0.0, 2.0, -5.0])),
        (plane(8), paint(0.8, [0.3, 0.5, 0.6]), place([4.0, 1.0, 8.0], side, [-3.0, 2.0, -2.0])),
    ];
    for (i, x) in [-1.6, -0.5, 0.6, 1.7].into_iter().enumerate() {
        let roughness = [0.15, 0.35, 0.6, 0.9][i];
        parts.push((sphere(24), paint(roughness, [0.6, 0.3, 0.2]), place([0.3; 3], DQuat::IDENTITY, [x, 0.3, -1.6])));
        let column = place([0.12, 1.4, 0.12], DQuat::IDENTITY, [x + 0.4, 1.4, -3.2]);
        parts.push((sphere(24), paint(0.7, [0.8, 0.8, 0.8]), column));
    }
    let view = look(DVec3::new(0.2, 1.3, 1.2), DVec3::new(0.0, 0.6, -3.0));
    let mut made = make_scene(parts, 0.2, view);
    made.lights = lights_before(&made.views[0], lights);
    made
}

/// A built-in scene, lit only by its environment and by `n` lamps.
fn built_in(name: &str, n: usize) -> Scene {
    let mut made = scene::load(name).expect("a built-in scene");
    made.lights = lights_before(&made.views[0], n);
    made
}

fn camera(scene: &Scene, settings: &Settings) -> StereoCamera {
    scene.views[0].stereo_camera(settings.aspect())
}

fn prepare(gpu: &Rc<Gpu>, scene: &Arc<Scene>, settings: &Settings) -> Prepared {
    let mut renderer = Renderer::new(gpu, Arc::clone(scene)).expect("uploaded");
    let method = Method::parse("sssr").expect("a method");
    renderer.prepare(&camera(scene, settings), &method, settings).expect("prepared")
}

/// Renders a frame whose lighting is computed anew. Returns the time of its lighting in milliseconds, and its radiance
/// without traced reflections.
fn lit(prepared: &mut Prepared) -> (f64, StereoPicture) {
    let camera = *prepared.camera();
    prepared.set_camera(&camera);
    let report = prepared.frame(&mut |_, _| Ok(())).expect("a frame");
    let ms = report.passes.iter().filter(|p| LIGHTING.contains(&p.name.as_str())).map(|p| p.ms).sum();
    let (mut radiance, reflection) = (prepared.linear().expect("read"), prepared.reflection().expect("read"));
    for (eye, reflected) in radiance.eyes.iter_mut().zip(&reflection.eyes) {
        for (sum, r) in eye.iter_mut().zip(reflected) {
            *sum = [0, 1, 2].map(|c| sum[c] - r[c]);
        }
    }
    (ms, radiance)
}

fn largest(c: [f32; 3]) -> f32 {
    c[0].max(c[1]).max(c[2])
}

/// The error of each pixel of the right eye: the largest difference of a channel, divided by the brightest channel of
/// full shading. The divisor is at least a hundredth of the picture's mean.
fn errors(shared: &StereoPicture, full: &StereoPicture) -> Vec<f64> {
    let mean = full.eyes[1].iter().map(|p| f64::from(largest(*p))).sum::<f64>() / full.eyes[1].len() as f64;
    let pairs = shared.eyes[1].iter().zip(&full.eyes[1]);
    pairs
        .map(|(a, b)| {
            let difference = largest([0, 1, 2].map(|c| (a[c] - b[c]).abs()));
            f64::from(difference) / f64::from(largest(*b)).max(0.01 * mean)
        })
        .collect()
}

fn share(errors: &[f64], above: f64) -> f64 {
    errors.iter().filter(|e| **e > above).count() as f64 / errors.len() as f64
}

/// The share of the right eye's surface pixels that took their light from the left eye.
fn reused(prepared: &Prepared) -> f64 {
    let geometry = prepared.geometry().expect("read");
    let surfaces = geometry.eyes[1].instance.iter().filter(|i| **i > 0).count();
    let again = prepared.pixels_lit_again().expect("read").expect("shared");
    1.0 - f64::from(again) / surfaces as f64
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    cyclopean::render::median_of_sorted(&values)
}

#[test]
fn switched_off_it_leaves_no_trace() {
    let gpu = gpu();
    let scene = Arc::new(hall(1));
    let off = Settings { shadows: false, ..settings(96, 54) };
    let auto = Settings { shading_reuse: ShadingReuse::Auto, ..off.clone() };
    assert!(serde_json::to_value(&off).expect("JSON").get("shading_reuse").is_none());
    let [mut without, mut with] = [&off, &auto].map(|settings| prepare(&gpu, &scene, settings));
    assert!(!with.needs().shading_reuse, "shading is shared for a single light");
    assert_eq!(with.pixels_lit_again().expect("read"), None);
    assert_eq!(lit(&mut without).1.eyes, lit(&mut with).1.eyes);
    let many = Arc::new(hall(64));
    assert!(prepare(&gpu, &many, &auto).needs().shading_reuse);
    // Where the processor finds the shadows, shading is shared only with `Always`, because nothing is gained by it.
    let by = |trace: Trace, shading_reuse: ShadingReuse| {
        let settings = Settings { shadows: true, trace, shading_reuse, ..off.clone() };
        let prepared = prepare(&gpu, &many, &settings);
        [prepared.needs().shading_reuse, prepared.needs().cpu_shadows]
    };
    assert_eq!(by(Trace::Bvh, ShadingReuse::Auto), [true, false]);
    assert_eq!(by(Trace::Cpu, ShadingReuse::Auto), [false, true]);
    assert_eq!(by(Trace::Cpu, ShadingReuse::Always), [true, false]);
    let mut renderer = Renderer::new(&gpu, Arc::clone(&many)).expect("uploaded");
    let reference = Method::parse("path-traced@1").expect("a method");
    let prepared = renderer.prepare(&camera(&many, &auto), &reference, &auto).expect("prepared");
    assert!(!prepared.needs().shading_reuse, "the reference shares shading");
    gpu.check_validation().expect("no message");
}

/// The pictures of a scene with full and with shared shading, and the prepared renderer of the latter.
fn both(gpu: &Rc<Gpu>, scene: &Arc<Scene>, full: &Settings) -> (StereoPicture, StereoPicture, Prepared) {
    let shared = Settings { shading_reuse: ShadingReuse::Always, ..full.clone() };
    let (mut in_full, mut of_both) = (prepare(gpu, scene, full), prepare(gpu, scene, &shared));
    let pictures = (lit(&mut in_full).1, lit(&mut of_both).1);
    gpu.check_validation().expect("no message");
    (pictures.0, pictures.1, of_both)
}

#[test]
fn errors_are_small_and_the_left_eye_has_none() {
    let gpu = gpu();
    for (lights, shadows, antialias) in [(64, true, 1), (64, false, 1), (8, true, 2)] {
        let full = Settings { shadows, antialias, ..settings(240, 136) };
        let (in_full, shared, prepared) = both(&gpu, &Arc::new(hall(lights)), &full);
        let (errors, reused) = (errors(&shared, &in_full), reused(&prepared));
        let above = share(&errors, 0.02);
        println!(
            "{lights} lights, shadows {shadows}: {:.2} % above 2 %, {:.1} % reused",
            100.0 * above,
            100.0 * reused
        );
        assert!(above <= 0.005, "{lights} lights, shadows {shadows}: {above}");
        assert!(reused >= 0.5, "{lights} lights, shadows {shadows}: {reused}");
        if shadows {
            assert_eq!(shared.eyes[0], in_full.eyes[0]);
        }
    }
}

#[test]
fn eyes_in_one_place_see_one_light() {
    let gpu = gpu();
    let mut scene = hall(8);
    scene.views[0].ipd_m = 0.0;
    let (_, shared, prepared) = both(&gpu, &Arc::new(scene), &settings(160, 90));
    let [left, right] = &shared.eyes;
    let most = left.iter().zip(right).map(|(l, r)| largest([0, 1, 2].map(|c| (l[c] - r[c]).abs())));
    let most = most.fold(0.0, f32::max);
    assert!(most <= 1e-3, "{most}");
    assert!(reused(&prepared) >= 0.97, "{}", reused(&prepared));
}

#[test]
fn no_ghost_stands_beside_what_is_near() {
    let gpu = gpu();
    let place = cyclopean::stress::shapes::place;
    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let parts = vec![
        (plane(2), paint(0.9, [0.1, 0.1, 0.5]), place([12.0, 1.0, 12.0], upright, [0.0, 0.0, -4.0])),
        (sphere(24), paint(0.9, [0.9, 0.8, 0.1]), place([0.25; 3], DQuat::IDENTITY, [0.0, 0.0, -0.8])),
        (plane(2), paint(0.9, [0.9, 0.8, 0.1]), place([0.1, 1.0, 1.2], upright, [0.5, 0.0, -0.8])),
    ];
    let mut scene = make_scene(parts, 0.05, look(DVec3::ZERO, DVec3::new(0.0, 0.0, -1.0)));
    scene.lights = lights_before(&scene.views[0], 8);
    let (width, height) = (240usize, 136usize);
    let (in_full, shared, prepared) = both(&gpu, &Arc::new(scene), &settings(width as u32, height as u32));
    let errors = errors(&shared, &in_full);
    let instance = &prepared.geometry().expect("read").eyes[1].instance;
    let (mut edge, mut worst) = (0, 0.0f64);
    for y in 0..height {
        for x in 0..width {
            let near = (x.saturating_sub(4)..(x + 5).min(width)).map(|u| instance[y * width + u]);
            if near.into_iter().any(|i| i != instance[y * width + x]) {
                edge += 1;
                worst = worst.max(errors[y * width + x]);
            }
        }
    }
    // A ghost would put the ball's light on the wall, which would be several times as bright.
    assert!(edge > 500 && worst <= 0.06, "{edge} pixels, {worst}");
    assert!(reused(&prepared) >= 0.6, "{}", reused(&prepared));
}

#[test]
fn excluded_materials_are_lit_in_full_to_the_bit() {
    let gpu = gpu();
    let mut scene = hall(8);
    // The floor and every second other material are excluded.
    for i in (0..scene.materials.len()).step_by(2) {
        scene.materials[i].shading_reuse = false;
    }
    let excluded: Vec<bool> = scene.primitives.iter().map(|p| !scene.materials[p.material].shading_reuse).collect();
    // Reflections are not traced, because they would show the materials that are not excluded.
    let full = Settings { ray_roughness_limit: -1.0, ..settings(160, 90) };
    let (in_full, shared, prepared) = both(&gpu, &Arc::new(scene), &full);
    let geometry = prepared.geometry().expect("read");
    let (mut pixels, mut others) = (0, 0);
    for (i, instance) in geometry.eyes[1].instance.iter().enumerate() {
        if *instance > 0 && excluded[*instance as usize - 1] {
            pixels += 1;
            assert_eq!(shared.eyes[1][i], in_full.eyes[1][i], "pixel {i}");
        } else if shared.eyes[1][i] != in_full.eyes[1][i] {
            others += 1;
        }
    }
    assert!(pixels > 1000 && others > 200, "{pixels} excluded, {others} others differ");
}

#[test]
fn another_pose_and_another_light_are_lit_anew() {
    let gpu = gpu();
    let full = settings(160, 90);
    let shared = Settings { shading_reuse: ShadingReuse::Always, ..full.clone() };
    let scene = Arc::new(hall(8));
    let mut of_both = prepare(&gpu, &scene, &shared);
    let before = lit(&mut of_both).1;
    let mut in_full = prepare(&gpu, &scene, &full);
    let mut view = scene.views[0].clone();
    view.position += DVec3::new(-0.3, 0.1, 0.0);
    let moved = view.stereo_camera(full.aspect());
    of_both.set_camera(&moved);
    in_full.set_camera(&moved);
    let (after, expected) = (lit(&mut of_both).1, lit(&mut in_full).1);
    assert!(share(&errors(&after, &expected), 0.02) <= 0.005);
    assert!(share(&errors(&after, &before), 0.02) > 0.2);
    // When a still view is rendered again, it keeps its lighting, shared or not.
    let again = of_both.frame(&mut |_, _| Ok(())).expect("a frame");
    assert!(again.passes.iter().all(|p| !["shadows", "shading_reuse"].contains(&p.name.as_str())));

    let mut other = (*scene).clone();
    for light in &mut other.lights {
        if let LightSource::Point { position, .. } = &mut light.source {
            *position += DVec3::new(0.5, 0.2, 0.0);
        }
    }
    let (in_full, of_both, _) = both(&gpu, &Arc::new(other), &full);
    assert!(share(&errors(&of_both, &in_full), 0.02) <= 0.005);
    assert!(share(&errors(&of_both, &before), 0.02) > 0.2);
}

#[test]
fn baked_light_is_each_eyes_own() {
    let gpu = gpu();
    let full = Settings { indirect: true, ..settings(120, 68) };
    let (in_full, shared, prepared) = both(&gpu, &Arc::new(hall(8)), &full);
    assert_eq!(shared.eyes[0], in_full.eyes[0]);
    let above = share(&errors(&shared, &in_full), 0.02);
    assert!(above <= 0.005 && reused(&prepared) >= 0.4, "{above}, {}", reused(&prepared));
}

#[test]
fn a_manifest_excludes_materials_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("x.json");
    let load = |name: &str| {
        let text = format!(
            r#"{{"name": "x", "geometry": {{"builtin": {{"name": "room", "detail": 0.01}}}},
                 "materials": [{{"name": "{name}", "shading_reuse": false}}]}}"#
        );
        std::fs::write(&path, text).expect("written");
        scene::load(&path.to_string_lossy())
    };
    let room = load("parquet").expect("a scene");
    assert!(room.materials.iter().all(|m| m.shading_reuse == (m.name != "parquet")));
    let error = load("plastic").expect_err("refused").to_string();
    assert!(error.contains("plastic") && error.contains("no material of that name"), "{error}");
}

/// Prints the table of docs/rendering.md.
#[test]
#[ignore = "a measurement of several minutes"]
fn measure() {
    let options = cyclopean::gpu::GpuOptions { validation: false, pipeline_cache: None };
    let gpu = Gpu::open(&cyclopean::gpu::OwnDevice::default(), &options).expect("a Vulkan device");
    let variable = |name: &str, otherwise: &str| std::env::var(name).unwrap_or_else(|_| otherwise.to_owned());
    let number = |name: &str, otherwise: &str| variable(name, otherwise).parse::<u32>().expect("a number");
    let rounds = number("ROUNDS", "5");
    let scenes = variable("SCENES", "hall,room,wine,pica");
    let counts = variable("LIGHTS", "1,8,64");
    let (width, height) = (number("WIDTH", "480"), number("HEIGHT", "270"));
    println!("device: {}, {width}x{height}, medians of {rounds} interleaved rounds", gpu.info().name);
    println!("| scene | lights | shadows | full, ms | shared / full | reused | error > 2 % | 99.9th percentile |");
    println!("|---|---|---|---|---|---|---|---|");
    for name in scenes.split(',') {
        for n in counts.split(',').map(|n| n.parse::<usize>().expect("a number")) {
            let scene = Arc::new(if name == "hall" { hall(n) } else { built_in(name, n) });
            for shadows in [false, true] {
                // The device finds the shadows of both. By default the processor would find those of full shading on a
                // software device.
                let full = Settings { shadows, trace: Trace::Bvh, ..settings(width, height) };
                let shared = Settings { shading_reuse: ShadingReuse::Always, ..full.clone() };
                let mut both = [prepare(&gpu, &scene, &full), prepare(&gpu, &scene, &shared)];
                let mut times = [Vec::new(), Vec::new()];
                let mut seen = None;
                for round in 0..=rounds {
                    let [a, b] = both.each_mut().map(lit);
                    if round > 0 {
                        times[0].push(a.0);
                        times[1].push(b.0);
                    }
                    seen = Some((a.1, b.1));
                }
                let (in_full, of_both) = seen.expect("a round");
                let mut errors = errors(&of_both, &in_full);
                let above = share(&errors, 0.02);
                errors.sort_by(f64::total_cmp);
                let [full_ms, shared_ms] = times.map(median);
                println!(
                    "| {name} | {n} | {} | {full_ms:.1} | {:.2} | {:.1} % | {:.2} % | {:.1} % |",
                    if shadows { "yes" } else { "no" },
                    shared_ms / full_ms,
                    100.0 * reused(&both[1]),
                    100.0 * above,
                    100.0 * errors[errors.len() * 999 / 1000],
                );
            }
        }
    }
}
