//! The settings of ambient occlusion.

use std::ops::RangeInclusive;

use crate::method::Ao;

/// How the ambient light of a picture is occluded.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct AoSettings {
    pub method: Ao,
    /// Matter farther away than this hides nothing, metres; see [`AoSettings::RADII_M`].
    pub radius_m: f32,
    /// The least difference between the eyes, relative to the pixel's own value, at which the adaptive methods process a pixel
    /// further; see [`AoSettings::THRESHOLDS`].
    pub threshold: f32,
    /// Rays for each pixel, with `ray-traced` only.
    pub rays: u32,
}

impl AoSettings {
    /// The valid radii. A smaller one is below the resolution of depth and normals; a larger one would reach beyond any scene.
    pub const RADII_M: RangeInclusive<f32> = 1e-3..=1e3;
    /// The valid thresholds. With 0, every pixel is processed whose eyes differ at all.
    pub const THRESHOLDS: RangeInclusive<f32> = 0.0..=1.0;

    /// Whether nothing is occluded. The other settings then have no effect.
    pub fn is_off(&self) -> bool {
        self.method == Ao::None
    }
}

impl Default for AoSettings {
    fn default() -> AoSettings {
        AoSettings { method: Ao::None, radius_m: 0.5, threshold: 0.02, rays: 256 }
    }
}
