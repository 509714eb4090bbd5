//! The manifest: a JSON file that turns geometry into a scene. Every field is documented here, which becomes
//! `scenes/schema.json`; unknown fields are refused. The loader reads it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Fallback;

/// A scene: geometry, viewpoints, light, and what moves. Lengths are in metres, angles in degrees; y is up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// What the scene is called in journals and tables.
    pub name: String,
    /// One sentence that describes the scene.
    #[serde(default)]
    pub description: String,
    /// What the triangles are. May be left out in a side-car (`NAME.cyclopean.json` beside `NAME.gltf`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometry: Option<Geometry>,
    /// Viewpoints; the first is the default. The cameras of the glTF follow them.
    #[serde(default)]
    pub views: Vec<ViewSpec>,
    /// Paths of the head through the scene, for sequences. Every scene also has `still`, `sway` and `cut`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub paths: Vec<HeadPathSpec>,
    /// Lights in addition to those of the glTF.
    #[serde(default)]
    pub lights: Vec<LightSpec>,
    /// What a glTF cannot state about its own lights: their size and whether they cast shadows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub file_lights: Vec<FileLightSpec>,
    /// What a glTF cannot state about its own materials.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<MaterialSpec>,
    /// Light from infinity; the default sky when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<EnvironmentSpec>,
    /// What a reflection ray sees that finds no answer.
    #[serde(default)]
    pub fallback: Fallback,
    /// Linear factor on radiance before the tone map, above 0.
    #[serde(default = "one")]
    pub exposure: f32,
    /// Thickness that is assumed behind the front face of an open mesh, metres. When left out it is 1/200 of the
    /// distance from the first view to the nearest content.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open_mesh_thickness_m: Option<f32>,
    /// Nodes that move.
    #[serde(default)]
    pub motion: Vec<MotionSpec>,
}

fn one() -> f32 {
    1.0
}

/// Where the triangles come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum Geometry {
    /// A scene made by code.
    Builtin {
        /// Its name: `pica`, `room`, `wine`, `pink` or `temple`.
        name: String,
        /// Scales the triangle count, 0.01–4; 1 is several hundred thousand triangles.
        detail: f64,
    },
    /// A `.gltf` or `.glb` file, relative to the manifest.
    File(String),
}

/// A viewpoint. Give either `target` or `orientation`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViewSpec {
    pub name: String,
    /// Position of the point half-way between the eyes.
    pub position: [f64; 3],
    /// A point to look at with the head upright.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<[f64; 3]>,
    /// Rotation from view to world as a quaternion x, y, z, w. The view looks along its −Z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// Whole vertical field of view, 1–170 degrees.
    #[serde(default = "default_fov")]
    pub vertical_fov_deg: f64,
    /// Distance between the eyes.
    #[serde(default = "default_ipd")]
    pub ipd_m: f64,
    /// Angle by which each eye is turned outwards.
    #[serde(default)]
    pub cant_deg: f64,
    /// Distance of the near plane.
    #[serde(default = "default_near")]
    pub near_m: f64,
}

/// A path of the head: a smooth curve through its keys, seen with the field of view and the eyes of a viewpoint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeadPathSpec {
    pub name: String,
    /// Frame rate at which the path is meant to be seen: above 0, at most 1000.
    #[serde(default = "default_rate")]
    pub rate_hz: f64,
    /// At least two, in order of time.
    pub keys: Vec<HeadKeySpec>,
}

fn default_rate() -> f64 {
    super::head_path::DEFAULT_RATE_HZ
}

/// A key of a path: the head's pose at one moment. Give either `target` or `orientation`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeadKeySpec {
    pub time_s: f64,
    /// Position of the point half-way between the eyes.
    pub position: [f64; 3],
    /// A point to look at with the head upright.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<[f64; 3]>,
    /// Rotation from view to world as a quaternion x, y, z, w. The view looks along its −Z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// Whether the head jumps here from the key before.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub cut: bool,
}

fn default_fov() -> f64 {
    50.0
}

fn default_ipd() -> f64 {
    super::camera::DEFAULT_IPD_M
}

fn default_near() -> f64 {
    0.05
}

/// Size and shadow of a light of the glTF. A light without an entry has a hard shadow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileLightSpec {
    /// Name of the light, or of its node where the light has none. All lights with this name are meant.
    pub name: String,
    /// If false, nothing blocks the light: it casts no shadows.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub shadows: bool,
    /// For a directional light: the whole angle under which it appears, 0 to 90 degrees.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub angle_deg: f32,
    /// For any other light: the radius of the sphere that it shines from, 0 to 1,000 m.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub radius_m: f32,
}

/// How a material of the geometry may be treated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialSpec {
    /// Name of the material. All materials with this name are meant.
    pub name: String,
    /// If false, each eye is lit on its own wherever this material is seen, whatever `--shading-reuse` says.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub shading_reuse: bool,
}

