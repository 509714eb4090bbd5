//! Compares the reference of the processor's path tracer with that of the device. With the same random numbers both
//! follow the same paths, except where rounding decides otherwise. With other numbers they agree within their standard
//! errors. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use cyclopean::console::Interrupted;
use cyclopean::gpu::Gpu;
use cyclopean::render::{Method, Prepared, Rendered, Renderer, Settings, Trace};
use cyclopean::scene::{self, Light, LightSource, Material, Scene, Texture, TextureRef, Wrap};
use glam::{DAffine3, DQuat, DVec3, Mat3, Vec3};

use crate::pictures::{self, deviations, glowing, gpu, lattices, look, material, plane, settings, sphere, values};

/// The largest share of pixels that may differ by more than [`ROUNDING`] with the same seed.
const APART: f64 = 0.01;
/// The largest difference that counts as rounding, relative to the larger of the two values.
const ROUNDING: f32 = 0.005;

fn by(gpu: &Rc<Gpu>, scene: &Arc<Scene>, trace: Trace, spp: u32, settings: &Settings) -> Rendered {
    let settings = Settings { trace, ..settings.clone() };
    let rendered = pictures::render(gpu, scene, &format!("path-traced@{spp}"), &settings);
    let way = if trace == Trace::Cpu { "cpu" } else { "bvh" };
    assert_eq!(rendered.tracer, Some(way));
    rendered
}

fn agree(gpu: &Rc<Gpu>, name: &str, scene: &Arc<Scene>, spp: u32, settings: &Settings) {
    let device = by(gpu, scene, Trace::Bvh, spp, settings);
    let same = by(gpu, scene, Trace::Cpu, spp, settings);
    let other = by(gpu, scene, Trace::Cpu, spp, &Settings { seed: 2, ..settings.clone() });

    let pixels = |r: &Rendered| r.reflection.eyes.iter().flatten().copied().collect::<Vec<_>>();
    let (a, b) = (pixels(&device), pixels(&same));
    let reflecting = a.iter().zip(&b).filter(|(x, y)| **x != [0.0; 3] || **y != [0.0; 3]);
    let reflecting: Vec<_> = reflecting.collect();
    let differs = |(x, y): &&(&[f32; 3], &[f32; 3])| {
        x.iter().zip(*y).any(|(x, y)| (x - y).abs() > ROUNDING * x.max(*y).max(1e-3))
    };
    let apart = reflecting.iter().filter(differs).count() as f64 / reflecting.len().max(1) as f64;
    let exact = reflecting.iter().filter(|(x, y)| x == y).count();
    let z = deviations(&device, &same);
    let largest = z.iter().fold(0.0f64, |m, z| m.max(z.abs()));
    let shift = z.iter().sum::<f64>() / z.len().max(1) as f64;
    let z = deviations(&device, &other);
    let mean = z.iter().sum::<f64>() / z.len().max(1) as f64;
    let beyond = z.iter().filter(|z| z.abs() > 5.0).count();
    println!(
        "{name}: {} reflecting pixels, {:.3} % differ, {exact} equal in every bit; with the same random numbers Δ/σ is \
         {shift:.4} on average and at most {largest:.2}; with others it is {mean:.4} on average, and {beyond} of {} \
         exceed 5",
        reflecting.len(),
        100.0 * apart,
        z.len()
    );
    let counted = |r: &Rendered| [r.counters.rays, r.counters.hits, r.counters.sky, r.counters.below_horizon];
    for (x, y) in counted(&device).into_iter().zip(counted(&same)) {
        assert!(x.abs_diff(y) as f64 <= 1e-4 * x.max(y) as f64 + 3.0, "{name}: {x} and {y} rays");
    }
    assert!(reflecting.len() > 500 && z.len() > 500, "{name}: {} pixels reflect", reflecting.len());
    assert!(apart <= APART, "{name}: {:.2} % of the pixels differ", 100.0 * apart);
    assert!(
        shift.abs() < 0.01 && largest < 5.0,
        "{name}: with the same random numbers Δ/σ is {shift} on average, at most {largest}"
    );
    assert!(
        mean.abs() < 0.05 && beyond as f64 <= 1e-3 * z.len() as f64,
        "{name}: Δ/σ is {mean} on average, and {beyond} pixels exceed 5"
    );
}

/// A built-in scene with few triangles.
fn coarse(name: &str) -> Arc<Scene> {
    Arc::new(
        scene::load_with(name, scene::Loading { detail: Some(0.03), ..scene::Loading::default() })
            .expect("a built-in scene"),
    )
}

