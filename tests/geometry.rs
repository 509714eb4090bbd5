//! Tests what the renderer returns to the metrics: the G-buffer, the distances to what pixels reflect, and the tone
//! map. The oracle of the distances is a floor below a ceiling, for which they can be computed; that of the Rust tone
//! map is the shader. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::sync::Arc;

use cyclopean::metrics::tone;
use cyclopean::render::{Geometry, Method, Prepared, Renderer};
use cyclopean::scene::{Scene, StereoCamera};
use glam::{DAffine3, DQuat, DVec3, Vec3};

use crate::pictures::{glowing, gpu, look, material, plane, scene, settings};

const W: u32 = 96;
const H: u32 = 64;

/// A metal floor with this roughness, two metres below a glowing ceiling of the same size.
fn hall(roughness: f32) -> Scene {
    let place = |height: f64, turn: f64| {
        let rotation = DQuat::from_rotation_x(turn);
        DAffine3::from_scale_rotation_translation(DVec3::splat(40.0), rotation, DVec3::new(0.0, height, 0.0))
    };
    let view = look(DVec3::new(0.0, 1.0, 3.0), DVec3::ZERO);
    let floor = (plane(4), material(roughness), place(0.0, 0.0));
    let ceiling = (plane(4), glowing(Vec3::new(0.9, 0.5, 0.2)), place(2.0, std::f64::consts::PI));
    scene(vec![floor, ceiling], 0.0, view)
}

fn prepared(scene: &Arc<Scene>, method: &str) -> (Prepared, StereoCamera) {
    let settings = settings(W, H);
    let camera = scene.views[0].stereo_camera(settings.aspect());
    let method = Method::parse(method).expect("a method");
    let mut renderer = Renderer::new(&gpu(), Arc::clone(scene)).expect("uploaded");
    let prepared = renderer.prepare(&camera, &method, &settings).expect("prepared");
    prepared.frame(&mut |_, _| Ok(())).expect("rendered");
    (prepared, camera)
}

/// For each pixel of the left eye, 1 over the distance from the floor to the ceiling along the mirrored view ray, in
/// 1/m.
fn expected(camera: &StereoCamera) -> Vec<f64> {
    let e = &camera.left;
    let [l, r, u, d] = [e.fov.left_rad, e.fov.right_rad, e.fov.up_rad, e.fov.down_rad].map(f64::tan);
    let ray = |i: u32| {
        let (x, y) = (f64::from(i % W) + 0.5, f64::from(i / W) + 0.5);
        DVec3::new(l + (r - l) * x / f64::from(W), u + (d - u) * y / f64::from(H), -1.0)
    };
    (0..W * H).map(|i| -(e.world_from_view * ray(i)).normalize().y / 2.0).collect()
}

fn floor_pixels(geometry: &Geometry) -> impl Iterator<Item = usize> + '_ {
    (0..(W * H) as usize).filter(|&i| geometry.eyes[0].instance[i] == 1)
}

#[test]
fn a_mirror_reports_how_far_it_reflects() {
    let scene = Arc::new(hall(0.0));
    let (prepared, camera) = prepared(&scene, "path-traced@3");
    let geometry = prepared.geometry().expect("read");
    let eye = &geometry.eyes[0];
    let inverse = expected(&camera);
    let mut seen = 0;
    for i in floor_pixels(&geometry) {
        assert!(eye.traced[i] && eye.roughness[i] == 0.0);
        assert!(eye.normal[i].distance(Vec3::Y) < 1e-3 && eye.face_normal[i].distance(Vec3::Y) < 1e-3);
        // Near the horizon the mirrored ray passes the ceiling's edge, so these pixels are left out.
        if inverse[i] > 0.1 {
            let found = f64::from(eye.inverse_hit_distance[i]);
            assert!(
                (found / inverse[i] - 1.0).abs() < 0.03,
                "pixel {i}: 1/distance is {found} and not {} per metre",
                inverse[i]
            );
            let distance = camera.left.near_m / f64::from(eye.depth[i]);
            assert!((0.5..30.0).contains(&distance), "pixel {i}: {distance} m");
            seen += 1;
        }
    }
    assert!(seen > W * H / 3, "{seen} pixels");
    assert!(eye.inverse_hit_distance.iter().zip(&eye.traced).all(|(d, traced)| *traced || *d == -1.0));
}

#[test]
fn a_rough_floor_reports_its_lobes_mean_and_other_methods_none() {
    let scene = Arc::new(hall(0.5));
    let (reference, camera) = prepared(&scene, "path-traced@64");
    let geometry = reference.geometry().expect("read");
    let inverse = expected(&camera);
    for i in floor_pixels(&geometry).filter(|&i| inverse[i] > 0.2) {
        let found = f64::from(geometry.eyes[0].inverse_hit_distance[i]);
        assert!(
            (0.5..1.6).contains(&(found / inverse[i])),
            "pixel {i}: 1/distance is {found}, and for a mirror {} per metre",
            inverse[i]
        );
    }
    let (screen_space, _) = prepared(&scene, "sssr");
    let geometry = screen_space.geometry().expect("read");
    assert!(geometry.eyes[1].inverse_hit_distance.iter().all(|d| *d == -1.0));
    // This method also draws a guard band around the view, which must not be read back.
    let (guarded, _) = prepared(&scene, "sssr-guardband");
    let other = guarded.geometry().expect("read");
    assert_eq!(other.eyes[0].instance.len(), (W * H) as usize);
    assert_eq!(other.eyes[0].instance, geometry.eyes[0].instance);
}

#[test]
fn the_tone_map_is_the_shaders() {
    let mut scene = hall(0.3);
    scene.exposure = 1.7;
    let scene = Arc::new(scene);
    let (prepared, _) = prepared(&scene, "path-traced@4");
    let (linear, display) = (prepared.linear().expect("read"), prepared.display().expect("read"));
    for (eye, bytes) in display.iter().enumerate() {
        let ours = tone::displayed(&linear.eyes[eye], scene.exposure);
        for (pixel, texel) in ours.iter().zip(bytes.chunks_exact(4)) {
            for (value, byte) in pixel.iter().zip(texel) {
                assert!((value * 255.0 - f32::from(*byte)).abs() < 0.51, "{value} is not {byte}/255");
            }
        }
    }
}
