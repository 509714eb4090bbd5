//! A view and a method made ready on a device: the passes in order, and what their frames share.
//!
//! Made once, run for as many frames, seeds and (in the same place) camera poses as are asked: nothing is allocated and
//! no pipeline is made again.

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
use super::cpu::{CpuPathTrace, CpuShadows, Sums, World};
use super::depth_pyramid::DepthPyramidPass;
use super::error::RenderError;
use super::fine::Fine;
use super::framing::Framing;
use super::gbuffer::{BackFacePass, GBufferPass};
use super::history::{History, Moment};
use super::indirect::IndirectPass;
use super::lazy_rays::LazyRays;
use super::lighting::LightingPass;
use super::method::Ao;
use super::method::Method;
use super::needs::Needs;
use super::path_rays::PathRaysPass;
use super::path_trace::PathTracePass;
use super::reproject::ReprojectPass;
use super::resolve::ResolvePass;
use super::settings::Settings;
use super::shading_reuse::ShadingReusePass;
use super::shadow_maps::{MappedShadowsPass, ShadowMaps};
use super::shadows::ShadowsPass;
use super::shared::Counts;
use super::targets::Targets;
use super::trace::TracePass;
use super::trace_geometry::TraceGeometryPass;
use super::upload::{EnvironmentMaps, SceneResources};

/// The passes of a frame, made for its needs.
struct Passes {
    gbuffer: GBufferPass,
    back_face: Option<BackFacePass>,
    shadows: Option<ShadowsPass>,
    mapped_shadows: Option<MappedShadowsPass>,
    indirect: Option<IndirectPass>,
    /// Stands in for `shadows` where the eyes share shading.
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
    /// Or the processor's, which also finds the views' shadows.
    cpu_shadows: Option<CpuShadows>,
    cpu_path_trace: Option<CpuPathTrace>,
    composite: CompositePass,
}

impl Passes {
    fn new(
        gpu: &Rc<Gpu>,
        (scene, resources, context): (&Scene, &SceneResources, &Context),
        needs: &Needs,
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
            accumulate: match (method.parts().accumulation, settings.temporal(method)) {
                (Some(how), Some(weights)) if needs.accumulate => {
                    let finish = method.parts().reprojection.is_none();
                    Some(AccumulatePass::new(gpu, needs, (how, weights), finish)?)
                }
                _ => None,
            },
            reproject: match method.parts().reprojection {
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
    /// The same for the processor's paths.
    world: Option<Rc<World>>,
    /// The geometry for rays that the views lose, built when the first one is lost.
    lazy_rays: Rc<LazyRays>,
    /// Made then, too.
    trace_geometry: OnceCell<TraceGeometryPass>,
    /// What unknown rays see, where that is not the scene's environment.
    probe: Option<Rc<EnvironmentMaps>>,
    /// Where the views' shadows are looked up, if rays do not find them.
    shadow_maps: Option<Rc<ShadowMaps>>,
    needs: Needs,
    /// Of what moves by itself, seconds.
    time_s: f64,
    /// Where the instances stand.
    places: Vec<DAffine3>,
    framing: Framing,
    method: Method,
    settings: Settings,
    camera: StereoCamera,
    context: Context,
    targets: Targets,
    /// Where frames are accumulated.
    history: Option<History>,
    /// With antialiasing.
    fine: Option<Fine>,
    passes: Passes,
    /// What lights and baked light put on the view is still that of the last frame: it depends on neither seed nor method.
    lit: Cell<bool>,
    /// When the reference's paths are enough before all are traced.
    until: Option<f64>,
    paths: RefCell<PathsSoFar>,
}

/// The reference's paths from frame to frame, where somebody asked to keep them.
#[derive(Default)]
struct PathsSoFar {
    kept: bool,
    sums: Option<Sums>,
    /// Samples, and the relative error that they were found to have.
    checks: Vec<(u32, f64)>,
    /// Of the last frame.
    samples: u32,
}

/// What is known of a frame besides its images.
#[derive(Debug, Clone)]
pub struct FrameReport {
    /// In order; passes that ran more than once (each eye, each sample) are summed under their name.
    pub passes: Vec<PassTime>,
    /// From the first command recorded to the last one finished.
    pub wall_ms: f64,
    pub counters: Counts,
}

/// What a scene lends to everything prepared from it.
pub(super) struct Shared {
    pub gpu: Rc<Gpu>,
    pub scene: Arc<Scene>,
    pub resources: Rc<SceneResources>,
    pub lazy_rays: Rc<LazyRays>,
}

impl Prepared {
    pub(super) fn new(
        shared: Shared,
        (context, fine): (Context, Option<Context>),
        needs: Needs,
        (camera, method, settings): (&StereoCamera, &Method, &Settings),
        rays: Option<Rc<RayScene>>,
        (probe, shadow_maps): (Option<Rc<EnvironmentMaps>>, Option<Rc<ShadowMaps>>),
    ) -> Result<Prepared, GpuError> {
        let Shared { gpu, scene, resources, lazy_rays } = shared;
        let framing = Framing::of(method, settings);
        let shown = (settings.width, settings.height);
        let targets = Targets::new(&gpu, &framing.settings(settings), shown, &needs, method)?;
        let drawn = framing.settings(settings);
        let size = (drawn.width, drawn.height);
        let history = needs.accumulate.then(|| History::new(&gpu, size, scene.instances.len())).transpose()?;
        let fine = fine.map(|c| Fine::new(&gpu, c, &drawn, (&needs, method), settings.antialias)).transpose()?;
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
            fine,
            passes,
            lit: Cell::new(false),
            until: None,
            paths: RefCell::default(),
        })
    }

