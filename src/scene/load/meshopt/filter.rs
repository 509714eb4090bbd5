//! The filters of the meshopt extensions: they undo what was done to attributes before these were compressed.

use crate::scene::error::Reason;

/// Applies the filter of this name, in place, to elements of `stride` bytes.
pub fn apply(name: &str, stride: usize, elements: &mut [u8]) -> Result<(), Reason> {
    let fits = match name {
        "NONE" => return Ok(()),
        "OCTAHEDRAL" | "COLOR" => stride == 4 || stride == 8,
        "QUATERNION" => stride == 8,
        "EXPONENTIAL" => true,
        _ => return Err(format!("filter `{name}` is unknown")),
    };
    if !fits {
        return Err(format!("filter {name} does not take a byteStride of {stride}"));
    }
    for element in elements.chunks_exact_mut(stride) {
        match (name, stride) {
            ("OCTAHEDRAL", 4) => put_i8(element, octahedral(get_i8(element), 127.0)),
            ("OCTAHEDRAL", _) => put_i16(element, octahedral(get_i16(element), 32767.0)),
            ("COLOR", 4) => put_u8(element, color(get_i8(element), 8)),
            ("COLOR", _) => put_u16(element, color(get_i16(element), 16)),
            ("QUATERNION", _) => put_i16(element, quaternion(get_i16(element))),
            _ => element.chunks_exact_mut(4).for_each(exponential),
        }
    }
    Ok(())
}

/// A unit vector from x and y on an octahedron whose size is `one`. The fourth component is kept.
fn octahedral([x, y, one, w]: [i32; 4], most: f32) -> [f32; 4] {
    let (mut x, mut y) = (x as f32 / one as f32, y as f32 / one as f32);
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    x -= if x >= 0.0 { fold } else { -fold };
    y -= if y >= 0.0 { fold } else { -fold };
    let scale = most / (x * x + y * y + z * z).sqrt();
    [x * scale, y * scale, z * scale, w as f32]
}

/// A quaternion from three components, scaled by the fourth. The fourth's two lowest bits say which component was left
/// out.
fn quaternion(given: [i32; 4]) -> [f32; 4] {
    let largest = (given[3] & 3) as usize;
    let scale = std::f32::consts::FRAC_1_SQRT_2 / (given[3] | 3) as f32;
    let [x, y, z] = [given[0], given[1], given[2]].map(|c| c as f32 * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut out = [0.0; 4];
    for (k, value) in [w, x, y, z].into_iter().enumerate() {
        out[(largest + k) % 4] = value * 32767.0;
    }
    out
}

/// RGBA from YCoCg. The highest set bit of alpha gives the scale. Luminance and alpha are unsigned.
fn color([y, orange, green, alpha]: [i32; 4], bits: u32) -> [f32; 4] {
    let mask = (1u32 << bits) - 1;
    let (y, alpha) = ((y as u32 & mask) as i32, alpha as u32 & mask);
    let full = 1u32.checked_shl(32 - alpha.leading_zeros()).map_or(0, |top| top - 1);
    let rgb = [y + orange - green, y + green, y - orange - green];
    let low = alpha & (full >> 1);
    let alpha = (low << 1 | low & 1) as i32;
    let scale = mask as f32 / full as f32;
    [rgb[0], rgb[1], rgb[2], alpha].map(|c| c as f32 * scale)
}

/// An f32 from a signed 24-bit mantissa and a signed 8-bit exponent of two.
fn exponential(word: &mut [u8]) {
    let value = i32::from_le_bytes([word[0], word[1], word[2], word[3]]);
    let (exponent, mantissa) = (value >> 24, value << 8 >> 8);
    let power = f32::from_bits(((exponent + 127) as u32) << 23);
    word.copy_from_slice(&(power * mantissa as f32).to_le_bytes());
}

fn get_i8(e: &[u8]) -> [i32; 4] {
    [0, 1, 2, 3].map(|k| i32::from(e[k] as i8))
}

fn get_i16(e: &[u8]) -> [i32; 4] {
    [0, 2, 4, 6].map(|k| i32::from(i16::from_le_bytes([e[k], e[k + 1]])))
}

// Casts from floats to integers saturate and turn NaN into 0, whatever numbers hostile bytes lead to.

fn put_i8(e: &mut [u8], v: [f32; 4]) {
    (0..4).for_each(|k| e[k] = v[k].round() as i8 as u8);
}

fn put_u8(e: &mut [u8], v: [f32; 4]) {
    (0..4).for_each(|k| e[k] = v[k].round() as u8);
}

fn put_i16(e: &mut [u8], v: [f32; 4]) {
    (0..4).for_each(|k| e[2 * k..2 * k + 2].copy_from_slice(&(v[k].round() as i16).to_le_bytes()));
}

fn put_u16(e: &mut [u8], v: [f32; 4]) {
    (0..4).for_each(|k| e[2 * k..2 * k + 2].copy_from_slice(&(v[k].round() as u16).to_le_bytes()));
}
