//! A view and a method, prepared on a device: the passes in their order, and what all of their frames share.
//!
//! `Renderer::prepare` makes a [`Prepared`]. It renders any number of frames with different seeds and camera poses, without
//! allocating images or making pipelines again. Camera poses must stay near the first one (see [`Prepared::set_camera`]).

mod read;
mod record;
mod until;

use std::cell::{Cell, OnceCell, RefCell};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use glam::DAffine3;

use crate::console::Interrupted;
use crate::gpu::{Gpu, GpuError, PassTime};
use crate::scene::{HeadPath, Scene, StereoCamera, View};

use super::accumulate::AccumulatePass;
use super::ao::AoPass;
use super::bvh::RayScene;
use super::classify::ClassifyPass;
use super::composite::CompositePass;
use super::context::Context;
use super::cpu::{CpuPathTrace, CpuShadows, KeptSums, World};
use super::depth_pyramid::DepthPyramidPass;
use super::error::RenderError;
use super::framing::Framing;
use super::gbuffer::{BackFacePass, GBufferPass};
use super::history::{History, TimedCamera};
use super::indirect::IndirectPass;
use super::lazy_rays::LazyRays;
use super::lighting::LightingPass;
use super::method::Ao;
use super::method::Method;
use super::needs::FrameNeeds;
use super::path_rays::PathRaysPass;
use super::path_trace::PathTracePass;
use super::reproject::ReprojectPass;
use super::resolve::ResolvePass;
use super::settings::Settings;
use super::shading_reuse::ShadingReusePass;
use super::shadow_maps::{MappedShadowsPass, ShadowMaps};
use super::shadows::ShadowsPass;
use super::shared::Counts;
use super::supersampled::SupersampledView;
use super::targets::Targets;
use super::trace::TracePass;
use super::trace_geometry::TraceGeometryPass;
use super::upload::{EnvironmentMaps, SceneResources};

/// The passes of a frame; `None` for those that it does not need.
struct Passes {
    gbuffer: GBufferPass,
    back_face: Option<BackFacePass>,
    shadows: Option<ShadowsPass>,
    mapped_shadows: Option<MappedShadowsPass>,
    indirect: Option<IndirectPass>,
    /// Replaces `shadows` where the eyes share their shading.
    shading_reuse: Option<ShadingReusePass>,
    ao: Option<AoPass>,
    lighting: LightingPass,
    classify: Option<ClassifyPass>,
    march: Option<(DepthPyramidPass, TracePass)>,
    path_rays: Option<PathRaysPass>,
    resolve: Option<ResolvePass>,
    accumulate: Option<AccumulatePass>,
    reproject: Option<ReprojectPass>,
    path_trace: Option<PathTracePass>,
    /// This and the next replace `shadows` and `path_trace` where the processor traces.
    cpu_shadows: Option<CpuShadows>,
    cpu_path_trace: Option<CpuPathTrace>,
    composite: CompositePass,
}

impl Passes {
    fn new(
        gpu: &Rc<Gpu>,
        (scene, resources, context): (&Scene, &SceneResources, &Context),
        needs: &FrameNeeds,
        (settings, method): (&Settings, &Method),
        rays: Option<&RayScene>,
    ) -> Result<Passes, GpuError> {
        let of_lights = rays;
        let reuse = || ShadingReusePass::new(gpu, scene, needs, rays, settings.soft_shadow_rays);
        let shading_reuse = needs.shading_reuse.then(reuse).transpose()?;
        let ao = AoPass::new(gpu, needs, settings.ao, rays)?;
        let rays = rays.filter(|_| needs.path_trace && !needs.cpu_paths);
        Ok(Passes {
            shading_reuse,
            ao,
            gbuffer: GBufferPass::new(gpu, resources, needs)?,
            back_face: needs.back_faces.then(|| BackFacePass::new(gpu, resources)).transpose()?,
            indirect: of_lights.filter(|_| needs.indirect).map(|r| IndirectPass::new(gpu, needs, r)).transpose()?,
            shadows: of_lights
                .filter(|_| needs.device_shadow_rays() && !needs.shading_reuse)
                .map(|r| ShadowsPass::new(gpu, needs, r, settings.soft_shadow_rays))
                .transpose()?,
            cpu_shadows: needs.cpu_shadows.then(|| CpuShadows::new(gpu, settings.soft_shadow_rays)),
            mapped_shadows: needs.shadow_maps.then(|| MappedShadowsPass::new(gpu, needs)).transpose()?,
            lighting: LightingPass::new(gpu, needs)?,
            classify: needs.rays.then(|| ClassifyPass::new(gpu, needs)).transpose()?,
            march: match needs.screen_space {
                false => None,
                true => Some((
                    DepthPyramidPass::new(gpu, needs, (settings, method))?,
                    TracePass::new(gpu, (settings, method))?,
                )),
            },
            path_rays: rays.filter(|_| needs.resolve).map(|r| PathRaysPass::new(gpu, needs, r)).transpose()?,
            resolve: needs.resolve.then(|| ResolvePass::new(gpu, needs, (settings, method))).transpose()?,
            accumulate: match (method.technique().accumulation, settings.temporal(method)) {
                (Some(how), Some(weights)) if needs.accumulate => {
                    let finish = method.technique().reprojection.is_none();
                    Some(AccumulatePass::new(gpu, needs, (how, weights), finish)?)
                }
                _ => None,
            },
            reproject: match method.technique().reprojection {
                Some(how) if needs.resolve => Some(ReprojectPass::new(gpu, needs, (how, method))?),
                _ => None,
            },
            cpu_path_trace: needs.cpu_paths.then(|| CpuPathTrace::new(gpu, needs, context)).transpose()?,
            path_trace: rays.filter(|_| !needs.resolve).map(|r| PathTracePass::new(gpu, needs, r)).transpose()?,
            composite: CompositePass::new(gpu, needs, (settings, method))?,
        })
    }
}

