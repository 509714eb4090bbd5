//! The analytic sky of a manifest: a gradient from horizon to zenith, haze around the sun, and the ground below. It
//! becomes a radiance map and, for the sun, a light.
//!
//! Above the horizon, with h = d.y, c = max(d · sun, 0):
//! L = horizon + (zenith − horizon)·(1 − (1 − h)⁴) + glow·(c¹⁶/2 + c²⁵⁶)·(1 − h/2).
//! Below, the horizon's colour runs into the ground within about six degrees (a smooth step over
//! −0.1 < h < 0). The sun itself is not in the map: a half-degree disc thousands of times brighter
//! than the sky is hit by few rays, and each of those is a firefly in every estimator. It is handed
//! out as a directional light instead, whose highlight is evaluated in closed form.

use glam::{DVec3, Vec3};

use crate::scene::manifest::SkySpec;
use crate::scene::{Equirect, Light, LightSource};

/// The radiance map of the sky. No feature is finer than the haze, so 256 × 128 texels are enough.
pub fn radiance(sky: &SkySpec) -> Equirect {
    let [zenith, horizon, ground, glow] = [sky.zenith, sky.horizon, sky.ground, sky.glow].map(Vec3::from_array);
    let sun = sun_direction(sky).as_vec3();
    Equirect::from_fn(256, 128, |d| {
        let h = d.y.max(0.0);
        let toward = d.dot(sun).max(0.0);
        let haze = (toward.powi(16) * 0.5 + toward.powi(256)) * (1.0 - 0.5 * h);
        let sky = horizon.lerp(zenith, 1.0 - (1.0 - h).powi(4)) + glow * haze;
        let t = (-d.y / 0.1).clamp(0.0, 1.0);
        sky.lerp(ground, t * t * (3.0 - 2.0 * t))
    })
}

/// The sun as a light; `None` when it is below the horizon or black.
pub fn sun(sky: &SkySpec) -> Option<Light> {
    let toward = sun_direction(sky);
    let irradiance = Vec3::from_array(sky.sun_irradiance);
    (toward.y > 0.0 && irradiance.max_element() > 0.0).then(|| Light {
        size: (0.5 * sky.sun_angle_deg).to_radians() as f32,
        ..LightSource::Directional { direction: -toward.as_vec3(), irradiance }.into()
    })
}

fn sun_direction(sky: &SkySpec) -> DVec3 {
    let (elevation, azimuth) = (sky.sun_elevation_deg.to_radians(), sky.sun_azimuth_deg.to_radians());
    DVec3::new(elevation.cos() * azimuth.sin(), elevation.sin(), -elevation.cos() * azimuth.cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sky_is_moderate_and_the_sun_shines_down() {
        let sky = SkySpec::default();
        let map = radiance(&sky);
        assert!(map.texels.iter().flatten().all(|c| (0.0..4.0).contains(c)));
        assert!(
            matches!(sun(&sky), Some(Light { source: LightSource::Directional { direction, .. }, .. }) if direction.y < 0.0)
        );
        assert!(sun(&SkySpec { sun_elevation_deg: -5.0, ..sky }).is_none());
    }
}
