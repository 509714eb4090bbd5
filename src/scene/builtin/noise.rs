//! Seamless noise from integer hashes, for the patterns and the placement of the built-in scenes. It is the same on
//! every machine.

/// A well-mixed 32-bit hash of up to three integers.
pub fn hash(x: i32, y: i32, seed: u32) -> u32 {
    let mut h =
        (x as u32).wrapping_mul(0x9E37_79B1) ^ (y as u32).wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    h = (h ^ (h >> 16)).wrapping_mul(0x7FEB_352D);
    h = (h ^ (h >> 15)).wrapping_mul(0x846C_A68B);
    h ^ (h >> 16)
}

/// [`hash`] as a number in 0–1.
pub fn unit(x: i32, y: i32, seed: u32) -> f32 {
    (hash(x, y, seed) >> 8) as f32 / 16_777_216.0
}

/// Value noise in 0–1 over u and v. It repeats after 1 and has `cells` cells along each of them.
pub fn value(u: f32, v: f32, cells: (i32, i32), seed: u32) -> f32 {
    let (x, y) = (u * cells.0 as f32, v * cells.1 as f32);
    let (x0, y0) = (x.floor(), y.floor());
    let ease = |t: f32| t * t * (3.0 - 2.0 * t);
    let (fx, fy) = (ease(x - x0), ease(y - y0));
    let at = |i: i32, j: i32| unit((x0 as i32 + i).rem_euclid(cells.0), (y0 as i32 + j).rem_euclid(cells.1), seed);
    let top = at(0, 0) + (at(1, 0) - at(0, 0)) * fx;
    let bottom = at(0, 1) + (at(1, 1) - at(0, 1)) * fx;
    top + (bottom - top) * fy
}

/// Sum of octaves of [`value`], each twice as fine and half as strong as the one before; in 0–1.
pub fn fractal(u: f32, v: f32, cells: (i32, i32), octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut weight, mut total) = (0.0, 0.5, 0.0);
    for k in 0..octaves {
        sum += weight * value(u, v, (cells.0 << k, cells.1 << k), seed.wrapping_add(k));
        total += weight;
        weight *= 0.5;
    }
    sum / total
}
