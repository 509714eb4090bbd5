//! `KHR_materials_clearcoat`, approximated. A surface here has only one highlight, so the stronger of the two is drawn.
//!
//! The coat reflects 0.04 · strength at normal incidence. Where that is at least half of what the surface below
//! reflects, the coat is what people see mirrored. Its reflectance and roughness then replace those of the surface
//! below, whose own rough and similarly weak highlight is left out. Over metal the coat would add a few per cent to a
//! strong reflection, so there the coat is left out. Textures of strength and roughness are replaced by their mean.

use std::sync::Arc;

use glam::Vec3;
use gltf::json::material::Material as JsonMaterial;
use gltf::json::texture::Info;
use serde::Deserialize;

use super::slots::Slots;
use super::unit;
use crate::scene::error::Reason;
use crate::scene::load::image::DecodedImage;
use crate::scene::{Material, TextureRef};

pub const NAME: &str = "KHR_materials_clearcoat";

/// Reflectance of the coat, whose index of refraction the extension fixes at 1.5.
const COAT_F0: f32 = 0.04;

#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
#[derive(Default)]
struct Coat {
    clearcoat_factor: f32,
    clearcoat_texture: Option<Info>,
    clearcoat_roughness_factor: f32,
    clearcoat_roughness_texture: Option<Info>,
    clearcoat_normal_texture: Option<serde_json::Value>,
}

/// Changes `material`, which was read without its coat, to show the stronger of the two highlights.
pub fn apply(slots: &mut Slots, json: &JsonMaterial, material: &mut Material) -> Result<(), Reason> {
    let Some(value) = json.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(()) };
    let coat = Coat::deserialize(value).map_err(|error| format!("{NAME}: {error}"))?;
    let strength = unit(coat.clearcoat_factor * slots.mean(&coat.clearcoat_texture, false)?.x);
    let roughness = unit(coat.clearcoat_roughness_factor * slots.mean(&coat.clearcoat_roughness_texture, false)?.y);
    if strength == 0.0 {
        return Ok(());
    }
    let pbr = &json.pbr_metallic_roughness;
    let metal = material.metallic * slots.mean(&pbr.metallic_roughness_texture, false)?.z;
    let base = material.base_color * slots.mean(&pbr.base_color_texture, true)?;
    let below = luminance(material.dielectric_f0.lerp(base.truncate(), metal));
    if COAT_F0 * strength * 2.0 < below {
        slots.notes.push(format!("{NAME}: its coat is left out, for the surface below it reflects far more"));
        return Ok(());
    }
    let own_bumps = if coat.clearcoat_normal_texture.is_some() { "; its normal map is not used" } else { "" };
    slots.notes.push(format!(
        "{NAME}: its coat (strength {strength:.2}, roughness {roughness:.2}) replaces the highlight below it{own_bumps}"
    ));
    material.dielectric_f0 = Vec3::splat(COAT_F0 * strength);
    material.roughness = roughness;
    if let (Some(info), Some(slot)) = (&pbr.metallic_roughness_texture, material.metallic_roughness_texture.take()) {
        // The metallic channel stays; the roughness becomes that of the coat everywhere.
        let texels = slots.textures.texels(slots.buffers, slots.reader, info.index.value())?;
        let mut rgba8 = texels.rgba8.to_vec();
        rgba8.chunks_exact_mut(4).for_each(|texel| texel[1] = 255);
        let name = format!("{} coated", slots.textures.list[slot.texture].name);
        let texels = DecodedImage { rgba8: Arc::new(rgba8), ..texels };
        let texture = slots.textures.made(slots.buffers, info.index.value(), name, texels, false)?;
        material.metallic_roughness_texture = Some(TextureRef { texture, ..slot });
    }
    Ok(())
}

fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
