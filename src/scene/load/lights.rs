//! The lights of a manifest, and what a manifest adds to the lights of its glTF. Called by the loader.

use glam::Vec3;

use super::assemble::{check_color, finite};
use super::document::Document;
use crate::scene::error::Reason;
use crate::scene::manifest::{EnvironmentSpec, FileLightSpec, LightSpec, Manifest};
use crate::scene::{Light, LightSource};

/// The manifest's own lights, checked. The lights of the glTF get what the manifest says about them.
pub fn of_manifest(manifest: &Manifest, document: &mut Document) -> Result<Vec<Light>, Reason> {
    shape_those_of_file(document, &manifest.file_lights)?;
    if let Some(EnvironmentSpec::Sky(sky)) = &manifest.environment {
        half_angle(sky.sun_angle_deg as f32).map_err(|reason| format!("environment.sky: sun_{reason}"))?;
    }
    let checked = |(i, spec)| light(spec).map_err(|reason| format!("lights[{i}]: {reason}"));
    manifest.lights.iter().enumerate().map(checked).collect()
}

/// Checks a light of the manifest and makes it one of the scene.
fn light(spec: &LightSpec) -> Result<Light, Reason> {
    let range = |range: Option<f32>| match range {
        None => Ok(f32::INFINITY),
        Some(r) if r > 0.0 && r.is_finite() => Ok(r),
        Some(r) => Err(format!("range_m is {r}; it must be a number above 0, or left out where there is no limit")),
    };
    Ok(match spec {
        LightSpec::Directional { direction, irradiance, angle_deg, shadows } => {
            check_color("irradiance", *irradiance)?;
            let direction = Vec3::from_array(*direction).try_normalize().ok_or("direction has no length")?;
            let source = LightSource::Directional { direction, irradiance: Vec3::from_array(*irradiance) };
            Light { source, size: half_angle(*angle_deg)?, casts_shadow: *shadows }
        }
        LightSpec::Point { position, intensity, range_m, radius_m, shadows } => {
            check_color("intensity", *intensity)?;
            let source = LightSource::Point {
                position: finite(*position)?,
                intensity: Vec3::from_array(*intensity),
                range_m: range(*range_m)?,
            };
            Light { source, size: radius(*radius_m)?, casts_shadow: *shadows }
        }
        LightSpec::Spot { position, target, intensity, range_m, inner_deg, outer_deg, radius_m, shadows } => {
            check_color("intensity", *intensity)?;
            if !(0.0 <= *inner_deg && inner_deg < outer_deg && *outer_deg <= 90.0) {
                return Err(format!("0 ≤ inner_deg < outer_deg ≤ 90 must hold; they are {inner_deg} and {outer_deg}"));
            }
            let position = finite(*position)?;
            let direction = (finite(*target)? - position).try_normalize().ok_or("target and position are one point")?;
            let source = LightSource::Spot {
                position,
                direction: direction.as_vec3(),
                intensity: Vec3::from_array(*intensity),
                range_m: range(*range_m)?,
                inner_rad: inner_deg.to_radians(),
                outer_rad: outer_deg.to_radians(),
            };
            Light { source, size: radius(*radius_m)?, casts_shadow: *shadows }
        }
    })
}

/// Half of the whole angle of a directional light, radians.
fn half_angle(angle_deg: f32) -> Result<f32, Reason> {
    match (0.0..=90.0).contains(&angle_deg) {
        true => Ok((0.5 * angle_deg).to_radians()),
        false => Err(format!("angle_deg is {angle_deg}; the angle under which a light appears must be 0 to 90")),
    }
}

fn radius(radius_m: f32) -> Result<f32, Reason> {
    match (0.0..=1000.0).contains(&radius_m) {
        true => Ok(radius_m),
        false => Err(format!("radius_m is {radius_m}; a light's radius must be 0 to 1000")),
    }
}

/// Gives the lights of a glTF the properties that only a manifest can state.
fn shape_those_of_file(document: &mut Document, specs: &[FileLightSpec]) -> Result<(), Reason> {
    for spec in specs {
        let fail = |reason: String| format!("file_lights `{}`: {reason}", spec.name);
        let mut found = false;
        for (light, _) in document.lights.iter_mut().zip(&document.light_names).filter(|(_, n)| **n == spec.name) {
            found = true;
            light.casts_shadow = spec.shadows;
            light.size = match light.source {
                LightSource::Directional { .. } if spec.radius_m != 0.0 => {
                    return Err(fail("a directional light has an angle_deg and no radius_m".to_owned()));
                }
                LightSource::Directional { .. } => half_angle(spec.angle_deg).map_err(fail)?,
                _ if spec.angle_deg != 0.0 => {
                    return Err(fail("only a directional light has an angle_deg; give radius_m".to_owned()));
                }
                _ => radius(spec.radius_m).map_err(fail)?,
            };
        }
        if !found {
            return Err(fail("the glTF has no light of that name".to_owned()));
        }
    }
    Ok(())
}
