//! Options of ambient occlusion, for the commands that render.

use super::WrongUsage;
use crate::render::{Ao, AoSettings};

/// How far ambient occlusion looks, and how it decides; docs/rendering.md defines all of these numbers.
#[derive(Debug, Clone, clap::Args)]
pub struct AoArgs {
    /// Radius of ambient occlusion: what is farther away hides no ambient light; metres, 0.001 to 1000.
    #[arg(long, value_name = "METRES", default_value_t = AoSettings::default().radius_m)]
    ao_radius: f32,
    /// For variant1 and variant2, the difference between the eyes from which they work on a pixel, as a share of its
    /// value, 0 to 1.
    #[arg(long, value_name = "SHARE", default_value_t = AoSettings::default().threshold)]
    ao_threshold: f32,
    /// Rays per pixel of ray-traced ambient occlusion.
    #[arg(long, value_name = "N", default_value_t = AoSettings::default().rays,
          value_parser = clap::value_parser!(u32).range(1..=65536))]
    ao_rays: u32,
}

impl AoArgs {
    /// The settings of ambient occlusion by a method.
    ///
    /// # Errors
    /// [`WrongUsage`] when a number lies outside its range.
    pub fn settings(&self, method: Ao) -> Result<AoSettings, WrongUsage> {
        let (radii, shares) = (AoSettings::RADII_M, AoSettings::THRESHOLDS);
        if !radii.contains(&self.ao_radius) {
            let (radius, least, most) = (self.ao_radius, radii.start(), radii.end());
            return Err(WrongUsage(format!("--ao-radius {radius} is outside {least} to {most} metres")));
        }
        if !shares.contains(&self.ao_threshold) {
            let (share, least, most) = (self.ao_threshold, shares.start(), shares.end());
            return Err(WrongUsage(format!("--ao-threshold {share} is outside {least} to {most}")));
        }
        Ok(AoSettings { method, radius_m: self.ao_radius, threshold: self.ao_threshold, rays: self.ao_rays })
    }
}
