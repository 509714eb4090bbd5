//! One eye's picture against its reference, in every measure at once.

use serde::Serialize;

use super::{Flip, Ssim, errors, tone};

/// A reference made ready for many pictures.
pub struct Judge {
    reference: Vec<[f32; 3]>,
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
        Judge { reference: reference.to_vec(), mask, exposure, ssim, flip }
    }

    /// `None`: no pixel counts.
    ///
    /// # Panics
    /// When the sizes differ.
    pub fn of(&self, picture: &[[f32; 3]]) -> Option<Scores> {
        let errors = errors(picture, &self.reference, &self.mask)?;
        let shown = tone::displayed(picture, self.exposure);
        Some(Scores {
            mse: errors.mse,
            rse: errors.rse,
            relmse: errors.relmse,
            ssim: self.ssim.as_ref().and_then(|s| s.over(&shown, &self.mask)),
            flip: self.flip.over(&shown, &self.mask),
        })
    }
}
