//! Collects a built-in scene's shapes, materials and textures and writes them as an ordinary glTF: JSON, one `.bin`,
//! and PNG textures. Every built-in scene is made with a [`Builder`]; the glTF goes to the scene loader.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use glam::{Quat, Vec3};
use serde_json::{Value, json};

use super::finish::{EMISSIVE_STRENGTH, IOR, TEXTURE_TRANSFORM, TRANSMISSION, material_json};
pub use super::finish::{Finish, TextureId};
use super::shape::{Shape, turn};
use super::texture::Image;
use super::writer::Writer;

/// A glTF and the files that it names, in memory.
#[derive(Debug)]
pub struct Generated {
    /// The `.gltf` itself.
    pub gltf: Vec<u8>,
    /// File name → bytes.
    pub files: BTreeMap<String, Vec<u8>>,
}

/// Where a mesh stands.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    pub position: Vec3,
    pub rotation: Quat,
    pub scale: f32,
}

impl Pose {
    pub fn at(x: f32, y: f32, z: f32) -> Pose {
        Pose { position: Vec3::new(x, y, z), rotation: Quat::IDENTITY, scale: 1.0 }
    }

    /// Turns the mesh about its own vertical axis before the rotation so far; counter-clockwise seen from above.
    pub fn yaw(self, degrees: f32) -> Pose {
        Pose { rotation: self.rotation * turn(Vec3::Y, degrees), ..self }
    }

    /// Tips the mesh backwards about its own x axis, before the rotation so far.
    pub fn pitch(self, degrees: f32) -> Pose {
        Pose { rotation: self.rotation * turn(Vec3::X, degrees), ..self }
    }

