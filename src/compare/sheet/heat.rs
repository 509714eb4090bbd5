//! The colours in which sheets show the difference between the eyes.

use super::canvas::Color;

/// The Weber contrast at the upper end of the scale.
pub const FULL: f32 = 0.5;

/// The colour of pixels of the left eye that have no partner.
pub const NO_PARTNER: Color = [208, 210, 214];

/// Samples of matplotlib's `inferno` at equal distances (CC0, N. Smith and S. van der Walt). Equal steps of contrast
/// are equal steps of lightness, also for colour-blind readers.
const INFERNO: [[f32; 3]; 9] = [
    [0.0, 0.0, 4.0],
    [31.0, 12.0, 72.0],
    [85.0, 15.0, 109.0],
    [136.0, 34.0, 106.0],
    [186.0, 54.0, 85.0],
    [227.0, 89.0, 51.0],
    [249.0, 140.0, 10.0],
    [249.0, 201.0, 50.0],
    [252.0, 255.0, 164.0],
];

/// The colour of a Weber contrast. [`FULL`] and more have the brightest.
pub fn color(contrast: f32) -> Color {
    let at = (contrast / FULL).clamp(0.0, 1.0) * (INFERNO.len() - 1) as f32;
    let low = (at as usize).min(INFERNO.len() - 2);
    let share = at - low as f32;
    [0, 1, 2].map(|c| (INFERNO[low][c] + (INFERNO[low + 1][c] - INFERNO[low][c]) * share).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_contrast_is_lighter() {
        let light = |c: f32| crate::metrics::luminance(color(c).map(f32::from));
        let steps: Vec<f64> = (0..=50).map(|i| light(FULL * i as f32 / 50.0)).collect();
        assert!(steps.windows(2).all(|w| w[0] < w[1]), "{steps:?}");
        assert_eq!(color(2.0), color(FULL));
    }
}