fn yes() -> bool {
    true
}

fn is_true(b: &bool) -> bool {
    *b
}

fn is_zero(x: &f32) -> bool {
    *x == 0.0
}

/// A light. Colours are linear. Intensities are as in `KHR_lights_punctual`, without the factor of 683 lm/W. The size
/// of a light softens its shadow and changes nothing else: no reflection shows the light itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum LightSpec {
    Directional {
        /// The direction in which the light travels.
        direction: [f32; 3],
        /// Irradiance on a surface that faces the light.
        irradiance: [f32; 3],
        /// The whole angle under which the light appears, 0 to 90 degrees; the sun's is 0.53.
        #[serde(default, skip_serializing_if = "is_zero")]
        angle_deg: f32,
        /// If false, nothing blocks the light: it casts no shadows.
        #[serde(default = "yes", skip_serializing_if = "is_true")]
        shadows: bool,
    },
    Point {
        position: [f64; 3],
        /// Irradiance on a surface one metre away that faces the light.
        intensity: [f32; 3],
        /// Distance beyond which there is no light; no limit when left out.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        range_m: Option<f32>,
        /// Radius of the sphere that it shines from, 0 to 1,000 m.
        #[serde(default, skip_serializing_if = "is_zero")]
        radius_m: f32,
        /// If false, nothing blocks the light: it casts no shadows.
        #[serde(default = "yes", skip_serializing_if = "is_true")]
        shadows: bool,
    },
    Spot {
        position: [f64; 3],
        /// A point on the axis of the cone.
        target: [f64; 3],
        intensity: [f32; 3],
        #[serde(default, skip_serializing_if = "Option::is_none")]
        range_m: Option<f32>,
        /// Angle from the axis within which the light has its full strength.
        inner_deg: f32,
        /// Angle from the axis beyond which there is no light.
        outer_deg: f32,
        /// Radius of the sphere that it shines from, 0 to 1,000 m.
        #[serde(default, skip_serializing_if = "is_zero")]
        radius_m: f32,
        /// If false, nothing blocks the light: it casts no shadows.
        #[serde(default = "yes", skip_serializing_if = "is_true")]
        shadows: bool,
    },
}

/// Light from infinity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum EnvironmentSpec {
    Sky(SkySpec),
    Map(MapSpec),
    /// The same radiance in every direction.
    Constant([f32; 3]),
}

/// The analytic sky; docs/scenes.md has its formula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SkySpec {
    /// Radiance overhead.
    pub zenith: [f32; 3],
    /// Radiance just above the horizon.
    pub horizon: [f32; 3],
    /// Radiance that comes from below the horizon.
    pub ground: [f32; 3],
    /// Height of the sun above the horizon.
    pub sun_elevation_deg: f64,
    /// Azimuth of the sun: 0 towards −Z, growing towards +X.
    pub sun_azimuth_deg: f64,
    /// Irradiance of the sun on a surface that faces it. The sun becomes a directional light and is never in the pixels
    /// of the sky.
    pub sun_irradiance: [f32; 3],
    /// The whole angle under which the sun appears, 0 to 90 degrees.
    pub sun_angle_deg: f64,
    /// Additional radiance of the haze around the sun.
    pub glow: [f32; 3],
}

impl Default for SkySpec {
    fn default() -> SkySpec {
        SkySpec {
            zenith: [0.16, 0.30, 0.62],
            horizon: [0.78, 0.86, 0.95],
            ground: [0.22, 0.20, 0.18],
            sun_elevation_deg: 42.0,
            sun_azimuth_deg: 140.0,
            sun_irradiance: [2.2, 2.05, 1.8],
            sun_angle_deg: 0.53,
            glow: [1.1, 0.95, 0.7],
        }
    }
}

/// An equirectangular image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapSpec {
    /// `.hdr` or `.exr`, relative to the manifest.
    pub file: String,
    /// Turns the map about the vertical axis: a feature at −Z moves towards +X.
    #[serde(default)]
    pub rotation_deg: f64,
    /// Factor on every texel.
    #[serde(default = "one")]
    pub intensity: f32,
    /// Largest radiance that is kept, after `intensity`; no limit when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clamp: Option<f32>,
}

/// A node that moves, together with all nodes below it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionSpec {
    /// The node's name in the glTF.
    pub node: String,
    pub path: PathSpec,
}

/// How a node moves. At time 0 it stands where the glTF puts it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum PathSpec {
    /// A rotation about an axis, vertical by default, through a point of the world.
    Orbit {
        center: [f64; 3],
        #[serde(default = "up")]
        axis: [f64; 3],
        period_s: f64,
    },
    /// A rotation about an axis through the middle of the node's bounding box.
    Spin {
        #[serde(default = "up")]
        axis: [f64; 3],
        period_s: f64,
    },
    /// A movement to and fro: `offset_m · sin(2π t / period_s)`.
    Translate { offset_m: [f64; 3], period_s: f64 },
}

fn up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}
