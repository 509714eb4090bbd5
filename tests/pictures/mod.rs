//! Small scenes whose answers are known, and the device they are rendered on.
#![allow(dead_code, reason = "each test file uses its part")]

use std::rc::Rc;
use std::sync::Arc;

use cyclopean::gpu::{Gpu, GpuOptions, OwnDevice};
use cyclopean::picture::StereoPicture;
use cyclopean::render::{Method, Rendered, Renderer, Request, Settings};
use cyclopean::scene::{
    Alpha, Environment, Equirect, Fallback, Instance, Material, Primitive, Scene, StereoCamera, View,
};
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3, Vec4};

/// The best device with validation on: one message fails the render.
pub fn gpu() -> Rc<Gpu> {
    let options = GpuOptions { validation: true, pipeline_cache: None };
    Gpu::open(&OwnDevice::default(), &options).expect("a Vulkan device; ./x test installs one")
}

/// Small, without the border's fade.
pub fn settings(width: u32, height: u32) -> Settings {
    Settings { width, height, edge_fade: 0.0, ..Settings::default() }
}

/// A perfect grey metal.
pub fn material(roughness: f32) -> Material {
    Material {
        name: "metal".to_owned(),
        base_color: Vec4::ONE,
        base_color_texture: None,
        metallic: 1.0,
        roughness,
        metallic_roughness_texture: None,
        normal_texture: None,
        normal_scale: 1.0,
        emissive: Vec3::ZERO,
        emissive_texture: None,
        dielectric_f0: Vec3::splat(0.04),
        alpha: Alpha::Opaque,
        double_sided: false,
        transmission: 0.0,
    }
}

/// Light of its own, no reflection.
pub fn glowing(color: Vec3) -> Material {
    let black = Vec4::new(0.0, 0.0, 0.0, 1.0);
    Material { emissive: color, base_color: black, metallic: 0.0, dielectric_f0: Vec3::ZERO, ..material(1.0) }
}

/// A grid of `n`×`n` quads over the unit square of the xz plane about the origin, facing +Y.
pub fn plane(n: u32) -> Primitive {
    let side = n + 1;
    let at = |i: u32| i as f32 / n as f32 - 0.5;
    let grid: Vec<(u32, u32)> = (0..side * side).map(|i| (i % side, i / side)).collect();
    let positions: Vec<Vec3> = grid.iter().map(|&(x, z)| Vec3::new(at(x), 0.0, at(z))).collect();
    let mut indices = Vec::new();
    for z in 0..n {
        for x in 0..n {
            let a = z * side + x;
            indices.extend([a, a + side, a + 1, a + 1, a + side, a + side + 1]);
        }
    }
    primitive(positions, vec![Vec3::Y; grid.len()], indices, false)
}

/// The unit sphere.
pub fn sphere(rings: u32) -> Primitive {
    let segments = 2 * rings;
    let mut positions = Vec::new();
    for ring in 0..=rings {
        let theta = std::f32::consts::PI * ring as f32 / rings as f32;
        for segment in 0..=segments {
            let phi = std::f32::consts::TAU * segment as f32 / segments as f32;
            positions.push(Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()));
        }
    }
    let mut indices = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let a = ring * (segments + 1) + segment;
            let b = a + segments + 1;
            indices.extend([a, a + 1, b, b, a + 1, b + 1]);
        }
    }
    primitive(positions.clone(), positions, indices, true)
}

pub fn primitive(positions: Vec<Vec3>, normals: Vec<Vec3>, indices: Vec<u32>, closed: bool) -> Primitive {
    let n = positions.len();
    Primitive {
        name: "shape".to_owned(),
        positions,
        normals,
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); n],
        uv0: vec![Vec2::ZERO; n],
        uv1: vec![Vec2::ZERO; n],
        colors: vec![Vec4::ONE; n],
        indices,
        material: 0,
        closed,
    }
}

/// The same radiance from everywhere.
pub fn constant_environment(radiance: f32) -> Environment {
    let map = Equirect { width: 4, height: 2, texels: vec![[radiance; 3]; 8] };
    Environment { radiance: map.clone(), irradiance: map.clone(), specular: vec![map.clone(), map] }
}