#[test]
fn the_built_in_scenes_look_alike() {
    let gpu = gpu();
    // `room` has lights with a size and panes of glass, and is rendered with and without shadows. `temple` has a sky.
    let size = settings(64, 40);
    let room = coarse("room");
    agree(&gpu, "room", &room, 8, &size);
    agree(&gpu, "room, no shadows", &room, 4, &Settings { shadows: false, ..size.clone() });
    agree(&gpu, "temple", &coarse("temple"), 8, &size);
}

/// Compares all built-in scenes at full detail: `cargo test --profile traced --test all full_detail -- --ignored --nocapture`.
#[test]
#[ignore = "takes minutes"]
fn the_built_in_scenes_look_alike_at_full_detail() {
    let gpu = gpu();
    for name in scene::builtin::NAMES {
        agree(&gpu, name, &Arc::new(scene::load(name).expect("a built-in scene")), 16, &settings(160, 90));
    }
}

/// A square texture with this side and four values a texel.
fn texture(side: u32, srgb: bool, (wrap_u, wrap_v): (Wrap, Wrap), of: impl Fn(u32, u32) -> [u8; 4]) -> Texture {
    let texels: Vec<u8> = (0..side * side).flat_map(|i| of(i % side, i / side)).collect();
    let (name, rgba8) = ("test".to_owned(), Arc::new(texels));
    Texture { name, width: side, height: side, rgba8, srgb, wrap_u, wrap_v, nearest: false }
}

/// The hall of lattices, with everything else that the shading of a hit may depend on: textures of all four kinds with
/// all wrap modes, glass in front of a spot light, and lights with and without a size, one of which casts no shadow.
fn everything() -> Scene {
    let mut made = lattices();
    let first = made.textures.len();
    made.textures.push(texture(16, true, (Wrap::Mirror, Wrap::Clamp), |x, y| [16 * x as u8, 16 * y as u8, 90, 255]));
    made.textures
        .push(texture(8, false, (Wrap::Repeat, Wrap::Mirror), |x, y| [0, 60 + 20 * x as u8, 30 * y as u8, 255]));
    made.textures
        .push(texture(8, false, (Wrap::Clamp, Wrap::Repeat), |x, y| [100 + 8 * x as u8, 90 + 9 * y as u8, 230, 255]));
    let transform = Mat3::from_scale_angle_translation(glam::Vec2::new(1.7, 2.3), 0.3, glam::Vec2::new(0.2, -0.6));
    let of = |texture| Some(TextureRef { texture: first + texture, uv_set: 0, transform });
    let bumpy = Material {
        metallic: 0.7,
        base_color_texture: of(0),
        metallic_roughness_texture: of(1),
        normal_texture: of(2),
        emissive_texture: of(0),
        emissive: Vec3::splat(0.2),
        normal_scale: 0.8,
        ..material(0.9)
    };
    let glass = Material { metallic: 0.0, transmission: 0.8, double_sided: true, ..material(0.1) };
    let turned = pictures::upright() * DQuat::from_rotation_x(0.3);
    for (shape, of, scale, at) in [
        (sphere(12), bumpy.clone(), 0.5, DVec3::new(0.7, 0.6, -0.6)),
        (plane(4), bumpy, 1.2, DVec3::new(-0.9, 0.8, -1.9)),
        (plane(2), glass, 0.9, DVec3::new(0.2, 1.3, -0.9)),
    ] {
        let primitive = cyclopean::scene::Primitive { material: made.materials.len(), ..shape };
        let place = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), turned, at);
        made.instances.push(scene::Instance {
            primitive: made.primitives.len(),
            world_from_object: place,
            previous_world_from_object: place,
        });
        made.primitives.push(primitive);
        made.materials.push(of);
    }
    let light = |source, size, casts_shadow| Light { source, size, casts_shadow };
    made.lights = vec![
        light(
            LightSource::Spot {
                position: DVec3::new(0.3, 2.4, -0.4),
                direction: Vec3::new(-0.1, -1.0, -0.2).normalize(),
                intensity: Vec3::new(6.0, 5.0, 4.0),
                range_m: 9.0,
                inner_rad: 0.4,
                outer_rad: 0.8,
            },
            0.05,
            true,
        ),
        light(
            LightSource::Point { position: DVec3::new(-1.0, 1.8, 0.4), intensity: Vec3::ONE, range_m: 6.0 },
            0.0,
            true,
        ),
        light(
            LightSource::Directional {
                direction: Vec3::new(0.3, -1.0, -0.5).normalize(),
                irradiance: Vec3::splat(0.7),
            },
            0.02,
            true,
        ),
        light(
            LightSource::Point { position: DVec3::new(1.0, 1.0, 0.8), intensity: Vec3::ONE, range_m: 4.0 },
            0.1,
            false,
        ),
    ];
    made
}