    /// Which parts run and which are left out.
    pub fn needs(&self) -> &Needs {
        &self.needs
    }

    /// How rays through the geometry find what they hit, `bvh` or `ray-query`, and `cpu` where the processor traces the
    /// reference's or those of the views' shadows; `None` where no ray asks it.
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

    /// The random numbers of the frames to come.
    pub fn set_seed(&mut self, seed: u32, frame: u32) {
        self.settings.seed = seed;
        self.settings.frame = frame;
        self.update();
    }

    /// The eyes of the frames to come. Light and geometry stay relative to where the head was at first: within some
    /// kilometres of it single precision is finer than a pixel.
    pub fn set_camera(&mut self, camera: &StereoCamera) {
        self.camera = *camera;
        self.lit.set(false);
        self.update();
    }

    /// The moment of a frame of `path`, which begins in `view`: what moves by itself, the eyes, and random numbers of its
    /// own.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn follow(&mut self, path: &HeadPath, view: &View, seed: u32, frame: u32) -> Result<(), GpuError> {
        self.set_time(path.time_of(frame))?;
        self.set_camera(&path.view(view, frame).stereo_camera(self.settings.aspect()));
        self.set_seed(seed, frame);
        Ok(())
    }

    /// Places everything that moves by itself at `time_s`. What was gathered once a scene, baked light and the probe, stays
    /// as it was at time 0.
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
        for context in std::iter::once(&self.context).chain(self.fine.iter().map(|f| &f.context)) {
            context.place(&self.scene, &self.places, &self.resources);
        }
        if self.rays.is_some() {
            self.rays = Some(self.lazy_rays.obtain(self.context.head, self.settings.trace)?);
        }
        self.world = self.world.take().map(|_| self.lazy_rays.world(self.context.head));
        self.trace_geometry = OnceCell::new();
        self.lit.set(false);
        Ok(())
    }

    fn moment(&self) -> Moment {
        Moment { camera: self.camera, time_s: self.time_s }
    }

    /// The next frame knows nothing of those before it: after a cut. A jump of the head or of the time is noticed without.
    pub fn forget(&self) {
        if let Some(history) = &self.history {
            history.forget();
        }
    }

    fn update(&self) {
        let (eyes, drawn) = (self.framing.camera(&self.camera), self.framing.settings(&self.settings));
        self.context.update(&eyes, &drawn, &self.scene);
        if let Some(fine) = &self.fine {
            fine.update(&eyes, &drawn, &self.scene);
        }
    }

    /// Renders one frame; `progress` hears how many of its samples are done.
    ///
    /// # Errors
    /// [`RenderError`]: what the device said, Ctrl-C, or a picture that holds NaN or infinity.
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
