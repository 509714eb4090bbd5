//! A triangle list on its way from the file to the scene.

use glam::{Vec2, Vec3, Vec4};

/// A triangle list before it becomes a [`crate::scene::Primitive`].
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
    /// A mesh whose vertex i is this mesh's vertex `from[i]`.
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
