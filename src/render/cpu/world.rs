//! A scene in the form in which the processor traces it: geometry, materials and lights in the host's memory, relative to the
//! head as on the device.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Mat3A, Vec2, Vec3A, Vec4};

use crate::scene::Scene;

use super::super::bvh::world_triangles;
use super::super::shared::{InstanceData, MaterialData, TextureSlot, TriangleData, Vertex};
use super::super::upload::{self, PrimitiveRange};
use super::environment::Environment;
use super::lights::Light;
use super::texture::Decoding;
use super::tree::Tree;

/// What does not depend on the head or on the instances' transforms.
pub struct StaticScene {
    pub scene: Arc<Scene>,
    pub vertices: Vec<Vertex>,
    pub indices: Vec<u32>,
    pub ranges: Vec<PrimitiveRange>,
    pub materials: Vec<Material>,
    pub environment: Environment,
    pub decoding: Decoding,
}

impl StaticScene {
    pub fn new(scene: &Arc<Scene>) -> StaticScene {
        let (vertices, indices, ranges) = upload::geometry(scene);
        StaticScene {
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

    /// The texture coordinates of this slot, from both pairs of a vertex' coordinates.
    #[inline]
    pub fn uv(&self, uv: Vec4) -> Vec2 {
        let p = if self.second_uv { Vec3A::new(uv.z, uv.w, 1.0) } else { Vec3A::new(uv.x, uv.y, 1.0) };
        Vec2::new(self.row_u.dot(p), self.row_v.dot(p))
    }
}

/// [`InstanceData`] in the types of this folder.
pub struct Instance {
    /// For directions: without the translation.
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
    pub content: Arc<StaticScene>,
    pub triangles: Vec<TriangleData>,
    pub instances: Vec<Instance>,
    pub lights: Vec<Light>,
    pub tree: Tree,
}

impl World {
    /// The scene relative to `head`, with the instances' transforms in `places`.
    pub fn new(content: &Arc<StaticScene>, places: &[DAffine3], head: DVec3) -> World {
        let StaticScene { scene, ranges, .. } = &**content;
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

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::time::Instant;

    use super::super::math::{Basis, FAR};
    use super::super::parallel::on_all_cores;
    use super::super::random::Sequence;
    use super::super::tree::Stack;
    use super::*;

    /// Rays from the scene's surfaces in cosine-weighted directions, as bounces and shadows have them: in no order.
    fn rays(world: &World, count: u32) -> Vec<(Vec3A, Vec3A)> {
        let [which, place, direction] = [0, 1, 2].map(|purpose| Sequence::of_purpose(7, purpose, 0, [0, 0]));
        let ray = |i: u32| {
            let [pick, _] = which.sample(i);
            let t = &world.triangles[((pick * world.triangles.len() as f32) as usize).min(world.triangles.len() - 1)];
            let [a, b] = place.sample(i);
            let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
            let (edge1, edge2) = (Vec3A::from(t.edge1), Vec3A::from(t.edge2));
            let normal = edge1.cross(edge2).normalize_or(Vec3A::Y);
            let [u, phi] = direction.sample(i);
            let (sin, cos) = (std::f32::consts::TAU * phi).sin_cos();
            let basis = Basis::about(normal);
            let along = basis.x * (u.sqrt() * cos) + basis.y * (u.sqrt() * sin) + normal * (1.0 - u).sqrt();
            (Vec3A::from(t.v0) + edge1 * a + edge2 * b + normal * 1e-3, along)
        };
        (0..count).map(ray).collect()
    }

    /// Figures, not verdicts: `cargo test --profile traced --lib rays_a_second -- --ignored --nocapture`. With `CYCLOPEAN_RAYS` the
    /// triangles and rays are written into that folder, for other tracers to be measured with.
    #[test]
    #[ignore = "a measurement"]
    fn rays_a_second() {
        for name in ["room", "temple"] {
            let scene = Arc::new(crate::scene::load(name).expect("a built-in scene"));
            let head = scene.views[0].stereo_camera(1.6).head();
            let world = World::new(&Arc::new(StaticScene::new(&scene)), &scene.places(), head);
            let rays = rays(&world, 1_000_000);
            if let Some(folder) = std::env::var_os("CYCLOPEAN_RAYS") {
                let write = |what: &str, words: Vec<[f32; 3]>| {
                    let path = std::path::Path::new(&folder).join(format!("{name}.{what}"));
                    std::fs::File::create(path)?.write_all(bytemuck::cast_slice(&words))
                };
                let corners = |t: &TriangleData| {
                    let v0 = Vec3A::from(t.v0);
                    [v0, v0 + Vec3A::from(t.edge1), v0 + Vec3A::from(t.edge2)].map(|v| v.to_array())
                };
                write("triangles", world.triangles.iter().flat_map(corners).collect()).expect("written");
                write("rays", rays.iter().flat_map(|(o, d)| [o.to_array(), d.to_array()]).collect()).expect("written");
            }
            for what in ["nearest", "every"] {
                let mut best = f64::MAX;
                let mut met = 0;
                for _ in 0..5 {
                    let started = Instant::now();
                    let found = on_all_cores(
                        rays.chunks(4096),
                        || (0u64, Stack::new()),
                        |(found, stack), chunk| {
                            for &(origin, direction) in chunk {
                                *found += match what {
                                    "nearest" => {
                                        u64::from(world.tree.nearest(origin, direction, stack, |_, _| true).is_some())
                                    }
                                    _ => {
                                        let mut hidden = 0;
                                        world.tree.every(origin, direction, FAR, stack, |_| {
                                            hidden = 1;
                                            false
                                        });
                                        hidden
                                    }
                                };
                            }
                        },
                    );
                    best = best.min(started.elapsed().as_secs_f64());
                    met = found.iter().map(|f| f.0).sum();
                }
                println!(
                    "{name}, {} triangles, {what}: {:.2} million rays a second, {met} of {} meet something",
                    world.triangles.len(),
                    rays.len() as f64 / best * 1e-6,
                    rays.len()
                );
            }
        }
    }
}
