//! Twin of `shaders/common/baked.glsl`: baked light, interpolated linearly between the points of a triangle's lattice.

use glam::{Vec2, Vec3A};

use super::super::baked::HostBakedLight;
use super::super::bvh::EXCHANGED;
use super::world::World;

/// Row j of a lattice of n intervals a side holds n + 1 − j points.
fn lattice_point(n: u32, i: u32, j: u32) -> u32 {
    j * (n + 1) - (j * j - j) / 2 + i
}

/// Irradiance / π at a point of a triangle; `back`: the triangle is seen from its back.
pub fn baked_light(gathered: &HostBakedLight, world: &World, triangle: u32, uv: Vec2, back: bool) -> Vec3A {
    let t = &world.triangles[triangle as usize];
    let uv = if t.first_index & EXCHANGED != 0 { Vec2::new(uv.y, uv.x) } else { uv };
    let instance = &world.instances[t.instance as usize];
    let patches = &gathered.patches;
    let patch = patches[t.instance as usize] + ((t.first_index & !EXCHANGED) - instance.first_index) / 3;
    let word = patches[patch as usize];
    let (n, mut base) = (word >> 26, word & 0x1ff_ffff);
    if back && word >> 25 & 1 != 0 {
        base += (n + 1) * (n + 2) / 2;
    }
    let p = uv.clamp(Vec2::ZERO, Vec2::ONE) * n as f32;
    let i = (p.x as u32).min(n - 1);
    let j = (p.y as u32).min(n - 1 - i);
    let f = (p - Vec2::new(i as f32, j as f32)).clamp(Vec2::ZERO, Vec2::ONE);
    let at = |i, j| {
        let [r, g, b, _] = gathered.light[(base + lattice_point(n, i, j)) as usize];
        Vec3A::new(r, g, b)
    };
    let (right, up) = (at(i + 1, j), at(i, j + 1));
    if f.x + f.y > 1.0 && i + j + 2 <= n {
        let far = at(i + 1, j + 1);
        return far * (f.x + f.y - 1.0) + right * (1.0 - f.y) + up * (1.0 - f.x);
    }
    let sum = (f.x + f.y).max(1.0);
    at(i, j) * (1.0 - (f.x + f.y) / sum) + (right * f.x + up * f.y) / sum
}
