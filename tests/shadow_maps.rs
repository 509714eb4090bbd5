//! Tests shadow maps. The oracle is shadows by rays. Maps must have no acne and no leaks, and must not change pictures
//! that do not use them. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::f64::consts::{FRAC_PI_2, PI};
use std::rc::Rc;
use std::sync::Arc;

use cyclopean::gpu::Gpu;
use cyclopean::render::{Method, Rendered, Renderer, Settings, Shadows};
use cyclopean::scene::{Light, LightSource, Material, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};

use crate::pictures::{chalk, floating_box, gpu, look, material, plane, render, scene, settings, sphere, with_floor};

const WIDTH: u32 = 160;
const HEIGHT: u32 = 120;

fn maps(width: u32, height: u32) -> Settings {
    Settings { shadows_by: Shadows::Maps, ..settings(width, height) }
}

/// For each eye and pixel, the green light with shadows divided by that without shadows, or `None` where there is no
/// light.
fn shares(gpu: &Rc<Gpu>, scene: &Arc<Scene>, settings: &Settings) -> Vec<Vec<Option<f32>>> {
    let lit = render(gpu, scene, "sssr", &Settings { shadows: false, ..settings.clone() });
    let dark = render(gpu, scene, "sssr", settings);
    let eye = |eye: usize| {
        let pairs = dark.linear.eyes[eye].iter().zip(&lit.linear.eyes[eye]);
        pairs.map(|(d, l)| (l[1] > 1e-6).then(|| d[1] / l[1])).collect()
    };
    (0..2).map(eye).collect()
}

/// The smallest and the largest share in the square of pixels about one.
fn around(shares: &[Option<f32>], width: u32, i: usize, reach: i64) -> (f32, f32) {
    let (width, x, y) = (i64::from(width), i as i64 % i64::from(width), i as i64 / i64::from(width));
    let height = shares.len() as i64 / width;
    let (mut low, mut high) = (f32::MAX, f32::MIN);
    for v in (y - reach).max(0)..=(y + reach).min(height - 1) {
        for u in (x - reach).max(0)..=(x + reach).min(width - 1) {
            if let Some(share) = shares[(v * width + u) as usize] {
                low = low.min(share);
                high = high.max(share);
            }
        }
    }
    (low, high)
}

fn sun(direction: Vec3) -> LightSource {
    LightSource::Directional { direction: direction.normalize(), irradiance: Vec3::splat(2.0) }
}

fn point(position: DVec3) -> LightSource {
    LightSource::Point { position, intensity: Vec3::splat(4.0), range_m: f32::INFINITY }
}

fn spot(position: DVec3, outer_rad: f32) -> LightSource {
    LightSource::Spot {
        position,
        direction: (-position).normalize().as_vec3(),
        intensity: Vec3::splat(4.0),
        range_m: 30.0,
        inner_rad: 0.7 * outer_rad,
        outer_rad,
    }
}

#[test]
fn a_boxs_umbra_ends_within_two_pixels_of_the_rays() {
    let gpu = gpu();
    let lamp = DVec3::new(0.7, 2.0, -0.5);
    let lights = [
        ("sun", sun(Vec3::new(-0.5, -1.0, 0.3))),
        ("point", point(lamp)),
        ("spot", spot(lamp, 1.2)),
        ("wide spot", spot(lamp, 1.5)),
    ];
    for (what, light) in lights {
        let scene = with_floor(floating_box(0.4, 0.3, 0.5), vec![light.into()]);
        let by_rays = shares(&gpu, &scene, &settings(WIDTH, HEIGHT));
        let by_maps = shares(&gpu, &scene, &maps(WIDTH, HEIGHT));
        let (mut compared, mut dark) = (0, 0);
        for eye in 0..2 {
            for (i, share) in by_maps[eye].iter().enumerate() {
                let (Some(found), Some(ray)) = (share, by_rays[eye][i]) else { continue };
                compared += 1;
                dark += u32::from(ray < 0.5);
                let (low, high) = around(&by_rays[eye], WIDTH, i, 2);
                let (x, y) = (i as u32 % WIDTH, i as u32 / WIDTH);
                assert!(
                    (low - 1e-3..=high + 1e-3).contains(found),
                    "{what}, eye {eye}, pixel {x}, {y}: {found} by maps, by rays {low} to {high} within two pixels"
                );
            }
        }
        assert!(compared > 20_000 && dark > 500, "{what}: {compared} pixels, {dark} of them dark");
    }
}

