//! What a renderer needs to know of the world: geometry, materials, lights, environment, views.
//!
//! Conventions are glTF's: right-handed, +Y up, metres, a camera looks down its own −Z. World
//! positions are `f64` (an `f32` step is a metre at 1e7 m); a frame subtracts the head's position
//! before anything becomes `f32`.

pub mod builtin;
pub mod camera;
pub mod environment;
mod error;
pub mod head_path;
mod load;
pub mod manifest;
pub mod motion;
mod shelf;
pub mod survey;

use std::sync::Arc;

use glam::{DAffine3, DVec3, Mat3, Vec2, Vec3, Vec4};

pub use camera::{Eye, EyeCamera, Fov, StereoCamera, View};
pub use error::SceneError;
pub use head_path::{HeadKey, HeadPath, HeadPathError, UnknownPath};
pub use load::{ExtensionUse, Loading, Treatment, load, load_bytes, load_with};
pub use motion::Motion;
pub use shelf::Shelf;

/// A loaded scene, every reference resolved, every hazard repaired or refused.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The built-in name, the manifest's `name`, or the file's stem.
    pub name: String,
    /// Triangle lists in their object's space.
    pub primitives: Vec<Primitive>,
    /// Where the primitives stand. Order is stable: the index is the instance id on screen.
    pub instances: Vec<Instance>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub lights: Vec<Light>,
    pub environment: Environment,
    /// At least one; the first is the default.
    pub views: Vec<View>,
    /// Ways of the head that the manifest names.
    pub paths: Vec<HeadPath>,
    /// What a reflection ray without an answer sees.
    pub fallback: Fallback,
    /// Linear factor before the tone map (1 = as it is).
    pub exposure: f32,
    /// Depth behind an open mesh's front face that counts as matter, metres.
    pub open_mesh_thickness_m: f32,
    /// What moves; [`Scene::set_time`] places it. A loaded scene stands at time 0.
    pub motions: Vec<Motion>,
    /// SHA-256 (hex) over every byte the scene was made from: manifest, geometry, textures, environment.
    pub content_sha256: String,
    /// The glTF extensions that the file names, and what became of each.
    pub extensions: Vec<ExtensionUse>,
    /// What was repaired at load, one sentence each ("mesh `Cup`: 12 zero normals made from the faces").
    pub repairs: Vec<String>,
}

/// One triangle list with one material. Attribute vectors have one entry a vertex.
#[derive(Debug, Clone)]
pub struct Primitive {
    pub name: String,
    pub positions: Vec<Vec3>,
    /// Unit length.
    pub normals: Vec<Vec3>,
    /// xyz unit length, w = ±1 (bitangent = w · cross(n, t)).
    pub tangents: Vec<Vec4>,
    pub uv0: Vec<Vec2>,
    pub uv1: Vec<Vec2>,
    /// Linear, straight alpha; white where the file has none.
    pub colors: Vec<Vec4>,
    /// Three per triangle, counter-clockwise seen from the front; degenerate triangles removed.
    pub indices: Vec<u32>,
    /// Index into `Scene::materials`.
    pub material: usize,
    /// Every welded edge has exactly two triangles of opposite direction: back faces bound matter.
    pub closed: bool,
}

/// A primitive placed in the world.
#[derive(Debug, Clone)]
pub struct Instance {
    /// Index into `Scene::primitives`.
    pub primitive: usize,
    pub world_from_object: DAffine3,
    /// The same one frame (1/90 s) earlier; equal when nothing moves.
    pub previous_world_from_object: DAffine3,
}

/// glTF's metallic-roughness material, resolved.
#[derive(Debug, Clone)]
pub struct Material {
    pub name: String,
    /// Linear, straight alpha.
    pub base_color: Vec4,
    pub base_color_texture: Option<TextureRef>,
    pub metallic: f32,
    /// Perceptual roughness r; α = r².
    pub roughness: f32,
    /// G = roughness, B = metallic.
    pub metallic_roughness_texture: Option<TextureRef>,
    pub normal_texture: Option<TextureRef>,
    pub normal_scale: f32,
    /// Linear radiance, `KHR_materials_emissive_strength` multiplied in.
    pub emissive: Vec3,
    pub emissive_texture: Option<TextureRef>,
    /// Reflectance of the dielectric part at normal incidence, from ior and specular (0.04 by default), linear RGB.
    pub dielectric_f0: Vec3,
    pub alpha: Alpha,
    pub double_sided: bool,
    /// `KHR_materials_transmission` factor, 0–1.
    pub transmission: f32,
    /// The eyes may share what lights put on it; a manifest may forbid it.
    pub shading_reuse: bool,
}