#[test]
fn cut_outs_glass_textures_and_every_kind_of_light_look_alike() {
    agree(&gpu(), "everything", &Arc::new(everything()), 16, &settings(64, 40));
}

/// The percentage of pixels whose light, and thus whose shadows, differs by more than rounding between device and
/// processor.
fn shadows_apart(gpu: &Rc<Gpu>, scene: &Arc<Scene>, settings: &Settings) -> f64 {
    let by = |trace: Trace| pictures::render(gpu, scene, "sssr", &Settings { trace, ..settings.clone() });
    let (device, cpu) = (by(Trace::Bvh), by(Trace::Cpu));
    assert_eq!((device.tracer, cpu.tracer), (Some("bvh"), Some("cpu")));
    let mean = values(&device.linear).map(f64::from).sum::<f64>() / values(&device.linear).count() as f64;
    let floor = (0.01 * mean) as f32;
    let pairs = device.linear.eyes.iter().flatten().zip(cpu.linear.eyes.iter().flatten());
    let differs = |(a, b): &(&[f32; 3], &[f32; 3])| {
        a.iter().zip(*b).any(|(a, b)| (a - b).abs() > ROUNDING * a.max(*b).max(floor))
    };
    let (mut apart, mut of) = (0, 0);
    pairs.for_each(|pair| {
        of += 1;
        apart += usize::from(differs(&pair));
    });
    100.0 * f64::from(apart as u32) / f64::from(of)
}

#[test]
fn shadows_of_the_views_look_alike() {
    let gpu = gpu();
    let size = settings(96, 60);
    let fine = Settings { antialias: 2, ..size.clone() };
    let mut dark = everything();
    dark.lights.iter_mut().for_each(|light| light.casts_shadow = false);
    for (name, scene, settings) in [
        ("everything", Arc::new(everything()), &size),
        ("everything, 2×2", Arc::new(everything()), &fine),
        ("room", coarse("room"), &size),
        ("temple", coarse("temple"), &size),
    ] {
        let apart = shadows_apart(&gpu, &scene, settings);
        println!("{name}: {apart:.3} % of the pixels differ");
        assert!(apart <= 100.0 * APART, "{name}: {apart} %");
    }
    // Where no light casts a shadow, the processor traces no shadow rays either.
    let dark = pictures::render(&gpu, &Arc::new(dark), "sssr", &Settings { trace: Trace::Cpu, ..size });
    assert!(dark.passes.iter().all(|pass| pass.name != "shadows"), "{:?}", dark.passes);
}

/// A small box with a glossy floor and a lamp in it. It has so little surface that its light is baked quickly.
fn cabinet() -> Scene {
    let chalk = |color: Vec3| Material { metallic: 0.0, base_color: color.extend(1.0), ..material(1.0) };
    let side = |turn: DQuat, at: DVec3, of: Material| {
        (plane(1), of, DAffine3::from_scale_rotation_translation(DVec3::splat(0.4), turn, at))
    };
    let turns = [
        (DQuat::IDENTITY, DVec3::NEG_Y, material(0.25)),
        (DQuat::from_rotation_x(std::f64::consts::PI), DVec3::Y, chalk(Vec3::splat(0.8))),
        (DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2), DVec3::NEG_Z, chalk(Vec3::new(0.2, 0.5, 0.8))),
        (DQuat::from_rotation_z(-std::f64::consts::FRAC_PI_2), DVec3::NEG_X, chalk(Vec3::new(0.8, 0.2, 0.1))),
        (DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2), DVec3::X, glowing(Vec3::splat(0.4))),
    ];
    let mut parts: Vec<_> = turns.into_iter().map(|(turn, at, of)| side(turn, at * 0.2, of)).collect();
    parts.push((sphere(8), chalk(Vec3::splat(0.5)), DAffine3::from_scale(DVec3::splat(0.08))));
    let mut made = pictures::scene(parts, 0.3, look(DVec3::new(0.02, 0.06, 0.55), DVec3::new(0.0, -0.15, -0.1)));
    let source =
        LightSource::Point { position: DVec3::new(0.1, 0.15, 0.0), intensity: Vec3::splat(0.02), range_m: 9.0 };
    made.lights.push(Light { source, size: 0.02, casts_shadow: true });
    made
}

#[test]
fn baked_light_is_read_alike() {
    agree(&gpu(), "baked light", &Arc::new(cabinet()), 16, &Settings { indirect: true, ..settings(64, 40) });
}

#[test]
fn a_scene_with_real_textures_looks_alike() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes/pica-mini-diorama/scene.gltf");
    if !file.is_file() {
        println!("skipped: {} is absent", file.display());
        return;
    }
    let scene = scene::load(&file.to_string_lossy()).expect("a scene");
    agree(&gpu(), "pica-mini-diorama", &Arc::new(scene), 4, &settings(64, 40));
}

