//! Compares one eye's picture with its reference in all measures at once. `compare` and the command that compares two
//! pictures make a [`Judge`] of a reference and ask it about pictures.

use serde::Serialize;

use super::error::mean_square;
use super::{Flip, Ssim, errors, tone};

/// A reference that is prepared once, for comparison with many pictures.
pub struct Judge {
    /// Linear radiance.
    reference: Vec<[f32; 3]>,
    /// The reference's display values.
    shown: Vec<[f32; 3]>,
    /// Pixels that count.
    mask: Vec<bool>,
    exposure: f32,
    /// `None`: the picture is smaller than the window of SSIM.
    ssim: Option<Ssim>,
    flip: Flip,
}

/// The measures of one picture. A measure that is undefined is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Scores {
    /// The errors in linear radiance over the mask; see [`super::Errors`].
    pub mse: f64,
    pub rse: Option<f64>,
    pub relmse: Option<f64>,
    /// The mean over the mask of (x − y)² of display values in [0, 1], tone-mapped with the reference's exposure.
    pub tonemapped_mse: f64,
    /// SSIM of the same display values, over the windows whose centre is in the mask.
    pub ssim: Option<f64>,
    /// FLIP of the same display values, over the mask.
    pub flip: Option<f64>,
}

impl Judge {
    /// Prepares a reference, which is linear radiance of `width`×`height` pixels.
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

    /// The measures of a picture in linear radiance. `None`: no pixel counts.
    ///
    /// # Panics
    /// When the sizes differ.
    pub fn of(&self, picture: &[[f32; 3]]) -> Option<Scores> {
        self.of_displayed(picture, &self.displayed(picture))
    }

    /// The display values of a picture, with the reference's exposure.
    pub fn displayed(&self, picture: &[[f32; 3]]) -> Vec<[f32; 3]> {
        tone::displayed(picture, self.exposure)
    }

    /// The display values of the reference.
    pub fn reference_displayed(&self) -> &[[f32; 3]] {
        &self.shown
    }

    /// The same as [`Judge::of`] for a picture whose display values, `shown`, are already known.
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
        // At exposure 2 the greys 0.25 and 0.05 become 0.5 and 0.1. The tone map takes 0.04 off, then they are encoded
        // as sRGB. The last pixel is masked out.
        let (y, x) = ([[0.25; 3], [0.05; 3], [9.0; 3]], [[0.05; 3], [0.05; 3], [0.0; 3]]);
        let judge = Judge::new((3, 1), &y, vec![true, true, false], 2.0, 67.0);
        let srgb = |c: f64| 1.055 * c.powf(1.0 / 2.4) - 0.055;
        let expected = (srgb(0.46) - srgb(0.06)).powi(2) / 2.0;
        let found = judge.of(&x).expect("a mask");
        assert!((found.tonemapped_mse - expected).abs() < 1e-6, "{found:?}, not {expected}");
        assert_eq!(judge.of(&y).expect("a mask").tonemapped_mse, 0.0);
    }
}