/// Primitives with materials and places, under a constant environment, seen by one view.
pub fn scene(parts: Vec<(Primitive, Material, DAffine3)>, radiance: f32, view: View) -> Scene {
    let (mut primitives, mut materials, mut instances) = (Vec::new(), Vec::new(), Vec::new());
    for (mut primitive, material, place) in parts {
        primitive.material = materials.len();
        instances.push(Instance {
            primitive: primitives.len(),
            world_from_object: place,
            previous_world_from_object: place,
        });
        primitives.push(primitive);
        materials.push(material);
    }
    Scene {
        name: "test".to_owned(),
        primitives,
        instances,
        materials,
        textures: Vec::new(),
        lights: Vec::new(),
        environment: constant_environment(radiance),
        views: vec![view],
        fallback: Fallback::Black,
        exposure: 1.0,
        open_mesh_thickness_m: 0.1,
        motions: Vec::new(),
        content_sha256: String::new(),
        repairs: Vec::new(),
    }
}

/// A view from a place towards another.
pub fn look(from: DVec3, to: DVec3) -> View {
    let back = (from - to).normalize();
    let right = DVec3::Y.cross(back).normalize();
    let world_from_view = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
    View {
        name: "main".to_owned(),
        position: from,
        world_from_view,
        vertical_fov_rad: 0.9,
        ipd_m: 0.064,
        cant_rad: 0.0,
        near_m: 0.05,
    }
}

/// Renders with validation; any message or value that is no number fails.
pub fn render(gpu: &Rc<Gpu>, scene: &Arc<Scene>, method: &str, settings: &Settings) -> Rendered {
    let camera = scene.views[0].stereo_camera(settings.aspect());
    render_from(gpu, scene, method, settings, &camera)
}

pub fn render_from(
    gpu: &Rc<Gpu>,
    scene: &Arc<Scene>,
    method: &str,
    settings: &Settings,
    camera: &StereoCamera,
) -> Rendered {
    let method = Method::parse(method).expect("a method");
    let mut renderer = Renderer::new(gpu, Arc::clone(scene)).expect("uploaded");
    let request = Request { camera, method: &method, settings, frames: 1 };
    renderer.render(&request, &mut |_, _| Ok(())).expect("rendered without a message")
}

/// Σ(x − y)²/Σ(y − ȳ)² over both eyes where `mask` holds.
pub fn relative_squared_error(x: &StereoPicture, y: &StereoPicture, mask: impl Fn(usize, usize) -> bool) -> f64 {
    let (mut pairs, mut sum) = (Vec::new(), 0.0);
    for eye in 0..2 {
        for i in 0..x.eyes[eye].len() {
            if mask(eye, i) {
                for c in 0..3 {
                    let pair = (f64::from(x.eyes[eye][i][c]), f64::from(y.eyes[eye][i][c]));
                    sum += pair.1;
                    pairs.push(pair);
                }
            }
        }
    }
    let mean = sum / pairs.len() as f64;
    let squares = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(|p| f(p) * f(p)).sum::<f64>();
    squares(&|p| p.0 - p.1) / squares(&|p| p.1 - mean)
}

/// A glossy floor, a wall of light stripes behind it, a column in the middle: part of what the floor reflects stands
/// beyond each eye's border or behind the column, seen by the other eye alone.
pub fn hall(roughness: f32) -> Arc<Scene> {
    let place = |scale: DVec3, turn: DQuat, at: DVec3| DAffine3::from_scale_rotation_translation(scale, turn, at);
    let floor = place(DVec3::new(4.0, 1.0, 3.0), DQuat::IDENTITY, DVec3::new(0.0, 0.0, -1.5));
    let mut parts = vec![(plane(4), material(roughness), floor)];
    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    for i in 0..8 {
        let color = if i % 2 == 0 { Vec3::new(1.0, 0.6, 0.2) } else { Vec3::new(0.05, 0.2, 0.6) };
        let stripe = place(DVec3::new(1.0, 1.0, 4.0), upright, DVec3::new(f64::from(i) - 3.5, 2.0, -3.0));
        parts.push((plane(2), glowing(color), stripe));
    }
    let column = place(DVec3::new(0.08, 0.6, 0.08), DQuat::IDENTITY, DVec3::new(0.0, 0.6, -0.6));
    parts.push((sphere(16), glowing(Vec3::new(0.3, 0.9, 0.3)), column));
    let mut view = look(DVec3::new(0.0, 0.7, 1.0), DVec3::new(0.0, 0.6, -3.0));
    // Far apart, so that a small picture shows it.
    view.ipd_m = 0.3;
    Arc::new(scene(parts, 0.0, view))
}
