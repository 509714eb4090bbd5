//! Reads a whole glTF: gathers the meshes, materials, lights and cameras of its nodes and repairs them. The loader
//! makes a scene of the result.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DAffine3, DMat4, DQuat, DVec3, Vec2, Vec3, Vec4};
use gltf::json::extensions::scene::khr_lights_punctual::{Light as JsonLight, Type as LightType};
use gltf::json::mesh::Primitive as JsonPrimitive;
use gltf::json::validation::Checked;

use super::accessor::Buffers;
use super::container::{self, Parsed};
use super::extensions::ExtensionUse;
use super::files::Reader;
use super::image::Textures;
use super::limits::{MOST_LIGHTS, MOST_PLACED, MOST_VIEWS};
use super::nodes::{self, PlacedNode};
use super::repair;
use super::triangle_list::Mesh;
use super::{draco, instancing, material, mesh, meshopt, weld};
use crate::scene::camera::DEFAULT_IPD_M;
use crate::scene::error::{Reason, SceneError};
use crate::scene::{Instance, Light, LightSource, Material, Primitive, Texture, View};

/// What a glTF file holds, in the terms of the renderer.
#[derive(Debug, Default)]
pub struct Document {
    pub primitives: Vec<Primitive>,
    pub instances: Vec<Instance>,
    /// The names of the placed nodes, each with the index of its parent in this list. A parent comes before its
    /// children.
    pub nodes: Vec<(String, Option<usize>)>,
    /// Per instance: the place of its node in `nodes`.
    pub node_of: Vec<usize>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub lights: Vec<Light>,
    /// For each light, its own name, or the name of its node where it has none.
    pub light_names: Vec<String>,
    pub views: Vec<View>,
    pub extensions: Vec<ExtensionUse>,
    pub repairs: Vec<String>,
}

/// Reads a `.gltf` or `.glb` from its bytes. The other files that it names are read through `reader`.
pub fn read(file: &str, bytes: &[u8], reader: &mut Reader) -> Result<Document, SceneError> {
    let parsed = container::parse(file, bytes)?;
    reader.hash(bytes);
    build(parsed, reader).map_err(|reason| SceneError::Invalid { file: file.to_owned(), reason })
}

fn build(parsed: Parsed, reader: &mut Reader) -> Result<Document, Reason> {
    let Parsed { mut root, mut blob, uses, notes } = parsed;
    let mut data = Vec::with_capacity(root.buffers.len());
    for (i, buffer) in root.buffers.iter().enumerate() {
        if meshopt::is_fallback(buffer) {
            data.push(Vec::new());
            continue;
        }
        let bytes = match &buffer.uri {
            Some(uri) => reader.read(uri).map_err(|reason| format!("buffers[{i}]: {reason}"))?,
            None => blob.take().ok_or_else(|| format!("buffers[{i}] has no uri and there is no binary chunk"))?,
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            return Err(format!("buffers[{i}] holds {} bytes, {} are promised", bytes.len(), buffer.byte_length.0));
        }
        data.push(bytes);
    }
    let budget = reader.budget().clone();
    meshopt::unpack(&mut root, &mut data, &budget)?;
    let mut buffers = Buffers { root, buffers: data, budget: budget.clone() };
    draco::unpack(&mut buffers, &budget)?;
    let placed = nodes::place(&buffers.root)?;
    let mut place_of = vec![None; buffers.root.nodes.len()];
    placed.iter().enumerate().for_each(|(place, p)| place_of[p.node] = Some(place));
    let mut builder = Builder {
        buffers: &buffers,
        placed: &placed,
        place_of,
        out: Document::default(),
        made: BTreeMap::new(),
        primes: BTreeMap::new(),
        view_names: BTreeSet::new(),
        default_material: None,
    };
    (builder.out.extensions, builder.out.repairs) = (uses, notes);
    builder.materials(reader)?;
    let name = |p: &PlacedNode| (buffers.root.nodes[p.node].name.clone().unwrap_or_default(), p.parent);
    builder.out.nodes = placed.iter().map(name).collect();
    for place in 0..placed.len() {
        builder.node(place)?;
    }
    Ok(builder.out)
}

/// Maps (mesh, primitive, bits of the morph weights, mirrored) to the primitive that was made of it; `None` where there
/// is nothing to draw.
type MadeKey = (usize, usize, Vec<u32>, bool);

