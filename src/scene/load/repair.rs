//! Repairs a mesh once, at load: degenerate triangles, and missing or zero normals and tangents. Called for each mesh
//! of a document.

use glam::Vec3;

use super::tangents;
use super::triangle_list::Mesh;

/// Repairs `mesh` in place and returns what was done, one sentence each, without the mesh's name. `normal_map_uv` is
/// the UV set of its material's normal map, if it has one.
pub fn mend(mesh: &mut Mesh, normal_map_uv: Option<u32>) -> Vec<String> {
    let mut said = Vec::new();
    drop_degenerate(mesh, &mut said);
    mend_normals(mesh, &mut said);
    mend_tangents(mesh, normal_map_uv, &mut said);
    said
}

fn drop_degenerate(mesh: &mut Mesh, said: &mut Vec<String>) {
    let before = mesh.indices.len() / 3;
    let mut kept = Vec::with_capacity(mesh.indices.len());
    for t in mesh.indices.chunks_exact(3) {
        if face_normal(&mesh.positions, t).is_some() {
            kept.extend_from_slice(t);
        }
    }
    let dropped = before - kept.len() / 3;
    if dropped > 0 {
        said.push(format!("{dropped} of {before} triangles have no area and were dropped"));
    }
    mesh.indices = kept;
}

/// The normal of a triangle in f64, of a length of twice its area; `None` when the triangle has no area.
fn face_normal(positions: &[Vec3], t: &[u32]) -> Option<glam::DVec3> {
    let [a, b, c] = [t[0], t[1], t[2]].map(|i| positions[i as usize].as_dvec3());
    let normal = (b - a).cross(c - a);
    (normal.length_squared() > 0.0 && normal.is_finite()).then_some(normal)
}

fn mend_normals(mesh: &mut Mesh, said: &mut Vec<String>) {
    if mesh.normals.is_empty() {
        // glTF 2.0 §3.7.2.1: without normals, flat ones are used and the file's tangents are ignored.
        let corners = std::mem::take(&mut mesh.indices);
        *mesh = mesh.gather(&corners);
        mesh.tangents.clear();
        mesh.normals = vec![Vec3::Y; mesh.positions.len()];
        for t in 0..mesh.positions.len() / 3 {
            let corner = [3 * t as u32, 3 * t as u32 + 1, 3 * t as u32 + 2];
            if let Some(n) = face_normal(&mesh.positions, &corner) {
                mesh.normals[3 * t..3 * t + 3].fill(n.normalize().as_vec3());
            }
        }
        if !mesh.positions.is_empty() {
            said.push("no normals: flat ones made from the faces".to_owned());
        }
        return;
    }
    let bad: Vec<usize> = (0..mesh.normals.len())
        .filter(|i| {
            let n = mesh.normals[*i];
            let length = n.as_dvec3().length();
            let good = length.is_finite() && length > 1e-12;
            if good {
                mesh.normals[*i] = (n.as_dvec3() / length).as_vec3();
            }
            !good
        })
        .collect();
    if bad.is_empty() {
        return;
    }
    let mut sums = vec![glam::DVec3::ZERO; mesh.positions.len()];
    for t in mesh.indices.chunks_exact(3) {
        if let Some(n) = face_normal(&mesh.positions, t) {
            t.iter().for_each(|i| sums[*i as usize] += n);
        }
    }
    for i in &bad {
        mesh.normals[*i] = sums[*i].try_normalize().unwrap_or(glam::DVec3::Y).as_vec3();
    }
    said.push(format!("{} zero or non-finite normals made from the faces", bad.len()));
}

fn mend_tangents(mesh: &mut Mesh, normal_map_uv: Option<u32>, said: &mut Vec<String>) {
    if mesh.tangents.is_empty() {
        match normal_map_uv {
            Some(uv_set) if !mesh.indices.is_empty() => {
                tangents::generate(mesh, uv_set);
                said.push("a normal map but no tangents: made by MikkTSpace".to_owned());
            }
            _ => mesh.tangents = mesh.normals.iter().map(|n| tangents::any(*n)).collect(),
        }
        return;
    }
    let mut mended = 0;
    for (tangent, normal) in mesh.tangents.iter_mut().zip(&mesh.normals) {
        let sign = if tangent.w < 0.0 { -1.0 } else { 1.0 };
        match tangents::against(tangent.truncate(), *normal) {
            Some(direction) => *tangent = direction.extend(sign),
            None => {
                *tangent = tangents::any(*normal);
                mended += 1;
            }
        }
    }
    if mended > 0 {
        said.push(format!("{mended} zero or non-finite tangents replaced by arbitrary ones"));
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec4};

    use super::*;

    fn quad() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y],
            uv0: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
            indices: vec![0, 1, 2, 0, 2, 3, 1, 1, 2],
            ..Mesh::default()
        }
    }

    #[test]
    fn a_bare_quad_becomes_whole() {
        let mut mesh = quad();
        let said = mend(&mut mesh, Some(0));
        assert_eq!(said.len(), 3, "{said:?}");
        assert_eq!(mesh.indices.len(), 6);
        assert!(mesh.normals.iter().all(|n| (*n - Vec3::Z).length() < 1e-6));
        assert!(mesh.tangents.iter().all(|t| (t.truncate() - Vec3::X).length() < 1e-5), "{:?}", mesh.tangents);
    }

    #[test]
    fn zero_normals_and_tangents_are_replaced() {
        let mut mesh = quad();
        mesh.normals = vec![Vec3::Z * 3.0, Vec3::ZERO, Vec3::NAN, Vec3::Z];
        mesh.tangents = vec![Vec4::ZERO, Vec4::new(f32::NAN, 0.0, 0.0, 1.0), Vec3::X.extend(-2.0), Vec3::Z.extend(1.0)];
        let said = mend(&mut mesh, None);
        assert!(mesh.normals.iter().all(|n| *n == Vec3::Z), "{:?}", mesh.normals);
        for (t, n) in mesh.tangents.iter().zip(&mesh.normals) {
            assert!(
                (t.truncate().length() - 1.0).abs() < 1e-6 && t.truncate().dot(*n).abs() < 1e-6 && t.w.abs() == 1.0
            );
        }
        assert!(said.iter().any(|s| s.contains("2 zero or non-finite normals")), "{said:?}");
        assert!(said.iter().any(|s| s.contains("3 zero or non-finite tangents")), "{said:?}");
    }
}
