//! `KHR_materials_pbrSpecularGlossiness`, converted to the metallic-roughness model.
//!
//! Without a specular texture nothing is lost: the specular colour becomes the dielectric reflectance. With one, each
//! texel is converted as in the conversion example of the extension's specification, from which the constants are
//! taken.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use gltf::json::material::Material as JsonMaterial;
use gltf::json::texture::Info;
use serde::Deserialize;

use super::slots::Slots;
use super::{finite3, finite4, unit};
use crate::scene::error::Reason;
use crate::scene::load::image::{DecodedImage, encoded, linear};
use crate::scene::{Material, TextureRef};

pub const NAME: &str = "KHR_materials_pbrSpecularGlossiness";

/// Reflectance of a dielectric in the metallic-roughness model.
const DIELECTRIC: f32 = 0.04;

#[derive(Debug, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Gloss {
    diffuse_factor: [f32; 4],
    diffuse_texture: Option<Info>,
    specular_factor: [f32; 3],
    glossiness_factor: f32,
    specular_glossiness_texture: Option<Info>,
}

impl Default for Gloss {
    fn default() -> Gloss {
        Gloss {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

/// Replaces the surface that the core format describes by the one that the extension describes.
pub fn apply(slots: &mut Slots, json: &JsonMaterial, material: &mut Material) -> Result<(), Reason> {
    let Some(value) = json.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(()) };
    let gloss = Gloss::deserialize(value).map_err(|error| format!("{NAME}: {error}"))?;
    let diffuse = finite4(Vec4::from_array(gloss.diffuse_factor), Vec4::ONE).clamp(Vec4::ZERO, Vec4::ONE);
    let specular = finite3(Vec3::from_array(gloss.specular_factor)).clamp(Vec3::ZERO, Vec3::ONE);
    let glossiness = unit(gloss.glossiness_factor);
    material.metallic_roughness_texture = None;
    if let Some(info) = &gloss.specular_glossiness_texture {
        let mapping = slots.mapping(info);
        let apart = match &gloss.diffuse_texture {
            Some(other) => slots.mapping(other) != mapping,
            None => false,
        };
        if !apart {
            return converted(slots, &gloss, info, (diffuse, specular, glossiness), material);
        }
        slots.notes.push(format!("{NAME}: its two textures lie differently on the mesh; of the specular one the mean"));
    }
    let mean = slots.mean(&gloss.specular_glossiness_texture, true)?;
    material.base_color = diffuse;
    material.base_color_texture = slots.optional(&gloss.diffuse_texture, true)?;
    material.metallic = 0.0;
    material.dielectric_f0 = specular * mean.truncate();
    material.roughness = 1.0 - glossiness * mean.w;
    Ok(())
}

/// Makes two textures of the metallic-roughness model from the extension's two. The factors are multiplied into the
/// texels.
fn converted(
    slots: &mut Slots,
    gloss: &Gloss,
    info: &Info,
    (diffuse, specular, glossiness): (Vec4, Vec3, f32),
    material: &mut Material,
) -> Result<(), Reason> {
    let shiny = slots.textures.texels(slots.buffers, slots.reader, info.index.value())?;
    let colored = match &gloss.diffuse_texture {
        Some(info) => Some(slots.textures.texels(slots.buffers, slots.reader, info.index.value())?),
        None => None,
    };
    let like = gloss.diffuse_texture.as_ref().unwrap_or(info).index.value();
    let (width, height) = colored
        .as_ref()
        .map_or((shiny.width, shiny.height), |c| (c.width.max(shiny.width), c.height.max(shiny.height)));
    let linear: [f32; 256] = std::array::from_fn(|byte| linear(byte as u8));
    let read = |image: &DecodedImage, x: u32, y: u32| {
        // The nearest texel, where the two images differ in size.
        let (x, y) = (u64::from(x) * u64::from(image.width), u64::from(y) * u64::from(image.height));
        let at = y / u64::from(height) * u64::from(image.width) + x / u64::from(width);
        let texel = &image.rgba8[at as usize * 4..at as usize * 4 + 4];
        let [r, g, b] = [0, 1, 2].map(|k| linear[usize::from(texel[k])]);
        Vec4::new(r, g, b, f32::from(texel[3]) / 255.0)
    };
    let texels = width as usize * height as usize;
    let (mut base, mut surface) = (Vec::with_capacity(texels * 4), Vec::with_capacity(texels * 4));
    for y in 0..height {
        for x in 0..width {
            let d = diffuse * colored.as_ref().map_or(Vec4::ONE, |image| read(image, x, y));
            let s = read(&shiny, x, y);
            let (color, metal) = metallic(d.truncate(), specular * s.truncate());
            base.extend(color.to_array().map(encoded));
            base.push((d.w * 255.0).round() as u8);
            let rough = 1.0 - glossiness * s.w;
            surface.extend([0, (rough * 255.0).round() as u8, (metal * 255.0).round() as u8, 255]);
        }
    }
    let (uv_set, transform) = slots.mapping(info);
    let mut texture = |what: &str, rgba8: Vec<u8>, srgb: bool| -> Result<Option<TextureRef>, Reason> {
        let name = format!("{} {what}", material.name);
        let texels = DecodedImage { width, height, rgba8: Arc::new(rgba8) };
        let texture = slots.textures.made(slots.buffers, like, name, texels, srgb)?;
        Ok(Some(TextureRef { texture, uv_set, transform }))
    };
    material.base_color_texture = texture("base colour", base, true)?;
    material.metallic_roughness_texture = texture("metal and roughness", surface, false)?;
    (material.base_color, material.metallic, material.roughness) = (Vec4::ONE, 1.0, 1.0);
    material.dielectric_f0 = Vec3::splat(DIELECTRIC);
    slots.notes.push(format!("{NAME}: its textures are converted to base colour, metal and roughness"));
    Ok(())
}

/// The base colour and metallic factor that look like this diffuse and this specular colour.
fn metallic(diffuse: Vec3, specular: Vec3) -> (Vec3, f32) {
    let rest = 1.0 - specular.max_element();
    let metal = solve(brightness(diffuse), brightness(specular), rest);
    let from_diffuse = diffuse * (rest / (1.0 - DIELECTRIC) / (1.0 - metal).max(1e-6));
    let from_specular = (specular - DIELECTRIC * (1.0 - metal)) / metal.max(1e-6);
    (from_diffuse.lerp(from_specular, metal * metal).clamp(Vec3::ZERO, Vec3::ONE), metal)
}

/// The metallic factor at which both models have the same brightness: the root of a quadratic equation.
fn solve(diffuse: f32, specular: f32, rest: f32) -> f32 {
    if specular < DIELECTRIC {
        return 0.0;
    }
    let b = diffuse * rest / (1.0 - DIELECTRIC) + specular - 2.0 * DIELECTRIC;
    let c = DIELECTRIC - specular;
    let root = (b * b - 4.0 * DIELECTRIC * c).max(0.0).sqrt();
    ((root - b) / (2.0 * DIELECTRIC)).clamp(0.0, 1.0)
}

fn brightness(c: Vec3) -> f32 {
    (c * c).dot(Vec3::new(0.299, 0.587, 0.114)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pure_metals_and_pure_dielectrics_convert_to_themselves() {
        let gold = Vec3::new(1.0, 0.77, 0.34);
        let (color, metal) = metallic(Vec3::ZERO, gold);
        assert!(metal > 0.999 && (color - gold).length() < 1e-3, "{color} {metal}");
        let red = Vec3::new(0.6, 0.1, 0.1);
        let (color, metal) = metallic(red, Vec3::splat(0.04));
        assert!(metal < 1e-3 && (color - red).length() < 1e-3, "{color} {metal}");
    }
}
