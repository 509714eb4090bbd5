//! A scene on a device, and stereo stills of it, with times and counters.
//!
//! `render`, `prepare` and `stress` call [`Renderer::render`]; `compare` and the live views call [`Renderer::prepare`] and render
//! the frames themselves.

use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

use glam::DVec3;

use crate::console::Interrupted;
use crate::gpu::{Gpu, GpuError, Image, PassTime};
use crate::picture::StereoPicture;
use crate::scene::{Scene, StereoCamera};

use super::baked::BakedLight;
use super::brdf_table::brdf_table;
use super::bvh::{RayScene, fast_ray_queries};
use super::context::Context;
use super::cpu;
use super::error::{MOST_PIXELS, RenderError};
use super::framing::Framing;
use super::lazy_rays::LazyRays;
use super::method::{Ao, Method};
use super::needs::{FrameNeeds, PassDecision};
use super::prepared::{Prepared, SceneOnDevice};
use super::probe::probe;
use super::settings::Settings;
use super::shadow_maps::ShadowMaps;
use super::shared::Counts;
use super::supersampled::SupersampledView;
use super::upload::{EnvironmentMaps, SceneResources};

/// A stereo still, and how it was made.
pub struct Rendered {
    /// Linear radiance.
    pub linear: StereoPicture,
    /// The outgoing reflection alone; zero where none was traced.
    pub reflection: StereoPicture,
    /// Standard error of the reflection's mean, per channel; the reference only.
    pub error: Option<StereoPicture>,
    /// How much of its surroundings each pixel sees, in all three channels; `None` where ambient light is not occluded.
    pub ambient_visibility: Option<StereoPicture>,
    /// sRGB bytes (RGBA) by eye.
    pub display: [Vec<u8>; 2],
    /// Median over the frames, in the order of the passes.
    pub passes: Vec<PassTime>,
    /// Wall time of each frame, ms.
    pub frame_ms: Vec<f64>,
    /// Of the last frame.
    pub counters: Counts,
    pub parts: Vec<PassDecision>,
    pub left_out: Vec<PassDecision>,
    /// Rays or paths for each pixel.
    pub samples: u32,
    /// The method that was rendered: the requested one, or the one that it stands for on this device.
    pub method: String,
    /// What traced rays through the geometry: `bvh`, `ray-query` or, for the reference's paths, `cpu`. `None` without such rays.
    pub tracer: Option<&'static str>,
}

/// What to render.
pub struct Request<'a> {
    pub camera: &'a StereoCamera,
    pub method: &'a Method,
    pub settings: &'a Settings,
    /// Number of frames to time. If it is more than one, a further frame is rendered first to warm up. A method that accumulates
    /// frames renders at least [`SETTLING`] of them.
    pub frames: u32,
}

/// A scene on a device, ready for any view and method.
pub struct Renderer {
    gpu: Rc<Gpu>,
    scene: Arc<Scene>,
    resources: Rc<SceneResources>,
    rays: Rc<LazyRays>,
    /// With the shaders' specialisation with which it was traced ([`FrameNeeds::of_hits`]).
    probe: Option<([u32; 4], Rc<EnvironmentMaps>)>,
    /// Likewise.
    baked: Option<([u32; 4], Rc<BakedLight>)>,
    /// The folder in which baked light is kept for later runs of the program.
    light_folder: Option<PathBuf>,
    /// Made for the first view whose shadows are looked up in maps.
    shadow_maps: Option<Rc<ShadowMaps>>,
    /// A placeholder for baked light.
    placeholder: Rc<BakedLight>,
    /// With the value of `delta_roughness` for which it was made.
    brdf_table: Option<(f32, Rc<Image>)>,
}

