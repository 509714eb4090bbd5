//! What a study asks of a renderer, and what a build can render. The renderer itself is behind a trait.

use std::path::Path;

use cyclopean_analysis::journal::record::{Film, Shown};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::definition::presentation::{is_false, is_true, yes};
use super::definition::{ConditionSpec, Definition};

/// One stimulus: both eyes of one view by one method, still or along a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StimulusRequest {
    /// Scene name.
    pub scene: String,
    /// View name; none: the scene's first.
    pub view: Option<String>,
    /// The path that the head follows; none: a still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// Longest time for which the stimulus is shown without interruption, and so moves, seconds. None for a still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// Method name, without `@samples`.
    pub method: String,
    /// Samples per pixel; none: the method's own default.
    pub samples: Option<u32>,
    /// Width of each eye's image, pixels.
    pub width_px: u32,
    /// Height of each eye's image, pixels.
    pub height_px: u32,
    /// Distance between the eyes, metres.
    pub ipd_m: f64,
    /// Horizontal field of view per eye, degrees; none: the view's own.
    pub horizontal_fov_deg: Option<f64>,
    /// Seed of the renderer's samples.
    pub seed: u64,
    /// Samples along a side of each pixel; none: 2 where graphics hardware renders, 1 in software.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub antialias: Option<u32>,
    /// Whether lights cast shadows.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub shadows: bool,
    /// Whether indirect diffuse light is used instead of the environment's.
    #[serde(default, skip_serializing_if = "is_false")]
    pub indirect: bool,
    /// Method of ambient occlusion; none: nothing occludes ambient light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ao: Option<String>,
}

impl StimulusRequest {
    /// The request for one method of a condition.
    pub fn new(definition: &Definition, condition: &ConditionSpec, method: &str) -> StimulusRequest {
        let stimuli = &definition.stimuli;
        let (name, _) = split_method(method);
        let shown = definition.protocol.iter().filter(|segment| segment.show != Shown::Blank);
        let longest = shown.map(|segment| segment.seconds).fold(0.0, f64::max);
        StimulusRequest {
            scene: condition.scene.clone(),
            view: condition.view.clone(),
            path: condition.path.clone(),
            seconds: condition.path.is_some().then_some(longest),
            method: name.to_owned(),
            samples: StimulusRequest::samples(definition, method),
            width_px: stimuli.width_px,
            height_px: stimuli.height_px,
            ipd_m: stimuli.ipd_m,
            horizontal_fov_deg: stimuli.horizontal_fov_deg,
            seed: stimuli.seed,
            antialias: stimuli.antialias,
            shadows: stimuli.shadows,
            indirect: stimuli.indirect,
            ao: stimuli.ao.clone().filter(|name| name != "none"),
        }
    }

    /// The samples per pixel that a study asks of a method; none: the method's own default.
    pub fn samples(definition: &Definition, method: &str) -> Option<u32> {
        let (name, written) = split_method(method);
        written.or_else(|| definition.stimuli.samples.get(name).copied())
    }

    /// A name for messages: `pica/default by sssr`, `pica/default along sway by sssr`.
    pub fn label(&self) -> String {
        let view = self.view.as_deref().unwrap_or("default");
        let path = self.path.as_ref().map(|path| format!(" along {path}")).unwrap_or_default();
        let samples = self.samples.map(|n| format!("@{n}")).unwrap_or_default();
        format!("{}/{view}{path} by {}{samples}", self.scene, self.method)
    }
}

/// `NAME@N` → name and samples. A suffix that is no positive number stays part of the name, and no catalogue knows such
/// a name.
pub fn split_method(method: &str) -> (&str, Option<u32>) {
    match method.split_once('@').map(|(name, n)| (name, n.parse::<u32>())) {
        Some((name, Ok(n))) if n > 0 => (name, Some(n)),
        _ => (method, None),
    }
}

/// What the renderer states about a stimulus that it made. It is deterministic: no times, no host.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct StimulusInfo {
    /// SHA-256 (hex) of the scene's bytes.
    pub scene_sha256: Option<String>,
    /// SHA-256 (hex) of the shaders.
    pub shaders_sha256: Option<String>,
    /// Name and version of the renderer, and the kind of device.
    pub renderer: String,
    /// Samples per pixel that were taken.
    pub samples: u32,
    /// Mean standard error of a pixel's luminance, linear; none where the method has no estimate.
    pub standard_error: Option<f64>,
    /// Horizontal field of view per eye, degrees; none in stores of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizontal_fov_deg: Option<f64>,
    /// Measured systematic inconsistency between the eyes, linear luminance; none where it was not measured.
    pub inconsistency: Option<f64>,
    /// Its frames, if it moves; none: a still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub film: Option<Film>,
}

