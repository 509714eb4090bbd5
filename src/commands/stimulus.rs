//! The renderer of studies, which turns requests into pictures for the store.

use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use anyhow::Context as _;
use cyclopean_analysis::journal::record::Film;

use crate::console::check_interrupted;
use crate::gpu::Gpu;
use crate::picture::{self, Part, StereoPicture};
use crate::render::{
    Ao, AoSettings, Method, Rendered, Renderer, Request, SETTLING, Settings, fast_ray_queries, identity, shaders,
};
use crate::scene::{self, HeadPath, Scene, SceneCache, StereoCamera, View};
use crate::study::sha256_hex;
use crate::study::stimulus::{STIMULUS_FILES, StimulusInfo, StimulusRenderer, StimulusRequest, frame_file};

use super::device;

/// Renders on one device. It keeps the last scene uploaded, because a study asks for the stimuli of one scene after
/// another.
pub struct GpuStimuli {
    gpu: Rc<Gpu>,
    scenes: SceneCache,
    renderer: Option<Renderer>,
}

/// The most frames of a moving stimulus: each has a file, whose hash is in a line of every journal.
const MOST_FRAMES: u32 = 10_000;

/// One request in the renderer's terms.
struct RenderJob {
    scene: Arc<Scene>,
    view: View,
    /// The path that the head follows from `view`, and the number of its frames that are shown; none: a still.
    film: Option<(HeadPath, u32)>,
    method: Method,
    settings: Settings,
}

impl GpuStimuli {
    /// A renderer on the device whose name contains `device`, or on the best one.
    ///
    /// # Errors
    /// No device.
    pub fn new(device: Option<&str>) -> anyhow::Result<GpuStimuli> {
        Ok(GpuStimuli::on(device::open(device)?, SceneCache::default()))
    }

    /// A renderer on an open device, with scenes that may be loaded already.
    pub fn on(gpu: Rc<Gpu>, scenes: SceneCache) -> GpuStimuli {
        GpuStimuli { gpu, scenes, renderer: None }
    }

    /// The device it renders on.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    fn scene(&self, name: &str) -> anyhow::Result<Arc<Scene>> {
        Ok(self.scenes.load(name)?)
    }

    fn job(&self, request: &StimulusRequest) -> anyhow::Result<RenderJob> {
        let scene = self.scene(&request.scene)?;
        let mut view = device::view(&scene, request.view.as_deref())?.clone();
        // The paper's studies show black where nothing is known of a reflection.
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
        // A stimulus is addressed by the method that is rendered, not by a name that means another method on another
        // device.
        let asked = Method::parse(&request.method)?.with_samples(request.samples);
        let method = asked.on(fast_ray_queries(&self.gpu, settings.trace));
        view.ipd_m = request.ipd_m;
        if let Some(degrees) = request.horizontal_fov_deg {
            let half = (degrees.to_radians() / 2.0).tan();
            view.vertical_fov_rad = 2.0 * (half / settings.aspect()).atan();
        }
        let film = match &request.path {
            None => None,
            Some(name) => {
                let path = scene.path(name, &view)?;
                let frames = path.frames_within(request.seconds.unwrap_or(f64::INFINITY));
                anyhow::ensure!(
                    frames <= MOST_FRAMES,
                    "{} has {frames} frames in the {} seconds that it is shown; a stimulus has {MOST_FRAMES} at the most",
                    request.label(),
                    request.seconds.unwrap_or_default()
                );
                Some((path, frames))
            }
        };
        Ok(RenderJob { scene, view, film, method, settings })
    }

    /// Renders a still into `into`.
    fn still(&mut self, job: &RenderJob, into: &Path) -> anyhow::Result<StimulusInfo> {
        let camera = job.camera(0);
        let asked = Request { camera: &camera, method: &job.method, settings: &job.settings, frames: 1 };
        let rendered = self.renderer(job)?.render(&asked, &mut |_, _| check_interrupted())?;
        let Rendered { linear, reflection, display, error, samples, .. } = &rendered;
        write_exr(into, linear, reflection)?;
        write_frame(into, 0, linear, display)?;
        let standard_error = error.as_ref().and_then(|error| mean_standard_error(error, reflection));
        Ok(self.info(job, *samples, standard_error))
    }

    /// Renders the frames of a path into `into`. A method that accumulates frames begins as if the head had been still
    /// before.
    fn film(&mut self, job: &RenderJob, (path, frames): (&HeadPath, u32), into: &Path) -> anyhow::Result<StimulusInfo> {
        let (view, seed) = (&job.view, job.settings.seed);
        let mut prepared = self.renderer(job)?.prepare(&job.camera(0), &job.method, &job.settings)?;
        let mut progress = |_, _| check_interrupted();
        prepared.follow(path, view, seed, 0)?;
        if prepared.needs().accumulate {
            for before in (1..SETTLING).rev() {
                prepared.set_seed(seed, 0u32.wrapping_sub(before));
                prepared.frame(&mut progress)?;
            }
        }
        let mut errors = Vec::new();
        for frame in 0..frames {
            prepared.follow(path, view, seed, frame)?;
            prepared.frame(&mut progress)?;
            let (linear, reflection) = (prepared.linear()?, prepared.reflection()?);
            if frame == 0 {
                write_exr(into, &linear, &reflection)?;
            }
            write_frame(into, frame, &linear, &prepared.display()?)?;
            let error = prepared.standard_error(&reflection)?;
            errors.extend(error.and_then(|error| mean_standard_error(&error, &reflection)));
        }
        self.gpu.check_validation()?;
        let standard_error = (!errors.is_empty()).then(|| errors.iter().sum::<f64>() / errors.len() as f64);
        let film = Some(Film { rate_hz: path.rate_hz, frames });
        Ok(StimulusInfo { film, ..self.info(job, job.method.samples(), standard_error) })
    }

    /// The renderer, with the job's scene uploaded.
    fn renderer(&mut self, job: &RenderJob) -> anyhow::Result<&mut Renderer> {
        if self.renderer.as_ref().is_none_or(|r| r.scene().content_sha256 != job.scene.content_sha256) {
            // The old scene's memory is freed first.
            self.renderer = None;
        }
        Ok(match &mut self.renderer {
            Some(renderer) => renderer,
            empty => {
                empty.insert(Renderer::new(&self.gpu, Arc::clone(&job.scene))?.keep_light_in(device::light_folder()))
            }
        })
    }

    fn info(&self, job: &RenderJob, samples: u32, standard_error: Option<f64>) -> StimulusInfo {
        let fov = job.camera(0).eye(scene::Eye::Left).fov;
        StimulusInfo {
            scene_sha256: Some(job.scene.content_sha256.clone()),
            shaders_sha256: Some(shaders::digest()),
            renderer: format!("cyclopean {} on {}", env!("CARGO_PKG_VERSION"), self.gpu.info().kind),
            samples,
            standard_error,
            horizontal_fov_deg: Some((fov.right_rad - fov.left_rad).to_degrees()),
            inconsistency: None,
            film: None,
        }
    }
}

