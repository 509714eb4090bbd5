//! The settings of a picture: everything that changes it besides the scene, the camera and the method. The commands and `compare`
//! set them; they are written to `render.json` and are part of a picture's address.

use crate::scene::{Fallback, Scene};

use super::ao::settings::AoSettings;
use super::method::{Method, Reuse, Temporal};

/// How the random streams of the eyes are related.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Streams {
    /// Each eye has a stream of its own.
    #[default]
    Independent,
    /// Both eyes have the same stream.
    Shared,
}

/// What the resolve does with taps that are much brighter than the pixel's other taps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Firefly {
    /// Nothing, which is unbiased.
    None,
    /// Weights each tap by 1/(1 + luminance), which reduces noise but is too dark wherever bright samples matter.
    ToneMapped,
    /// Bounds each tap to a fifth of the pixel's light plus a fiftieth of display white, which is too dark only where fewer than
    /// five of 25 taps agree on a bright light.
    BoundedShare,
}

/// What traces rays through the scene's geometry. All choices give the same hits, except for rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Trace {
    /// Ray queries on a graphics card that has them, otherwise the BVH; on a software device the same as `cpu`.
    #[default]
    Auto,
    /// The shader traverses a BVH in textures, which works on every device.
    Bvh,
    /// `VK_KHR_ray_query`.
    RayQuery,
    /// The processor traces the reference's paths and the shadows in the views, on all cores; other rays as with `auto`.
    Cpu,
}

/// How the shadows in the views are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Shadows {
    /// By rays through the scene's geometry, once for each view.
    #[default]
    Rays,
    /// In shadow maps drawn once for each scene, which are coarser, but quick where rays are slow.
    Maps,
}

impl Shadows {
    fn are_by_rays(&self) -> bool {
        *self == Shadows::Rays
    }
}

/// Whether the right eye's pixels take the light of punctual lights from the left eye's pixels that show the same place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ShadingReuse {
    /// Each eye is lit in full.
    #[default]
    Off,
    /// Shading is shared where the scene's lights cost more than sharing.
    Auto,
    /// Shading is shared wherever there is a light, for comparisons.
    Always,
}

impl ShadingReuse {
    /// Whether each eye is lit in full, whatever the scene.
    pub fn is_off(&self) -> bool {
        *self == ShadingReuse::Off
    }
}

