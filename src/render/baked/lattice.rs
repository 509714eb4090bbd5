//! The points at which baked light is kept: a lattice on every triangle (after Yuksel et al., "Mesh Colors", 2010). Each triangle
//! has its own points, so that no light leaks through a wall or around a corner, and no texture coordinates are needed.

use glam::{DVec3, Vec3};

use crate::scene::Scene;

/// The largest number of intervals along a triangle's side, which takes six bits of a patch's word.
const MOST_INTERVALS: u32 = 63;
/// Flag in a patch's word: a second lattice follows, for the triangle's back.
const BACK: u32 = 1 << 25;
/// The largest index of a patch's first point, which takes the lower bits of its word.
const MOST_POINTS: usize = (1 << 25) - 1;

/// A point of a lattice.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Relative to the head, metres.
    pub position: Vec3,
    /// The mesh's interpolated normal on the lit side, unit length.
    pub normal: Vec3,
    /// The position moved a little towards the triangle's centre, where rays start: a point in a room's corner would lie inside
    /// the next wall.
    pub inner: Vec3,
    pub instance: u32,
}

/// The lattices of a scene.
#[derive(Debug)]
pub struct Lattice {
    /// First one word for each instance, the index of its first patch. Then the patches, one word for each triangle: its first
    /// point | [`BACK`] | intervals << 26.
    pub patches: Vec<u32>,
    pub points: Vec<Point>,
}

/// Area of all surfaces, square metres.
pub fn area(scene: &Scene) -> f64 {
    let mut sum = 0.0;
    each_triangle(scene, |_, corners, _| {
        sum += 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
    });
    sum
}

impl Lattice {
    /// A lattice relative to `head` with about `spacing` metres between points; `None` if it has more points than a patch's word
    /// can refer to.
    pub fn new(scene: &Scene, head: DVec3, spacing: f64) -> Option<Lattice> {
        let mut patches = vec![0; scene.instances.len()];
        let mut points = Vec::new();
        let mut fits = true;
        each_triangle(scene, |number, corners, normals| {
            if patches[number] == 0 {
                patches[number] = patches.len() as u32;
            }
            let edges = [corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]];
            let longest = edges.iter().map(|e| e.length()).fold(0.0, f64::max);
            let wide = edges[0].cross(edges[2]).length().sqrt();
            // By the geometric mean of the longest side and √(2 · area), so that slivers get fewer points than their length asks
            // for.
            let intervals = ((longest * wide).sqrt() / spacing).ceil().clamp(1.0, f64::from(MOST_INTERVALS)) as u32;
            let material = &scene.materials[scene.primitives[scene.instances[number].primitive].material];
            let sides: &[f32] = if material.double_sided { &[1.0, -1.0] } else { &[1.0] };
            if points.len() > MOST_POINTS {
                fits = false;
                return;
            }
            patches.push(points.len() as u32 | if sides.len() == 2 { BACK } else { 0 } | intervals << 26);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            for side in sides {
                for j in 0..=intervals {
                    for i in 0..=intervals - j {
                        let (u, v) = (f64::from(i) / f64::from(intervals), f64::from(j) / f64::from(intervals));
                        let w = 1.0 - u - v;
                        let at = corners[0] * w + corners[1] * u + corners[2] * v;
                        let inward = middle - at;
                        let step = (0.15 * spacing / inward.length().max(1e-30)).min(0.2);
                        let normal = (normals[0] * w as f32 + normals[1] * u as f32 + normals[2] * v as f32) * *side;
                        points.push(Point {
                            position: (at - head).as_vec3(),
                            normal: normal.normalize_or(Vec3::Y),
                            inner: (at + inward * step - head).as_vec3(),
                            instance: number as u32,
                        });
                    }
                }
            }
        });
        fits.then_some(Lattice { patches, points })
    }
}

/// Calls `see` for every triangle of every instance, with the instance's index and the triangle's corners and vertex normals in
/// world space.
fn each_triangle(scene: &Scene, mut see: impl FnMut(usize, [DVec3; 3], [Vec3; 3])) {
    for (number, instance) in scene.instances.iter().enumerate() {
        let primitive = &scene.primitives[instance.primitive];
        let to_normal = instance.world_from_object.matrix3.inverse().transpose();
        let place = |i: u32| instance.world_from_object.transform_point3(primitive.positions[i as usize].as_dvec3());
        let turn = |i: u32| {
            let n = to_normal * primitive.normals[i as usize].as_dvec3();
            n.normalize_or(DVec3::Y).as_vec3()
        };
        for k in primitive.indices.chunks_exact(3) {
            let k = [k[0], k[1], k[2]];
            see(number, k.map(place), k.map(turn));
        }
    }
}
