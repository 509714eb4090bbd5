//! Shapes of furniture and fittings: tables, chairs, sofas, shelves, lamps, windows, pictures, plants and curtains. The
//! built-in scenes place them.

use glam::{Vec2, Vec3};

use super::builder::{Builder, MaterialId};
use super::noise::unit;
use super::shape::{Shape, grid, sin};
use super::solids::{block, rounded_box, sphere};
use super::surface::{cushion, plate};
use super::sweep::{self, disc, frame, lathe, smooth, smooth3, tapered, tube};
use super::tableware::MeshParts;

/// A table with four tapered legs. The upper face of its top is at `height`.
pub fn table(b: &Builder, top: MaterialId, legs: MaterialId, width: f32, depth: f32, height: f32) -> MeshParts {
    let s = b.segments(4, 1);
    let thick = 0.045;
    let mut frame = Shape::default();
    for (sx, sz) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        let (x, z) = (sx * (width / 2.0 - 0.09), sz * (depth / 2.0 - 0.09));
        let leg = [
            (0.0, 0.0),
            (0.022, 0.0),
            (0.024, 0.01),
            (0.035, height - thick - 0.02),
            (0.035, height - thick - 0.001),
            (0.0, height - thick - 0.001),
        ];
        frame.push(lathe(&leg, b.segments(28, 8)).at(x, 0.0, z));
    }
    let apron = height - thick - 0.08;
    frame.push(block(width - 0.24, 0.078, 0.02, 0.004, s).at(0.0, apron, depth / 2.0 - 0.09));
    frame.push(block(width - 0.24, 0.078, 0.02, 0.004, s).at(0.0, apron, 0.09 - depth / 2.0));
    vec![(top, block(width, thick, depth, 0.012, s).at(0.0, height - thick, 0.0)), (legs, frame)]
}

/// A dining chair that faces +Z, with its seat at 0.46 m.
pub fn chair(b: &Builder, wood: MaterialId, seat: MaterialId) -> MeshParts {
    let n = b.segments(18, 6);
    let mut bars = Shape::default();
    for x in [-0.19f32, 0.19] {
        bars.push(tapered(&[Vec3::new(x, 0.02, 0.19), Vec3::new(x * 0.96, 0.44, 0.18)], |t| 0.014 + 0.006 * t, n));
        let back = [
            Vec3::new(x, 0.02, -0.23),
            Vec3::new(x, 0.45, -0.19),
            Vec3::new(x * 1.02, 0.75, -0.24),
            Vec3::new(x * 1.04, 0.98, -0.3),
        ];
        bars.push(tube(&smooth3(&back, b.segments(6, 2)), 0.016, n));
    }
    for (y, z) in [(0.62, -0.213), (0.76, -0.243), (0.9, -0.275)] {
        bars.push(rounded_box(Vec3::new(0.37, 0.07, 0.018), 0.006, b.segments(3, 1)).at(0.0, y, z));
    }
    bars.push(rounded_box(Vec3::new(0.44, 0.04, 0.42), 0.012, b.segments(3, 1)).at(0.0, 0.425, 0.0));
    vec![(wood, bars), (seat, cushion(0.41, 0.4, 0.06, b.segments(20, 6)).at(0.0, 0.445, 0.0))]
}

/// A sofa for `seats` people that faces +Z, with bulging cushions and round arms.
pub fn sofa(b: &Builder, cloth: MaterialId, pillow: MaterialId, feet: MaterialId, seats: usize) -> MeshParts {
    let s = b.segments(7, 2);
    let seat = 0.66;
    let inner = seats as f32 * seat;
    let mut body = block(inner + 0.36, 0.24, 0.86, 0.05, s).at(0.0, 0.1, 0.0);
    body.push(block(inner + 0.34, 0.56, 0.2, 0.08, s).at(0.0, 0.3, -0.34));
    for side in [-1.0, 1.0] {
        body.push(block(0.19, 0.46, 0.88, 0.085, s).at(side * (inner + 0.19) / 2.0, 0.12, 0.01));
    }
    let (mut soft, mut legs) = (Shape::default(), Shape::default());
    for k in 0..seats {
        let x = (k as f32 + 0.5) * seat - inner / 2.0;
        body.push(rounded_box(Vec3::new(seat - 0.012, 0.17, 0.64), 0.06, s).at(x, 0.42, 0.07));
        body.push(rounded_box(Vec3::new(seat - 0.02, 0.4, 0.17), 0.07, s).turned(Vec3::X, -12.0).at(x, 0.68, -0.2));
        let lean = if k % 2 == 0 { 18.0 } else { -14.0 };
        let pillow = cushion(0.42, 0.42, 0.17, b.segments(28, 8)).turned(Vec3::X, 70.0).turned(Vec3::Z, lean);
        soft.push(pillow.at(x + lean * 0.004, 0.7, -0.02));
    }
    for (x, z) in [(-1.0, -0.36), (1.0, -0.36), (-1.0, 0.36), (1.0, 0.36)] {
        legs.push(disc(0.025, 0.1, b.segments(20, 8)).at(x * inner / 2.0, 0.0, z));
    }
    vec![(cloth, body), (pillow, soft), (feet, legs)]
}