#[test]
fn nothing_shadows_a_plane_that_stands_alone() {
    let gpu = gpu();
    let floor = |light: Light| {
        let parts = vec![(plane(16), chalk(), DAffine3::from_scale(DVec3::new(30.0, 1.0, 30.0)))];
        let mut made = scene(parts, 0.0, look(DVec3::new(0.0, 1.5, 3.0), DVec3::ZERO));
        made.lights = vec![light];
        Arc::new(made)
    };
    let low = |degrees: f32| sun(Vec3::new(degrees.to_radians().cos(), -degrees.to_radians().sin(), 0.3));
    let soft = |source: LightSource, size: f32| Light { size, ..source.into() };
    let lights = [
        ("sun at 60 degrees", low(60.0).into()),
        ("sun at 5 degrees", low(5.0).into()),
        ("sun at 0.3 degrees", low(0.3).into()),
        ("soft sun at 5 degrees", soft(low(5.0), 0.02)),
        ("point", point(DVec3::new(0.3, 0.4, 0.2)).into()),
        ("large point", soft(point(DVec3::new(0.3, 0.4, 0.2)), 0.1)),
        ("spot", spot(DVec3::new(2.0, 0.3, 0.5), 0.6).into()),
    ];
    for (what, light) in lights {
        for share in shares(&gpu, &floor(light), &maps(96, 64)).concat().into_iter().flatten() {
            assert!((share - 1.0).abs() < 2e-3, "{what}: {share}");
        }
    }
}

/// A closed room with a ball in it, seen from within.
fn room(lights: Vec<Light>) -> Arc<Scene> {
    let side = |turn: DQuat, at: [f64; 3]| {
        (plane(3), chalk(), DAffine3::from_scale_rotation_translation(DVec3::splat(4.0), turn, at.into()))
    };
    let (x, z) = (DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_z(FRAC_PI_2));
    let ball = DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), DQuat::IDENTITY, DVec3::NEG_Y);
    let parts = vec![
        side(DQuat::IDENTITY, [0.0, -2.0, 0.0]),
        side(DQuat::from_rotation_x(PI), [0.0, 2.0, 0.0]),
        side(x, [0.0, 0.0, -2.0]),
        side(DQuat::from_rotation_x(PI) * x, [0.0, 0.0, 2.0]),
        side(z.inverse(), [-2.0, 0.0, 0.0]),
        side(z, [2.0, 0.0, 0.0]),
        (sphere(24), chalk(), ball),
    ];
    let mut made = scene(parts, 0.0, look(DVec3::new(0.3, 0.0, 1.7), DVec3::new(0.0, -0.8, -1.0)));
    made.lights = lights;
    Arc::new(made)
}

#[test]
fn a_closed_room_lets_no_light_in() {
    let gpu = gpu();
    let soft = Light { size: 0.01, ..sun(Vec3::new(0.3, -0.8, 0.5)).into() };
    let lamp = Light { size: 0.1, ..point(DVec3::new(2.5, 2.5, 0.0)).into() };
    for (what, light) in [
        ("sun", sun(Vec3::new(0.3, -0.8, 0.5)).into()),
        ("soft sun", soft),
        ("lamp", point(DVec3::new(2.5, 2.5, 0.0)).into()),
        ("soft lamp", lamp),
        ("lamp below the floor", point(DVec3::new(0.0, -2.05, 0.0)).into()),
    ] {
        let lit = render(&gpu, &room(vec![light]), "sssr", &Settings { shadows: false, ..maps(96, 64) });
        let shot = render(&gpu, &room(vec![light]), "sssr", &maps(96, 64));
        let most = |r: &Rendered| r.linear.eyes.iter().flatten().map(|t| t[1]).fold(0.0, f32::max);
        assert!(most(&lit) > 0.01, "{what}: without shadows the light does not reach the room either");
        assert!(most(&shot) <= 1e-4, "{what}: light of {} comes in", most(&shot));
    }
}

