//! Reads glTF materials into [`Material`]: the metallic-roughness model with those extensions that change what is seen
//! in a reflection. Called when a document is read.

mod coat;
mod gloss;
mod slots;

use glam::{Vec3, Vec4};
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::{AlphaMode, Material as JsonMaterial};
use gltf::json::validation::Checked;

use slots::Slots;

use super::accessor::Buffers;
use super::files::Reader;
use super::image::Textures;
use crate::scene::error::Reason;
use crate::scene::manifest::MaterialSpec;
use crate::scene::{Alpha, Material, TextureRef};

/// The material of a primitive that names none (glTF 2.0 §3.7.2.1).
pub fn default_material() -> Material {
    Material {
        name: "default".to_owned(),
        base_color: Vec4::ONE,
        base_color_texture: None,
        metallic: 1.0,
        roughness: 1.0,
        metallic_roughness_texture: None,
        normal_texture: None,
        normal_scale: 1.0,
        emissive: Vec3::ZERO,
        emissive_texture: None,
        dielectric_f0: Vec3::splat(0.04),
        alpha: Alpha::Opaque,
        double_sided: false,
        transmission: 0.0,
        shading_reuse: true,
    }
}

/// Gives the materials of a glTF the properties that only a manifest can state.
pub fn shape_those_of_file(materials: &mut [Material], specs: &[MaterialSpec]) -> Result<(), Reason> {
    for spec in specs {
        let mut named = materials.iter_mut().filter(|m| m.name == spec.name).peekable();
        if named.peek().is_none() {
            return Err(format!("materials `{}`: the glTF has no material of that name", spec.name));
        }
        named.for_each(|m| m.shading_reuse = spec.shading_reuse);
    }
    Ok(())
}

/// Name of the extension whose surfaces emit their base colour and are not lit.
pub const UNLIT: &str = "KHR_materials_unlit";

/// Reads one material. Sentences about what had to be left out are added to `notes`, without the material's name.
pub fn read(
    buffers: &Buffers,
    reader: &mut Reader,
    textures: &mut Textures,
    json: &JsonMaterial,
    notes: &mut Vec<String>,
) -> Result<Material, Reason> {
    let mut slots = Slots { buffers, reader, textures, notes };
    let mut material = core(&mut slots, json)?;
    if is_unlit(json) {
        unlit(&mut material);
        slots.notes.push(format!("{UNLIT}: its base colour is emitted"));
    }
    let others = json.extensions.iter().flat_map(|e| e.others.keys()).map(String::as_str);
    for name in others.filter(|name| ![UNLIT, coat::NAME, gloss::NAME].contains(name)) {
        slots.notes.push(format!("the extension {name} is not used"));
    }
    Ok(material)
}

/// Whether the material is not lit.
pub fn is_unlit(json: &JsonMaterial) -> bool {
    json.extensions.as_ref().is_some_and(|e| e.others.contains_key(UNLIT))
}

/// Reads the metallic-roughness model and the extensions that change it. An unlit material only needs its base colour.
fn core(slots: &mut Slots, json: &JsonMaterial) -> Result<Material, Reason> {
    let pbr = &json.pbr_metallic_roughness;
    let lit = !is_unlit(json);
    let extensions = json.extensions.as_ref().filter(|_| lit);
    let strength = extensions.and_then(|e| e.emissive_strength.as_ref()).map_or(1.0, |e| e.emissive_strength.0);
    let transmission = extensions.and_then(|e| e.transmission.as_ref());
    if transmission.is_some_and(|t| t.transmission_texture.is_some()) {
        slots.notes.push("its transmission texture is not used, only the factor".to_owned());
    }
    let base_color = finite4(Vec4::from_array(pbr.base_color_factor.0), Vec4::ONE).clamp(Vec4::ZERO, Vec4::ONE);
    // A surface of the specular-glossiness extension has its own base colour.
    let glossy = extensions.is_some_and(|e| e.others.contains_key(gloss::NAME));
    let mut material = Material {
        name: json.name.clone().unwrap_or_default(),
        base_color,
        base_color_texture: if glossy { None } else { slots.optional(&pbr.base_color_texture, true)? },
        metallic: unit(pbr.metallic_factor.0),
        roughness: unit(pbr.roughness_factor.0),
        metallic_roughness_texture: match &pbr.metallic_roughness_texture {
            Some(info) if lit && !glossy => Some(slots.texture(info, false)?),
            _ => None,
        },
        emissive_texture: if lit { slots.optional(&json.emissive_texture, true)? } else { None },
        normal_texture: if lit { normal_texture(slots, json)? } else { None },
        normal_scale: json.normal_texture.as_ref().map_or(1.0, |n| if n.scale.is_finite() { n.scale } else { 1.0 }),
        emissive: finite3(Vec3::from_array(json.emissive_factor.0) * strength.max(0.0)).max(Vec3::ZERO),
        dielectric_f0: specular_f0(slots, json)?,
        alpha: match json.alpha_mode {
            Checked::Valid(AlphaMode::Mask) => Alpha::Mask { cutoff: json.alpha_cutoff.map_or(0.5, |c| unit(c.0)) },
            Checked::Valid(AlphaMode::Blend) => {
                slots.notes.push("blending is drawn as a cut-out at alpha 0.5".to_owned());
                Alpha::Mask { cutoff: 0.5 }
            }
            _ => Alpha::Opaque,
        },
        double_sided: json.double_sided,
        transmission: transmission.map_or(0.0, |t| unit(t.transmission_factor.0)),
        shading_reuse: true,
    };
    if lit {
        gloss::apply(slots, json, &mut material)?;
        coat::apply(slots, json, &mut material)?;
    }
    Ok(material)
}

