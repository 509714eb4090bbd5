//! Reads one glTF primitive into a posed triangle list in f32: attributes, morph targets, skin, strips and fans. Called
//! for each primitive that a document places.

use glam::{DAffine3, DMat3, DMat4, Mat3, Vec2, Vec3, Vec4};
use gltf::json::Index;
use gltf::json::mesh::{Mode, Primitive as JsonPrimitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::Buffers;
use super::triangle_list::Mesh;
use crate::scene::error::Reason;

/// The joint matrices of a skin: from object space (bind pose) to the space that the mesh is placed in.
pub type Joints = [DMat4];

/// Reads a primitive; `Ok(None)` for points and lines, which are not drawn.
pub fn read(
    buffers: &Buffers,
    primitive: &JsonPrimitive,
    weights: &[f32],
    joints: Option<&Joints>,
) -> Result<Option<Mesh>, Reason> {
    let Checked::Valid(mode) = primitive.mode else { return Err("mode is unknown".to_owned()) };
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        return Ok(None);
    }
    let mut mesh = attributes(buffers, primitive)?;
    let count = mesh.positions.len();
    morph(buffers, primitive, weights, &mut mesh)?;
    if let Some(joints) = joints {
        skin(buffers, primitive, joints, &mut mesh)?;
    }
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(format!("position of vertex {vertex} is not finite ({})", mesh.positions[vertex]));
    }
    for uv in mesh.uv0.iter_mut().chain(&mut mesh.uv1).filter(|uv| !uv.is_finite()) {
        *uv = Vec2::ZERO;
    }
    for color in mesh.colors.iter_mut().filter(|c| !c.is_finite()) {
        *color = Vec4::ONE;
    }
    let listed = match primitive.indices {
        Some(index) => buffers.integers(index)?,
        None => (0..count as u32).collect(),
    };
    if let Some(bad) = listed.iter().find(|i| **i as usize >= count) {
        return Err(format!("index {bad} is not below the {count} vertices"));
    }
    mesh.indices = triangles(mode, &listed);
    Ok(Some(mesh))
}

fn attributes(buffers: &Buffers, primitive: &JsonPrimitive) -> Result<Mesh, Reason> {
    let find = |semantic: Semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
    let positions = find(Semantic::Positions).ok_or("no POSITION attribute")?;
    let positions = vectors3(buffers, positions)?;
    let count = positions.len();
    let same = |name: &str, n: usize| {
        if n == count { Ok(()) } else { Err(format!("{name} has {n} elements, POSITION has {count}")) }
    };
    let mut mesh = Mesh { positions, ..Mesh::default() };
    if let Some(index) = find(Semantic::Normals) {
        mesh.normals = vectors3(buffers, index)?;
        same("NORMAL", mesh.normals.len())?;
    }
    if let Some(index) = find(Semantic::Tangents) {
        mesh.tangents = buffers.numbers(index, &[4])?.values.chunks_exact(4).map(Vec4::from_slice).collect();
        same("TANGENT", mesh.tangents.len())?;
    }
    for set in 0..2 {
        let Some(index) = find(Semantic::TexCoords(set)) else { continue };
        let uv: Vec<Vec2> = buffers.numbers(index, &[2])?.values.chunks_exact(2).map(Vec2::from_slice).collect();
        same(&format!("TEXCOORD_{set}"), uv.len())?;
        if set == 0 {
            mesh.uv0 = uv;
        } else {
            mesh.uv1 = uv;
        }
    }
    if let Some(index) = find(Semantic::Colors(0)) {
        let elements = buffers.numbers(index, &[3, 4])?;
        let width = elements.width;
        let alpha = |c: &[f32]| c.get(3).copied().unwrap_or(1.0);
        mesh.colors = elements.values.chunks_exact(width).map(|c| Vec4::new(c[0], c[1], c[2], alpha(c))).collect();
        same("COLOR_0", mesh.colors.len())?;
    }
    Ok(mesh)
}

fn vectors3<T>(buffers: &Buffers, index: Index<T>) -> Result<Vec<Vec3>, Reason> {
    Ok(buffers.numbers(index, &[3])?.values.chunks_exact(3).map(Vec3::from_slice).collect())
}

