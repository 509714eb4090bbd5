//! Tells whether a mesh is closed. Only the back faces of closed meshes bound matter. Called when a document is read.

use std::collections::HashMap;

use glam::Vec3;

/// Whether every edge between welded vertices (equal position bits) belongs to exactly two triangles, which run along
/// it in opposite directions.
///
/// Triangles with two welded corners have no area and cannot open a mesh, so they are ignored.
/// An empty mesh is not closed.
pub fn is_closed(positions: &[Vec3], indices: &[u32]) -> bool {
    let mut ids: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    let welded: Vec<u32> = positions
        .iter()
        .map(|p| {
            // −0 and +0 are the same place.
            let key = (*p + Vec3::ZERO).to_array().map(f32::to_bits);
            let next = ids.len() as u32;
            *ids.entry(key).or_insert(next)
        })
        .collect();
    let mut edges = Vec::with_capacity(indices.len());
    for triangle in indices.chunks_exact(3) {
        let corner = [welded[triangle[0] as usize], welded[triangle[1] as usize], welded[triangle[2] as usize]];
        if corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0] {
            continue;
        }
        for k in 0..3 {
            let (a, b) = (corner[k], corner[(k + 1) % 3]);
            edges.push((u64::from(a.min(b)) << 32 | u64::from(a.max(b)), a < b));
        }
    }
    edges.sort_unstable();
    // After sorting, the two uses of each edge are neighbours: (edge, false), then (edge, true), and no third one.
    !edges.is_empty()
        && edges.len().is_multiple_of(2)
        && edges.chunks_exact(2).all(|pair| pair[0].0 == pair[1].0 && pair[0].1 != pair[1].1)
        && edges.chunks_exact(2).zip(edges.chunks_exact(2).skip(1)).all(|(a, b)| a[0].0 != b[0].0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [u32; 12] = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];

    #[test]
    fn a_tetrahedron_is_closed_and_not_without_a_face_or_with_one_flipped() {
        let p = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        assert!(is_closed(&p, &TETRAHEDRON));
        assert!(!is_closed(&p, &TETRAHEDRON[3..]));
        let mut flipped = TETRAHEDRON;
        flipped.swap(0, 1);
        assert!(!is_closed(&p, &flipped));
        assert!(!is_closed(&p, &[]));
    }

    #[test]
    fn split_vertices_weld_by_position() {
        let p = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let split: Vec<Vec3> = TETRAHEDRON.iter().map(|i| p[*i as usize]).collect();
        let indices: Vec<u32> = (0..12).collect();
        assert!(is_closed(&split, &indices));
    }
}
