//! Smaller versions (mip levels) of a picture, averaged in linear light: averages of sRGB values would darken every
//! edge.

use std::sync::OnceLock;

/// A picture of RGBA bytes (sRGB, opaque or premultiplied), rows from the top, with all of its levels down to one
/// texel.
pub(super) fn chain(width: u32, height: u32, texels: Vec<u8>) -> Vec<Vec<u8>> {
    assert_eq!(texels.len(), (width * height * 4) as usize, "RGBA of {width}×{height}");
    let (mut width, mut height) = (width as usize, height as usize);
    let mut levels = vec![texels];
    while width > 1 || height > 1 {
        let (w, h) = ((width / 2).max(1), (height / 2).max(1));
        let above = &levels[levels.len() - 1];
        let mut level = Vec::with_capacity(w * h * 4);
        for y in 0..h {
            // The last row or column of an odd size counts for the last texel.
            let rows = y * height / h..((y + 1) * height / h).max(y * height / h + 1);
            for x in 0..w {
                let columns = x * width / w..((x + 1) * width / w).max(x * width / w + 1);
                let mut sum = [0.0f32; 4];
                for row in rows.clone() {
                    for column in columns.clone() {
                        let at = (row * width + column) * 4;
                        for c in 0..3 {
                            sum[c] += linear()[above[at + c] as usize];
                        }
                        sum[3] += f32::from(above[at + 3]);
                    }
                }
                let n = (rows.len() * columns.len()) as f32;
                level.extend(sum[..3].iter().map(|s| encode(s / n)));
                level.push((sum[3] / n).round() as u8);
            }
        }
        levels.push(level);
        (width, height) = (w, h);
    }
    levels
}

/// The number of levels that [`chain`] returns.
pub(super) fn count(width: u32, height: u32) -> u32 {
    32 - width.max(height).leading_zeros()
}

/// The linear value of each byte (IEC 61966-2-1).
fn linear() -> &'static [f32; 256] {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| {
        std::array::from_fn(|byte| {
            let v = byte as f32 / 255.0;
            if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        })
    })
}

/// The byte whose linear value is nearest.
fn encode(value: f32) -> u8 {
    let table = linear();
    let above = table.partition_point(|v| *v < value).min(255);
    let below = above.saturating_sub(1);
    if value - table[below] < table[above] - value { below as u8 } else { above as u8 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_picture_stays_as_it_is_and_black_and_white_meet_at_half_the_light() {
        for byte in [0u8, 1, 17, 128, 254, 255] {
            let levels = chain(6, 5, [byte, byte, byte, 255].repeat(30));
            assert_eq!(levels.len() as u32, count(6, 5));
            assert!(levels.iter().all(|l| l.chunks(4).all(|t| t == [byte, byte, byte, 255])));
            assert_eq!(levels.last().map(Vec::len), Some(4));
        }
        let levels = chain(2, 1, vec![0, 0, 0, 255, 255, 255, 255, 255]);
        // Linear 0.5 is sRGB 188.
        assert_eq!(levels[1], [188, 188, 188, 255]);
        assert_eq!((count(1, 1), count(2, 1), count(1920, 1080), count(2048, 3)), (1, 2, 11, 12));
    }
}