impl RenderJob {
    /// The eyes of a frame; a still has one.
    fn camera(&self, frame: u32) -> StereoCamera {
        let aspect = self.settings.aspect();
        match &self.film {
            None => self.view.stereo_camera(aspect),
            Some((path, _)) => path.view(&self.view, frame).stereo_camera(aspect),
        }
    }
}

impl StimulusRenderer for GpuStimuli {
    fn identity(&self, request: &StimulusRequest) -> anyhow::Result<String> {
        let job = self.job(request)?;
        let RenderJob { scene, film, method, settings, .. } = &job;
        let of = |frame: u32| identity(scene, &job.camera(frame), method, settings, self.gpu.info().kind);
        let Some((path, frames)) = film else { return Ok(of(0)?) };
        // The hash covers every frame's camera and the rate, because the motion of the scene itself follows from both.
        let frames = (0..*frames).map(of).collect::<Result<Vec<String>, _>>()?;
        let all = serde_json::json!({ "rate_hz": path.rate_hz, "frames": frames });
        Ok(sha256_hex(&serde_json::to_vec(&all)?))
    }

    fn render(&mut self, request: &StimulusRequest, into: &Path) -> anyhow::Result<StimulusInfo> {
        let job = self.job(request)?;
        match &job.film {
            None => self.still(&job, into),
            Some((path, frames)) => self.film(&job, (path, *frames), into),
        }
    }
}

fn ambient_occlusion(request: &StimulusRequest) -> anyhow::Result<Ao> {
    let Some(name) = &request.ao else { return Ok(Ao::None) };
    Ao::ALL.into_iter().find(|ao| ao.name() == name).with_context(|| format!("unknown ambient occlusion `{name}`"))
}

fn write_exr(into: &Path, linear: &StereoPicture, reflection: &StereoPicture) -> Result<(), picture::PictureError> {
    let parts = [Part { layer: "", picture: linear }, Part { layer: "reflection", picture: reflection }];
    picture::write_exr(&into.join(STIMULUS_FILES[1]), &parts)
}

/// Writes the files of one frame. `display`: both eyes' display values, of the size of `linear`.
fn write_frame(
    into: &Path,
    frame: u32,
    linear: &StereoPicture,
    [left, right]: &[Vec<u8>; 2],
) -> Result<(), picture::PictureError> {
    picture::write_side_by_side(&into.join(frame_file(frame)), linear.width, linear.height, [left, right])
}

/// Mean standard error of the luminance, over the pixels that reflect. The channels come from the same paths, so their
/// errors add up linearly. This is exact for grey light, and an upper bound for any other.
fn mean_standard_error(error: &StereoPicture, reflection: &StereoPicture) -> Option<f64> {
    let luminance = |c: &[f32; 3]| f64::from(0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]);
    let pixels = error.eyes.iter().flatten().zip(reflection.eyes.iter().flatten());
    let values: Vec<f64> = pixels.filter(|(_, r)| **r != [0.0; 3]).map(|(e, _)| luminance(e)).collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
