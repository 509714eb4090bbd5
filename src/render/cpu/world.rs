//! A scene as the processor traces it: geometry, materials and light in its own memory, relative to the head as on the
//! device.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Mat3A, Vec2, Vec3A, Vec4};

use crate::scene::Scene;

use super::super::bvh::world_triangles;
use super::super::shared::{InstanceData, MaterialData, TextureSlot, TriangleData, Vertex};
use super::super::upload::{self, Range};
use super::environment::Environment;
use super::lights::Light;
use super::texture::Decoding;
use super::tree::Tree;

/// What does not depend on where anything stands.
pub struct Content {
    pub scene: Arc<Scene>,
    pub vertices: Vec<Vertex>,
    pub indices: Vec<u32>,
    pub ranges: Vec<Range>,
    pub materials: Vec<Material>,
    pub environment: Environment,
    pub decoding: Decoding,
}

impl Content {
    pub fn new(scene: &Arc<Scene>) -> Content {
        let (vertices, indices, ranges) = upload::geometry(scene);
        Content {
            vertices,
            indices,
            ranges,
            materials: scene.materials.iter().map(|m| Material::new(&upload::material_data(m))).collect(),
            environment: Environment::new(&scene.environment),
            decoding: Decoding::new(),
            scene: Arc::clone(scene),
        }
    }
}

/// [`MaterialData`] in the types of this folder.
pub struct Material {
    pub base_color: Vec4,
    pub emissive: Vec3A,
    pub metallic: f32,
    pub dielectric_f0: Vec3A,
    pub roughness: f32,
    pub normal_scale: f32,
    pub alpha_cutoff: f32,
    pub transmission: f32,
    /// Base colour, metallic-roughness, normal, emissive.
    pub slots: [Option<Slot>; 4],
}

/// A texture and its coordinates.
pub struct Slot {
    pub texture: usize,
    second_uv: bool,
    row_u: Vec3A,
    row_v: Vec3A,
}

impl Material {
    fn new(m: &MaterialData) -> Material {
        Material {
            base_color: Vec4::from(m.base_color),
            emissive: Vec3A::from(m.emissive),
            metallic: m.metallic,
            dielectric_f0: Vec3A::from(m.dielectric_f0),
            roughness: m.roughness,
            normal_scale: m.normal_scale,
            alpha_cutoff: m.alpha_cutoff,
            transmission: m.transmission,
            slots: m.slots.each_ref().map(Slot::new),
        }
    }
}

impl Slot {
    fn new(data: &TextureSlot) -> Option<Slot> {
        let row = |r: [f32; 4]| Vec3A::new(r[0], r[1], r[2]);
        Some(Slot {
            texture: usize::try_from(data.texture_index).ok()?,
            second_uv: data.uv_set != 0,
            row_u: row(data.row_u),
            row_v: row(data.row_v),
        })
    }

    /// Of a vertex' two pairs of coordinates.
    #[inline]
    pub fn uv(&self, uv: Vec4) -> Vec2 {
        let p = if self.second_uv { Vec3A::new(uv.z, uv.w, 1.0) } else { Vec3A::new(uv.x, uv.y, 1.0) };
        Vec2::new(self.row_u.dot(p), self.row_v.dot(p))
    }
}

/// [`InstanceData`] in the types of this folder.
pub struct Instance {
    /// Of directions.
    pub render_from_object: Mat3A,
    pub normal_matrix: Mat3A,
    pub material: u32,
    pub first_vertex: u32,
    pub first_index: u32,
    pub closed: bool,
}

impl Instance {
    fn new(data: &InstanceData) -> Instance {
        let matrix = |rows: &[[f32; 4]; 3]| {
            let [x, y, z] = rows.map(|row| Vec3A::from_vec4(Vec4::from(row)));
            Mat3A::from_cols(x, y, z).transpose()
        };
        Instance {
            render_from_object: matrix(&data.render_from_object),
            normal_matrix: matrix(&data.normal_matrix),
            material: data.material,
            first_vertex: data.first_vertex,
            first_index: data.first_index,
            closed: data.closed != 0,
        }
    }
}

/// See the module's documentation.
pub struct World {
    pub head: DVec3,
    pub content: Arc<Content>,
    pub triangles: Vec<TriangleData>,
    pub instances: Vec<Instance>,
    pub lights: Vec<Light>,
    pub tree: Tree,
}

impl World {
    /// With the instances at `places`.
    pub fn new(content: &Arc<Content>, places: &[DAffine3], head: DVec3) -> World {
        let Content { scene, ranges, .. } = &**content;
        let triangles = world_triangles(scene, places, ranges, head);
        World {
            head,
            tree: Tree::new(&triangles),
            triangles,
            instances: upload::instances(scene, places, ranges, head).iter().map(Instance::new).collect(),
            lights: upload::lights(scene, head).iter().map(Light::new).collect(),
            content: Arc::clone(content),
        }
    }
}
