//! The studies' renderer: requests become pictures in the store.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use anyhow::Context as _;

use crate::console::check_interrupted;
use crate::gpu::Gpu;
use crate::picture::{self, Part};
use crate::render::{
    Ao, AoSettings, Method, Rendered, Renderer, Request, Settings, fast_ray_queries, identity, shaders,
};
use crate::scene::{self, Scene, StereoCamera, builtin};
use crate::study::stimulus::{Catalogue, CatalogueScene, StimulusInfo, StimulusRenderer, StimulusRequest};

use super::device;

/// Renders on one device; keeps the last scene uploaded, because a study asks for one scene after another.
pub struct GpuStimuli {
    gpu: Rc<Gpu>,
    scenes: RefCell<HashMap<String, Arc<Scene>>>,
    renderer: Option<Renderer>,
}

/// What one request means to the renderer.
struct Job {
    scene: Arc<Scene>,
    camera: StereoCamera,
    method: Method,
    settings: Settings,
}

/// The built-in scenes with their views, and every method.
pub fn catalogue() -> Catalogue {
    let scenes = builtin::NAMES.iter().map(|&name| {
        let views = builtin::manifest(name)
            .and_then(|text| serde_json::from_str::<scene::manifest::Manifest>(text).ok())
            .map(|manifest| manifest.views.iter().map(|v| v.name.clone()).collect())
            .unwrap_or_default();
        CatalogueScene { name: name.to_owned(), views }
    });
    let owned = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect();
    Catalogue {
        scenes: scenes.collect(),
        methods: owned(Method::names()),
        with_percentage: owned(Method::names_with_percentage()),
        ao: owned(Ao::ALL.into_iter().filter(|ao| *ao != Ao::None).map(Ao::name).collect()),
    }
}

impl GpuStimuli {
    /// On the best device.
    ///
    /// # Errors
    /// No device.
    pub fn new(device: Option<&str>) -> anyhow::Result<GpuStimuli> {
        Ok(GpuStimuli { gpu: device::open(device)?, scenes: RefCell::default(), renderer: None })
    }

    /// The device it renders on.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    fn scene(&self, name: &str) -> anyhow::Result<Arc<Scene>> {
        if let Some(scene) = self.scenes.borrow().get(name) {
            return Ok(Arc::clone(scene));
        }
        let scene = Arc::new(scene::load(name)?);
        self.scenes.borrow_mut().insert(name.to_owned(), Arc::clone(&scene));
        Ok(scene)
    }

    fn job(&self, request: &StimulusRequest) -> anyhow::Result<Job> {
        let scene = self.scene(&request.scene)?;
        let mut view = device::view(&scene, request.view.as_deref())?.clone();
        // The paper's studies show black where nothing is known.
        let settings = Settings {
            width: request.width_px,
            height: request.height_px,
            seed: u32::try_from(request.seed).context("stimuli.seed is beyond 32 bits")?,
            fallback: Some(scene::Fallback::Black),
            antialias: request.antialias.unwrap_or(if self.gpu.is_cpu() { 1 } else { 2 }),
            shadows: request.shadows,
            indirect: request.indirect,
            ao: AoSettings { method: ambient_occlusion(request)?, ..AoSettings::default() },
            ..Settings::default()
        };
        // A stimulus is addressed by what is rendered, not by a name that means something else on another device.
        let asked = Method::parse(&request.method)?.with_samples(request.samples);
        let method = asked.on(fast_ray_queries(&self.gpu, settings.trace));
        view.ipd_m = request.ipd_m;
        if let Some(degrees) = request.horizontal_fov_deg {
            let half = (degrees.to_radians() / 2.0).tan();
            view.vertical_fov_rad = 2.0 * (half / settings.aspect()).atan();
        }
        let camera = view.stereo_camera(settings.aspect());
        Ok(Job { scene, camera, method, settings })
    }
}

impl StimulusRenderer for GpuStimuli {
    fn identity(&self, request: &StimulusRequest) -> anyhow::Result<String> {
        let job = self.job(request)?;
        let Job { scene, camera, method, settings } = &job;
        Ok(identity(scene, camera, method, settings, self.gpu.info().kind)?)
    }

    fn render(&mut self, request: &StimulusRequest, into: &Path) -> anyhow::Result<StimulusInfo> {
        let job = self.job(request)?;
        if self.renderer.as_ref().is_none_or(|r| r.scene().content_sha256 != job.scene.content_sha256) {
            // The old scene's memory goes first.
            self.renderer = None;
        }
        let renderer = match &mut self.renderer {
            Some(renderer) => renderer,
            empty => {
                empty.insert(Renderer::new(&self.gpu, Arc::clone(&job.scene))?.keep_light_in(device::light_folder()))
            }
        };
        let asked = Request { camera: &job.camera, method: &job.method, settings: &job.settings, frames: 1 };
        let rendered = renderer.render(&asked, &mut |_, _| check_interrupted())?;
        write(into, &rendered)?;
        Ok(StimulusInfo {
            scene_sha256: Some(job.scene.content_sha256.clone()),
            shaders_sha256: Some(shaders::digest()),
            renderer: format!("cyclopean {} on {}", env!("CARGO_PKG_VERSION"), self.gpu.info().kind),
            samples: rendered.samples,
            standard_error: mean_standard_error(&rendered),
            horizontal_fov_deg: Some({
                let fov = job.camera.eye(scene::Eye::Left).fov;
                (fov.right_rad - fov.left_rad).to_degrees()
            }),
            inconsistency: None,
        })
    }
}

fn ambient_occlusion(request: &StimulusRequest) -> anyhow::Result<Ao> {
    let Some(name) = &request.ao else { return Ok(Ao::None) };
    Ao::ALL.into_iter().find(|ao| ao.name() == name).with_context(|| format!("unknown ambient occlusion `{name}`"))
}

fn write(into: &Path, rendered: &Rendered) -> Result<(), picture::PictureError> {
    let parts =
        [Part { layer: "", picture: &rendered.linear }, Part { layer: "reflection", picture: &rendered.reflection }];
    picture::write_exr(&into.join("stereo.exr"), &parts)?;
    let (width, height) = (rendered.linear.width, rendered.linear.height);
    let [left, right] = &rendered.display;
    picture::write_side_by_side(&into.join("sbs.png"), width, height, [left, right])
}

/// Of the luminance, over the pixels that reflect. The channels come from the same paths, so their errors add up
/// linearly: exact for grey light, an upper bound for any.
fn mean_standard_error(rendered: &Rendered) -> Option<f64> {
    let error = rendered.error.as_ref()?;
    let luminance = |c: &[f32; 3]| f64::from(0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]);
    let pixels = error.eyes.iter().flatten().zip(rendered.reflection.eyes.iter().flatten());
    let values: Vec<f64> = pixels.filter(|(_, r)| **r != [0.0; 3]).map(|(e, _)| luminance(e)).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
