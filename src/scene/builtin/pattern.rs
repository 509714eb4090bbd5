//! Seamless patterns over u and v in 0–1 for the textures of the built-in scenes: wood, stone, tiles, cloth, books,
//! pictures. Colours are in linear light.

use std::sync::LazyLock;

use glam::Vec3;

use super::noise::{fractal, unit, value};

/// Linear values of the 256 sRGB bytes. They are tabulated because patterns ask for colours at every texel.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|c| {
        let x = c as f64 / 255.0;
        (if x <= 0.040_45 { x / 12.92 } else { libm::pow((x + 0.055) / 1.055, 2.4) }) as f32
    })
});

/// Linear colour of sRGB values, 0–255.
pub fn rgb(r: u8, g: u8, b: u8) -> [f32; 3] {
    [r, g, b].map(|c| LINEAR[usize::from(c)])
}

fn smooth(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The cell of u and v among `n` cells, and how far they lie inside it along each direction (0 at its edge, up to ½).
/// Every other row is shifted by `shift` cells.
fn cell(u: f32, v: f32, n: (i32, i32), shift: f32) -> (i32, i32, f32, f32) {
    let y = v * n.1 as f32;
    let row = y.floor() as i32;
    let x = u * n.0 as f32 + if row.rem_euclid(2) == 1 { shift } else { 0.0 };
    let column = x.floor() as i32;
    let edge = |t: f32| 0.5 - (t - t.floor() - 0.5).abs();
    (column.rem_euclid(n.0), row.rem_euclid(n.1), edge(x), edge(y))
}

/// Boards along u, `boards` of them across v, each with a shade of its own. `light` and `dark` are the colours of the
/// wood; the seams are dark.
pub fn planks(u: f32, v: f32, boards: i32, light: [f32; 3], dark: [f32; 3]) -> Vec3 {
    let (column, row, ex, ey) = cell(u, v, (2, boards), 0.37);
    let shade = unit(column, row, 11);
    let grain = fractal(u, v + shade * 3.0, (3, 96), 3, 5 + row as u32);
    let rings = fractal(u, v, (4, 24), 2, 31 + row as u32);
    let t = (0.25 + 0.35 * shade + 0.35 * grain + 0.25 * (rings - 0.5)).clamp(0.0, 1.0);
    let color = Vec3::from_array(dark).lerp(Vec3::from_array(light), t);
    color * (0.35 + 0.65 * smooth(0.0, 0.03, ey) * smooth(0.0, 0.004, ex))
}

/// Height of [`planks`]: 1 on a board and 0 in a seam.
pub fn plank_height(u: f32, v: f32, boards: i32) -> f32 {
    let (_, row, ex, ey) = cell(u, v, (2, boards), 0.37);
    smooth(0.0, 0.04, ey) * smooth(0.0, 0.006, ex) + 0.06 * fractal(u, v, (4, 96), 2, 5 + row as u32)
}

/// A slab whose grain runs along u without seams.
pub fn grain(u: f32, v: f32, light: [f32; 3], dark: [f32; 3]) -> Vec3 {
    let warp = fractal(u, v, (3, 5), 3, 77) * 0.25;
    let rings = value((u + warp) * 0.5, v + warp * 0.3, (2, 40), 3);
    let fibre = fractal(u, v, (6, 128), 2, 9);
    Vec3::from_array(dark).lerp(Vec3::from_array(light), (0.55 * rings + 0.45 * fibre).clamp(0.0, 1.0))
}

/// Clouds with thin veins.
pub fn marble(u: f32, v: f32, base: [f32; 3], vein: [f32; 3], seed: u32) -> Vec3 {
    let clouds = fractal(u, v, (4, 4), 5, seed);
    let ridge = 1.0 - (2.0 * fractal(u, v, (3, 3), 6, seed + 50) - 1.0).abs();
    let veins = smooth(0.93, 1.0, ridge) * 0.9 + smooth(0.75, 1.0, ridge) * 0.25;
    let base = Vec3::from_array(base) * (0.82 + 0.3 * clouds);
    base.lerp(Vec3::from_array(vein), veins.min(1.0))
}

/// Squares of two colours.
pub fn checker(u: f32, v: f32, n: i32, a: [f32; 3], b: [f32; 3]) -> Vec3 {
    let (i, j, ex, ey) = cell(u, v, (n, n), 0.0);
    let color = Vec3::from_array(if (i + j) % 2 == 0 { a } else { b });
    let cloud = 0.85 + 0.3 * fractal(u, v, (8, 8), 4, (i * 7 + j) as u32);
    color * cloud * (0.5 + 0.5 * smooth(0.0, 0.012, ex.min(ey)))
}

/// Stone tiles with joints, each tile with a shade of its own.
pub fn tiles(u: f32, v: f32, n: (i32, i32), stone: [f32; 3], joint: [f32; 3], shift: f32) -> Vec3 {
    let (i, j, ex, ey) = cell(u, v, n, shift);
    let shade = 0.7 + 0.5 * unit(i, j, 21);
    let rough = 0.8 + 0.4 * fractal(u, v, (16, 16), 4, 60);
    let color = Vec3::from_array(stone) * shade * rough;
    Vec3::from_array(joint).lerp(color, smooth(0.015, 0.04, ex.min(ey)))
}

/// Height of [`tiles`]: 0 in the joints and 1 on the tiles.
pub fn tile_height(u: f32, v: f32, n: (i32, i32), shift: f32) -> f32 {
    let (_, _, ex, ey) = cell(u, v, n, shift);
    smooth(0.01, 0.05, ex.min(ey)) + 0.08 * fractal(u, v, (24, 24), 3, 61)
}

/// Woven threads of two colours that pass over and under each other.
pub fn weave(u: f32, v: f32, threads: i32, warp: [f32; 3], weft: [f32; 3]) -> Vec3 {
    let (i, j, ex, ey) = cell(u, v, (threads, threads), 0.0);
    let over = (i + j) % 2 == 0;
    let round = if over { smooth(0.0, 0.35, ex) } else { smooth(0.0, 0.35, ey) };
    let color = Vec3::from_array(if over { warp } else { weft });
    color * (0.55 + 0.45 * round) * (0.85 + 0.3 * fractal(u, v, (16, 16), 3, 41))
}

/// A rug: border, medallions and stripes from three colours.
pub fn rug(u: f32, v: f32, ground: [f32; 3], figure: [f32; 3], line: [f32; 3]) -> Vec3 {
    let [ground, figure, line] = [ground, figure, line].map(Vec3::from_array);
    let edge = u.min(1.0 - u).min(v.min(1.0 - v));
    let pile = 0.75 + 0.5 * value(u, v, (256, 256), 8);
    let fold = |x: f32, n: f32| (x * n - (x * n).floor() - 0.5).abs();
    let diamond = fold(u, 6.0) + fold(v, 6.0);
    let small = fold(u, 24.0) + fold(v, 24.0);
    let lined = edge < 0.02 || (0.09..0.105).contains(&edge);
    let color = if lined {
        line
    } else if edge < 0.09 {
        if small < 0.32 { line } else { figure }
    } else if diamond < 0.16 || (diamond - 0.62).abs() < 0.03 {
        line
    } else if diamond < 0.34 {
        figure
    } else {
        ground
    };
    color * pile
}

/// An abstract picture of a horizon, blocks and strokes, which the seed chooses.
pub fn painting(u: f32, v: f32, seed: u32) -> Vec3 {
    let hue = |k: i32| Vec3::new(unit(k, 0, seed), unit(k, 1, seed), unit(k, 2, seed)) * 0.8 + 0.05;
    let wave = 0.35 + 0.3 * unit(0, 9, seed) + 0.12 * (value(u, 0.5, (5, 1), seed) - 0.5);
    let mut color =
        if v < wave { hue(1).lerp(hue(2), v / wave) } else { hue(3).lerp(hue(4), (v - wave) / (1.0 - wave)) };
    for k in 0..7 {
        let (cx, cy) = (unit(k, 3, seed), unit(k, 4, seed));
        let r = 0.05 + 0.14 * unit(k, 5, seed);
        let d = ((u - cx) * (u - cx) + (v - cy) * (v - cy)).sqrt();
        let inside = if k % 2 == 0 { d < r } else { (u - cx).abs() < r && (v - cy).abs() < r * 0.6 };
        if inside {
            color = hue(10 + k);
        }
    }
    let grey = Vec3::splat(color.dot(Vec3::new(0.21, 0.72, 0.07)));
    color.lerp(grey, 0.45) * (0.8 + 0.4 * fractal(u, v, (24, 8), 3, seed))
}

/// Roughness factor of a polished but used surface: mostly 1, and lower or higher in smears and fine scratches.
pub fn wear(u: f32, v: f32, strength: f32, seed: u32) -> f32 {
    let smear = fractal(u, v, (5, 5), 4, seed);
    let mut scratch: f32 = 0.0;
    for k in 0..24 {
        let (x, y) = (unit(k, 1, seed), unit(k, 2, seed));
        let (dx, dy) = (unit(k, 3, seed) - 0.5, unit(k, 4, seed) - 0.5);
        let length = (dx * dx + dy * dy).sqrt().max(0.05);
        let (px, py) = (u - x, v - y);
        let (along, across) = (px * dx + py * dy, (px * dy - py * dx).abs());
        if across < 0.0012 * length && along.abs() < length * length * 0.5 {
            scratch = 1.0;
        }
    }
    (1.0 - strength * (0.65 - smear).max(0.0) * 1.2 + 0.1 * strength * scratch).clamp(0.05, 1.0)
}

/// Height of hammered or beaded metal.
pub fn beads(u: f32, v: f32, n: i32) -> f32 {
    let (_, _, ex, ey) = cell(u, v, (n, n), 0.5);
    let (x, y) = (0.5 - ex, 0.5 - ey);
    (1.0 - 4.0 * (x * x + y * y)).max(0.0).sqrt()
}
