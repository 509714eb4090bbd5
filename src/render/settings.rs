//! How to render, apart from the scene, the view and the method.

use crate::scene::{Fallback, Scene};

use super::ao::settings::AoSettings;
use super::method::{Method, Reuse, Temporal};

/// The random streams of the eyes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Streams {
    /// One each.
    #[default]
    Independent,
    /// The same for both.
    Shared,
}

/// What the resolve does with taps that are much brighter than the pixel's other taps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Firefly {
    /// Nothing: unbiased.
    None,
    /// Weights each tap by 1/(1 + luminance): calmer, and too dark wherever bright samples matter.
    ToneMapped,
    /// Bounds each tap to a fifth of the pixel's light plus a fiftieth of display white: dark only where fewer than five
    /// of 25 taps agree on a bright light.
    BoundedShare,
}

/// How rays through the scene's geometry find what they hit. All ways answer alike, but for rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Trace {
    /// Ray queries where a graphics card has them, else the BVH; the reference's paths on a software device: `cpu`.
    #[default]
    Auto,
    /// A BVH in textures, walked by the shader: every device.
    Bvh,
    /// `VK_KHR_ray_query`.
    RayQuery,
    /// The processor traces the reference's paths, on all cores; other rays go as with `auto`.
    Cpu,
}

/// How the shadows of lights on the views are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Shadows {
    /// By rays through the scene's geometry, once a view.
    #[default]
    Rays,
    /// In depth maps drawn from the lights, once a scene: coarser, and quick where rays are slow.
    Maps,
}

impl Shadows {
    fn are_by_rays(&self) -> bool {
        *self == Shadows::Rays
    }
}

/// Whether the right eye's pixels take from the left eye's what lights put on them, where both show one place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ShadingReuse {
    /// Each eye is lit in full.
    #[default]
    Off,
    /// Where the scene's lights cost more than the test.
    Auto,
    /// Wherever there is a light, for comparisons.
    Always,
}

impl ShadingReuse {
    /// Each eye is lit in full, whatever the scene.
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
    /// Index of the frame in its sequence: part of the random numbers.
    pub frame: u32,
    pub streams: Streams,
    /// How taps are weighted, unless the method says it itself.
    pub reuse: Reuse,
    /// How a new frame is weighed against the frames before it, unless the method says it itself; left out of what is
    /// written where it is the default.
    #[serde(skip_serializing_if = "is_default")]
    pub temporal: Temporal,
    /// `None`: `BoundedShare` with [`Reuse::Balance`], nothing with [`Reuse::Ratio`].
    pub firefly: Option<Firefly>,
    /// Overrides the scene's.
    pub fallback: Option<Fallback>,
    /// Perceptual roughness above which no ray is traced.
    pub ray_roughness_limit: f32,
    /// Perceptual roughness below which a surface is a mirror.
    pub delta_roughness: f32,
    /// Width of the fade at a view's border, as a fraction of its size; 0 = none.
    pub edge_fade: f32,
    /// Radius of the spatial reuse, pixels; 2 = 5×5 (paper §5).
    pub reuse_radius: u32,
    /// Steps of a march before its answer is *unknown*.
    pub max_steps: u32,
    pub trace: Trace,
    /// Lights cast shadows.
    pub shadows: bool,
    /// Left out of what is written where rays find them, so that such a picture keeps its address.
    #[serde(skip_serializing_if = "Shadows::are_by_rays")]
    pub shadows_by: Shadows,
    /// Indirect diffuse light, gathered once a scene, stands in for the environment's.
    pub indirect: bool,
    /// Rays to a light that has a size, of each pixel in its penumbra: 1 to 1,024.
    pub soft_shadow_rays: u32,
    /// Left out of what is written where it is off, so that such a picture keeps its address.
    #[serde(skip_serializing_if = "ShadingReuse::is_off")]
    pub shading_reuse: ShadingReuse,
    /// Samples along a side of each pixel, of surfaces and their light; 1: no antialiasing. 1 to 4.
    pub antialias: u32,
    /// Left out of what is written where nothing is occluded, so that a picture without it keeps its address.
    #[serde(skip_serializing_if = "AoSettings::is_off")]
    pub ao: AoSettings,
    /// Run every pass, needed or not: the picture must not change.
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
    /// What unknown rays see.
    pub fn fallback(&self, scene: &Scene) -> Fallback {
        self.fallback.unwrap_or(scene.fallback)
    }

    /// How a method's taps are weighted.
    pub fn reuse(&self, method: &Method) -> Reuse {
        method.parts().reuse.unwrap_or(self.reuse)
    }

    /// How a method's frames are accumulated; `None`: each stands for itself.
    pub fn temporal(&self, method: &Method) -> Option<Temporal> {
        method.parts().accumulation.map(|a| a.weights.unwrap_or(self.temporal))
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
