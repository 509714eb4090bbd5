//! A view and a method made ready on a device: the passes in order, and what their frames share.
//!
//! Made once, run for as many frames, seeds and (in the same place) camera poses as are asked: nothing is allocated and
//! no pipeline is made again.

use std::cell::{Cell, OnceCell};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use crate::console::Interrupted;
use crate::gpu::{Frame, Gpu, GpuError, Image, PassTime};
use crate::picture::StereoPicture;
use crate::scene::{Scene, StereoCamera};

use super::ao::{Ao, AoImages, AoPass, Seen};
use super::bvh::RayScene;
use super::classify::ClassifyPass;
use super::composite::CompositePass;
use super::context::{Context, read_buffer, read_image};
use super::depth_pyramid::DepthPyramidPass;
use super::fine::Fine;
use super::framing::Framing;
use super::gbuffer::{BackFacePass, GBufferPass};
use super::geometry::Geometry;
use super::hits::{self, RayEnd};
use super::indirect::IndirectPass;
use super::lazy_rays::LazyRays;
use super::lighting::LightingPass;
use super::method::Method;
use super::needs::Needs;
use super::path_rays::PathRaysPass;
use super::path_trace::PathTracePass;
use super::renderer::RenderError;
use super::reproject::ReprojectPass;
use super::resolve::ResolvePass;
use super::settings::Settings;
use super::shadows::ShadowsPass;
use super::shared::{CountersData, Counts};
use super::targets::{GBuffer, Marched, Targets};
use super::trace::TracePass;
use super::trace_geometry::TraceGeometryPass;
use super::upload::{EnvironmentMaps, SceneResources};

/// The passes of a frame, made for its needs.
struct Passes {
    gbuffer: GBufferPass,
    back_face: Option<BackFacePass>,
    shadows: Option<ShadowsPass>,
    indirect: Option<IndirectPass>,
    ao: Option<AoPass>,
    lighting: LightingPass,
    classify: Option<ClassifyPass>,
    march: Option<(DepthPyramidPass, TracePass)>,
    path_rays: Option<PathRaysPass>,
    resolve: Option<ResolvePass>,
    reproject: Option<ReprojectPass>,
    path_trace: Option<PathTracePass>,
    composite: CompositePass,
}

impl Passes {
    fn new(
        gpu: &Rc<Gpu>,
        resources: &SceneResources,
        needs: &Needs,
        (settings, method): (&Settings, &Method),
        rays: Option<&RayScene>,
    ) -> Result<Passes, GpuError> {
        let of_lights = rays;
        let ao = AoPass::new(gpu, needs, settings.ao, rays)?;
        let rays = rays.filter(|_| needs.path_trace);
        Ok(Passes {
            ao,
            gbuffer: GBufferPass::new(gpu, resources, needs)?,
            back_face: needs.back_faces.then(|| BackFacePass::new(gpu, resources)).transpose()?,
            indirect: of_lights.filter(|_| needs.indirect).map(|r| IndirectPass::new(gpu, needs, r)).transpose()?,
            shadows: of_lights
                .filter(|_| needs.shadows)
                .map(|r| ShadowsPass::new(gpu, needs, r, settings.soft_shadow_rays))
                .transpose()?,
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
            reproject: match method.parts().reprojection {
                Some(how) if needs.resolve => Some(ReprojectPass::new(gpu, needs, (how, method))?),
                _ => None,
            },
            path_trace: rays.filter(|_| !needs.resolve).map(|r| PathTracePass::new(gpu, needs, r)).transpose()?,
            composite: CompositePass::new(gpu, needs, (settings, method))?,
        })
    }
}

/// Samples of a screen-space method recorded into one submission, at the most: fewer where their counts would not stay
/// within 32 bits.
const SAMPLES_A_SUBMISSION: u64 = 8;
/// More than a march takes, on the mean of an image.
const STEPS_A_RAY: u64 = 128;
/// A submission of the reference aims at this long, so that progress is seen and no watchdog bites.
const SUBMISSION_SECONDS: f64 = 0.5;