/// See the module's documentation.
pub struct Prepared {
    gpu: Rc<Gpu>,
    scene: Arc<Scene>,
    resources: Rc<SceneResources>,
    rays: Option<Rc<RayScene>>,
    /// The geometry for the processor, if it traces paths or shadows.
    world: Option<Rc<World>>,
    /// Builds the geometry for lost rays when the first ray is lost.
    lazy_rays: Rc<LazyRays>,
    /// Made at the same time.
    trace_geometry: OnceCell<TraceGeometryPass>,
    /// What stands in for unknown rays, if that is a probe.
    probe: Option<Rc<EnvironmentMaps>>,
    /// If the shadows in the views are looked up in maps.
    shadow_maps: Option<Rc<ShadowMaps>>,
    needs: FrameNeeds,
    /// Time in the scene's motions, seconds.
    time_s: f64,
    /// The instances' transforms.
    places: Vec<DAffine3>,
    framing: Framing,
    method: Method,
    settings: Settings,
    camera: StereoCamera,
    context: Context,
    targets: Targets,
    /// If frames are accumulated.
    history: Option<History>,
    /// With antialiasing.
    supersampled: Option<SupersampledView>,
    passes: Passes,
    /// The light of the punctual lights and the baked light of the view are on the device already. They depend neither on the
    /// seed nor on the method, so that they are computed again only when the camera or an instance has moved.
    is_lighting_current: Cell<bool>,
    /// The relative error at which the reference stops before all its samples are traced; see [`Prepared::set_until`].
    until: Option<f64>,
    paths: RefCell<PathsSoFar>,
}

/// The state of the reference's paths between frames.
#[derive(Default)]
struct PathsSoFar {
    /// Whether the sums are kept after a frame; see [`Prepared::continue_from`].
    kept: bool,
    sums: Option<KeptSums>,
    /// The number of samples at each check of the last frame, and the relative error at that check.
    checks: Vec<(u32, f64)>,
    /// The number of samples of the last frame.
    samples: u32,
}

/// The times and counters of a frame.
#[derive(Debug, Clone)]
pub struct FrameReport {
    /// The passes' times, in order. The times of a pass that ran more than once (for each eye or sample) are summed.
    pub passes: Vec<PassTime>,
    /// Wall time from the recording of the first command to the end of the last one, ms.
    pub wall_ms: f64,
    pub counters: Counts,
}

/// What all prepared views of a scene share.
pub(super) struct SceneOnDevice {
    pub gpu: Rc<Gpu>,
    pub scene: Arc<Scene>,
    pub resources: Rc<SceneResources>,
    pub lazy_rays: Rc<LazyRays>,
}

impl Prepared {
    pub(super) fn new(
        on_device: SceneOnDevice,
        (context, supersampled): (Context, Option<Context>),
        needs: FrameNeeds,
        (camera, method, settings): (&StereoCamera, &Method, &Settings),
        rays: Option<Rc<RayScene>>,
        (probe, shadow_maps): (Option<Rc<EnvironmentMaps>>, Option<Rc<ShadowMaps>>),
    ) -> Result<Prepared, GpuError> {
        let SceneOnDevice { gpu, scene, resources, lazy_rays } = on_device;
        let framing = Framing::of(method, settings);
        let shown = (settings.width, settings.height);
        let targets = Targets::new(&gpu, &framing.settings(settings), shown, &needs, method)?;
        let drawn = framing.settings(settings);
        let size = (drawn.width, drawn.height);
        let history = needs.accumulate.then(|| History::new(&gpu, size, scene.instances.len())).transpose()?;
        let supersampled = supersampled
            .map(|c| SupersampledView::new(&gpu, c, &drawn, (&needs, method), settings.antialias))
            .transpose()?;
        let places = scene.places();
        let world = (needs.cpu_paths || needs.cpu_shadows).then(|| lazy_rays.world(context.head));
        let passes = Passes::new(&gpu, (&scene, &resources, &context), &needs, (settings, method), rays.as_deref())?;
        let (method, settings, camera) = (method.clone(), settings.clone(), *camera);
        Ok(Prepared {
            gpu,
            scene,
            resources,
            rays,
            world,
            lazy_rays,
            trace_geometry: OnceCell::new(),
            probe,
            shadow_maps,
            needs,
            time_s: 0.0,
            places,
            framing,
            method,
            settings,
            camera,
            context,
            targets,
            history,
            supersampled,
            passes,
            is_lighting_current: Cell::new(false),
            until: None,
            paths: RefCell::default(),
        })
    }