/// A polished floor with a chalk ball and a polished one.
fn balls(lights: Vec<Light>) -> Arc<Scene> {
    let ball = |material: Material, x: f64| {
        let place = DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), DQuat::IDENTITY, [x, 0.5, 0.0].into());
        (sphere(24), material, place)
    };
    let mut made = scene(
        vec![
            (plane(2), material(0.2), DAffine3::from_scale(DVec3::new(6.0, 1.0, 6.0))),
            ball(chalk(), -0.6),
            ball(material(0.1), 0.6),
        ],
        0.0,
        look(DVec3::new(0.3, 1.0, 2.5), DVec3::new(0.0, 0.3, 0.0)),
    );
    made.lights = lights;
    Arc::new(made)
}

#[test]
fn many_lights_and_lights_within_matter_are_drawn() {
    let gpu = gpu();
    let place = |k: u32| {
        let turn = 2.0 * PI * f64::from(k) / 64.0;
        DVec3::new(2.0 * turn.cos(), 1.5, 2.0 * turn.sin())
    };
    let many: Vec<Light> = (0..64).map(|k| point(place(k)).into()).collect();
    let mean = |r: &Rendered| r.linear.eyes.iter().flatten().map(|t| f64::from(t[1])).sum::<f64>();
    let scene = balls(many);
    let (rays, mapped) = (render(&gpu, &scene, "sssr", &settings(48, 32)), render(&gpu, &scene, "sssr", &maps(48, 32)));
    let ratio = mean(&mapped) / mean(&rays);
    assert!((ratio - 1.0).abs() < 0.03, "with 64 lights, maps give {ratio} of the light that rays give");
    let inside = [
        point(DVec3::new(-0.6, 0.5, 0.0)),
        point(DVec3::new(0.0, -0.5, 0.0)),
        point(DVec3::new(0.0, 0.0, 0.0)),
        point(DVec3::new(0.3, 1.0, 2.5)),
        spot(DVec3::new(-0.6, 0.5, 0.0), 0.5),
    ];
    for source in inside {
        for size in [0.0, 1e-6, 0.05, 1000.0] {
            render(&gpu, &balls(vec![Light { size, ..source.into() }]), "stereo", &maps(48, 32));
        }
    }
}

#[test]
fn a_penumbra_is_about_as_wide_as_by_rays() {
    let gpu = gpu();
    let lights = [
        ("sun", Light { size: 0.1, ..sun(Vec3::new(-0.5, -1.0, 0.3)).into() }),
        ("lamp", Light { size: 0.1, ..point(DVec3::new(0.7, 2.0, -0.5)).into() }),
    ];
    for (what, light) in lights {
        let scene = with_floor(floating_box(0.4, 0.3, 0.5), vec![light]);
        let rays = Settings { soft_shadow_rays: 256, ..settings(WIDTH, HEIGHT) };
        let (by_rays, by_maps) =
            (shares(&gpu, &scene, &rays).concat(), shares(&gpu, &scene, &maps(WIDTH, HEIGHT)).concat());
        let half = |s: &[Option<f32>]| s.iter().flatten().filter(|s| (0.05..0.95).contains(*s)).count() as f64;
        let pairs =
            by_rays.iter().zip(&by_maps).filter_map(|(a, b)| Some(f64::from((a.as_ref()? - b.as_ref()?).abs())));
        let (sum, count) = pairs.fold((0.0, 0), |(sum, n), d| (sum + d, n + 1));
        let (wide, error) = (half(&by_maps) / half(&by_rays), sum / f64::from(count));
        println!("{what}: the penumbra has {wide:.3} of the rays' pixels, mean difference {error:.4}");
        assert!((0.5..1.5).contains(&wide), "{what}: the penumbra covers {wide} of the pixels that it covers by rays");
        assert!(error < 0.02, "{what}: {error}");
    }
}