fn normal_texture(slots: &mut Slots, json: &JsonMaterial) -> Result<Option<TextureRef>, Reason> {
    let Some(normal) = &json.normal_texture else { return Ok(None) };
    let transform: Option<TextureTransform> = normal
        .extensions
        .as_ref()
        .and_then(|e| e.others.get("KHR_texture_transform"))
        .and_then(|value| serde_json::from_value(value.clone()).ok());
    let texture = slots.textures.slot(slots.buffers, slots.reader, normal.index.value(), false)?;
    let (uv_set, transform) = slots.placed(normal.tex_coord, transform.as_ref());
    Ok(Some(TextureRef { texture, uv_set, transform }))
}

/// The reflectance that follows from the index of refraction and `KHR_materials_specular`. Of its textures only the
/// mean is used.
fn specular_f0(slots: &mut Slots, json: &JsonMaterial) -> Result<Vec3, Reason> {
    let extensions = json.extensions.as_ref().filter(|_| !is_unlit(json));
    let ior = extensions.and_then(|e| e.ior.as_ref()).map_or(1.5, |e| e.ior.0);
    let Some(specular) = extensions.and_then(|e| e.specular.as_ref()) else {
        return Ok(dielectric_f0(ior, Vec3::ONE, 1.0));
    };
    if specular.specular_texture.is_some() || specular.specular_color_texture.is_some() {
        slots.notes.push("KHR_materials_specular: of its textures only the mean is used".to_owned());
    }
    let strength = specular.specular_factor.0 * slots.mean(&specular.specular_texture, false)?.w;
    let color = slots.mean(&specular.specular_color_texture, true)?.truncate();
    Ok(dielectric_f0(ior, Vec3::from_array(specular.specular_color_factor.0) * color, strength))
}

/// Makes a material emit its base colour, and makes its surface as black as the shading model allows.
fn unlit(material: &mut Material) {
    material.emissive = material.base_color.truncate();
    material.emissive_texture = material.base_color_texture.clone();
    // The alpha stays, and the texture stays for its alpha channel: they decide what is cut out.
    material.base_color = Vec3::ZERO.extend(material.base_color.w);
    (material.metallic, material.roughness, material.dielectric_f0) = (0.0, 1.0, Vec3::ZERO);
}

/// Reflectance at normal incidence: min(((ior−1)/(ior+1))² · colour, 1) · factor.
///
/// An ior of 0 is the extension's way to say "like metal": the reflectance is 1.
pub fn dielectric_f0(ior: f32, specular_color: Vec3, specular: f32) -> Vec3 {
    let ior = if ior.is_finite() { ior.max(0.0) } else { 1.5 };
    let ratio = if ior == 0.0 { 1.0 } else { (ior - 1.0) / (ior + 1.0) };
    finite3(specular_color).max(Vec3::ZERO).map(|c| (ratio * ratio * c).min(1.0)) * unit(specular)
}

fn unit(x: f32) -> f32 {
    if x.is_finite() { x.clamp(0.0, 1.0) } else { 1.0 }
}

fn finite3(v: Vec3) -> Vec3 {
    if v.is_finite() { v } else { Vec3::ZERO }
}

fn finite4(v: Vec4, otherwise: Vec4) -> Vec4 {
    if v.is_finite() { v } else { otherwise }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflectance_of_known_dielectrics() {
        assert!((dielectric_f0(1.5, Vec3::ONE, 1.0).x - 0.04).abs() < 1e-6);
        assert!((dielectric_f0(1.33, Vec3::ONE, 0.5).x - 0.5 * 0.020_059).abs() < 1e-5);
        assert_eq!(dielectric_f0(0.0, Vec3::ONE, 1.0), Vec3::ONE);
        assert_eq!(dielectric_f0(1.5, Vec3::splat(100.0), 0.25), Vec3::splat(0.25));
    }
}
