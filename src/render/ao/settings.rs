//! How far ambient occlusion looks.

use std::ops::RangeInclusive;

use crate::method::Ao;

/// Ambient occlusion of a picture.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct AoSettings {
    pub method: Ao,
    /// What is farther away hides nothing, metres; see [`AoSettings::RADII_M`].
    pub radius_m: f32,
    /// Difference between the eyes, relative to the pixel's own value, from which on the adaptive methods work on it.
    pub threshold: f32,
    /// A pixel's rays, of `ray-traced` alone.
    pub rays: u32,
}

impl AoSettings {
    /// Below, a radius lies under what depth and normals resolve; above, nothing of a scene is out of reach.
    pub const RADII_M: RangeInclusive<f32> = 1e-3..=1e3;
    /// Weber shares that mean something: 0 works on every pixel whose eyes differ at all.
    pub const THRESHOLDS: RangeInclusive<f32> = 0.0..=1.0;

    /// Nothing is occluded: the picture is what it is without these settings.
    pub fn is_off(&self) -> bool {
        self.method == Ao::None
    }
}

impl Default for AoSettings {
    fn default() -> AoSettings {
        AoSettings { method: Ao::None, radius_m: 0.5, threshold: 0.02, rays: 256 }
    }
}
