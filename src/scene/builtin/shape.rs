//! Triangle meshes while they are being made, and versions of sine and cosine that give the same result on every
//! machine.

use glam::{Mat3, Quat, Vec2, Vec3};

/// A mesh that is being made: one entry for each vertex and three indices for each triangle, counter-clockwise seen
/// from outside.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    /// In metres, or from 0 to 1 where a texture covers the shape once.
    pub uvs: Vec<Vec2>,
    pub indices: Vec<u32>,
}

/// Sine. The results of `std` differ between platforms in the last bit; these do not.
pub fn sin(x: f32) -> f32 {
    libm::sin(f64::from(x)) as f32
}

/// Cosine; see [`sin`].
pub fn cos(x: f32) -> f32 {
    libm::cos(f64::from(x)) as f32
}

/// A rotation by degrees about a unit axis.
pub fn turn(axis: Vec3, degrees: f32) -> Quat {
    let half = degrees.to_radians() / 2.0;
    let v = axis * sin(half);
    Quat::from_xyzw(v.x, v.y, v.z, cos(half))
}

impl Shape {
    /// Appends a vertex and returns its index.
    pub fn vertex(&mut self, position: Vec3, normal: Vec3, uv: Vec2) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.uvs.push(uv);
        (self.positions.len() - 1) as u32
    }

    /// Appends the two triangles a-b-c and a-c-d.
    pub fn quad(&mut self, a: u32, b: u32, c: u32, d: u32) {
        self.indices.extend([a, b, c, a, c, d]);
    }

    /// Appends another shape.
    pub fn push(&mut self, other: Shape) -> &mut Shape {
        let base = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.uvs.extend(other.uvs);
        self.indices.extend(other.indices.into_iter().map(|i| i + base));
        self
    }

    /// The shape moved by this vector.
    pub fn at(mut self, x: f32, y: f32, z: f32) -> Shape {
        self.positions.iter_mut().for_each(|p| *p += Vec3::new(x, y, z));
        self
    }

    /// The shape rotated about the origin.
    pub fn turned(mut self, axis: Vec3, degrees: f32) -> Shape {
        let m = Mat3::from_quat(turn(axis, degrees));
        self.positions.iter_mut().chain(&mut self.normals).for_each(|v| *v = m * *v);
        self
    }

    /// The shape stretched along the axes. The factors must be positive.
    pub fn scaled(mut self, x: f32, y: f32, z: f32) -> Shape {
        let s = Vec3::new(x, y, z);
        self.positions.iter_mut().for_each(|p| *p *= s);
        self.normals.iter_mut().for_each(|n| *n = (*n / s).normalize_or(Vec3::Y));
        self
    }

    /// The shape with its UVs multiplied by these factors.
    pub fn uv_scaled(mut self, u: f32, v: f32) -> Shape {
        self.uvs.iter_mut().for_each(|uv| *uv *= Vec2::new(u, v));
        self
    }

    /// The shape with new normals from its faces, smooth across all vertices at one place.
    pub fn smoothed(self) -> Shape {
        self.smoothed_within(|_| false)
    }

    /// As [`Shape::smoothed`], but the edge between the sides and the flat ends stays sharp. The ends are where normals
    /// lie within 40° of the vertical.
    pub fn smoothed_sides(self) -> Shape {
        self.smoothed_within(|n| n.y.abs() > 0.77)
    }

    /// Vertices at one place share a normal only when `group` gives the same answer for their present normals.
    fn smoothed_within(mut self, group: impl Fn(Vec3) -> bool) -> Shape {
        let mut sums = std::collections::BTreeMap::<([u32; 3], bool), Vec3>::new();
        let key = |p: Vec3, n: Vec3| ((p + Vec3::ZERO).to_array().map(f32::to_bits), group(n));
        for t in self.indices.chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| self.positions[i as usize]);
            let face = (b - a).cross(c - a);
            for i in t {
                *sums.entry(key(self.positions[*i as usize], self.normals[*i as usize])).or_default() += face;
            }
        }
        for (p, n) in self.positions.iter().zip(&mut self.normals) {
            *n = sums.get(&key(*p, *n)).copied().unwrap_or(*n).normalize_or(Vec3::Y);
        }
        self
    }
}

/// A grid of `columns + 1` × `rows + 1` vertices. `put(i, j)` gives the position, the normal and the UV of a vertex.
/// Triangles are counter-clockwise for a viewer who sees i grow to the right and j grow upwards. Triangles with two
/// corners at one place are left out.
pub fn grid(columns: usize, rows: usize, mut put: impl FnMut(usize, usize) -> (Vec3, Vec3, Vec2)) -> Shape {
    let mut shape = Shape::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let (p, n, uv) = put(i, j);
            shape.vertex(p, n, uv);
        }
    }
    let at = |i: usize, j: usize| (j * (columns + 1) + i) as u32;
    for j in 0..rows {
        for i in 0..columns {
            for t in [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]] {
                let [a, b, c] = t.map(|k| shape.positions[k as usize]);
                if a != b && b != c && c != a {
                    shape.indices.extend(t);
                }
            }
        }
    }
    shape
}