#[test]
fn the_same_request_makes_the_same_bits() {
    let gpu = gpu();
    let (scene, size) = (coarse("room"), settings(48, 30));
    let (a, b) = (by(&gpu, &scene, Trace::Cpu, 4, &size), by(&gpu, &scene, Trace::Cpu, 4, &size));
    assert!(a.linear.eyes == b.linear.eyes && a.reflection.eyes == b.reflection.eyes);
    assert_eq!(a.error.map(|e| e.eyes), b.error.map(|e| e.eyes));
    assert_eq!(a.counters, b.counters);
}

#[test]
fn paths_go_on_where_they_stopped_and_end_where_they_are_enough() {
    let gpu = gpu();
    let scene = Arc::new(everything());
    let settings = Settings { trace: Trace::Cpu, ..settings(48, 30) };
    let camera = scene.views[0].stereo_camera(settings.aspect());
    let mut renderer = Renderer::new(&gpu, Arc::clone(&scene)).expect("uploaded");
    let mut prepare = |spp: u32| {
        let method = Method::parse("path-traced").expect("a method").with_samples(Some(spp));
        renderer.prepare(&camera, &method, &settings).expect("prepared")
    };
    let whole = prepare(40);
    whole.frame(&mut |_, _| Ok(())).expect("a frame");

    // The frame is interrupted after at least five samples. The rest is rendered anew from the kept sums, as another
    // process would do it.
    let broken = prepare(40);
    broken.continue_from(None);
    let stop = &mut |done: u32, _: u32| if done >= 5 { Err(Interrupted) } else { Ok(()) };
    assert!(broken.frame(stop).is_err());
    let sums = broken.sums().expect("sums are kept");
    assert!((5..40).contains(&sums.samples), "{}", sums.samples);
    let rest = prepare(40);
    rest.continue_from(Some(sums.clone()));
    let report = rest.frame(&mut |_, _| Ok(())).expect("a frame");
    let bits = |p: &Prepared| p.linear().expect("read back").eyes;
    assert!(bits(&rest) == bits(&whole), "the picture depends on where it was interrupted");
    let pixels = sums.pixels.len() as u64;
    let paths = report.counters.rays + report.counters.below_horizon;
    assert_eq!(paths, u64::from(40 - sums.samples) * pixels, "not just the missing samples were traced");
    assert_eq!(rest.sums().map(|s| s.samples), Some(40));
    // Sums of more samples than are asked for are not used.
    let fewer = prepare(4);
    fewer.continue_from(Some(sums));
    fewer.frame(&mut |_, _| Ok(())).expect("a frame");
    assert_eq!(fewer.sums().map(|s| s.samples), Some(4));

    // A target between the errors of 16 and 32 samples must be reached with 32 samples, on the device and on the
    // processor.
    let mut counts = Vec::new();
    for trace in [Trace::Cpu, Trace::Bvh] {
        let method = Method::parse("path-traced@64").expect("a method");
        let settings = Settings { trace, ..settings.clone() };
        let mut prepared = renderer.prepare(&camera, &method, &settings).expect("prepared");
        prepared.set_until(Some(1e-9));
        prepared.frame(&mut |_, _| Ok(())).expect("a frame");
        let checks = prepared.checks();
        assert_eq!(checks.iter().map(|c| c.0).collect::<Vec<_>>(), [16, 32, 48, 64]);
        assert!(checks.windows(2).all(|w| w[1].1 < w[0].1), "{checks:?}");
        assert_eq!(prepared.samples_reached(), 64);
        prepared.set_until(Some(f64::midpoint(checks[0].1, checks[1].1)));
        prepared.frame(&mut |_, _| Ok(())).expect("a frame");
        counts.push((prepared.samples_reached(), prepared.checks().len()));
        println!("{trace:?}: relative error {checks:.4?}");
    }
    assert_eq!(counts, [(32, 2), (32, 2)]);
}

/// Prints figures and checks nothing: `cargo test --profile traced --test all cpu:: -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn rays_a_second() {
    let gpu = gpu();
    for name in ["room", "temple"] {
        let scene = Arc::new(scene::load(name).expect("a built-in scene"));
        for (trace, spp) in [(Trace::Bvh, 2), (Trace::Cpu, 16)] {
            let rendered = by(&gpu, &scene, trace, spp, &settings(640, 360));
            let ms: f64 = rendered.passes.iter().filter(|p| p.name == "path_trace").map(|p| p.ms).sum();
            let rays = rendered.counters.rays as f64;
            println!("{name}, {trace:?}: {:.0} rays in {ms:.0} ms, {:.2} million a second", rays, rays / ms / 1e3);
        }
    }
}
