//! Turns linear radiance into the values that a display is given: exposure, the Khronos PBR Neutral tone map, and the
//! sRGB encoding. Measures of what a display shows begin with it. It does the same as `shaders/composite.comp` except
//! that it does not round to eight bits.

/// The sRGB values, in [0, 1], of linear Rec. 709 radiance.
///
/// Callers use the reference's exposure for every picture that they compare with it.
pub fn display(linear: [f32; 3], exposure: f32) -> [f32; 3] {
    neutral(linear.map(|c| c * exposure)).map(srgb)
}

/// Applies [`display`] to every pixel of a picture.
pub fn displayed(picture: &[[f32; 3]], exposure: f32) -> Vec<[f32; 3]> {
    picture.iter().map(|&c| display(c, exposure)).collect()
}

/// The Khronos PBR Neutral tone map. It takes a small offset off, which removes the reflection at normal incidence, and
/// compresses only colours whose largest channel is then at least `START`.
fn neutral(color: [f32; 3]) -> [f32; 3] {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let least = color[0].min(color[1]).min(color[2]);
    let offset = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let color = color.map(|c| c - offset);
    let peak = color[0].max(color[1]).max(color[2]);
    if peak < START {
        return color;
    }
    let d = 1.0 - START;
    let new_peak = 1.0 - d * d / (peak + d - START);
    let g = 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    color.map(|c| c * new_peak / peak * g + new_peak * (1.0 - g))
}

fn srgb(c: f32) -> f32 {
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_grey_and_light_beyond_white() {
        assert_eq!(display([0.0; 3], 1.0), [0.0; 3]);
        // A grey above 0.08 loses the offset of 0.04: 0.5 becomes 0.46, which is 0.708 in sRGB.
        assert!((display([0.5; 3], 1.0)[0] - 0.7088).abs() < 1e-3);
        assert_eq!(display([0.25; 3], 2.0), display([0.5; 3], 1.0));
        for strong in [1.0, 10.0, 1e4] {
            let [r, g, b] = display([strong, 0.1, 0.1], 1.0);
            assert!(r <= 1.0 && r > g && (g - b).abs() < 1e-6, "{r} {g} {b}");
        }
    }
}