/// An open shelf whose back is towards −Z: boards at distances of `height / boards` between two sides.
pub fn shelf(b: &Builder, wood: MaterialId, width: f32, depth: f32, height: f32, boards: usize) -> MeshParts {
    let s = b.segments(3, 1);
    let mut shape = Shape::default();
    for side in [-1.0, 1.0] {
        shape.push(block(0.03, height, depth, 0.004, s).at(side * (width - 0.03) / 2.0, 0.0, 0.0));
    }
    for k in 0..=boards {
        let y = k as f32 / boards as f32 * (height - 0.032) + 0.001;
        shape.push(block(width - 0.062, 0.028, depth - 0.012, 0.003, s).at(0.0, y, 0.0));
    }
    shape.push(block(width - 0.064, height - 0.01, 0.008, 0.001, 1).at(0.0, 0.005, 0.006 - depth / 2.0));
    vec![(wood, shape)]
}

/// A floor lamp: a foot, a pole, and a shade that glows.
pub fn floor_lamp(b: &Builder, metal: MaterialId, shade: MaterialId, height: f32) -> MeshParts {
    let n = b.segments(48, 10);
    let mut stand = disc(0.15, 0.025, n);
    stand.push(tube(&[Vec3::new(0.0, 0.024, 0.0), Vec3::new(0.0, height, 0.0)], 0.011, b.segments(14, 6)));
    let (h, t) = (height, 0.006);
    let wall = [(0.21, h - 0.26), (0.16, h), (0.16 - t, h), (0.21 - t, h - 0.26), (0.21, h - 0.26)];
    vec![(metal, stand), (shade, lathe(&wall, n))]
}

/// A lamp that hangs below (0, 0, 0): a cord, a dome and a bulb.
pub fn pendant(b: &Builder, metal: MaterialId, bulb: MaterialId, cord: f32, radius: f32) -> MeshParts {
    let n = b.segments(56, 10);
    let r = radius;
    let mut dome = smooth(&[(r, 0.0), (r * 0.92, r * 0.35), (r * 0.5, r * 0.75), (0.03, r * 0.85)], b.segments(8, 2));
    dome.push((0.0, r * 0.86));
    let mut inner: Vec<(f32, f32)> = dome.iter().rev().map(|p| ((p.0 - 0.006).max(0.0), p.1 - 0.006)).collect();
    inner.push((r, 0.0));
    // The profile runs up the outside, then down the inside back to the rim, so that the wall is closed.
    dome.extend(inner.into_iter().skip(1));
    let mut shape = lathe(&dome, n).at(0.0, -cord - r, 0.0);
    shape.push(tube(&[Vec3::new(0.0, -cord - r * 0.2, 0.0), Vec3::ZERO], 0.006, 6));
    vec![(metal, shape), (bulb, sphere(r * 0.33, b.segments(32, 8)).at(0.0, -cord - r * 0.8, 0.0))]
}

/// A window in the xy-plane, centred on the origin and facing +Z: glowing panes behind bars.
pub fn window(
    b: &Builder,
    bars: MaterialId,
    pane: MaterialId,
    width: f32,
    height: f32,
    panes: (usize, usize),
) -> MeshParts {
    let s = b.segments(3, 1);
    let mut shape = frame(width, height, 0.07, 0.1, s);
    for i in 1..panes.0 {
        let x = (i as f32 / panes.0 as f32 - 0.5) * width;
        shape.push(rounded_box(Vec3::new(0.035, height - 0.004, 0.05), 0.006, s).at(x, 0.0, 0.0));
    }
    for j in 1..panes.1 {
        let y = (j as f32 / panes.1 as f32 - 0.5) * height;
        shape.push(rounded_box(Vec3::new(width - 0.004, 0.03, 0.044), 0.006, s).at(0.0, y, 0.0));
    }
    shape.push(block(width + 0.2, 0.035, 0.22, 0.01, s).at(0.0, -height / 2.0 - 0.11, 0.06));
    vec![
        (bars, shape),
        (pane, rounded_box(Vec3::new(width + 0.02, height + 0.02, 0.01), 0.001, 1).at(0.0, 0.0, -0.045)),
    ]
}

/// A wall across the x axis, from the floor to `height`. `openings` are the z coordinates of the middles of its
/// windows.
pub fn wall_with_windows(
    x: f32,
    height: f32,
    (first, last): (f32, f32),
    openings: &[f32],
    (width, bottom, top): (f32, f32, f32),
) -> Shape {
    let piece = |low: f32, high: f32, from: f32, to: f32| {
        let middle = Vec3::new(x, (low + high) / 2.0, (from + to) / 2.0);
        slab(Vec3::new(0.2, high - low, to - from), middle)
    };
    let mut wall = piece(0.0, bottom, first, last);
    wall.push(piece(top, height, first, last));
    let mut from = first;
    // The piers reach a little into the strips above and below: a mesh whose edges coincide would not count as closed.
    let (low, high) = (bottom - 0.01, top + 0.01);
    for middle in openings {
        wall.push(piece(low, high, from, middle - width / 2.0));
        from = middle + width / 2.0;
    }
    wall.push(piece(low, high, from, last));
    wall
}