impl StimulusInfo {
    /// Names of the stimulus's files: [`STIMULUS_FILES`], and one more for each frame of a film after the first.
    pub fn files(&self) -> Vec<String> {
        let more = self.film.map_or(0..0, |film| 1..film.frames).map(frame_file);
        STIMULUS_FILES.into_iter().map(str::to_owned).chain(more).collect()
    }
}

/// Renders stimuli.
pub trait StimulusRenderer {
    /// The content address: SHA-256 (hex) over scene bytes, shaders, method, camera, settings, renderer version and
    /// device kind. Equal addresses promise equal bytes.
    ///
    /// # Errors
    /// The scene cannot be loaded, or the method does not exist.
    fn identity(&self, request: &StimulusRequest) -> anyhow::Result<String>;

    /// Writes `stereo.exr` (linear, multi-view) and `sbs.png` into the existing empty folder `into`. For a stimulus
    /// along a path, these are the first frame; [`frame_file`] names the others.
    ///
    /// # Errors
    /// What failed; the caller removes the folder.
    fn render(&mut self, request: &StimulusRequest, into: &Path) -> anyhow::Result<StimulusInfo>;
}

/// The files of every stimulus.
pub const STIMULUS_FILES: [&str; 2] = ["sbs.png", "stereo.exr"];

/// The file of a frame of a moving stimulus: display values of the left and the right eye, side by side; frame 0 is
/// `sbs.png`.
pub fn frame_file(frame: u32) -> String {
    match frame {
        0 => STIMULUS_FILES[0].to_owned(),
        _ => format!("sbs_{frame:05}.png"),
    }
}

/// What this build can render.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Catalogue {
    pub scenes: Vec<CatalogueScene>,
    /// Names of methods, without `@samples`.
    pub methods: Vec<String>,
    /// Methods whose name may end in a percentage, such as `stereo-hybrid-25`.
    pub with_percentage: Vec<String>,
    /// Methods of ambient occlusion.
    pub ao: Vec<String>,
    /// Paths of the head that every scene has.
    pub paths: Vec<String>,
}

/// A scene and its views. Without views only the default one can be asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CatalogueScene {
    pub name: String,
    pub views: Vec<String>,
    /// Paths of this scene, besides [`Catalogue::paths`].
    pub paths: Vec<String>,
}

impl Catalogue {
    /// A catalogue of these names, in which every scene has only its default view.
    pub fn of(scenes: &[&str], methods: &[&str]) -> Catalogue {
        let scene = |name: &&str| CatalogueScene { name: (*name).to_owned(), views: Vec::new(), paths: Vec::new() };
        let scenes = scenes.iter().map(scene);
        let methods = methods.iter().map(|m| (*m).to_owned()).collect();
        Catalogue { scenes: scenes.collect(), methods, ..Catalogue::default() }
    }

    /// The same, with methods whose name may end in a percentage.
    pub fn with_percentage(self, methods: &[&str]) -> Catalogue {
        Catalogue { with_percentage: methods.iter().map(|m| (*m).to_owned()).collect(), ..self }
    }

    /// The same, with these methods of ambient occlusion.
    pub fn with_ao(self, methods: &[&str]) -> Catalogue {
        Catalogue { ao: methods.iter().map(|m| (*m).to_owned()).collect(), ..self }
    }

    /// The same, with these paths of the head in every scene.
    pub fn with_paths(self, paths: &[&str]) -> Catalogue {
        Catalogue { paths: paths.iter().map(|p| (*p).to_owned()).collect(), ..self }
    }

    /// Every path that a scene's stimuli can follow.
    pub fn paths_of<'a>(&'a self, scene: &'a CatalogueScene) -> Vec<&'a str> {
        scene.paths.iter().chain(&self.paths).map(String::as_str).collect()
    }

    /// Whether this build renders a method of this name. `@samples` and a percentage from 0 to 100 may be part of it.
    pub fn has_method(&self, method: &str) -> bool {
        let (name, _) = split_method(method);
        let digits = |p: &str| p.chars().all(|c| c.is_ascii_digit() || c == '.');
        let is_percentage =
            |p: &str| digits(p) && p.parse::<f64>().is_ok_and(|percent| (0.0..=100.0).contains(&percent));
        self.methods.iter().any(|m| m == name)
            || name
                .rsplit_once('-')
                .is_some_and(|(stem, percent)| self.with_percentage.iter().any(|m| m == stem) && is_percentage(percent))
    }
}