#[test]
fn glass_lets_its_share_through() {
    let gpu = gpu();
    let plate = DAffine3::from_translation(DVec3::new(0.0, 1.0, 0.0)) * DAffine3::from_scale(DVec3::new(2.0, 1.0, 2.0));
    let glass = Material { transmission: 0.5, base_color: Vec3::splat(0.8).extend(1.0), ..chalk() };
    let scene = with_floor(vec![(plane(1), glass, plate)], vec![sun(Vec3::NEG_Y).into()]);
    let (by_rays, by_maps) =
        (shares(&gpu, &scene, &settings(WIDTH, HEIGHT)), shares(&gpu, &scene, &maps(WIDTH, HEIGHT)));
    let (mut sum, mut count) = (0.0, 0);
    for eye in 0..2 {
        for (i, share) in by_maps[eye].iter().enumerate() {
            let Some(found) = share else { continue };
            // Only pixels well within the shadow of the plate count.
            if around(&by_rays[eye], WIDTH, i, 3).1 < 0.5 {
                sum += found;
                count += 1;
            }
        }
    }
    let mean = sum / count as f32;
    assert!(count > 500 && (mean - 0.4).abs() < 0.1, "{mean} instead of 0.4 in {count} pixels");
}

#[test]
fn maps_are_made_where_a_light_casts_and_are_asked_for_and_drawn_once() {
    let gpu = gpu();
    let casting = balls(vec![point(DVec3::new(1.0, 1.5, 0.5)).into(), sun(Vec3::new(0.3, -1.0, 0.2)).into()]);
    let through = balls(vec![Light { casts_shadow: false, ..point(DVec3::new(1.0, 1.5, 0.5)).into() }]);
    let runs = |r: &Rendered, name: &str| r.parts.iter().any(|p| p.name == name && p.runs);
    let rays = render(&gpu, &casting, "sssr", &settings(48, 32));
    assert!(runs(&rays, "shadows") && !runs(&rays, "shadow_maps"));
    let off = render(&gpu, &casting, "sssr", &Settings { shadows: false, ..maps(48, 32) });
    assert!(!runs(&off, "shadows") && !runs(&off, "shadow_maps"));
    let none = render(&gpu, &through, "sssr", &maps(48, 32));
    assert!(!runs(&none, "shadow_maps") && !none.passes.iter().any(|p| p.name.contains("shadow")));
    assert!(none.linear == render(&gpu, &through, "sssr", &settings(48, 32)).linear);

    let mut renderer = Renderer::new(&gpu, Arc::clone(&casting)).expect("uploaded");
    let method = Method::parse("sssr").expect("known");
    let camera = casting.views[0].stereo_camera(1.5);
    let mut prepared = renderer.prepare(&camera, &method, &maps(48, 32)).expect("prepared");
    let mut drawn = |by: f64| {
        let mut moved = camera;
        moved.left.position.x += by;
        moved.right.position.x += by;
        prepared.set_camera(&moved);
        let report = prepared.frame(&mut |_, _| Ok(())).expect("a frame");
        let names: Vec<&str> = report.passes.iter().map(|p| p.name.as_str()).collect();
        assert!(names.contains(&"shadows_mapped") && !names.contains(&"shadows"), "{names:?}");
        names.contains(&"shadow_map")
    };
    // A map is drawn at first, not after a small step, and again after a longer way, because the sun's inner cascade
    // follows the head.
    assert_eq!([0.0, 0.01, 1.5].map(&mut drawn), [true, false, true]);
    assert!(prepared.tracer().is_none(), "geometry for rays was built");
    gpu.check_validation().expect("no message");
}
