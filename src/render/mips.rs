//! Makes mip chains by averaging in linear light, for uploaded textures and for the textures that rays hit.

/// All levels down to 1×1, each four bytes a texel; the RGB of `srgb` textures is averaged linearly.
pub fn mip_chain(rgba8: &[u8], width: u32, height: u32, srgb: bool) -> Vec<Vec<u8>> {
    let decode = decode_table(srgb);
    let mut levels = vec![rgba8.to_vec()];
    let (mut w, mut h) = (width as usize, height as usize);
    while w > 1 || h > 1 {
        let last = levels.last().map(Vec::as_slice).unwrap_or_default();
        let (nw, nh) = ((w / 2).max(1), (h / 2).max(1));
        let mut next = Vec::with_capacity(nw * nh * 4);
        for y in 0..nh {
            // Where a size is odd, the last row or column of the finer level is dropped, as is usual for mip chains.
            let rows = [(2 * y).min(h - 1), (2 * y + 1).min(h - 1)];
            for x in 0..nw {
                let columns = [(2 * x).min(w - 1), (2 * x + 1).min(w - 1)];
                for c in 0..4 {
                    let mut sum = 0.0f32;
                    for row in rows {
                        for column in columns {
                            let byte = last[(row * w + column) * 4 + c];
                            sum += if c < 3 { decode[usize::from(byte)] } else { f32::from(byte) / 255.0 };
                        }
                    }
                    next.push(encode(sum * 0.25, srgb && c < 3));
                }
            }
        }
        levels.push(next);
        (w, h) = (nw, nh);
    }
    levels
}

fn decode_table(srgb: bool) -> [f32; 256] {
    std::array::from_fn(|i| {
        let x = i as f32 / 255.0;
        match (srgb, x <= 0.04045) {
            (false, _) => x,
            (true, true) => x / 12.92,
            (true, false) => ((x + 0.055) / 1.055).powf(2.4),
        }
    })
}

fn encode(x: f32, srgb: bool) -> u8 {
    let x = match (srgb, x <= 0.003_130_8) {
        (false, _) => x,
        (true, true) => 12.92 * x,
        (true, false) => 1.055 * x.powf(1.0 / 2.4) - 0.055,
    };
    (x * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_ends_in_one_texel_and_keeps_a_constant() {
        let levels = mip_chain(&[100, 150, 200, 255].repeat(7 * 3), 7, 3, true);
        assert_eq!(levels.iter().map(Vec::len).collect::<Vec<_>>(), [84, 12, 4]);
        assert_eq!(levels[2], [100, 150, 200, 255]);
    }

    #[test]
    fn srgb_is_averaged_in_linear_light() {
        let levels = mip_chain(&[0, 0, 0, 0, 255, 255, 255, 255], 2, 1, true);
        // Half the light is 188 of 255 in sRGB; alpha is linear.
        assert_eq!(levels[1], [188, 188, 188, 128]);
    }
}