struct Builder<'a> {
    buffers: &'a Buffers,
    placed: &'a [PlacedNode],
    /// For each node of the document, its index in `placed`; `None` when it is not in the scene.
    place_of: Vec<Option<usize>>,
    out: Document,
    made: BTreeMap<MadeKey, Option<usize>>,
    /// For each camera name, how many apostrophes the next view of this name gets.
    primes: BTreeMap<String, usize>,
    view_names: BTreeSet<String>,
    default_material: Option<usize>,
}

impl Builder<'_> {
    fn materials(&mut self, reader: &mut Reader) -> Result<(), Reason> {
        let mut textures = Textures::new(reader.budget().clone());
        for (i, json) in self.buffers.root.materials.iter().enumerate() {
            let name = json.name.clone().unwrap_or_else(|| i.to_string());
            let mut notes = Vec::new();
            let made = material::read(self.buffers, reader, &mut textures, json, &mut notes);
            self.out.materials.push(made.map_err(|reason| format!("material `{name}`: {reason}"))?);
            self.out.repairs.extend(notes.into_iter().map(|note| format!("material `{name}`: {note}")));
        }
        self.out.textures = textures.list;
        Ok(())
    }

    fn node(&mut self, place: usize) -> Result<(), Reason> {
        let placed = &self.placed[place];
        let node = &self.buffers.root.nodes[placed.node];
        let label = nodes::label(node, placed.node);
        if let Some(camera) = node.camera {
            self.camera(camera.value(), placed, &label)?;
        }
        if !placed.visible {
            return Ok(());
        }
        if let Some(light) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) {
            self.light(light.light.value(), placed, &label)?;
        }
        let Some(mesh) = node.mesh else { return Ok(()) };
        let json =
            self.buffers.root.meshes.get(mesh.value()).ok_or_else(|| format!("{label}: its mesh does not exist"))?;
        let name = json.name.clone().unwrap_or_else(|| format!("meshes[{}]", mesh.value()));
        let weights = node.weights.as_ref().or(json.weights.as_ref()).cloned().unwrap_or_default();
        let skin = node.skin.map(|s| self.joints(s.value())).transpose().map_err(|r| format!("{label}: {r}"))?;
        let left = instancing::MOST_INSTANCES.saturating_sub(self.out.instances.len()) / json.primitives.len().max(1);
        let places = instancing::places(self.buffers, node, left).map_err(|r| format!("{label}: {r}"))?;
        for (k, primitive) in json.primitives.iter().enumerate() {
            let at = |reason: Reason| format!("mesh `{name}` primitive {k}: {reason}");
            if let Some((origin, joints)) = &skin {
                let made = self.primitive(&name, k, primitive, &weights, Some(joints)).map_err(at)?;
                self.place(made, DAffine3::from_translation(*origin), place)?;
                continue;
            }
            let bits: Vec<u32> = weights.iter().map(|w| w.to_bits()).collect();
            for within in places.as_deref().unwrap_or(&[DAffine3::IDENTITY]) {
                let world_from_object = placed.world_from_node * *within;
                let mirrored = world_from_object.matrix3.determinant() < 0.0;
                let key = (mesh.value(), k, bits.clone(), mirrored);
                let made = match self.made.get(&key) {
                    Some(made) => *made,
                    None => {
                        let made = self.primitive(&name, k, primitive, &weights, None).map_err(at)?;
                        if let Some(index) = made.filter(|_| mirrored) {
                            mesh::mirror(&mut self.out.primitives[index]);
                        }
                        self.made.insert(key, made);
                        made
                    }
                };
                // The mirrored mesh is placed by the un-mirrored transform, so that every instance keeps its winding.
                let flip = DVec3::new(if mirrored { -1.0 } else { 1.0 }, 1.0, 1.0);
                self.place(made, world_from_object * DAffine3::from_scale(flip), place)?;
            }
        }
        Ok(())
    }

    fn place(&mut self, primitive: Option<usize>, world_from_object: DAffine3, place: usize) -> Result<(), Reason> {
        let Some(primitive) = primitive else { return Ok(()) };
        if self.out.instances.len() == MOST_PLACED {
            return Err(format!("the scene places more than {MOST_PLACED} primitives, which is not read"));
        }
        let previous_world_from_object = world_from_object;
        self.out.instances.push(Instance { primitive, world_from_object, previous_world_from_object });
        self.out.node_of.push(place);
        Ok(())
    }

    fn primitive(
        &mut self,
        mesh_name: &str,
        k: usize,
        json: &JsonPrimitive,
        weights: &[f32],
        joints: Option<&Vec<DMat4>>,
    ) -> Result<Option<usize>, Reason> {
        let name = if k == 0 { mesh_name.to_owned() } else { format!("{mesh_name}/{k}") };
        let Some(mut mesh) = mesh::read(self.buffers, json, weights, joints.map(Vec::as_slice))? else {
            self.out.repairs.push(format!("mesh `{name}`: points or lines are not drawn"));
            return Ok(None);
        };
        // 72 bytes for each vertex of the result: position, normal, tangent, two UV sets and a colour.
        self.buffers.budget.take(mesh.positions.len() as u64 * 72 + mesh.indices.len() as u64 * 4)?;
        let closed = weld::is_closed(&mesh.positions, &mesh.indices);
        let material = match json.material {
            Some(index) if index.value() < self.buffers.root.materials.len() => index.value(),
            Some(index) => return Err(format!("materials[{}] does not exist", index.value())),
            None => *self.default_material.get_or_insert_with(|| {
                self.out.materials.push(material::default_material());
                self.out.materials.len() - 1
            }),
        };
        let unlit = self.buffers.root.materials.get(material).is_some_and(material::is_unlit);
        if unlit && !mesh.colors.is_empty() {
            let left_out = "its vertex colours are left out, for its material is unlit";
            self.out.repairs.push(format!("mesh `{name}`: {left_out}"));
        }
        let normal_map_uv = self.out.materials[material].normal_texture.as_ref().map(|t| t.uv_set);
        let said = repair::mend(&mut mesh, normal_map_uv);
        self.out.repairs.extend(said.into_iter().map(|what| format!("mesh `{name}`: {what}")));
        if mesh.indices.is_empty() {
            self.out.repairs.push(format!("mesh `{name}`: no triangle is left, so it is not drawn"));
            return Ok(None);
        }
        self.out.primitives.push(finish(name, mesh, material, closed));
        Ok(Some(self.out.primitives.len() - 1))
    }

    /// The origin of a skin, and its joint matrices relative to that origin. The origin is kept apart so that positions
    /// in f32 stay small.
    fn joints(&self, index: usize) -> Result<(DVec3, Vec<DMat4>), Reason> {
        let skin = self.buffers.root.skins.get(index).ok_or_else(|| format!("skins[{index}] does not exist"))?;
        let world = |node: usize| {
            let place = self.place_of.get(node).copied().flatten();
            let found = place.map(|place| self.placed[place].world_from_node);
            found.ok_or_else(|| format!("skins[{index}]: joint node {node} is not in the scene"))
        };
        // One matrix for each joint. Every mesh with this skin computes them again.
        self.buffers.budget.take(skin.joints.len() as u64 * 128)?;
        let inverse: Vec<DMat4> = match skin.inverse_bind_matrices {
            Some(accessor) => self
                .buffers
                .numbers(accessor, &[16])?
                .values
                .chunks_exact(16)
                .map(|m| DMat4::from_cols_slice(&m.iter().map(|x| f64::from(*x)).collect::<Vec<_>>()))
                .collect(),
            None => vec![DMat4::IDENTITY; skin.joints.len()],
        };
        if inverse.len() < skin.joints.len() {
            return Err(format!("skins[{index}]: {} bind matrices for {} joints", inverse.len(), skin.joints.len()));
        }
        let origin = skin.joints.first().map_or(Ok(DVec3::ZERO), |j| world(j.value()).map(|w| w.translation))?;
        let joints: Result<Vec<DMat4>, Reason> = skin
            .joints
            .iter()
            .zip(&inverse)
            .map(|(joint, inverse)| {
                Ok(DMat4::from_translation(-origin) * DMat4::from(world(joint.value())?) * *inverse)
            })
            .collect();
        Ok((origin, joints?))
    }

    fn camera(&mut self, index: usize, placed: &PlacedNode, label: &str) -> Result<(), Reason> {
        let Some(camera) = self.buffers.root.cameras.get(index) else { return Ok(()) };
        let Some(lens) = camera.perspective.as_ref().filter(|l| l.yfov > 0.0 && l.yfov < 3.1) else {
            self.out.repairs.push(format!("{label}: its camera is not a perspective one and makes no view"));
            return Ok(());
        };
        let Some(world_from_view) = orientation(placed) else {
            self.out.repairs.push(format!("{label}: its camera has no direction and makes no view"));
            return Ok(());
        };
        let name = camera.name.clone().or_else(|| self.buffers.root.nodes[placed.node].name.clone());
        let name = self.fresh(name.unwrap_or_else(|| format!("camera{index}")));
        if self.out.views.len() == MOST_VIEWS {
            return Err(format!("the scene has more than {MOST_VIEWS} cameras, which is not read"));
        }
        self.out.views.push(View {
            name,
            position: placed.world_from_node.translation,
            world_from_view,
            vertical_fov_rad: f64::from(lens.yfov),
            ipd_m: DEFAULT_IPD_M,
            cant_rad: 0.0,
            near_m: if lens.znear > 0.0 { f64::from(lens.znear) } else { 0.05 },
        });
        Ok(())
    }

    /// A view name that is not taken yet: `name` followed by as many apostrophes as are needed.
    fn fresh(&mut self, name: String) -> String {
        let primes = self.primes.entry(name.clone()).or_default();
        loop {
            let marked = format!("{name}{}", "'".repeat(*primes));
            *primes += 1;
            if self.view_names.insert(marked.clone()) {
                return marked;
            }
        }
    }

    fn light(&mut self, index: usize, placed: &PlacedNode, label: &str) -> Result<(), Reason> {
        let lights = self.buffers.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        let light = lights.and_then(|l| l.lights.get(index));
        let light: &JsonLight = light.ok_or_else(|| format!("{label}: light {index} does not exist"))?;
        let power = Vec3::from_array(light.color) * light.intensity;
        if !power.is_finite() || power.min_element() < 0.0 {
            return Err(format!("{label}: its light's colour times intensity is {power}"));
        }
        let range_m = light.range.filter(|r| *r > 0.0).unwrap_or(f32::INFINITY);
        let position = placed.world_from_node.translation;
        let direction = orientation(placed).map_or(DVec3::NEG_Z, |q| q * DVec3::NEG_Z).as_vec3();
        let Checked::Valid(kind) = &light.type_ else { return Err(format!("{label}: unknown kind of light")) };
        let source = match kind {
            LightType::Directional => LightSource::Directional { direction, irradiance: power },
            LightType::Point => LightSource::Point { position, intensity: power, range_m },
            LightType::Spot => {
                let (inner, outer) = light
                    .spot
                    .as_ref()
                    .map_or((0.0, std::f32::consts::FRAC_PI_4), |s| (s.inner_cone_angle, s.outer_cone_angle));
                let outer_rad = if outer.is_finite() {
                    outer.clamp(1e-3, std::f32::consts::FRAC_PI_2)
                } else {
                    std::f32::consts::FRAC_PI_4
                };
                let inner_rad = if inner.is_finite() { inner.clamp(0.0, outer_rad - 5e-4) } else { 0.0 };
                LightSource::Spot { position, direction, intensity: power, range_m, inner_rad, outer_rad }
            }
        };
        if self.out.lights.len() == MOST_LIGHTS {
            return Err(format!("the scene has more than {MOST_LIGHTS} lights, which is not read"));
        }
        self.out.lights.push(source.into());
        let name = light.name.as_ref().or(self.buffers.root.nodes[placed.node].name.as_ref());
        self.out.light_names.push(name.cloned().unwrap_or_default());
        Ok(())
    }
}

/// A node's rotation without its scale; `None` when its axes have collapsed.
fn orientation(placed: &PlacedNode) -> Option<DQuat> {
    let m = placed.world_from_node.matrix3;
    let back = m.z_axis.try_normalize()?;
    let right = m.y_axis.cross(back).try_normalize()?;
    Some(DQuat::from_mat3(&glam::DMat3::from_cols(right, back.cross(right), back)).normalize())
}

fn finish(name: String, mesh: Mesh, material: usize, closed: bool) -> Primitive {
    let count = mesh.positions.len();
    let or = |uv: Vec<Vec2>| if uv.is_empty() { vec![Vec2::ZERO; count] } else { uv };
    Primitive {
        name,
        normals: mesh.normals,
        tangents: mesh.tangents,
        uv0: or(mesh.uv0),
        uv1: or(mesh.uv1),
        colors: if mesh.colors.is_empty() { vec![Vec4::ONE; count] } else { mesh.colors },
        positions: mesh.positions,
        indices: mesh.indices,
        material,
        closed,
    }
}
