//! Shapes of things that stand on tables and shelves: glasses, bottles, plates, mugs, books, candles, fruit. The
//! built-in scenes place them.

use glam::{Vec2, Vec3};

use super::builder::{Builder, MaterialId};
use super::shape::{Shape, cos, sin};
use super::solids::{block, sphere};
use super::sweep::{disc, lathe, prism, smooth, tapered, tube};

/// The parts of a mesh, each with its material.
pub type MeshParts = Vec<(MaterialId, Shape)>;

/// A stemmed glass with a closed wall 3 mm thick. `height` and `bowl`, the largest radius, are in metres.
pub fn wine_glass(b: &Builder, height: f32, bowl: f32) -> Shape {
    let (h, r) = (height, bowl);
    let outer = smooth(
        &[
            (0.006, h * 0.06),
            (0.005, h * 0.25),
            (0.006, h * 0.42),
            (r * 0.7, h * 0.52),
            (r, h * 0.68),
            (r * 0.93, h * 0.85),
            (r * 0.78, h),
        ],
        b.segments(8, 2),
    );
    let inner: Vec<(f32, f32)> =
        outer.iter().rev().filter(|p| p.1 > h * 0.47).map(|p| ((p.0 - 0.003).max(0.0), p.1 + 0.0005)).collect();
    let mut profile = vec![(0.0, 0.0), (r * 0.85, 0.0), (r * 0.86, 0.002), (r * 0.5, 0.006), (0.012, h * 0.03)];
    profile.extend(outer);
    profile.extend(inner);
    profile.push((0.0, h * 0.47));
    lathe(&profile, b.segments(56, 10))
}

/// A tumbler, or a mug without its handle. Its wall is `wall` metres thick.
pub fn cup(b: &Builder, radius: f32, height: f32, wall: f32) -> Shape {
    let (r, h, e) = (radius, height, wall * 0.45);
    let profile = [
        (0.0, 0.0),
        (r * 0.86, 0.0),
        (r * 0.93, h * 0.03),
        (r, h * 0.15),
        (r, h - e),
        (r - e, h),
        (r - wall + e, h),
        (r - wall, h - e),
        (r - wall, h * 0.15),
        (r * 0.8, h * 0.08),
        (0.0, h * 0.07),
    ];
    lathe(&profile, b.segments(48, 10))
}

/// A mug with a handle towards +X. It is 1.15 diameters high.
pub fn mug(b: &Builder, radius: f32) -> Shape {
    let h = radius * 2.3;
    let mut shape = cup(b, radius, h, radius * 0.12);
    let arc: Vec<Vec3> = (0..=b.segments(14, 5))
        .map(|i| {
            let t = i as f32 / b.segments(14, 5) as f32 * std::f32::consts::PI;
            Vec3::new(radius * 0.96 + sin(t) * radius * 0.62, h * 0.5 + cos(t) * h * 0.3, 0.0)
        })
        .collect();
    shape.push(tube(&arc, radius * 0.11, b.segments(12, 5)));
    shape
}

/// A bottle with its label and its cap. `shoulder` goes from 0, a slope, to 1, a step.
pub fn bottle(
    b: &Builder,
    glass: MaterialId,
    label: MaterialId,
    cap: MaterialId,
    height: f32,
    shoulder: f32,
) -> MeshParts {
    let (h, r) = (height, height * 0.125);
    let s = 0.58 + 0.06 * shoulder;
    let profile = smooth(
        &[
            (0.0, 0.004),
            (r * 0.9, 0.0),
            (r, h * 0.03),
            (r, h * 0.3),
            (r, h * s),
            (r * (0.55 + 0.3 * shoulder), h * 0.68),
            (r * 0.36, h * 0.76),
            (r * 0.34, h * 0.93),
            (r * 0.42, h * 0.94),
            (r * 0.42, h * 0.97),
            (0.0, h * 0.972),
        ],
        b.segments(6, 2),
    );
    let n = b.segments(48, 10);
    let l = r * 1.012;
    let band = [(0.0, h * 0.16), (l, h * 0.16), (l, h * 0.42), (0.0, h * 0.42)];
    vec![
        (glass, lathe(&profile, n)),
        (label, lathe(&band, n)),
        (cap, disc(r * 0.47, h * 0.09, n / 2 + 4).at(0.0, h * 0.915, 0.0)),
    ]
}