impl Renderer {
    /// Uploads the scene.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn new(gpu: &Rc<Gpu>, scene: Arc<Scene>) -> Result<Renderer, GpuError> {
        let resources = Rc::new(SceneResources::new(gpu, &scene)?);
        let rays = Rc::new(LazyRays::new(gpu, &scene, &resources));
        Ok(Renderer {
            placeholder: Rc::new(BakedLight::placeholder(gpu)?),
            gpu: Rc::clone(gpu),
            scene,
            resources,
            rays,
            probe: None,
            baked: None,
            shadow_maps: None,
            light_folder: None,
            brdf_table: None,
        })
    }

    /// Another scene on the same device. What does not depend on the scene is kept.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn with_scene(self, scene: Arc<Scene>) -> Result<Renderer, GpuError> {
        let Renderer { gpu, brdf_table, light_folder, scene: old, resources, rays, probe, baked, shadow_maps, .. } =
            self;
        // The old scene's memory is freed before the new scene is uploaded.
        drop((old, resources, rays, probe, baked, shadow_maps));
        Ok(Renderer { brdf_table, light_folder, ..Renderer::new(&gpu, scene)? })
    }

    /// Stores baked light in a folder, and reads it from there if it is already stored.
    pub fn keep_light_in(self, folder: PathBuf) -> Renderer {
        Renderer { light_folder: Some(folder), ..self }
    }

    fn baked_light(
        &mut self,
        needs: &FrameNeeds,
        context: &Context,
        rays: &RayScene,
    ) -> Result<Rc<BakedLight>, RenderError> {
        let light = needs.of_hits();
        match &self.baked {
            Some((of, baked)) if *of == light => Ok(Rc::clone(baked)),
            _ => {
                let scene = (&*self.resources, rays);
                let folder = self.light_folder.as_deref();
                let made = BakedLight::obtain(&self.gpu, &self.scene, scene, (context, needs), folder)?;
                let made = Rc::new(made);
                self.baked = Some((light, Rc::clone(&made)));
                Ok(made)
            }
        }
    }

    /// The device that it renders on.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Makes a view and a method ready for any number of frames.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn prepare(
        &mut self,
        camera: &StereoCamera,
        method: &Method,
        settings: &Settings,
    ) -> Result<Prepared, RenderError> {
        let method = &method.on(fast_ray_queries(&self.gpu, settings.trace));
        let needs = FrameNeeds::of(&self.scene, method, settings);
        let needs = match cpu::traces(method, settings.trace, self.gpu.info().kind) {
            true => needs.with_paths_on_the_cpu(),
            false => needs,
        };
        let needs = match cpu::is_chosen(settings.trace, self.gpu.info().kind) {
            true => needs.with_shadows_on_the_cpu(settings.shading_reuse),
            false => needs,
        };
        let framing = Framing::of(method, settings);
        let (eyes, drawn) = (framing.camera(camera), framing.settings(settings));
        if drawn.width.max(drawn.height) > MOST_PIXELS / settings.antialias.max(1) {
            return Err(RenderError::TooLarge { width: drawn.width, height: drawn.height });
        }
        let table = self.brdf_table(settings.delta_roughness)?;
        let placeholder = Rc::clone(&self.placeholder);
        let view = (&eyes, &drawn, framing.guard);
        let mut context =
            Context::new(&self.gpu, &self.scene, &self.resources, (Rc::clone(&table), placeholder), view)?;
        let light = needs.of_hits();
        let probe_fits = self.probe.as_ref().is_some_and(|(of, _)| *of == light);
        let asks_geometry = needs.path_trace && !needs.cpu_paths
            || needs.device_shadow_rays()
            || needs.indirect
            || needs.ao == Ao::RayTraced
            || needs.probe && !probe_fits;
        let rays = asks_geometry.then(|| self.rays.obtain(context.head, settings.trace)).transpose()?;
        if let (true, Some(rays)) = (needs.indirect, &rays) {
            context.baked = self.baked_light(&needs, &context, rays)?;
        }
        if let (true, false, Some(rays)) = (needs.probe, probe_fits, &rays) {
            let made = probe(&self.gpu, &self.scene, &self.resources, rays, &context, &needs)?;
            self.probe = Some((light, Rc::new(made)));
        }
        let supersampled = match settings.antialias {
            1 => None,
            finer => {
                let baked = Rc::clone(&context.baked);
                let view = (&eyes, &SupersampledView::settings(&drawn, finer), framing.guard.map(|n| n * finer));
                Some(Context::new(&self.gpu, &self.scene, &self.resources, (table, baked), view)?)
            }
        };
        let on_device = SceneOnDevice {
            gpu: Rc::clone(&self.gpu),
            scene: Arc::clone(&self.scene),
            resources: Rc::clone(&self.resources),
            lazy_rays: Rc::clone(&self.rays),
        };
        let maps = needs.shadow_maps.then(|| self.shadow_maps(context.head)).transpose()?;
        let probe = self.probe.as_ref().map(|(_, maps)| Rc::clone(maps));
        Ok(Prepared::new(on_device, (context, supersampled), needs, (camera, method, settings), rays, (probe, maps))?)
    }

    fn shadow_maps(&mut self, head: DVec3) -> Result<Rc<ShadowMaps>, GpuError> {
        if let Some(maps) = self.shadow_maps.as_ref().filter(|m| m.covers_view_from(head)) {
            return Ok(Rc::clone(maps));
        }
        let made = Rc::new(ShadowMaps::new(&self.gpu, &self.scene, &self.resources, head)?);
        self.shadow_maps = Some(Rc::clone(&made));
        Ok(made)
    }

    fn brdf_table(&mut self, delta_roughness: f32) -> Result<Rc<Image>, GpuError> {
        match &self.brdf_table {
            Some((of, table)) if *of == delta_roughness => Ok(Rc::clone(table)),
            _ => {
                let made = Rc::new(brdf_table(&self.gpu, delta_roughness)?);
                self.brdf_table = Some((delta_roughness, Rc::clone(&made)));
                Ok(made)
            }
        }
    }

    /// Renders a still. `progress` is told how many of the reference's samples are done, and of how many.
    ///
    /// # Errors
    /// [`RenderError`]; there is no partial result.
    pub fn render(
        &mut self,
        request: &Request<'_>,
        progress: &mut dyn FnMut(u32, u32) -> Result<(), Interrupted>,
    ) -> Result<Rendered, RenderError> {
        let &Request { camera, method, settings, frames } = request;
        let mut prepared = self.prepare(camera, method, settings)?;
        let is_accumulated = prepared.needs().accumulate;
        let (mut times, mut frame_ms, mut counters) = (Vec::new(), Vec::new(), Counts::default());
        let warm_up = u32::from(frames > 1);
        let count = if is_accumulated { frames.max(SETTLING) } else { frames.max(1) };
        for number in 0..count + warm_up {
            if is_accumulated {
                prepared.set_seed(settings.seed, settings.frame.wrapping_add(number));
            }
            let report = prepared.frame(progress)?;
            counters = report.counters;
            if number >= warm_up {
                frame_ms.push(report.wall_ms);
                times.push(report.passes);
            }
        }
        let reflection = prepared.reflection()?;
        let ambient = prepared.ambient_visibility()?;
        let rendered = Rendered {
            linear: prepared.linear()?,
            error: prepared.standard_error(&reflection)?,
            reflection,
            ambient_visibility: ambient.map(|eyes| grey(eyes, settings)),
            display: prepared.display()?,
            passes: medians(&times),
            frame_ms,
            counters,
            parts: prepared.needs().decisions().to_vec(),
            left_out: prepared.needs().left_out(),
            samples: method.samples(),
            method: prepared.method().to_string(),
            tracer: prepared.tracer(),
        };
        // Checked after the last submission, so that messages about reading back count too.
        self.gpu.check_validation()?;
        Ok(rendered)
    }
}

/// The least number of frames for a still by a method that accumulates frames. The still shows the view after the head has stood
/// still for them.
pub const SETTLING: u32 = 16;

/// A grey picture with one number for each pixel.
fn grey(eyes: [Vec<f32>; 2], settings: &Settings) -> StereoPicture {
    let eyes = eyes.map(|eye| eye.into_iter().map(|v| [v; 3]).collect());
    StereoPicture { width: settings.width, height: settings.height, eyes }
}

fn medians(frames: &[Vec<PassTime>]) -> Vec<PassTime> {
    let Some(first) = frames.first() else { return Vec::new() };
    first
        .iter()
        .enumerate()
        .map(|(i, pass)| {
            let mut ms: Vec<f64> = frames.iter().filter_map(|f| f.get(i)).map(|p| p.ms).collect();
            ms.sort_by(f64::total_cmp);
            PassTime { name: pass.name.clone(), ms: median_of_sorted(&ms) }
        })
        .collect()
}

/// The median: the middle number, or the mean of the two middle ones; 0 for an empty slice.
pub fn median_of_sorted(sorted: &[f64]) -> f64 {
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => (sorted[n / 2 - 1] + sorted[n / 2]) / 2.0,
    }
}
