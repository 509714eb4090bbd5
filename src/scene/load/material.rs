//! glTF materials → [`Material`]: metallic-roughness with the extensions that change what a reflection sees.

use glam::{Mat3, Vec3, Vec4};
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::{AlphaMode, Material as JsonMaterial};
use gltf::json::texture::Info;
use gltf::json::validation::Checked;

use super::accessor::Buffers;
use super::files::Reader;
use super::image::Textures;
use crate::scene::error::Reason;
use crate::scene::{Alpha, Material, TextureRef};

/// What a primitive without a material gets (glTF 2.0 §3.7.2.1).
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
    }
}

/// Reads one material; `notes` takes what had to be left out, without the material's name.
pub fn read(
    buffers: &Buffers,
    reader: &mut Reader,
    textures: &mut Textures,
    json: &JsonMaterial,
    notes: &mut Vec<String>,
) -> Result<Material, Reason> {
    let pbr = &json.pbr_metallic_roughness;
    let extensions = json.extensions.as_ref();
    let mut slot = |info: &Option<Info>, srgb: bool, notes: &mut Vec<String>| -> Result<Option<TextureRef>, Reason> {
        let Some(info) = info else { return Ok(None) };
        let texture = textures.slot(buffers, reader, info.index.value(), srgb)?;
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        let uv_set = transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
        Ok(Some(TextureRef { texture, uv_set: known_set(uv_set, notes), transform: matrix(transform) }))
    };
    let base_color_texture = slot(&pbr.base_color_texture, true, notes)?;
    let metallic_roughness_texture = slot(&pbr.metallic_roughness_texture, false, notes)?;
    let emissive_texture = slot(&json.emissive_texture, true, notes)?;
    let normal_texture = match &json.normal_texture {
        None => None,
        Some(normal) => {
            let transform: Option<TextureTransform> = normal
                .extensions
                .as_ref()
                .and_then(|e| e.others.get("KHR_texture_transform"))
                .and_then(|value| serde_json::from_value(value.clone()).ok());
            let uv_set = transform.as_ref().and_then(|t| t.tex_coord).unwrap_or(normal.tex_coord);
            let texture = textures.slot(buffers, reader, normal.index.value(), false)?;
            Some(TextureRef { texture, uv_set: known_set(uv_set, notes), transform: matrix(transform.as_ref()) })
        }
    };
    let strength = extensions.and_then(|e| e.emissive_strength.as_ref()).map_or(1.0, |e| e.emissive_strength.0);
    let ior = extensions.and_then(|e| e.ior.as_ref()).map_or(1.5, |e| e.ior.0);
    let specular = extensions.and_then(|e| e.specular.as_ref());
    let transmission = extensions.and_then(|e| e.transmission.as_ref());
    if specular.is_some_and(|s| s.specular_texture.is_some() || s.specular_color_texture.is_some()) {
        notes.push("its specular textures are not used, only the factors".to_owned());
    }
    if transmission.is_some_and(|t| t.transmission_texture.is_some()) {
        notes.push("its transmission texture is not used, only the factor".to_owned());
    }
    for name in extensions.iter().flat_map(|e| e.others.keys()) {
        notes.push(format!("the extension {name} is not used"));
    }
    let base_color = finite4(Vec4::from_array(pbr.base_color_factor.0), Vec4::ONE).clamp(Vec4::ZERO, Vec4::ONE);
    Ok(Material {
        name: json.name.clone().unwrap_or_default(),
        base_color,
        base_color_texture,
        metallic: unit(pbr.metallic_factor.0),
        roughness: unit(pbr.roughness_factor.0),
        metallic_roughness_texture,
        normal_texture,
        normal_scale: json.normal_texture.as_ref().map_or(1.0, |n| if n.scale.is_finite() { n.scale } else { 1.0 }),
        emissive: finite3(Vec3::from_array(json.emissive_factor.0) * strength.max(0.0)).max(Vec3::ZERO),
        emissive_texture,
        dielectric_f0: dielectric_f0(
            ior,
            specular.map_or(Vec3::ONE, |s| Vec3::from_array(s.specular_color_factor.0)),
            specular.map_or(1.0, |s| s.specular_factor.0),
        ),
        alpha: match json.alpha_mode {
            Checked::Valid(AlphaMode::Mask) => Alpha::Mask { cutoff: json.alpha_cutoff.map_or(0.5, |c| unit(c.0)) },
            Checked::Valid(AlphaMode::Blend) => {
                notes.push("blending is drawn as a cut-out at alpha 0.5".to_owned());
                Alpha::Mask { cutoff: 0.5 }
            }
            _ => Alpha::Opaque,
        },
        double_sided: json.double_sided,
        transmission: transmission.map_or(0.0, |t| unit(t.transmission_factor.0)),
    })
}

/// Reflectance at normal incidence: min(((ior−1)/(ior+1))² · colour, 1) · factor.
///
/// An ior of 0 is the extension's way to say "metal-like": reflectance 1.
pub fn dielectric_f0(ior: f32, specular_color: Vec3, specular: f32) -> Vec3 {
    let ior = if ior.is_finite() { ior.max(0.0) } else { 1.5 };
    let ratio = if ior == 0.0 { 1.0 } else { (ior - 1.0) / (ior + 1.0) };
    finite3(specular_color).max(Vec3::ZERO).map(|c| (ratio * ratio * c).min(1.0)) * unit(specular)
}

/// uv' = T(offset) · R(rotation) · S(scale), as the extension defines them.
fn matrix(transform: Option<&TextureTransform>) -> Mat3 {
    let Some(t) = transform else { return Mat3::IDENTITY };
    let (sin, cos) = t.rotation.0.sin_cos();
    let [sx, sy] = t.scale.0;
    let matrix = Mat3::from_cols(
        Vec3::new(cos * sx, -sin * sx, 0.0),
        Vec3::new(sin * sy, cos * sy, 0.0),
        Vec3::new(t.offset.0[0], t.offset.0[1], 1.0),
    );
    if matrix.is_finite() { matrix } else { Mat3::IDENTITY }
}

fn known_set(set: u32, notes: &mut Vec<String>) -> u32 {
    if set > 1 {
        notes.push(format!("TEXCOORD_{set} is not read; TEXCOORD_0 stands in"));
        return 0;
    }
    set
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