    /// Which parts run and which are left out, and why.
    pub fn needs(&self) -> &FrameNeeds {
        &self.needs
    }

    /// What traces rays through the geometry: `bvh` or `ray-query`, or `cpu` if the processor traces the reference's paths or the
    /// shadows in the views; `None` without such rays.
    pub fn tracer(&self) -> Option<&'static str> {
        if self.needs.cpu_paths || self.needs.cpu_shadows {
            return Some("cpu");
        }
        let asked = self.rays.as_deref().filter(|_| {
            let needs = &self.needs;
            needs.path_trace || needs.probe || needs.shadow_rays() || needs.indirect || needs.ao == Ao::RayTraced
        });
        asked.or(self.trace_geometry.get().map(TraceGeometryPass::rays)).map(RayScene::structure_name)
    }

    pub fn method(&self) -> &Method {
        &self.method
    }

    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    pub fn camera(&self) -> &StereoCamera {
        &self.camera
    }

    /// Sets the seed and the frame number, and so the random numbers, of the next frames.
    pub fn set_seed(&mut self, seed: u32, frame: u32) {
        self.settings.seed = seed;
        self.settings.frame = frame;
        self.update();
    }

    /// Sets the camera of the next frames. Lights and geometry stay relative to where the head was at first. Within a few
    /// kilometres of that place, single precision is finer than a pixel.
    pub fn set_camera(&mut self, camera: &StereoCamera) {
        self.camera = *camera;
        self.is_lighting_current.set(false);
        self.update();
    }

    /// Sets time, camera and random numbers to those of a frame of `path`, which begins in `view`.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn follow(&mut self, path: &HeadPath, view: &View, seed: u32, frame: u32) -> Result<(), GpuError> {
        self.set_time(path.time_of(frame))?;
        self.set_camera(&path.view(view, frame).stereo_camera(self.settings.aspect()));
        self.set_seed(seed, frame);
        Ok(())
    }

    /// Moves the instances to where the scene's motions have them at `time_s`. Baked light and the probe stay as they are at time
    /// 0.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn set_time(&mut self, time_s: f64) -> Result<(), GpuError> {
        if self.scene.motions.is_empty() {
            return Ok(());
        }
        self.time_s = time_s;
        self.places = self.scene.places_at(time_s);
        self.lazy_rays.place(&self.places);
        if let Some(maps) = &self.shadow_maps {
            maps.place(&self.places);
        }
        for context in std::iter::once(&self.context).chain(self.supersampled.iter().map(|f| &f.context)) {
            context.place(&self.scene, &self.places, &self.resources);
        }
        if self.rays.is_some() {
            self.rays = Some(self.lazy_rays.obtain(self.context.head, self.settings.trace)?);
        }
        self.world = self.world.take().map(|_| self.lazy_rays.world(self.context.head));
        self.trace_geometry = OnceCell::new();
        self.is_lighting_current.set(false);
        Ok(())
    }

    fn moment(&self) -> TimedCamera {
        TimedCamera { camera: self.camera, time_s: self.time_s }
    }

    /// Forgets the history, for example after a cut. Jumps of the head or of the time are noticed without this call.
    pub fn forget(&self) {
        if let Some(history) = &self.history {
            history.forget();
        }
    }

    fn update(&self) {
        let (eyes, drawn) = (self.framing.camera(&self.camera), self.framing.settings(&self.settings));
        self.context.update(&eyes, &drawn, &self.scene);
        if let Some(supersampled) = &self.supersampled {
            supersampled.update(&eyes, &drawn, &self.scene);
        }
    }

    /// Renders one frame. `progress` is told how many of its samples are done, and of how many.
    ///
    /// # Errors
    /// [`RenderError`]: a Vulkan call failed, Ctrl-C was pressed, or the picture contains NaN or infinity.
    pub fn frame(
        &self,
        progress: &mut dyn FnMut(u32, u32) -> Result<(), Interrupted>,
    ) -> Result<FrameReport, RenderError> {
        let start = Instant::now();
        let (times, counters) = self.record(progress)?;
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;
        if counters.nan > 0 || counters.inf > 0 {
            return Err(RenderError::NotFinite {
                scene: self.scene.name.clone(),
                method: self.method.to_string(),
                nan: counters.nan,
                inf: counters.inf,
            });
        }
        Ok(FrameReport { passes: by_name(times), wall_ms, counters })
    }
}

/// Sums the times of passes that ran more than once (each eye, each sample), in order of first appearance.
fn by_name(times: Vec<PassTime>) -> Vec<PassTime> {
    let mut sums: Vec<PassTime> = Vec::new();
    for time in times {
        match sums.iter_mut().find(|s| s.name == time.name) {
            Some(sum) => sum.ms += time.ms,
            None => sums.push(time),
        }
    }
    sums
}
