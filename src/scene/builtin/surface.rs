//! Closed height fields: cushions, cloth, rugs, ground.

use glam::{Vec2, Vec3};

use super::shape::{Shape, grid};

/// A closed plate of `width` × `depth`. Its top is at `height(x, z)` and its bottom at `bottom(x, z)`, with x and z in
/// metres from its middle; a rim joins the two. UVs are in metres.
pub fn plate(
    width: f32,
    depth: f32,
    cells: (usize, usize),
    height: impl Fn(f32, f32) -> f32,
    bottom: impl Fn(f32, f32) -> f32,
) -> Shape {
    let (columns, rows) = (cells.0.max(1), cells.1.max(1));
    let x = |i: usize| (i as f32 / columns as f32 - 0.5) * width;
    let z = |j: usize| (0.5 - j as f32 / rows as f32) * depth;
    let uv = |i: usize, j: usize| Vec2::new(i as f32 / columns as f32 * width, (1.0 - j as f32 / rows as f32) * depth);
    let mut top = grid(columns, rows, |i, j| (Vec3::new(x(i), height(x(i), z(j)), z(j)), Vec3::Y, uv(i, j)));
    let under = grid(columns, rows, |i, j| {
        let i = columns - i;
        (Vec3::new(x(i), bottom(x(i), z(j)), z(j)), Vec3::NEG_Y, uv(i, j))
    });
    let mut rim = Shape::default();
    let mut side = |from: (usize, usize), to: (usize, usize), normal: Vec3| {
        let corner = |(i, j): (usize, usize), up: bool| {
            let y = if up { height(x(i), z(j)) } else { bottom(x(i), z(j)) };
            (Vec3::new(x(i), y, z(j)), uv(i, j) + Vec2::splat(if up { 0.0 } else { 0.01 }))
        };
        let [a, b, c, d] = [(from, false), (to, false), (to, true), (from, true)].map(|(at, up)| {
            let (p, uv) = corner(at, up);
            rim.vertex(p, normal, uv)
        });
        rim.quad(a, b, c, d);
    };
    for i in 0..columns {
        side((i, 0), (i + 1, 0), Vec3::Z);
        side((i + 1, rows), (i, rows), Vec3::NEG_Z);
    }
    for j in 0..rows {
        side((columns, j), (columns, j + 1), Vec3::X);
        side((0, j + 1), (0, j), Vec3::NEG_X);
    }
    // Normals are smooth within the top and within the bottom; the rim keeps its own.
    top = top.smoothed();
    let mut shape = under.smoothed();
    shape.push(top);
    shape.push(rim);
    shape
}

/// A pillow: two bulging sheets that meet at a seam.
pub fn cushion(width: f32, depth: f32, thickness: f32, cells: usize) -> Shape {
    let bulge = move |x: f32, z: f32| {
        let (u, v) = (2.0 * x / width, 2.0 * z / depth);
        let edge = ((1.0 - u * u).max(0.0) * (1.0 - v * v).max(0.0)).sqrt();
        thickness * (0.06 + 0.44 * edge.sqrt())
    };
    plate(width, depth, (cells, cells), bulge, move |x, z| -bulge(x, z)).at(0.0, thickness * 0.5, 0.0)
}