/// See the module's documentation.
pub struct Prepared {
    gpu: Rc<Gpu>,
    scene: Arc<Scene>,
    resources: Rc<SceneResources>,
    rays: Option<Rc<RayScene>>,
    /// The geometry for rays that the views lose, built when the first one is lost.
    lazy_rays: Rc<LazyRays>,
    /// Made then, too.
    trace_geometry: OnceCell<TraceGeometryPass>,
    /// What unknown rays see, where that is not the scene's environment.
    probe: Option<Rc<EnvironmentMaps>>,
    needs: Needs,
    framing: Framing,
    method: Method,
    settings: Settings,
    camera: StereoCamera,
    context: Context,
    targets: Targets,
    /// With antialiasing.
    fine: Option<Fine>,
    passes: Passes,
    /// What lights and baked light put on the view is still that of the last frame: it depends on neither seed nor method.
    lit: Cell<bool>,
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
        probe: Option<Rc<EnvironmentMaps>>,
    ) -> Result<Prepared, GpuError> {
        let Shared { gpu, scene, resources, lazy_rays } = shared;
        let framing = Framing::of(method, settings);
        let shown = (settings.width, settings.height);
        let targets = Targets::new(&gpu, &framing.settings(settings), shown, &needs, method)?;
        let drawn = framing.settings(settings);
        let fine = fine.map(|c| Fine::new(&gpu, c, &drawn, (&needs, method), settings.antialias)).transpose()?;
        let passes = Passes::new(&gpu, &resources, &needs, (settings, method), rays.as_deref())?;
        let (method, settings, camera) = (method.clone(), settings.clone(), *camera);
        Ok(Prepared {
            gpu,
            scene,
            resources,
            rays,
            lazy_rays,
            trace_geometry: OnceCell::new(),
            probe,
            needs,
            framing,
            method,
            settings,
            camera,
            context,
            targets,
            fine,
            passes,
            lit: Cell::new(false),
        })
    }

    /// Which parts run and which are left out.
    pub fn needs(&self) -> &Needs {
        &self.needs
    }

    /// How rays through the geometry find what they hit, `bvh` or `ray-query`; `None` where no ray asks it.
    pub fn way(&self) -> Option<&'static str> {
        let asked = self.rays.as_deref().filter(|_| {
            let needs = &self.needs;
            needs.path_trace || needs.probe || needs.shadows || needs.indirect || needs.ao == Ao::RayTraced
        });
        asked.or(self.trace_geometry.get().map(TraceGeometryPass::rays)).map(RayScene::way_name)
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

    fn record(
        &self,
        progress: &mut dyn FnMut(u32, u32) -> Result<(), Interrupted>,
    ) -> Result<(Vec<PassTime>, Counts), RenderError> {
        let Prepared { scene, resources, passes, context, targets, .. } = self;
        let samples = self.method.samples();
        // Only where the settings ask for the probe: one that was made for other settings is not looked at.
        let fallback = self.probe.as_deref().filter(|_| self.needs.probe).unwrap_or(&resources.environment);
        let mut frame = Frame::begin(&self.gpu)?;
        let (mut times, mut counts) = (Vec::new(), Counts::default());
        frame.fill(&context.counters, 0);
        passes.gbuffer.record(&mut frame, scene, resources, context, &targets.gbuffer)?;
        if let (Some(pass), Some(marched)) = (&passes.back_face, &targets.marched)
            && let Some(back) = &marched.back_depth
        {
            pass.record(&mut frame, scene, resources, context, &targets.gbuffer, back)?;
        }
        if self.settings.all_passes || !self.lit.get() {
            self.record_lights(&mut frame, context, targets, 1)?;
        }
        frame = self.record_ao(frame, (&mut times, &mut counts), progress)?;
        let visibility = targets.ao.as_ref().map(|ao| &ao.visibility);
        passes.lighting.record(&mut frame, resources, context, targets, visibility)?;
        if let Some(fine) = &self.fine {
            passes.gbuffer.record(&mut frame, scene, resources, &fine.context, &fine.targets.gbuffer)?;
            if self.settings.all_passes || !self.lit.get() {
                self.record_lights(&mut frame, &fine.context, &fine.targets, self.settings.antialias)?;
            }
            passes.lighting.record(&mut frame, resources, &fine.context, &fine.targets, visibility)?;
        }
        if let (Some(classify), Some(list)) = (&passes.classify, &targets.rays) {
            classify.record(&mut frame, context, targets, list)?;
            if let (Some((pyramid, _)), Some(marched)) = (&passes.march, &targets.marched) {
                pyramid.record(&mut frame, context, &targets.gbuffer, marched)?;
            }
            if let (Some(resolve), Some(out)) = (&passes.resolve, &targets.filtered) {
                let together = (u64::from(u32::MAX) / (self.pixels() * STEPS_A_RAY)).clamp(1, SAMPLES_A_SUBMISSION);
                for sample in 0..samples {
                    if sample > 0 && u64::from(sample) % together == 0 {
                        times.extend(frame.finish()?);
                        progress(sample, samples)?;
                        frame = self.next_submission(&mut counts)?;
                    }
                    if let (Some((_, trace)), Some(marched)) = (&passes.march, &targets.marched) {
                        trace.record(&mut frame, context, &targets.gbuffer, list, (marched, out), sample)?;
                    }
                    if let (true, Some(marched)) = (self.needs.geometry, &targets.marched) {
                        if self.trace_geometry.get().is_none() {
                            // Nothing lost, nothing built: the first frame looks before it goes on.
                            times.extend(frame.finish()?);
                            self.make_trace_geometry(marched)?;
                            frame = self.next_submission(&mut counts)?;
                        }
                        if let Some(pass) = self.trace_geometry.get() {
                            pass.record(&mut frame, resources, context, targets, sample)?;
                        }
                    }
                    if let (Some(pass), Some(rays)) = (&passes.path_rays, &self.rays) {
                        pass.record(&mut frame, resources, rays, context, targets, sample)?;
                    }
                    resolve.record(&mut frame, resources, fallback, context, targets, (sample, samples))?;
                }
            }
            if let Some(reproject) = &passes.reproject {
                reproject.record(&mut frame, resources, fallback, context, targets)?;
            }
            if let (Some(pass), Some(rays)) = (&passes.path_trace, &self.rays) {
                let (mut first, mut count) = (0, 1);
                // So that a submission's counts stay within 32 bits.
                let most_paths = (u64::from(u32::MAX) / self.pixels()).max(1) as u32;
                while first < samples {
                    count = count.min(samples - first);
                    // Before the recording: with the host's clock each pass is submitted and waited for at once.
                    let start = Instant::now();
                    pass.record(&mut frame, resources, rays, context, targets, (first, count))?;
                    times.extend(frame.finish()?);
                    let seconds = start.elapsed().as_secs_f64();
                    frame = self.next_submission(&mut counts)?;
                    first += count;
                    progress(first, samples)?;
                    // The first one also rasterises and compiles; it only makes the next estimate cautious.
                    count = next_count(count, seconds).min(most_paths);
                }
            }
        }
        passes.composite.record(&mut frame, context, targets, self.fine.as_ref())?;
        times.extend(frame.finish()?);
        self.count(&mut counts)?;
        // Only now: a frame that was broken off may have lit nothing.
        self.lit.set(true);
        Ok((times, counts))
    }

    /// What lights and baked light put on the view.
    fn record_lights(
        &self,
        frame: &mut Frame,
        context: &Context,
        targets: &Targets,
        finer: u32,
    ) -> Result<(), GpuError> {
        let Prepared { resources, passes, .. } = self;
        let Some(rays) = &self.rays else { return Ok(()) };
        if let (Some(pass), Some(direct)) = (&passes.shadows, &targets.direct) {
            pass.record(frame, resources, rays, context, (targets, direct), finer)?;
        }
        if let (Some(pass), Some(indirect)) = (&passes.indirect, &targets.indirect) {
            pass.record(frame, resources, rays, context, (targets, indirect))?;
        }
        Ok(())
    }

    /// Adds the passes of ambient occlusion, if the frame has any; those of its rays are submitted a part at a time.
    fn record_ao(
        &self,
        mut frame: Frame,
        (times, counts): (&mut Vec<PassTime>, &mut Counts),
        progress: &mut dyn FnMut(u32, u32) -> Result<(), Interrupted>,
    ) -> Result<Frame, RenderError> {
        let (Some(pass), Some(images)) = (&self.passes.ao, &self.targets.ao) else { return Ok(frame) };
        let seen = Seen { context: &self.context, gbuffer: &self.targets.gbuffer, images };
        match (pass, &self.rays) {
            (AoPass::Views(pass), _) => pass.record(&mut frame, seen)?,
            (AoPass::Rays(pass), Some(rays)) => {
                let (mut first, mut count) = (0, 1);
                while first < pass.count() {
                    count = count.min(pass.count() - first);
                    let start = Instant::now();
                    pass.record(&mut frame, (&self.resources, rays), seen, (first, count))?;
                    times.extend(frame.finish()?);
                    first += count;
                    count = next_count(count, start.elapsed().as_secs_f64());
                    frame = self.next_submission(counts)?;
                    // For Ctrl-C: none of the method's own samples is done.
                    progress(0, self.method.samples())?;
                }
            }
            (AoPass::Rays(_), None) => {}
        }
        Ok(frame)
    }

    /// Builds the geometry for lost rays, if the list of `marched` holds any.
    fn make_trace_geometry(&self, marched: &Marched) -> Result<(), GpuError> {
        let arguments = read_buffer(&self.gpu, &marched.lost.arguments)?;
        let [_, _, _, lost]: [u32; 4] = bytemuck::pod_read_unaligned(&arguments[..16]);
        if lost > 0 {
            let rays = self.lazy_rays.obtain(self.context.head, self.settings.trace)?;
            let pass = TraceGeometryPass::new(&self.gpu, &self.needs, rays)?;
            // It was empty a line ago, and nothing else fills it.
            let _ = self.trace_geometry.set(pass);
        }
        Ok(())
    }

    /// Drawn, of both eyes.
    fn pixels(&self) -> u64 {
        let (width, height) = self.targets.linear.extent();
        2 * u64::from(width) * u64::from(height)
    }

    /// The counters so far, and a submission that starts them anew.
    fn next_submission(&self, counts: &mut Counts) -> Result<Frame, GpuError> {
        self.count(counts)?;
        let mut frame = Frame::begin(&self.gpu)?;
        frame.fill(&self.context.counters, 0);
        Ok(frame)
    }

    fn count(&self, counts: &mut Counts) -> Result<(), GpuError> {
        let bytes = read_buffer(&self.gpu, &self.context.counters)?;
        counts.add(&bytemuck::pod_read_unaligned::<CountersData>(&bytes[..size_of::<CountersData>()]));
        Ok(())
    }

    /// Linear radiance of the last frame.
    ///
    /// # Errors
    /// What the device said; also below.
    pub fn linear(&self) -> Result<StereoPicture, GpuError> {
        self.picture(&self.targets.linear)
    }

    /// The outgoing reflection alone; zero where none was traced.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn reflection(&self) -> Result<StereoPicture, GpuError> {
        self.picture(&self.targets.reflection_out)
    }

    /// How much of its surroundings each pixel sees, by eye: 1 open, 0 hidden; `None` where ambient light is not occluded.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn ambient_visibility(&self) -> Result<Option<[Vec<f32>; 2]>, GpuError> {
        let Some(ao) = &self.targets.ao else { return Ok(None) };
        let bytes = read_image(&self.gpu, &ao.visibility)?;
        let texels: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
        let (left, right) = texels.split_at(texels.len() / 2);
        Ok(Some([left, right].map(|eye| self.framing.crop(eye))))
    }

    /// Pixels of the last frame, of both eyes and a guard band, that adaptive ambient occlusion worked on again; `None`
    /// of other methods.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn ambient_pixels_again(&self) -> Result<Option<u32>, GpuError> {
        let Some(list) = self.targets.ao.as_ref().and_then(AoImages::listed) else { return Ok(None) };
        let arguments = read_buffer(&self.gpu, &list.arguments)?;
        let [_, _, _, count]: [u32; 4] = bytemuck::pod_read_unaligned(&arguments[..16]);
        Ok(Some(count))
    }

    /// Draws the G-buffer and finds the visibility of the surroundings, and does nothing else: for those who look at
    /// nothing else.
    ///
    /// # Errors
    /// What the device said, or Ctrl-C.
    pub fn ambient_frame(
        &self,
        progress: &mut dyn FnMut(u32, u32) -> Result<(), Interrupted>,
    ) -> Result<Vec<PassTime>, RenderError> {
        let mut frame = Frame::begin(&self.gpu)?;
        let (mut times, mut counts) = (Vec::new(), Counts::default());
        frame.fill(&self.context.counters, 0);
        let Prepared { scene, resources, passes, context, targets, .. } = self;
        passes.gbuffer.record(&mut frame, scene, resources, context, &targets.gbuffer)?;
        let frame = self.record_ao(frame, (&mut times, &mut counts), progress)?;
        times.extend(frame.finish()?);
        Ok(by_name(times))
    }

    /// Standard error of the reflection's mean, per channel; the reference only.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn standard_error(&self, reflection: &StereoPicture) -> Result<Option<StereoPicture>, GpuError> {
        let error = self.targets.path_traced.as_ref().map(|p| self.picture(&p.error)).transpose()?;
        Ok(error.map(|e| masked(e, reflection)))
    }

    /// How the rays of the last sample ended, pixel by pixel; `None` where none are filtered. A guard band is in it.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn ray_ends(&self) -> Result<Option<[Vec<RayEnd>; 2]>, GpuError> {
        self.targets.filtered.as_ref().map(|f| hits::read(&self.gpu, &f.hits, &self.targets.guide)).transpose()
    }

    /// What the pixels of the last frame show, apart from light.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn geometry(&self) -> Result<Geometry, GpuError> {
        let GBuffer { depth, surface, instance, .. } = &self.targets.gbuffer;
        let read = |image: &Image| read_image(&self.gpu, image);
        let reflection = self.targets.path_traced.as_ref().map(|p| read(&p.reflection)).transpose()?;
        let images = [read(depth)?, read(surface)?, read(instance)?];
        let limit = self.settings.ray_roughness_limit;
        let drawn = Geometry::decode(images.each_ref().map(Vec::as_slice), reflection.as_deref(), limit);
        Ok(drawn.cropped(&self.framing))
    }

    /// sRGB bytes (RGBA) by eye.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn display(&self) -> Result<[Vec<u8>; 2], GpuError> {
        let bytes = read_image(&self.gpu, &self.targets.display)?;
        let (left, right) = bytes.split_at(bytes.len() / 2);
        Ok([left.to_vec(), right.to_vec()])
    }

    /// The tone-mapped picture where it lies: two layers of RGBA8, sRGB values.
    pub fn display_image(&self) -> &Image {
        &self.targets.display
    }

    fn picture(&self, image: &Image) -> Result<StereoPicture, GpuError> {
        let bytes = read_image(&self.gpu, image)?;
        let texels: Vec<[f32; 3]> = bytes
            .chunks_exact(16)
            .map(|t| [0, 4, 8].map(|i| f32::from_le_bytes([t[i], t[i + 1], t[i + 2], t[i + 3]])))
            .collect();
        let (left, right) = texels.split_at(texels.len() / 2);
        let eyes = [left, right].map(|eye| self.framing.crop(eye));
        Ok(StereoPicture { width: self.settings.width, height: self.settings.height, eyes })
    }
}

/// Samples of the next submission, after `count` took so long.
fn next_count(count: u32, seconds: f64) -> u32 {
    let fitting = f64::from(count) * SUBMISSION_SECONDS / seconds.max(1e-6);
    (fitting as u32).clamp(1, 4 * count)
}

/// The error exists where a reflection does; elsewhere the image was never written.
fn masked(mut error: StereoPicture, reflection: &StereoPicture) -> StereoPicture {
    for (errors, values) in error.eyes.iter_mut().zip(&reflection.eyes) {
        for (e, v) in errors.iter_mut().zip(values) {
            if *v == [0.0; 3] {
                *e = [0.0; 3];
            }
        }
    }
    error
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
