//! Closed solids: boxes with rounded edges, spheres, tori.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::shape::{Shape, cos, grid, sin};

/// A box of the full size `size` about the origin, with edges rounded by `radius` in `steps` steps.
///
/// A point of a rounded corner depends only on its place on the cube, so neighbouring faces meet exactly.
pub fn rounded_box(size: Vec3, radius: f32, steps: usize) -> Shape {
    let steps = steps.max(1);
    let radius = radius.min(size.min_element() * 0.499);
    let inner = size / 2.0 - Vec3::splat(radius);
    // Along an axis: the place on the rounded corner (−1…0, then 0…1), and the side of the flat part that it belongs
    // to.
    let line = |k: usize| -> (f32, f32) {
        if k <= steps { (k as f32 / steps as f32 - 1.0, -1.0) } else { ((k - steps - 1) as f32 / steps as f32, 1.0) }
    };
    let point = |corner: Vec3, side: Vec3| {
        // The tangent spreads the steps evenly over the arc of the corner.
        let direction = corner.map(|w| libm::tan(f64::from(w) * std::f64::consts::FRAC_PI_4) as f32).normalize();
        (inner * side + direction * radius, direction)
    };
    let mut shape = Shape::default();
    let lines = 2 * steps + 1;
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0f32)] {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        shape.push(grid(lines, lines, |i, j| {
            let i = if sign > 0.0 { i } else { lines - i };
            let ((wa, sa), (wb, sb)) = (line(i), line(j));
            let (mut corner, mut side) = (Vec3::ZERO, Vec3::ZERO);
            (corner[axis], side[axis]) = (sign, sign);
            (corner[a], side[a]) = (wa, sa);
            (corner[b], side[b]) = (wb, sb);
            let (p, n) = point(corner, side);
            // u runs horizontally and v downwards, in metres from the face's corner.
            let uv = match axis {
                0 => Vec2::new(-sign * p.z + size.z / 2.0, size.y / 2.0 - p.y),
                1 => Vec2::new(p.x + size.x / 2.0, sign * p.z + size.z / 2.0),
                _ => Vec2::new(sign * p.x + size.x / 2.0, size.y / 2.0 - p.y),
            };
            (p, n, uv)
        }));
    }
    shape
}

/// [`rounded_box`] that stands on y = 0.
pub fn block(x: f32, y: f32, z: f32, radius: f32, steps: usize) -> Shape {
    rounded_box(Vec3::new(x, y, z), radius, steps).at(0.0, y / 2.0, 0.0)
}

/// A sphere about the origin, with `segments` segments around it and half as many from pole to pole.
pub fn sphere(radius: f32, segments: usize) -> Shape {
    let around = segments.max(6);
    let rows = (around / 2).max(3);
    grid(around, rows, |i, j| {
        let phi = (i % around) as f32 / around as f32 * TAU;
        let ring = if j == 0 || j == rows { 0.0 } else { sin(j as f32 / rows as f32 * PI) };
        let height = if j == 0 {
            -1.0
        } else if j == rows {
            1.0
        } else {
            -cos(j as f32 / rows as f32 * PI)
        };
        let n = Vec3::new(ring * sin(phi), height, ring * cos(phi));
        (n * radius, n, Vec2::new(i as f32 / around as f32, 1.0 - j as f32 / rows as f32))
    })
}

/// A ring that lies in the xz-plane. `radius` is measured to the middle of the tube, whose own radius is `tube`.
pub fn torus(radius: f32, tube: f32, around: usize, across: usize) -> Shape {
    let (around, across) = (around.max(8), across.max(5));
    grid(around, across, |i, j| {
        let (u, v) = ((i % around) as f32 / around as f32 * TAU, (j % across) as f32 / across as f32 * TAU);
        let out = Vec3::new(sin(u), 0.0, cos(u));
        let n = out * cos(v) + Vec3::Y * sin(v);
        (out * radius + n * tube, n, Vec2::new(i as f32 / around as f32, j as f32 / across as f32))
    })
}