/// A plate with a raised rim.
pub fn plate(b: &Builder, radius: f32) -> Shape {
    let r = radius;
    let mut profile = smooth(
        &[(0.0, 0.0), (r * 0.55, 0.0), (r * 0.68, r * 0.04), (r * 0.98, r * 0.12), (r, r * 0.135)],
        b.segments(6, 2),
    );
    let top =
        smooth(&[(r * 0.97, r * 0.14), (r * 0.68, r * 0.07), (r * 0.55, r * 0.03), (0.0, r * 0.03)], b.segments(6, 2));
    profile.extend(top);
    lathe(&profile, b.segments(64, 12))
}

/// A bowl.
pub fn bowl(b: &Builder, radius: f32) -> Shape {
    let r = radius;
    let mut profile =
        smooth(&[(0.0, 0.0), (r * 0.4, 0.0), (r * 0.5, r * 0.06), (r * 0.9, r * 0.4), (r, r * 0.62)], b.segments(8, 2));
    profile.extend(smooth(
        &[(r * 0.96, r * 0.63), (r * 0.85, r * 0.42), (r * 0.4, r * 0.1), (0.0, r * 0.08)],
        b.segments(8, 2),
    ));
    lathe(&profile, b.segments(64, 12))
}

/// A closed vase; `kind` chooses one of four silhouettes.
pub fn vase(b: &Builder, kind: usize, height: f32) -> Shape {
    let forms: [[f32; 7]; 4] = [
        [0.16, 0.22, 0.30, 0.26, 0.13, 0.10, 0.15],
        [0.12, 0.14, 0.20, 0.28, 0.30, 0.20, 0.22],
        [0.20, 0.24, 0.20, 0.14, 0.10, 0.09, 0.12],
        [0.10, 0.20, 0.28, 0.30, 0.28, 0.20, 0.10],
    ];
    let form = forms[kind % 4];
    let mut points = vec![(0.0, 0.0)];
    points.extend(form.iter().enumerate().map(|(i, r)| (r * height, i as f32 / 6.0 * height)));
    let mut profile = smooth(&points, b.segments(8, 2));
    profile.extend([
        (form[6] * height * 0.8, height * 0.995),
        (form[6] * height * 0.6, height * 0.8),
        (0.0, height * 0.78),
    ]);
    lathe(&profile, b.segments(72, 12))
}

/// A book that lies flat: a cover with a rounded spine, and the pages.
pub fn book(b: &Builder, cover: MaterialId, pages: MaterialId, size: Vec3) -> MeshParts {
    let s = b.segments(3, 1);
    let board = size.y * 0.12;
    let mut covers = block(size.x, board, size.z, board * 0.4, s);
    covers.push(block(size.x, board, size.z, board * 0.4, s).at(0.0, size.y - board, 0.0));
    covers.push(block(board, size.y * 0.98, size.z * 0.998, board * 0.4, s).at(
        -size.x / 2.0 + board * 0.45,
        size.y * 0.01,
        0.0,
    ));
    let leaves =
        block(size.x * 0.93, size.y - 2.0 * board - 0.0006, size.z * 0.95, 0.001, 1).at(0.0, board + 0.0003, 0.0);
    vec![(cover, covers), (pages, leaves)]
}

