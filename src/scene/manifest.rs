//! The manifest: a JSON file that makes a scene of geometry. Every field is documented; unknown ones are refused.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Fallback;

/// A scene: geometry, viewpoints, light and what moves. Lengths in metres, angles in degrees, y up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// What the scene is called in journals and tables.
    pub name: String,
    /// One sentence for people.
    #[serde(default)]
    pub description: String,
    /// What there is to see. May be left out in a side-car (`NAME.cyclopean.json` beside `NAME.gltf`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometry: Option<Geometry>,
    /// Viewpoints; the first is the default. A glTF's own cameras follow them.
    #[serde(default)]
    pub views: Vec<ViewSpec>,
    /// Ways of the head through the scene, for sequences. Every scene also has `still`, `sway` and `cut`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub paths: Vec<HeadPathSpec>,
    /// Lights beside those of the glTF.
    #[serde(default)]
    pub lights: Vec<LightSpec>,
    /// What a glTF cannot say of its own lights: their size and whether they cast shadows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub file_lights: Vec<FileLightSpec>,
    /// What a glTF cannot say of its materials.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<MaterialSpec>,
    /// Light from infinity; the default sky when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<EnvironmentSpec>,
    /// What a reflection ray without an answer sees.
    #[serde(default)]
    pub fallback: Fallback,
    /// Linear factor before the tone map, > 0.
    #[serde(default = "one")]
    pub exposure: f32,
    /// Depth behind an open mesh's front face that counts as matter, metres; 1/200 of the nearest content's
    /// distance from the first view when left out.
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

/// A viewpoint; give `target` or `orientation`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViewSpec {
    pub name: String,
    /// Of the point half-way between the eyes.
    pub position: [f64; 3],
    /// A point to look at, the head upright.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<[f64; 3]>,
    /// World from view as a quaternion x, y, z, w; the view looks down its −Z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// Whole vertical field of view, 1–170 degrees.
    #[serde(default = "default_fov")]
    pub vertical_fov_deg: f64,
    /// Distance between the eyes.
    #[serde(default = "default_ipd")]
    pub ipd_m: f64,
    /// Each eye turned outwards by this angle.
    #[serde(default)]
    pub cant_deg: f64,
    /// Distance of the near plane.
    #[serde(default = "default_near")]
    pub near_m: f64,
}

/// A way of the head: a smooth curve through its keys, seen with the field of view and eyes of a viewpoint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeadPathSpec {
    pub name: String,
    /// Frames a second at which it is meant to be seen, above 0 to 1000.
    #[serde(default = "default_rate")]
    pub rate_hz: f64,
    /// At least two, in order of time.
    pub keys: Vec<HeadKeySpec>,
}

fn default_rate() -> f64 {
    super::head_path::DEFAULT_RATE_HZ
}

/// A moment of a path; give `target` or `orientation`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeadKeySpec {
    pub time_s: f64,
    /// Of the point half-way between the eyes.
    pub position: [f64; 3],
    /// A point to look at, the head upright.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<[f64; 3]>,
    /// World from view as a quaternion x, y, z, w; the view looks down its −Z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// The head jumps here from the key before.
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

/// Size and shadow of a light that stands in the glTF. Without an entry its shadow is hard.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileLightSpec {
    /// Of the light, or of its node where the light has none. All lights of this name are meant.
    pub name: String,
    /// False: its light goes through everything.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub shadows: bool,
    /// Of a directional light: the whole angle under which it appears, 0 to 90 degrees.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub angle_deg: f32,
    /// Of any other light: radius of the sphere that it shines from, 0 to 1,000 m.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub radius_m: f32,
}

/// What may be done with a material of the geometry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialSpec {
    /// All materials of this name are meant.
    pub name: String,
    /// False: each eye is lit in full where it is seen, whatever `--shading-reuse` says.
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

/// A light. Colours are linear; intensities as in `KHR_lights_punctual` without the 683 lm/W. Its size softens its
/// shadow and changes nothing else: no reflection shows the light itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum LightSpec {
    Directional {
        /// Where the light travels to.
        direction: [f32; 3],
        /// On a facing surface.
        irradiance: [f32; 3],
        /// The whole angle under which the light appears, 0 to 90 degrees; the sun's is 0.53.
        #[serde(default, skip_serializing_if = "is_zero")]
        angle_deg: f32,
        /// False: the light goes through everything.
        #[serde(default = "yes", skip_serializing_if = "is_true")]
        shadows: bool,
    },
    Point {
        position: [f64; 3],
        /// Irradiance on a facing surface one metre away.
        intensity: [f32; 3],
        /// No light beyond; none = no limit.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        range_m: Option<f32>,
        /// Of the sphere that it shines from, 0 to 1,000 m.
        #[serde(default, skip_serializing_if = "is_zero")]
        radius_m: f32,
        /// False: the light goes through everything.
        #[serde(default = "yes", skip_serializing_if = "is_true")]
        shadows: bool,
    },
    Spot {
        position: [f64; 3],
        /// A point on the axis.
        target: [f64; 3],
        intensity: [f32; 3],
        #[serde(default, skip_serializing_if = "Option::is_none")]
        range_m: Option<f32>,
        /// From the axis: full strength within.
        inner_deg: f32,
        /// From the axis: nothing beyond.
        outer_deg: f32,
        /// Of the sphere that it shines from, 0 to 1,000 m.
        #[serde(default, skip_serializing_if = "is_zero")]
        radius_m: f32,
        /// False: the light goes through everything.
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
    /// The same radiance from everywhere.
    Constant([f32; 3]),
}

/// The analytic sky; see docs/scenes.md for its formula.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SkySpec {
    /// Radiance overhead.
    pub zenith: [f32; 3],
    /// Radiance just above the horizon.
    pub horizon: [f32; 3],
    /// Radiance from below.
    pub ground: [f32; 3],
    /// Height of the sun above the horizon.
    pub sun_elevation_deg: f64,
    /// Direction of the sun from −Z, growing towards +X.
    pub sun_azimuth_deg: f64,
    /// What the sun puts on a surface facing it; it becomes a directional light, never pixels.
    pub sun_irradiance: [f32; 3],
    /// The whole angle under which the sun appears, 0 to 90 degrees.
    pub sun_angle_deg: f64,
    /// Extra radiance of the haze towards the sun.
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
    /// Turns the world under the map: a feature at −Z moves towards +X.
    #[serde(default)]
    pub rotation_deg: f64,
    /// Factor on every texel.
    #[serde(default = "one")]
    pub intensity: f32,
    /// Largest radiance kept after `intensity`; none = all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clamp: Option<f32>,
}

/// A node (with everything below it) that moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionSpec {
    /// The node's name in the glTF.
    pub node: String,
    pub path: PathSpec,
}

/// How it moves; at time 0 it stands where the glTF puts it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum PathSpec {
    /// Around a vertical or other axis through a point of the world.
    Orbit {
        center: [f64; 3],
        #[serde(default = "up")]
        axis: [f64; 3],
        period_s: f64,
    },
    /// About an axis through the middle of the node's bounding box.
    Spin {
        #[serde(default = "up")]
        axis: [f64; 3],
        period_s: f64,
    },
    /// There and back: `offset_m · sin(2π t / period_s)`.
    Translate { offset_m: [f64; 3], period_s: f64 },
}

fn up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}