    pub fn scale(self, scale: f32) -> Pose {
        Pose { scale, ..self }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct MaterialId(usize);

#[derive(Debug, Clone, Copy)]
pub struct MeshId(usize);

/// Collects the parts of a scene. Its `detail` scales the triangle counts.
pub struct Builder {
    name: String,
    /// √detail: the factor on the number of segments along each direction.
    fineness: f32,
    finishes: Vec<Finish>,
    images: Vec<(String, Image)>,
    meshes: Vec<(String, Vec<(MaterialId, Shape)>)>,
    nodes: Vec<(String, MeshId, Pose)>,
}

impl Builder {
    pub fn new(name: &str, detail: f64) -> Builder {
        Builder {
            name: name.to_owned(),
            fineness: detail.sqrt() as f32,
            finishes: Vec::new(),
            images: Vec::new(),
            meshes: Vec::new(),
            nodes: Vec::new(),
        }
    }

    /// The number of segments for this scene's detail: `full` at detail 1, and never fewer than `least`.
    pub fn segments(&self, full: usize, least: usize) -> usize {
        ((full as f32 * self.fineness).round() as usize).max(least)
    }

    pub fn texture(&mut self, name: &str, image: Image) -> TextureId {
        self.images.push((name.to_owned(), image));
        TextureId(self.images.len() - 1)
    }

    pub fn material(&mut self, finish: Finish) -> MaterialId {
        self.finishes.push(finish);
        MaterialId(self.finishes.len() - 1)
    }

    /// Materials of one kind in several colours (0–255) and roughnesses, called `NAME 1`, `NAME 2`, …
    pub fn palette(&mut self, name: &str, entries: &[([u8; 3], f32)]) -> Vec<MaterialId> {
        let finish = |(i, ([r, g, b], roughness)): (usize, &([u8; 3], f32))| {
            Finish::dielectric(&format!("{name} {}", i + 1), super::pattern::rgb(*r, *g, *b), *roughness)
        };
        entries.iter().enumerate().map(finish).map(|f| self.material(f)).collect()
    }

    /// A mesh of one or more parts. Parts with the same material are joined.
    pub fn mesh(&mut self, name: &str, parts: Vec<(MaterialId, Shape)>) -> MeshId {
        let mut joined: BTreeMap<MaterialId, Shape> = BTreeMap::new();
        for (material, shape) in parts {
            joined.entry(material).or_default().push(shape);
        }
        self.meshes.push((name.to_owned(), joined.into_iter().collect()));
        MeshId(self.meshes.len() - 1)
    }

    pub fn place(&mut self, name: &str, mesh: MeshId, pose: Pose) {
        self.nodes.push((name.to_owned(), mesh, pose));
    }

    /// Adds a mesh that is placed once, where its shape already is.
    pub fn add(&mut self, name: &str, material: MaterialId, shape: Shape) {
        let mesh = self.mesh(name, vec![(material, shape)]);
        self.place(name, mesh, Pose::at(0.0, 0.0, 0.0));
    }

    /// The number of triangles of all placed meshes.
    pub fn triangle_count(&self) -> usize {
        let of = |mesh: &MeshId| self.meshes[mesh.0].1.iter().map(|(_, shape)| shape.indices.len() / 3).sum::<usize>();
        self.nodes.iter().map(|(_, mesh, _)| of(mesh)).sum()
    }

    /// The number of materials.
    pub fn material_count(&self) -> usize {
        self.finishes.len()
    }

    /// The textures as PNG files, in order; all processor cores work on them.
    fn pngs(&self) -> Vec<Result<Vec<u8>, String>> {
        let next = AtomicUsize::new(0);
        let threads = thread::available_parallelism().map_or(1, |n| n.get());
        let mut made: Vec<(usize, Result<Vec<u8>, String>)> = thread::scope(|scope| {
            let work = || {
                let mut made = Vec::new();
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some((_, image)) = self.images.get(i) else { return made };
                    made.push((i, image.to_png()));
                }
            };
            let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            workers.into_iter().flat_map(|w| w.join().unwrap_or_default()).collect()
        });
        made.sort_by_key(|(i, _)| *i);
        made.into_iter().map(|(_, png)| png).collect()
    }

    /// The glTF. The same scene gives the same bytes every time.
    pub fn finish(self) -> Result<Generated, String> {
        let mut out = Writer::default();
        let materials: Vec<Value> = self.finishes.iter().map(material_json).collect();
        let mut meshes = Vec::new();
        for (name, parts) in &self.meshes {
            let primitives: Vec<Value> = parts
                .iter()
                .map(|(material, shape)| out.primitive(shape, material.0, &self.finishes[material.0]))
                .collect();
            meshes.push(json!({ "name": name, "primitives": primitives }));
        }
        let nodes: Vec<Value> = self.nodes.iter().map(|(name, mesh, pose)| node_json(name, *mesh, pose)).collect();
        let mut files = BTreeMap::new();
        let mut images = Vec::new();
        for ((name, _), png) in self.images.iter().zip(self.pngs()) {
            let file = format!("{}-{name}.png", self.name);
            images.push(json!({ "name": name, "uri": file }));
            files.insert(file, png?);
        }
        let textures: Vec<Value> = (0..images.len()).map(|i| json!({ "source": i, "sampler": 0 })).collect();
        let bin = format!("{}.bin", self.name);
        let mut root = json!({
            "asset": { "version": "2.0", "generator": "cyclopean" },
            "scene": 0,
            "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
            "nodes": nodes,
            "meshes": meshes,
            "materials": materials,
            "accessors": out.accessors,
            "bufferViews": out.views,
            "buffers": [{ "uri": bin, "byteLength": out.bytes.len() }],
        });
        if !images.is_empty() {
            root["images"] = images.into();
            root["textures"] = textures.into();
            root["samplers"] = json!([{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497 }]);
        }
        let used = [
            (TEXTURE_TRANSFORM, self.finishes.iter().any(|f| f.repeat != 1.0)),
            (EMISSIVE_STRENGTH, self.finishes.iter().any(|f| f.emissive.iter().any(|c| *c > 1.0))),
            (TRANSMISSION, self.finishes.iter().any(|f| f.transmission != 0.0)),
            (IOR, self.finishes.iter().any(|f| f.ior != 1.5)),
        ];
        let used: Vec<&str> = used.iter().filter(|(_, used)| *used).map(|(name, _)| *name).collect();
        if !used.is_empty() {
            root["extensionsUsed"] = json!(used);
        }
        files.insert(bin, out.bytes);
        let gltf = serde_json::to_vec_pretty(&root).map_err(|error| error.to_string())?;
        Ok(Generated { gltf, files })
    }
}

fn node_json(name: &str, mesh: MeshId, pose: &Pose) -> Value {
    let mut node = json!({ "name": name, "mesh": mesh.0 });
    if pose.position != Vec3::ZERO {
        node["translation"] = json!(pose.position.to_array());
    }
    if pose.rotation != Quat::IDENTITY {
        node["rotation"] = json!(pose.rotation.normalize().to_array());
    }
    if pose.scale != 1.0 {
        node["scale"] = json!(Vec3::splat(pose.scale).to_array());
    }
    node
}