/// Upright books of varying sizes in a row of `length` along +X, with their spines towards +Z. They take the covers in
/// turn.
pub fn book_row(
    b: &Builder,
    covers: &[MaterialId],
    pages: MaterialId,
    length: f32,
    height: f32,
    seed: u32,
) -> MeshParts {
    let mut parts = MeshParts::new();
    let (mut x, mut i) = (0.0, 0);
    while x < length - 0.05 {
        let u = |k| super::noise::unit(i, k, seed);
        let (thick, tall, deep) = (0.018 + 0.03 * u(0), height * (0.72 + 0.26 * u(1)), 0.16 + 0.05 * u(2));
        let cover = covers[(u(3) * covers.len() as f32) as usize % covers.len()];
        for (material, shape) in book(b, cover, pages, Vec3::new(deep, thick, tall)) {
            // The spine (−X) is turned to the front, and the book's height upwards.
            let upright = shape.turned(Vec3::X, 90.0).turned(Vec3::Y, 90.0).at(x + thick, tall / 2.0, -deep / 2.0);
            parts.push((material, upright));
        }
        x += thick + 0.003;
        i += 1;
    }
    parts
}

/// A candle with its flame.
pub fn candle(b: &Builder, wax: MaterialId, flame: MaterialId, radius: f32, height: f32) -> MeshParts {
    let n = b.segments(32, 8);
    vec![
        (wax, disc(radius, height, n)),
        (flame, sphere(radius * 0.38, n / 2 + 4).scaled(1.0, 2.6, 1.0).at(0.0, height + radius * 1.1, 0.0)),
    ]
}

/// An apple; its stem is part of the shape.
pub fn apple(b: &Builder, radius: f32) -> Shape {
    let r = radius;
    let profile = smooth(
        &[
            (0.0, r * 0.12),
            (r * 0.35, 0.0),
            (r * 0.85, r * 0.45),
            (r, r * 1.0),
            (r * 0.85, r * 1.5),
            (r * 0.4, r * 1.72),
            (0.0, r * 1.5),
        ],
        b.segments(6, 2),
    );
    let mut shape = lathe(&profile, b.segments(40, 10));
    shape.push(tube(&[Vec3::new(0.0, r * 1.45, 0.0), Vec3::new(r * 0.1, r * 1.95, 0.0)], r * 0.05, 6));
    shape
}

/// A pencil along +Y: a hexagonal body, a wooden cone and the lead.
pub fn pencil(b: &Builder, body: MaterialId, wood: MaterialId, length: f32) -> MeshParts {
    let r = 0.0045 * length / 0.18;
    let hexagon: Vec<Vec2> = (0..6)
        .map(|k| {
            Vec2::new(cos(k as f32 * std::f32::consts::FRAC_PI_3), sin(k as f32 * std::f32::consts::FRAC_PI_3)) * r
        })
        .collect();
    let tip =
        lathe(&[(0.0, length * 0.88), (r * 0.86, length * 0.881), (r * 0.1, length), (0.0, length)], b.segments(16, 6));
    vec![(body, prism(&hexagon, length * 0.88)), (wood, tip)]
}

/// A piece of cutlery that lies flat along −Z; `kind` chooses a knife, a fork or a spoon.
pub fn cutlery(b: &Builder, kind: usize) -> Shape {
    let n = b.segments(12, 5);
    let handle = [Vec3::new(0.0, 0.006, 0.1), Vec3::new(0.0, 0.005, 0.0), Vec3::new(0.0, 0.006, -0.04)];
    let mut shape = tapered(&handle, |t| 0.006 - 0.003 * t, n);
    match kind % 3 {
        0 => {
            shape.push(sphere(0.022, b.segments(24, 8)).scaled(0.8, 0.25, 1.4).at(0.0, 0.007, -0.065));
        }
        1 => {
            for k in 0..4 {
                let x = (k as f32 - 1.5) * 0.007;
                let tine = [Vec3::new(0.0, 0.006, -0.036), Vec3::new(x, 0.005, -0.055), Vec3::new(x, 0.008, -0.1)];
                shape.push(tube(&tine, 0.0022, n));
            }
        }
        _ => {
            shape.push(block(0.018, 0.003, 0.12, 0.0012, 2).at(0.002, 0.004, -0.095));
        }
    }
    shape
}
