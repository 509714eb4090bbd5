//! One eye's picture against its reference, in every measure at once.

use serde::Serialize;

use super::error::mean_square;
use super::{Flip, Ssim, errors, tone};

/// A reference made ready for many pictures.
pub struct Judge {
    /// Linear radiance.
    reference: Vec<[f32; 3]>,
    /// The same as a display shows it.
    shown: Vec<[f32; 3]>,
    /// Pixels that count.
    mask: Vec<bool>,
    exposure: f32,
    /// `None`: too small for its window.
    ssim: Option<Ssim>,
    flip: Flip,
}

/// How a picture compares. What is undefined is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Scores {
    /// See [`super::Errors`]: linear radiance over the mask.
    pub mse: f64,
    pub rse: Option<f64>,
    pub relmse: Option<f64>,
    /// Mean of (x − y)² of the display values in [0, 1], tone-mapped with the reference's exposure; over the mask.
    pub tonemapped_mse: f64,
    /// Tone-mapped with the reference's exposure; over windows whose centre the mask holds.
    pub ssim: Option<f64>,
    /// Tone-mapped likewise; over the mask.
    pub flip: Option<f64>,
}

impl Judge {
    /// `reference` is linear radiance of `width`×`height` pixels.
    pub fn new(
        (width, height): (usize, usize),
        reference: &[[f32; 3]],
        mask: Vec<bool>,
        exposure: f32,
        pixels_per_degree: f32,
    ) -> Judge {
        let shown = tone::displayed(reference, exposure);
        let ssim = Ssim::new(width, height, &shown);
        let flip = Flip::new(width, height, &shown, pixels_per_degree);
        Judge { reference: reference.to_vec(), shown, mask, exposure, ssim, flip }
    }

    /// `None`: no pixel counts.
    ///
    /// # Panics
    /// When the sizes differ.
    pub fn of(&self, picture: &[[f32; 3]]) -> Option<Scores> {
        self.of_displayed(picture, &self.displayed(picture))
    }

    /// Display values of a picture with the reference's exposure.
    pub fn displayed(&self, picture: &[[f32; 3]]) -> Vec<[f32; 3]> {
        tone::displayed(picture, self.exposure)
    }

    /// Display values of the reference.
    pub fn reference_displayed(&self) -> &[[f32; 3]] {
        &self.shown
    }

    /// [`Judge::of`] a picture whose display values, `shown`, are known already.
    ///
    /// # Panics
    /// When the sizes differ.
    pub fn of_displayed(&self, picture: &[[f32; 3]], shown: &[[f32; 3]]) -> Option<Scores> {
        let errors = errors(picture, &self.reference, &self.mask)?;
        Some(Scores {
            mse: errors.mse,
            rse: errors.rse,
            relmse: errors.relmse,
            tonemapped_mse: mean_square(shown, &self.shown, &self.mask)?,
            ssim: self.ssim.as_ref().and_then(|s| s.over(shown, &self.mask)),
            flip: self.flip.over(shown, &self.mask),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tone_mapped_error_is_that_of_what_a_display_shows() {
        // At exposure 2 the greys 0.25 and 0.05 are shown as 0.5 and 0.1: 0.04 less, then sRGB. The last pixel is
        // masked out.
        let (y, x) = ([[0.25; 3], [0.05; 3], [9.0; 3]], [[0.05; 3], [0.05; 3], [0.0; 3]]);
        let judge = Judge::new((3, 1), &y, vec![true, true, false], 2.0, 67.0);
        let srgb = |c: f64| 1.055 * c.powf(1.0 / 2.4) - 0.055;
        let expected = (srgb(0.46) - srgb(0.06)).powi(2) / 2.0;
        let found = judge.of(&x).expect("a mask");
        assert!((found.tonemapped_mse - expected).abs() < 1e-6, "{found:?}, not {expected}");
        assert_eq!(judge.of(&y).expect("a mask").tonemapped_mse, 0.0);
    }
}