fn morph(buffers: &Buffers, primitive: &JsonPrimitive, weights: &[f32], mesh: &mut Mesh) -> Result<(), Reason> {
    for (k, target) in primitive.targets.iter().flatten().enumerate() {
        let weight = weights.get(k).copied().unwrap_or(0.0);
        if weight == 0.0 {
            continue;
        }
        let add = |what: &str, index: Option<Index<_>>, to: &mut dyn FnMut(usize, Vec3)| -> Result<(), Reason> {
            let Some(index) = index else { return Ok(()) };
            let deltas = vectors3(buffers, index)?;
            if deltas.len() != mesh.positions.len() {
                return Err(format!("morph target {k}: {what} has {} elements", deltas.len()));
            }
            deltas.iter().enumerate().for_each(|(i, d)| to(i, *d * weight));
            Ok(())
        };
        let mut moved = vec![Vec3::ZERO; mesh.positions.len()];
        add("POSITION", target.positions, &mut |i, d| moved[i] = d)?;
        let (normals, tangents) = (&mut mesh.normals, &mut mesh.tangents);
        let mut turned = vec![Vec3::ZERO; normals.len()];
        if !normals.is_empty() {
            add("NORMAL", target.normals, &mut |i, d| turned[i] = d)?;
        }
        let mut twisted = vec![Vec3::ZERO; tangents.len()];
        if !tangents.is_empty() {
            add("TANGENT", target.tangents, &mut |i, d| twisted[i] = d)?;
        }
        mesh.positions.iter_mut().zip(moved).for_each(|(p, d)| *p += d);
        normals.iter_mut().zip(turned).for_each(|(n, d)| *n += d);
        tangents.iter_mut().zip(twisted).for_each(|(t, d)| *t += d.extend(0.0));
    }
    Ok(())
}

fn skin(buffers: &Buffers, primitive: &JsonPrimitive, joints: &Joints, mesh: &mut Mesh) -> Result<(), Reason> {
    let count = mesh.positions.len();
    let mut blended = vec![DMat4::ZERO; count];
    let mut total = vec![0.0f64; count];
    for set in 0.. {
        let numbers = primitive.attributes.get(&Checked::Valid(Semantic::Joints(set))).copied();
        let weights = primitive.attributes.get(&Checked::Valid(Semantic::Weights(set))).copied();
        let (Some(numbers), Some(weights)) = (numbers, weights) else { break };
        let (numbers, weights) = (buffers.integers(numbers)?, buffers.numbers(weights, &[4])?.values);
        if numbers.len() != count * 4 || weights.len() != count * 4 {
            return Err(format!("JOINTS_{set} and WEIGHTS_{set} need four components for each of {count} vertices"));
        }
        for (k, (joint, weight)) in numbers.iter().zip(&weights).enumerate().filter(|(_, (_, w))| **w != 0.0) {
            let matrix = joints.get(*joint as usize);
            let matrix = matrix.ok_or_else(|| format!("JOINTS_{set}: joint {joint} is not below {}", joints.len()))?;
            blended[k / 4] += *matrix * f64::from(*weight);
            total[k / 4] += f64::from(*weight);
        }
    }
    for i in 0..count {
        // A vertex without weights keeps its bind pose. Weights that do not sum to 1 are normalised.
        let Some(matrix) = (total[i] > 0.0).then(|| blended[i] * (1.0 / total[i])) else { continue };
        let affine = DAffine3::from_mat4(matrix);
        mesh.positions[i] = affine.transform_point3(mesh.positions[i].as_dvec3()).as_vec3();
        let turn = normal_matrix(affine.matrix3);
        if let Some(n) = mesh.normals.get_mut(i) {
            *n = (turn * *n).normalize_or_zero();
        }
        if let Some(t) = mesh.tangents.get_mut(i) {
            *t = affine.matrix3.mul_vec3(t.truncate().as_dvec3()).normalize_or_zero().as_vec3().extend(t.w);
        }
    }
    Ok(())
}

/// The cofactor matrix. It transforms normals as the inverse transpose does, and exists for singular matrices as well.
fn normal_matrix(m: DMat3) -> Mat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)).as_mat3()
}

/// Triangles of lists, strips and fans (glTF 2.0 §3.7.2.1) as a triangle list with the same winding.
fn triangles(mode: Mode, listed: &[u32]) -> Vec<u32> {
    match mode {
        Mode::TriangleStrip => (0..listed.len().saturating_sub(2))
            .flat_map(|i| [listed[i], listed[i + 1 + i % 2], listed[i + 2 - i % 2]])
            .collect(),
        Mode::TriangleFan => {
            (1..listed.len().saturating_sub(1)).flat_map(|i| [listed[i], listed[i + 1], listed[0]]).collect()
        }
        _ => listed[..listed.len() - listed.len() % 3].to_vec(),
    }
}

/// Mirrors a mesh in x, for placements that mirror it. The winding and the handedness of the tangents are reversed with
/// it.
pub fn mirror(mesh: &mut crate::scene::Primitive) {
    let flip = |v: &mut Vec3| v.x = -v.x;
    mesh.positions.iter_mut().for_each(flip);
    mesh.normals.iter_mut().for_each(flip);
    for t in &mut mesh.tangents {
        *t = Vec4::new(-t.x, t.y, t.z, -t.w);
    }
    mesh.indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
}
