//! Small scenes that are made in code: shapes, materials and views whose right picture is known. The cases, the sweeps
//! and tests of the renderer call it.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3, Vec4};

use crate::render::Settings;
use crate::scene::{Alpha, Environment, Equirect, Fallback, Instance, Material, Primitive, Scene, View};

/// The default settings with this size, without the fade at the border.
pub fn settings(width: u32, height: u32) -> Settings {
    Settings { width, height, edge_fade: 0.0, ..Settings::default() }
}

/// A white metal that absorbs nothing.
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
        shading_reuse: true,
    }
}

/// A material that emits light and reflects none.
pub fn glowing(color: Vec3) -> Material {
    let black = Vec4::new(0.0, 0.0, 0.0, 1.0);
    Material { emissive: color, base_color: black, metallic: 0.0, dielectric_f0: Vec3::ZERO, ..material(1.0) }
}

/// A unit square in the xz plane, centred on the origin, that faces +Y. It has `n`×`n` quads.
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
    let uv = positions.iter().map(|p| Vec2::new(p.x, p.z) + 0.5).collect();
    Primitive { uv0: uv, ..primitive(positions, vec![Vec3::Y; grid.len()], indices, false) }
}

/// The unit sphere, with this number of rings.
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

/// An environment with the same radiance from all directions.
pub fn constant_environment(radiance: f32) -> Environment {
    let map = Equirect { width: 4, height: 2, texels: vec![[radiance; 3]; 8] };
    Environment { radiance: map.clone(), irradiance: map.clone(), specular: vec![map.clone(), map] }
}

/// A scene of primitives with their materials and places, in a constant environment, with one view.
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
        paths: Vec::new(),
        content_sha256: String::new(),
        extensions: Vec::new(),
        repairs: Vec::new(),
    }
}

/// A view from one place towards another. It must be neither straight up nor straight down.
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

/// A placement that scales, then turns, then moves.
pub fn place(scale: [f64; 3], turn: DQuat, at: [f64; 3]) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(scale.into(), turn, at.into())
}

/// The rotation that turns +Y to +Z.
pub fn upright() -> DQuat {
    DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2)
}

/// A sphere of white metal in a white world. What it reflects is the albedo of its lobe.
pub fn furnace(roughness: f32) -> Scene {
    let view = look(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO);
    scene(vec![(sphere(32), material(roughness), DAffine3::IDENTITY)], 1.0, view)
}

/// A floor in front of a wall of glowing stripes. Everything that the floor reflects is on the screen. The light of
/// every second stripe is multiplied by `bright`.
pub fn stripes(roughness: f32, bright: f32) -> Scene {
    let floor = place([3.0, 1.0, 1.0], DQuat::IDENTITY, [0.0, 0.0, -1.2]);
    let mut parts = vec![(plane(4), material(roughness), floor)];
    for i in 0..10 {
        let color = if i % 2 == 0 { Vec3::new(1.0, 0.6, 0.2) * bright } else { Vec3::new(0.05, 0.2, 0.6) };
        parts.push((
            plane(2),
            glowing(color),
            place([12.0, 1.0, 0.5], upright(), [0.0, 0.25 + 0.5 * f64::from(i), -2.0]),
        ));
    }
    scene(parts, 0.0, look(DVec3::new(0.0, 0.8, 1.5), DVec3::new(0.0, 0.8, -2.0)))
}

/// A glossy floor, a wall of upright stripes and a column. The other eye sees a part of what one eye does not see.
pub fn hall(roughness: f32, ipd_m: f64) -> Scene {
    let floor = place([4.0, 1.0, 3.0], DQuat::IDENTITY, [0.0, 0.0, -1.5]);
    let mut parts = vec![(plane(4), material(roughness), floor)];
    for i in 0..8 {
        let color = if i % 2 == 0 { Vec3::new(1.0, 0.6, 0.2) } else { Vec3::new(0.05, 0.2, 0.6) };
        parts.push((plane(2), glowing(color), place([1.0, 1.0, 4.0], upright(), [f64::from(i) - 3.5, 2.0, -3.0])));
    }
    let column = place([0.08, 0.6, 0.08], DQuat::IDENTITY, [0.0, 0.6, -0.6]);
    parts.push((sphere(16), glowing(Vec3::new(0.3, 0.9, 0.3)), column));
    let view = look(DVec3::new(0.0, 0.7, 1.0), DVec3::new(0.0, 0.6, -3.0));
    scene(parts, 0.0, View { ipd_m, ..view })
}

/// The scene with everything larger or smaller, including the viewer. The picture must stay the same.
pub fn scaled(scene: &Scene, factor: f64) -> Arc<Scene> {
    let mut out = scene.clone();
    for instance in &mut out.instances {
        instance.world_from_object = DAffine3::from_scale(DVec3::splat(factor)) * instance.world_from_object;
    }
    for view in &mut out.views {
        view.position *= factor;
        view.ipd_m *= factor;
        view.near_m *= factor;
    }
    out.open_mesh_thickness_m *= factor as f32;
    Arc::new(out)
}

/// The scene with everything moved, including the viewer. The picture must stay the same.
pub fn moved(scene: &Scene, by: DVec3) -> Arc<Scene> {
    let mut out = scene.clone();
    for instance in &mut out.instances {
        instance.world_from_object.translation += by;
    }
    for view in &mut out.views {
        view.position += by;
    }
    Arc::new(out)
}

/// The scene with everything turned about the origin, including the viewer. The picture must stay the same.
pub fn turned(scene: &Scene, by: DQuat) -> Arc<Scene> {
    let mut out = scene.clone();
    for instance in &mut out.instances {
        instance.world_from_object = DAffine3::from_quat(by) * instance.world_from_object;
    }
    for view in &mut out.views {
        view.position = by * view.position;
        view.world_from_view = by * view.world_from_view;
    }
    Arc::new(out)
}
