//! Tangent frames for the repair of meshes: MikkTSpace where a normal map needs the frame that it was baked with, and
//! any orthonormal frame elsewhere.

use std::collections::BTreeMap;

use bevy_mikktspace::{Geometry, TangentSpace};
use glam::{Vec3, Vec4};

use super::triangle_list::Mesh;

/// A unit tangent that is orthogonal to the unit normal. It is well defined for every normal, the poles included.
pub fn any(normal: Vec3) -> Vec4 {
    normal.any_orthonormal_vector().extend(1.0)
}

/// `tangent` made orthogonal to the unit normal and normalised; `None` when nothing is left of it.
pub fn against(tangent: Vec3, normal: Vec3) -> Option<Vec3> {
    let flat = tangent - normal * normal.dot(tangent);
    (flat.is_finite() && flat.length_squared() > 1e-12 * tangent.length_squared()).then(|| flat.normalize())
}

struct Corners<'a> {
    mesh: &'a Mesh,
    uv_set: u32,
    tangents: Vec<Option<Vec4>>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.indices[face * 3 + corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.indices.len() / 3
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)].to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = if self.uv_set == 1 { &self.mesh.uv1 } else { &self.mesh.uv0 };
        // glTF's v grows downwards, and that of the algorithm upwards.
        uv.get(self.vertex(face, corner)).map_or([0.0, 0.0], |uv| [uv.x, 1.0 - uv.y])
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        self.tangents[face * 3 + corner] = space.map(|s| Vec4::from_array(s.tangent_encoded()));
    }
}

/// Gives `mesh` MikkTSpace tangents for this UV set. A vertex whose corners have different tangents is split.
pub fn generate(mesh: &mut Mesh, uv_set: u32) {
    let mut corners = Corners { mesh, uv_set, tangents: vec![None; mesh.indices.len()] };
    // This fails only when memory runs out. Corners without a tangent then get an arbitrary frame below.
    let _ = bevy_mikktspace::generate_tangents(&mut corners);
    let given = corners.tangents;
    let mut seen: BTreeMap<(u32, [u32; 4]), u32> = BTreeMap::new();
    let mut from = Vec::new();
    let mut tangents = Vec::new();
    let mut indices = Vec::with_capacity(mesh.indices.len());
    for (vertex, tangent) in mesh.indices.iter().zip(given) {
        let normal = mesh.normals[*vertex as usize];
        let tangent = tangent
            .and_then(|t| against(t.truncate(), normal).map(|d| d.extend(if t.w < 0.0 { -1.0 } else { 1.0 })))
            .unwrap_or_else(|| any(normal));
        let key = (*vertex, tangent.to_array().map(f32::to_bits));
        let index = *seen.entry(key).or_insert_with(|| {
            from.push(*vertex);
            tangents.push(tangent);
            (from.len() - 1) as u32
        });
        indices.push(index);
    }
    *mesh = mesh.gather(&from);
    mesh.tangents = tangents;
    mesh.indices = indices;
}
