//! What a renderer needs to know about the world: geometry, materials, lights, environment and views. [`load()`] makes
//! a [`Scene`]; renderers, comparisons and studies of stability read it.
//!
//! The conventions are those of glTF: right-handed, +Y up, metres, and a camera looks along its own −Z. World positions
//! are `f64`, because at 1e7 m a step of an `f32` is a metre. A frame subtracts the head's position before anything
//! becomes `f32`.

pub mod builtin;
pub mod camera;
pub mod environment;
mod error;
pub mod head_path;
mod load;
pub mod manifest;
pub mod motion;
mod scene_cache;
pub mod survey;

use std::sync::Arc;

use glam::{DAffine3, DVec3, Mat3, Vec2, Vec3, Vec4};

pub use camera::{Eye, EyeCamera, Fov, StereoCamera, View};
pub use error::SceneError;
pub use head_path::{HeadKey, HeadPath, HeadPathError, UnknownPath};
pub use load::{ExtensionUse, Loading, Treatment, load, load_bytes, load_with};
pub use motion::Motion;
pub use scene_cache::SceneCache;

/// A loaded scene. All references in it are resolved, and all hazards are repaired or refused.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The built-in name, the manifest's `name`, or the file's stem.
    pub name: String,
    /// Triangle lists in the space of their object.
    pub primitives: Vec<Primitive>,
    /// Where the primitives stand. The order is stable: an instance's index is its id in the G-buffer.
    pub instances: Vec<Instance>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub lights: Vec<Light>,
    pub environment: Environment,
    /// At least one; the first is the default.
    pub views: Vec<View>,
    /// Paths of the head that the manifest defines.
    pub paths: Vec<HeadPath>,
    /// What a reflection ray sees that finds no answer.
    pub fallback: Fallback,
    /// Linear factor on radiance before the tone map; 1 leaves it unchanged.
    pub exposure: f32,
    /// Thickness that is assumed behind the front face of an open mesh, metres.
    pub open_mesh_thickness_m: f32,
    /// What moves. [`Scene::set_time`] puts it in its place; a loaded scene is at time 0.
    pub motions: Vec<Motion>,
    /// SHA-256, in hexadecimal, over every byte that the scene was made from: manifest, geometry, textures and
    /// environment.
    pub content_sha256: String,
    /// The glTF extensions that the file names, and what became of each.
    pub extensions: Vec<ExtensionUse>,
    /// What was repaired at load, one sentence each ("mesh `Cup`: 12 zero normals made from the faces").
    pub repairs: Vec<String>,
}

/// One triangle list with one material. The attribute vectors have one entry for each vertex.
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
    /// Linear, straight alpha; white where the file has no colours.
    pub colors: Vec<Vec4>,
    /// Three indices for each triangle, counter-clockwise seen from the front. Degenerate triangles are removed.
    pub indices: Vec<u32>,
    /// Index into `Scene::materials`.
    pub material: usize,
    /// Whether every welded edge belongs to exactly two triangles of opposite direction. Then back faces bound matter.
    pub closed: bool,
}

/// A primitive placed in the world.
#[derive(Debug, Clone)]
pub struct Instance {
    /// Index into `Scene::primitives`.
    pub primitive: usize,
    pub world_from_object: DAffine3,
    /// The same transform one frame (1/90 s) earlier. Both are equal where nothing moves.
    pub previous_world_from_object: DAffine3,
}

/// glTF's metallic-roughness material, with its textures and extensions resolved.
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
    /// Linear radiance, including the factor of `KHR_materials_emissive_strength`.
    pub emissive: Vec3,
    pub emissive_texture: Option<TextureRef>,
    /// Reflectance of the dielectric part at normal incidence, from ior and specular (0.04 by default), linear RGB.
    pub dielectric_f0: Vec3,
    pub alpha: Alpha,
    pub double_sided: bool,
    /// `KHR_materials_transmission` factor, 0–1.
    pub transmission: f32,
    /// Whether the eyes may share the direct light of this material. A manifest may forbid it.
    pub shading_reuse: bool,
}

/// How coverage is decided. Blended surfaces are cut out at an alpha of one half, because a deferred renderer has one
/// surface for each pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Alpha {
    Opaque,
    /// The fragment is discarded where alpha is below the cutoff.
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
    /// Whether the RGB bytes are sRGB-encoded (base colour, emissive).
    pub srgb: bool,
    pub wrap_u: Wrap,
    pub wrap_v: Wrap,
    /// Whether the texture is filtered by the nearest texel instead of linearly.
    pub nearest: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wrap {
    Repeat,
    Mirror,
    Clamp,
}

/// A light in the world that has no visible shape.
#[derive(Debug, Clone, Copy)]
pub struct Light {
    pub source: LightSource,
    /// Softens the shadow and does nothing else. For a directional light it is half the angle under which the light
    /// appears, radians; for any other, the radius of a sphere about it, metres. 0 gives a hard shadow.
    pub size: f32,
    /// If false, nothing blocks the light.
    pub casts_shadow: bool,
}

impl From<LightSource> for Light {
    /// The light with a hard shadow.
    fn from(source: LightSource) -> Light {
        Light { source, size: 0.0, casts_shadow: true }
    }
}

/// Where a light comes from and how strong it is, as in `KHR_lights_punctual`.
#[derive(Debug, Clone, Copy)]
pub enum LightSource {
    /// `irradiance` is that on a surface facing the light, lux-like. `direction` is the one in which the light travels,
    /// unit length.
    Directional { direction: Vec3, irradiance: Vec3 },
    /// `intensity` is radiant intensity, candela-like. There is no light beyond `range_m` (infinite when the file gives
    /// no range).
    Point { position: DVec3, intensity: Vec3, range_m: f32 },
    /// As a point, with a cone: `direction` has unit length, and the angles from the axis are in radians.
    Spot { position: DVec3, direction: Vec3, intensity: Vec3, range_m: f32, inner_rad: f32, outer_rad: f32 },
}

/// Light from infinity, with what shading needs of it.
#[derive(Debug, Clone)]
pub struct Environment {
    /// Equirectangular radiance, linear Rec. 709, with intensity and rotation applied.
    ///
    /// u = atan2(d.x, −d.z)/2π + ½ (the middle column looks down −Z, u grows to the right),
    /// v = acos(d.y)/π (the top row looks up).
    pub radiance: Equirect,
    /// Cosine-weighted mean radiance (irradiance / π) by normal, to be multiplied by a diffuse albedo.
    pub irradiance: Equirect,
    /// Radiance prefiltered with GGX. Level i of n is for the perceptual roughness i/(n−1). All levels have the same
    /// size.
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

/// What a reflection ray sees whose answer is *unknown*. A ray that reached the sky is not unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Fallback {
    /// Nothing, as in the paper.
    #[default]
    Black,
    /// A probe of the scene, path-traced at its first view and prefiltered.
    Probe,
    /// The environment. In closed rooms it shows sky where there is none.
    Environment,
}

impl Scene {
    /// The material of an instance.
    pub fn material_of(&self, instance: &Instance) -> &Material {
        &self.materials[self.primitives[instance.primitive].material]
    }

    /// The number of triangles of all instances.
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().map(|i| self.primitives[i.primitive].indices.len() / 3).sum()
    }
}