/// How coverage is decided. Blended surfaces are cut out at one half: a deferred renderer has one surface a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Alpha {
    Opaque,
    /// Discarded where alpha is below the cutoff.
    Mask {
        cutoff: f32,
    },
}

/// A texture slot of a material.
#[derive(Debug, Clone)]
pub struct TextureRef {
    /// Index into `Scene::textures`.
    pub texture: usize,
    /// 0 or 1: which UV set.
    pub uv_set: u32,
    /// `KHR_texture_transform`: uv' = matrix · (u, v, 1); identity by default.
    pub transform: Mat3,
}

/// A decoded image with its sampler. An image used both as colour and as data appears twice.
#[derive(Debug, Clone)]
pub struct Texture {
    pub name: String,
    pub width: u32,
    pub height: u32,
    /// Row-major from the top-left, four bytes a texel.
    pub rgba8: Arc<Vec<u8>>,
    /// The RGB bytes are sRGB-encoded (base colour, emissive).
    pub srgb: bool,
    pub wrap_u: Wrap,
    pub wrap_v: Wrap,
    /// Nearest instead of linear filtering.
    pub nearest: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wrap {
    Repeat,
    Mirror,
    Clamp,
}

/// A light without a shape that is seen, in the world.
#[derive(Debug, Clone, Copy)]
pub struct Light {
    pub source: LightSource,
    /// Softens the shadow, and nothing else: half the angle under which a directional light appears, radians; the radius
    /// of a sphere about any other, metres. 0: a hard shadow.
    pub size: f32,
    /// False: the light goes through everything.
    pub casts_shadow: bool,
}

impl From<LightSource> for Light {
    /// With a hard shadow.
    fn from(source: LightSource) -> Light {
        Light { source, size: 0.0, casts_shadow: true }
    }
}

/// Where a light comes from and how strong it is, as in `KHR_lights_punctual`.
#[derive(Debug, Clone, Copy)]
pub enum LightSource {
    /// Irradiance on a facing surface, lux-like; `direction` is where the light travels to, unit length.
    Directional { direction: Vec3, irradiance: Vec3 },
    /// Radiant intensity, candela-like; no light beyond `range_m` (infinite when none is given).
    Point { position: DVec3, intensity: Vec3, range_m: f32 },
    /// As a point with a cone: `direction` unit length, angles from the axis in radians.
    Spot { position: DVec3, direction: Vec3, intensity: Vec3, range_m: f32, inner_rad: f32, outer_rad: f32 },
}

/// Light from infinity, with what is needed to shade by it.
#[derive(Debug, Clone)]
pub struct Environment {
    /// Equirectangular radiance, linear Rec. 709, intensity and rotation applied.
    ///
    /// u = atan2(d.x, −d.z)/2π + ½ (the middle column looks down −Z, u grows to the right),
    /// v = acos(d.y)/π (the top row looks up).
    pub radiance: Equirect,
    /// Cosine-weighted mean radiance (irradiance / π) by normal: multiply by a diffuse albedo.
    pub irradiance: Equirect,
    /// GGX-prefiltered radiance; level i of n is for perceptual roughness i/(n−1). All levels equal in size.
    pub specular: Vec<Equirect>,
}

/// An equirectangular map; see [`Environment::radiance`] for the mapping.
#[derive(Debug, Clone, PartialEq)]
pub struct Equirect {
    pub width: u32,
    pub height: u32,
    /// Row-major from the top-left.
    pub texels: Vec<[f32; 3]>,
}

/// What an *unknown* reflection ray sees (never one that reached the sky).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Fallback {
    /// Nothing, as in the paper.
    #[default]
    Black,
    /// One probe in the scene, prefiltered at load.
    Probe,
    /// The environment; puts sky into closed rooms.
    Environment,
}

impl Scene {
    /// What an instance is made of.
    pub fn material_of(&self, instance: &Instance) -> &Material {
        &self.materials[self.primitives[instance.primitive].material]
    }

    /// Triangles over all instances.
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().map(|i| self.primitives[i.primitive].indices.len() / 3).sum()
    }
}
