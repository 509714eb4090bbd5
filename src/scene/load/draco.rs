//! `KHR_draco_mesh_compression`: replaces compressed primitives by plain accessors. Called when a document is read.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute, PointIndex};
use gltf::json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer};
use serde::Deserialize;

use super::accessor::{Buffers, MOST_ELEMENTS};
use super::budget::Budget;
use crate::scene::error::Reason;

pub const NAME: &str = "KHR_draco_mesh_compression";

/// The extension's object in a primitive.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct DracoExtension {
    buffer_view: usize,
    /// Maps glTF's name of an attribute to Draco's number of it.
    attributes: BTreeMap<String, u32>,
}

/// What one compressed buffer view was unpacked to: the accessors of its attributes by Draco's numbers, and the
/// accessor of its indices.
struct Unpacked {
    attributes: BTreeMap<u32, Index<Accessor>>,
    indices: Index<Accessor>,
}

/// Decodes every compressed primitive and gives it accessors of its own.
pub fn unpack(buffers: &mut Buffers, budget: &Budget) -> Result<(), Reason> {
    // Several primitives may share a view, which is decoded once.
    let mut done: BTreeMap<usize, Unpacked> = BTreeMap::new();
    for m in 0..buffers.root.meshes.len() {
        for k in 0..buffers.root.meshes[m].primitives.len() {
            let primitive = &buffers.root.meshes[m].primitives[k];
            let Some(value) = primitive.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { continue };
            let name = buffers.root.meshes[m].name.clone().unwrap_or_else(|| format!("meshes[{m}]"));
            let at = |reason: Reason| format!("mesh `{name}` primitive {k}: {NAME}: {reason}");
            let packed = DracoExtension::deserialize(value).map_err(|error| at(error.to_string()))?;
            let unpacked = match done.entry(packed.buffer_view) {
                Entry::Occupied(found) => found.into_mut(),
                Entry::Vacant(place) => place.insert(decode(buffers, packed.buffer_view, budget).map_err(at)?),
            };
            let primitive = &mut buffers.root.meshes[m].primitives[k];
            for (attribute, number) in &packed.attributes {
                let semantic = primitive.attributes.keys().find(|s| s.to_string() == *attribute).cloned();
                let Some(semantic) = semantic.filter(|s| matches!(s, Checked::Valid(_))) else { continue };
                let accessor = unpacked.attributes.get(number).copied();
                let accessor = accessor.ok_or_else(|| at(format!("attribute {number} is not in the stream")))?;
                let given = primitive.attributes.insert(semantic, accessor);
                // Draco does not store whether glTF normalises an attribute, so this is kept from the accessor that the
                // file declares.
                let given = given.and_then(|index| buffers.root.accessors.get(index.value()));
                let normalized = given.is_some_and(|a| a.normalized);
                buffers.root.accessors[accessor.value()].normalized |= normalized;
            }
            primitive.indices = Some(unpacked.indices);
            primitive.mode = Checked::Valid(Mode::Triangles);
            if !packed.attributes.contains_key(&Semantic::Positions.to_string()) {
                return Err(at("POSITION is not among its attributes".to_owned()));
            }
        }
    }
    Ok(())
}

fn decode(buffers: &mut Buffers, view: usize, budget: &Budget) -> Result<Unpacked, Reason> {
    let bytes = buffers.view(view)?;
    if !bytes.starts_with(b"DRACO") {
        return Err("the bytes are not a Draco stream".to_owned());
    }
    // The header: a magic number, two bytes of version, and the kind of geometry.
    if bytes.get(7) != Some(&1) {
        return Err("the Draco stream holds no mesh".to_owned());
    }
    let mut limits = DecodeLimits::default();
    limits.max_points = MOST_ELEMENTS;
    limits.max_faces = MOST_ELEMENTS;
    limits.max_decoded_bytes = budget.left();
    let mut mesh = Mesh::new();
    MeshDecoder::new()
        .decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut mesh)
        .map_err(|error| format!("the Draco stream cannot be decoded: {error}").replace('\n', " "))?;
    let mut attributes = BTreeMap::new();
    for i in 0..mesh.num_attributes() {
        let attribute = mesh.attribute(i);
        let width = usize::from(attribute.num_components());
        let Some(kind) = [Type::Scalar, Type::Vec2, Type::Vec3, Type::Vec4].get(width.wrapping_sub(1)) else {
            continue;
        };
        budget.take((mesh.num_points() * width * 4) as u64)?;
        let (component, values) = values(attribute, mesh.num_points(), width);
        attributes.insert(attribute.unique_id(), push(buffers, values, component, mesh.num_points(), *kind));
    }
    budget.take(mesh.num_faces() as u64 * 12)?;
    let indices: Vec<u8> = mesh.faces().iter().flatten().flat_map(|point| point.0.to_le_bytes()).collect();
    let count = mesh.num_faces() * 3;
    Ok(Unpacked { attributes, indices: push(buffers, indices, ComponentType::U32, count, Type::Scalar) })
}

/// An attribute's values in the order of the points. They keep their component type where glTF has it, and become
/// floats otherwise.
fn values(attribute: &PointAttribute, points: usize, width: usize) -> (ComponentType, Vec<u8>) {
    let component = match attribute.data_type() {
        DataType::Int8 => ComponentType::I8,
        DataType::Uint8 => ComponentType::U8,
        DataType::Int16 => ComponentType::I16,
        DataType::Uint16 => ComponentType::U16,
        DataType::Uint32 => ComponentType::U32,
        _ => {
            let floats = attribute.read_f32s(points, width);
            return (ComponentType::F32, floats.iter().flat_map(|v| v.to_le_bytes()).collect());
        }
    };
    let size = component.size() * width;
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(size);
    let mut out = vec![0; points * size];
    for (point, out) in out.chunks_exact_mut(size).enumerate() {
        let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let at = value.checked_mul(stride).and_then(|at| Some(at..at.checked_add(size)?));
        if let Some(bytes) = at.and_then(|range| attribute.buffer().data().get(range)) {
            out.copy_from_slice(bytes);
        }
    }
    (component, out)
}

/// Appends a buffer, a buffer view of it, and an accessor over the whole view.
fn push(buffers: &mut Buffers, bytes: Vec<u8>, component: ComponentType, count: usize, kind: Type) -> Index<Accessor> {
    let length = bytes.len() as u64;
    let buffer = Index::new(buffers.buffers.len() as u32);
    buffers.buffers.push(bytes);
    let root = &mut buffers.root;
    root.buffers.push(buffer::Buffer {
        byte_length: length.into(),
        name: None,
        uri: None,
        extensions: None,
        extras: Default::default(),
    });
    root.buffer_views.push(buffer::View {
        buffer,
        byte_length: length.into(),
        byte_offset: None,
        byte_stride: None,
        name: None,
        target: None,
        extensions: None,
        extras: Default::default(),
    });
    root.accessors.push(Accessor {
        buffer_view: Some(Index::new((root.buffer_views.len() - 1) as u32)),
        byte_offset: None,
        count: (count as u64).into(),
        component_type: Checked::Valid(GenericComponentType(component)),
        extensions: None,
        extras: Default::default(),
        type_: Checked::Valid(kind),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    });
    Index::new((root.accessors.len() - 1) as u32)
}
