//! What a surface is made of, and the glTF material that is written for it.

use serde_json::{Value, json};

/// A texture of the scene that is being made.
#[derive(Debug, Clone, Copy)]
pub struct TextureId(pub(super) usize);

/// A material; start from [`Finish::dielectric`] or [`Finish::metal`].
#[derive(Debug, Clone)]
pub struct Finish {
    pub(super) name: String,
    pub(super) color: [f32; 3],
    pub(super) metallic: f32,
    pub(super) roughness: f32,
    pub(super) emissive: [f32; 3],
    pub(super) ior: f32,
    pub(super) transmission: f32,
    pub(super) color_map: Option<TextureId>,
    pub(super) roughness_map: Option<TextureId>,
    pub(super) normal_map: Option<TextureId>,
    /// How often the textures repeat along a metre (or along a unit of UV).
    pub(super) repeat: f32,
}

impl Finish {
    pub fn dielectric(name: &str, color: [f32; 3], roughness: f32) -> Finish {
        Finish {
            name: name.to_owned(),
            color,
            metallic: 0.0,
            roughness,
            emissive: [0.0; 3],
            ior: 1.5,
            transmission: 0.0,
            color_map: None,
            roughness_map: None,
            normal_map: None,
            repeat: 1.0,
        }
    }

    pub fn metal(name: &str, color: [f32; 3], roughness: f32) -> Finish {
        Finish { metallic: 1.0, ..Finish::dielectric(name, color, roughness) }
    }

    pub fn emissive(self, radiance: [f32; 3]) -> Finish {
        Finish { emissive: radiance, ..self }
    }

    /// Index of refraction: 1.5 is plastic, 1.8–2 a lacquer or polish that mirrors more.
    pub fn ior(self, ior: f32) -> Finish {
        Finish { ior, ..self }
    }

    /// Share of the light that passes through, 0–1, tinted by the finish's colour: about 0.4 for cloth, nearly 1 for a
    /// pane.
    pub fn transmitting(self, transmission: f32) -> Finish {
        Finish { transmission, ..self }
    }

    pub fn map(self, color_map: TextureId, repeat: f32) -> Finish {
        Finish { color_map: Some(color_map), repeat, ..self }
    }

    /// A map whose green channel is the roughness factor and whose blue channel is the metallic factor.
    pub fn roughness_map(self, map: TextureId) -> Finish {
        Finish { roughness_map: Some(map), ..self }
    }

    pub fn normal_map(self, map: TextureId) -> Finish {
        Finish { normal_map: Some(map), ..self }
    }
}

/// The glTF material.
pub(super) fn material_json(finish: &Finish) -> Value {
    let slot = |map: TextureId| {
        let mut slot = json!({ "index": map.0 });
        if finish.repeat != 1.0 {
            slot["extensions"] = json!({ "KHR_texture_transform": { "scale": [finish.repeat, finish.repeat] } });
        }
        slot
    };
    let [r, g, b] = finish.color;
    let mut pbr = json!({
        "baseColorFactor": [r, g, b, 1.0],
        "metallicFactor": finish.metallic,
        "roughnessFactor": finish.roughness,
    });
    if let Some(map) = finish.color_map {
        pbr["baseColorTexture"] = slot(map);
    }
    if let Some(map) = finish.roughness_map {
        pbr["metallicRoughnessTexture"] = slot(map);
    }
    let mut material = json!({ "name": finish.name, "pbrMetallicRoughness": pbr });
    if let Some(map) = finish.normal_map {
        material["normalTexture"] = slot(map);
    }
    let mut extensions = serde_json::Map::new();
    let strength = finish.emissive.into_iter().fold(0.0, f32::max);
    if strength > 0.0 {
        material["emissiveFactor"] = json!(finish.emissive.map(|c| c / strength.max(1.0)));
        if strength > 1.0 {
            extensions.insert(EMISSIVE_STRENGTH.to_owned(), json!({ "emissiveStrength": strength }));
        }
    }
    if finish.ior != 1.5 {
        extensions.insert(IOR.to_owned(), json!({ "ior": finish.ior }));
    }
    if finish.transmission != 0.0 {
        extensions.insert(TRANSMISSION.to_owned(), json!({ "transmissionFactor": finish.transmission }));
    }
    if !extensions.is_empty() {
        material["extensions"] = extensions.into();
    }
    material
}

pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";
pub(super) const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";
pub(super) const TRANSMISSION: &str = "KHR_materials_transmission";
pub(super) const IOR: &str = "KHR_materials_ior";