/// A framed picture in the xy-plane, facing +Z. Its canvas has UVs from 0 to 1.
pub fn picture(b: &Builder, moulding: MaterialId, canvas: MaterialId, width: f32, height: f32) -> MeshParts {
    let bars = frame(width, height, 0.05, 0.045, b.segments(4, 1)).at(0.0, 0.0, 0.022);
    let front = rounded_box(Vec3::new(width + 0.01, height + 0.01, 0.016), 0.001, 1);
    vec![(moulding, bars), (canvas, front.uv_scaled(1.0 / (width + 0.01), 1.0 / (height + 0.01)).at(0.0, 0.0, 0.014))]
}

/// A pot with arching leaves. Each leaf is a thin closed lens.
pub fn plant(b: &Builder, pot: MaterialId, leaf: MaterialId, height: f32, leaves: usize, seed: u32) -> MeshParts {
    let r = height * 0.16;
    let n = b.segments(40, 10);
    let profile = [
        (0.0, 0.0),
        (r * 0.72, 0.0),
        (r * 0.76, 0.01),
        (r, r * 1.5),
        (r * 0.92, r * 1.5),
        (r * 0.9, r * 1.3),
        (0.0, r * 1.3),
    ];
    let mut green = Shape::default();
    for k in 0..leaves {
        let u = |i| unit(k as i32, i, seed);
        let (reach, rise) = (height * (0.25 + 0.3 * u(0)), height * (0.45 + 0.5 * u(1)));
        let (steps, across) = (b.segments(14, 4), 2 * b.segments(3, 1));
        let width = height * (0.035 + 0.02 * u(2));
        let blade = |side: f32| {
            grid(across, steps, |i, j| {
                let i = if side < 0.0 { i } else { across - i };
                let (s, t) = (i as f32 / across as f32 * 2.0 - 1.0, j as f32 / steps as f32);
                let spread = if j == 0 || j == steps { 0.0 } else { width * sin(t * std::f32::consts::PI) };
                // Both sheets of a leaf share their rim, so the leaf has no thickness there.
                let thick = if i == 0 || i == across { 0.0 } else { side * 0.0025 };
                let out = Vec3::new(
                    s * spread,
                    rise * t - 0.35 * rise * t * t * t + thick,
                    reach * t * (0.4 + 0.6 * t) + 0.02,
                );
                (out, Vec3::Y * side, Vec2::new(s * 0.5 + 0.5, t))
            })
        };
        let mut lens = blade(-1.0).smoothed();
        lens.push(blade(1.0).smoothed());
        green.push(lens.turned(Vec3::Y, k as f32 * 137.5 + 30.0 * u(3)).at(0.0, r * 1.3, 0.0));
    }
    vec![(pot, lathe(&profile, n)), (leaf, green)]
}

/// A folded curtain in the xy-plane that hangs from `height` to the floor and faces +Z.
pub fn curtain(b: &Builder, width: f32, height: f32, folds: f32) -> Shape {
    let wave = move |x: f32, z: f32| {
        0.05 * sin(x / width * folds * std::f32::consts::TAU) * (0.7 + 0.3 * sin(z * 1.7 + x * 3.0))
    };
    let cells = (b.segments(220, 30), b.segments(16, 3));
    plate(width, height, cells, wave, move |x, z| wave(x, z) - 0.006).turned(Vec3::X, 90.0).at(0.0, height / 2.0, 0.0)
}

/// A rug that lies on the floor. Its pile is slightly uneven; its UVs run from 0 to 1.
pub fn rug(b: &Builder, width: f32, depth: f32) -> Shape {
    let cells = (b.segments(60, 8), b.segments(40, 6));
    let height = |x: f32, z: f32| 0.014 + 0.002 * sin(x * 23.0) * sin(z * 19.0);
    plate(width, depth, cells, height, |_, _| 0.0).uv_scaled(1.0 / width, 1.0 / depth)
}

/// A plain closed slab for floors, walls and ceilings, of this size, centred on `middle`.
pub fn slab(size: Vec3, middle: Vec3) -> Shape {
    rounded_box(size, 0.004, 1).at(middle.x, middle.y, middle.z)
}

/// A turned foot, as of a table lamp or a stool, standing on y = 0.
pub fn turned_foot(b: &Builder, height: f32, radius: f32) -> Shape {
    let (h, r) = (height, radius);
    let points = [
        (0.0, 0.0),
        (r, 0.0),
        (r * 0.95, h * 0.06),
        (r * 0.35, h * 0.15),
        (r * 0.5, h * 0.4),
        (r * 0.25, h * 0.6),
        (r * 0.3, h * 0.9),
        (r * 0.7, h * 0.97),
        (0.0, h),
    ];
    sweep::lathe(&smooth(&points, b.segments(6, 2)), b.segments(56, 10))
}
