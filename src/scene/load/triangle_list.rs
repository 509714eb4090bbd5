//! A triangle list on its way from the file to the scene.

use glam::{Vec2, Vec3, Vec4};

/// A triangle list on its way to a [`crate::scene::Primitive`].
#[derive(Debug, Default)]
pub struct Mesh {
    pub positions: Vec<Vec3>,
    /// Empty when the file has none.
    pub normals: Vec<Vec3>,
    /// Empty when the file has none.
    pub tangents: Vec<Vec4>,
    pub uv0: Vec<Vec2>,
    pub uv1: Vec<Vec2>,
    pub colors: Vec<Vec4>,
    pub indices: Vec<u32>,
}

impl Mesh {
    /// The mesh with its vertices copied in the order of `from` (indices into the old vertices).
    pub fn gather(&self, from: &[u32]) -> Mesh {
        fn pick<T: Copy>(of: &[T], from: &[u32]) -> Vec<T> {
            if of.is_empty() { Vec::new() } else { from.iter().map(|i| of[*i as usize]).collect() }
        }
        Mesh {
            positions: pick(&self.positions, from),
            normals: pick(&self.normals, from),
            tangents: pick(&self.tangents, from),
            uv0: pick(&self.uv0, from),
            uv1: pick(&self.uv1, from),
            colors: pick(&self.colors, from),
            indices: (0..from.len() as u32).collect(),
        }
    }
}