/// Everything that changes a picture besides scene, view and method.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Settings {
    /// Pixels of one eye.
    pub width: u32,
    pub height: u32,
    pub seed: u32,
    /// Index of the frame in its sequence; the random numbers depend on it.
    pub frame: u32,
    pub streams: Streams,
    /// How taps are weighted, unless the method fixes it.
    pub reuse: Reuse,
    /// How a new frame is weighted against the history, unless the method fixes it. The default is not written, so that such a
    /// picture keeps its address.
    #[serde(skip_serializing_if = "is_default")]
    pub temporal: Temporal,
    /// `None`: [`Firefly::BoundedShare`] with [`Reuse::Balance`], [`Firefly::None`] with [`Reuse::Ratio`].
    pub firefly: Option<Firefly>,
    /// What stands in for unknown rays; `None`: what the scene says.
    pub fallback: Option<Fallback>,
    /// Perceptual roughness above which no ray is traced.
    pub ray_roughness_limit: f32,
    /// Perceptual roughness below which a surface is a mirror.
    pub delta_roughness: f32,
    /// Width of the fade at a view's border, as a fraction of its size; 0: no fade.
    pub edge_fade: f32,
    /// Radius of the spatial reuse, pixels; 2: 5×5 pixels (paper §5).
    pub reuse_radius: u32,
    /// Steps after which a march gives up and its ray is unknown.
    pub max_steps: u32,
    pub trace: Trace,
    /// Whether lights cast shadows.
    pub shadows: bool,
    /// How they are found. [`Shadows::Rays`] is not written, so that such a picture keeps its address.
    #[serde(skip_serializing_if = "Shadows::are_by_rays")]
    pub shadows_by: Shadows,
    /// Baked indirect diffuse light replaces the environment's diffuse light.
    pub indirect: bool,
    /// Rays from each pixel in a penumbra to its light: 1 to 1,024.
    pub soft_shadow_rays: u32,
    /// [`ShadingReuse::Off`] is not written, so that such a picture keeps its address.
    #[serde(skip_serializing_if = "ShadingReuse::is_off")]
    pub shading_reuse: ShadingReuse,
    /// Samples of surfaces and their light along each side of a pixel, 1 to 4; 1: no antialiasing.
    pub antialias: u32,
    /// Ambient occlusion. If it is off it is not written, so that such a picture keeps its address.
    #[serde(skip_serializing_if = "AoSettings::is_off")]
    pub ao: AoSettings,
    /// Runs passes that are not needed, too. The picture must not change, which tests check.
    pub all_passes: bool,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            width: 1920,
            height: 1080,
            seed: 1,
            frame: 0,
            streams: Streams::Independent,
            reuse: Reuse::Balance,
            temporal: Temporal::Variance,
            firefly: None,
            fallback: None,
            ray_roughness_limit: 0.8,
            delta_roughness: 0.03,
            edge_fade: 0.1,
            reuse_radius: 2,
            max_steps: 256,
            trace: Trace::Auto,
            shadows: true,
            shadows_by: Shadows::Rays,
            indirect: false,
            soft_shadow_rays: 16,
            shading_reuse: ShadingReuse::Off,
            antialias: 1,
            ao: AoSettings::default(),
            all_passes: false,
        }
    }
}

impl Settings {
    /// What stands in for unknown rays.
    pub fn fallback(&self, scene: &Scene) -> Fallback {
        self.fallback.unwrap_or(scene.fallback)
    }

    /// How a method's taps are weighted.
    pub fn reuse(&self, method: &Method) -> Reuse {
        method.technique().reuse.unwrap_or(self.reuse)
    }

    /// How a method's frames are accumulated; `None`: they are not accumulated.
    pub fn temporal(&self, method: &Method) -> Option<Temporal> {
        method.technique().accumulation.map(|a| a.weights.unwrap_or(self.temporal))
    }

    /// What is done with a method's bright taps.
    pub fn firefly(&self, method: &Method) -> Firefly {
        self.firefly.unwrap_or(match self.reuse(method) {
            Reuse::Balance => Firefly::BoundedShare,
            Reuse::Ratio => Firefly::None,
        })
    }

    /// Width over height of one eye.
    pub fn aspect(&self) -> f64 {
        f64::from(self.width) / f64::from(self.height)
    }
}

fn is_default(temporal: &Temporal) -> bool {
    *temporal == Temporal::default()
}

#[cfg(test)]
mod tests {
    use super::super::method::Ao;
    use super::*;

    #[test]
    fn shadows_by_rays_are_written_as_ever() {
        let written = |shadows_by| serde_json::to_value(Settings { shadows_by, ..Settings::default() }).expect("JSON");
        assert!(written(Shadows::Rays).get("shadows_by").is_none());
        assert_eq!(written(Shadows::Maps)["shadows_by"], "maps");
    }

    #[test]
    fn settings_without_occlusion_are_written_as_ever() {
        let written = |settings: &Settings| serde_json::to_value(settings).expect("JSON");
        let off = AoSettings { radius_m: 2.0, ..AoSettings::default() };
        assert_eq!(written(&Settings { ao: off, ..Settings::default() }), written(&Settings::default()));
        assert!(written(&Settings::default()).get("ao").is_none());
        let on = AoSettings { method: Ao::Variant1, ..off };
        let ao = &written(&Settings { ao: on, ..Settings::default() })["ao"];
        assert_eq!((&ao["method"], &ao["radius_m"]), (&"variant1".into(), &2.0.into()));
    }
}
