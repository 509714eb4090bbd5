//! One stereo still: the frame's parts in order, timed, counted, read back.

use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use crate::console::Interrupted;
use crate::gpu::{Frame, Gpu, GpuError, Image, PassTime};
use crate::picture::StereoPicture;
use crate::scene::{Scene, StereoCamera};

use super::bvh::RayScene;
use super::classify::ClassifyPass;
use super::composite::CompositePass;
use super::context::{Context, read_buffer, read_image};
use super::depth_pyramid::DepthPyramidPass;
use super::gbuffer::{BackFacePass, GBufferPass};
use super::lighting::LightingPass;
use super::method::Method;
use super::needs::{Needs, Part};
use super::path_trace::PathTracePass;
use super::probe::probe;
use super::resolve::ResolvePass;
use super::settings::Settings;
use super::shared::{CountersData, Counts};
use super::targets::Targets;
use super::trace::TracePass;
use super::upload::{EnvironmentMaps, SceneResources};

/// A picture could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// A result that would poison a study.
    #[error(
        "scene `{scene}`, method `{method}`: {nan} values are not numbers and {inf} are infinite; the picture is refused"
    )]
    NotFinite { scene: String, method: String, nan: u64, inf: u64 },
}

/// A stereo still with what is known of its making.
pub struct Rendered {
    /// Linear radiance.
    pub linear: StereoPicture,
    /// The outgoing reflection alone; zero where none was traced.
    pub reflection: StereoPicture,
    /// Standard error of the reflection's mean, per channel; the reference only.
    pub error: Option<StereoPicture>,
    /// sRGB bytes (RGBA) by eye.
    pub display: [Vec<u8>; 2],
    /// Median over the frames, in the order of the passes.
    pub passes: Vec<PassTime>,
    /// Wall time of each frame, ms.
    pub frame_ms: Vec<f64>,
    /// Of one frame.
    pub counters: Counts,
    pub parts: Vec<Part>,
    pub left_out: Vec<Part>,
    /// Rays or paths a pixel.
    pub samples: u32,
}

/// What to render.
pub struct Request<'a> {
    pub camera: &'a StereoCamera,
    pub method: &'a Method,
    pub settings: &'a Settings,
    /// Frames to time; the first of several only warms up.
    pub frames: u32,
}

/// A scene on a device, ready for any view and method.
pub struct Renderer {
    gpu: Rc<Gpu>,
    scene: Arc<Scene>,
    resources: SceneResources,
    rays: Option<RayScene>,
    probe: Option<EnvironmentMaps>,
}

/// The passes of a frame, made for its needs.
struct Passes {
    gbuffer: GBufferPass,
    back_face: Option<BackFacePass>,
    lighting: LightingPass,
    classify: Option<ClassifyPass>,
    screen_space: Option<(DepthPyramidPass, TracePass, ResolvePass)>,
    path_trace: Option<PathTracePass>,
    composite: CompositePass,
}

/// Samples of a screen-space method recorded into one submission: eight keep its counts within 32 bits.
const SAMPLES_A_SUBMISSION: u32 = 8;
/// A submission of the reference aims at this long, so that progress is seen and no watchdog bites.
const SUBMISSION_SECONDS: f64 = 0.5;

impl Renderer {
    /// Uploads the scene.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn new(gpu: &Rc<Gpu>, scene: Arc<Scene>) -> Result<Renderer, GpuError> {
        let resources = SceneResources::new(gpu, &scene)?;
        Ok(Renderer { gpu: Rc::clone(gpu), scene, resources, rays: None, probe: None })
    }

    /// The scene it was made for.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Renders; `progress` hears how many of the reference's samples are done.
    ///
    /// # Errors
    /// [`RenderError`]; nothing is half made.
    pub fn render(
        &mut self,
        request: &Request<'_>,
        progress: &mut dyn FnMut(u32, u32) -> Result<(), Interrupted>,
    ) -> Result<Rendered, RenderError> {
        let &Request { camera, method, settings, frames } = request;
        let samples = method.samples();
        let needs = Needs::of(&self.scene, method, settings);
        let targets = Targets::new(&self.gpu, settings, &needs, method)?;
        let context = Context::new(&self.gpu, &self.scene, &self.resources, camera, settings)?;
        let passes = self.passes(&needs, settings, method)?;
        let asks_geometry = needs.path_trace || needs.probe && self.probe.is_none();
        if asks_geometry && self.rays.as_ref().is_none_or(|r| r.head != context.head) {
            let rays = RayScene::new(&self.gpu, &self.scene, &self.resources.ranges, context.head)?;
            if rays.halvings > 0 {
                tracing::warn!("the textures that rays hit were halved {} times to fit the device", rays.halvings);
            }
            self.rays = Some(rays);
        }
        if let (true, None, Some(rays)) = (needs.probe, &self.probe, &self.rays) {
            self.probe = Some(probe(&self.gpu, &self.scene, &self.resources, rays, &context, &needs)?);
        }
        // Only where the settings ask for it: an earlier picture's probe is kept, not looked at.
        let fallback = self.probe.as_ref().filter(|_| needs.probe).unwrap_or(&self.resources.environment);
        let (mut times, mut frame_ms, mut counters) = (Vec::new(), Vec::new(), Counts::default());
        let warm_up = u32::from(frames > 1);
        for number in 0..frames.max(1) + warm_up {
            let start = Instant::now();
            let (time, counted) = self.frame(&passes, &context, &targets, fallback, samples, progress)?;
            counters = counted;
            if number >= warm_up {
                frame_ms.push(start.elapsed().as_secs_f64() * 1e3);
                times.push(by_name(time));
            }
        }
        if counters.nan > 0 || counters.inf > 0 {
            return Err(RenderError::NotFinite {
                scene: self.scene.name.clone(),
                method: method.to_string(),
                nan: counters.nan,
                inf: counters.inf,
            });
        }
        let error = targets.path_traced.as_ref().map(|p| self.picture(&p.error)).transpose()?;
        let reflection = self.picture(&targets.reflection_out)?;
        let rendered = Rendered {
            linear: self.picture(&targets.linear)?,
            error: error.map(|e| masked(e, &reflection)),
            reflection,
            display: split(read_image(&self.gpu, &targets.display)?),
            passes: medians(&times),
            frame_ms,
            counters,
            parts: needs.parts().to_vec(),
            left_out: needs.left_out(),
            samples,
        };
        // After the last submission, so that a message about the reading counts too.
        self.gpu.check_validation()?;
        Ok(rendered)
    }

    fn passes(&self, needs: &Needs, settings: &Settings, method: &Method) -> Result<Passes, GpuError> {
        let gpu = &self.gpu;
        Ok(Passes {
            gbuffer: GBufferPass::new(gpu, &self.resources, needs)?,
            back_face: needs.back_faces.then(|| BackFacePass::new(gpu, &self.resources)).transpose()?,
            lighting: LightingPass::new(gpu, needs)?,
            classify: needs.rays.then(|| ClassifyPass::new(gpu, needs)).transpose()?,
            screen_space: match needs.screen_space {
                false => None,
                true => Some((
                    DepthPyramidPass::new(gpu, needs)?,
                    TracePass::new(gpu, method)?,
                    ResolvePass::new(gpu, settings, method)?,
                )),
            },
            path_trace: needs.path_trace.then(|| PathTracePass::new(gpu, needs)).transpose()?,
            composite: CompositePass::new(gpu, needs, method)?,
        })
    }

    fn frame(
        &self,
        passes: &Passes,
        context: &Context,
        targets: &Targets,
        fallback: &EnvironmentMaps,
        samples: u32,
        progress: &mut dyn FnMut(u32, u32) -> Result<(), Interrupted>,
    ) -> Result<(Vec<PassTime>, Counts), RenderError> {
        let (scene, resources) = (&*self.scene, &self.resources);
        let mut frame = Frame::begin(&self.gpu)?;
        let (mut times, mut counts) = (Vec::new(), Counts::default());
        frame.fill(&context.counters, 0);
        passes.gbuffer.record(&mut frame, scene, resources, context, &targets.gbuffer)?;
        if let (Some(pass), Some(out)) = (&passes.back_face, &targets.screen_space)
            && let Some(back) = &out.back_depth
        {
            pass.record(&mut frame, scene, resources, context, &targets.gbuffer, back)?;
        }
        passes.lighting.record(&mut frame, resources, context, targets)?;
        if let (Some(classify), Some(list)) = (&passes.classify, &targets.rays) {
            classify.record(&mut frame, context, targets, list)?;
            if let (Some((pyramid, trace, resolve)), Some(out)) = (&passes.screen_space, &targets.screen_space) {
                pyramid.record(&mut frame, context, &targets.gbuffer, out)?;
                for sample in 0..samples {
                    if sample > 0 && sample % SAMPLES_A_SUBMISSION == 0 {
                        times.extend(frame.finish()?);
                        progress(sample, samples)?;
                        frame = self.next_submission(context, &mut counts)?;
                    }
                    trace.record(&mut frame, context, &targets.gbuffer, list, out, sample)?;
                    resolve.record(&mut frame, resources, fallback, context, targets, (sample, samples))?;
                }
            }
            if let (Some(pass), Some(rays)) = (&passes.path_trace, &self.rays) {
                let (mut first, mut count) = (0, 1);
                while first < samples {
                    count = count.min(samples - first);
                    pass.record(&mut frame, resources, rays, context, targets, (first, count))?;
                    let start = Instant::now();
                    times.extend(frame.finish()?);
                    let seconds = start.elapsed().as_secs_f64();
                    frame = self.next_submission(context, &mut counts)?;
                    first += count;
                    progress(first, samples)?;
                    // The first one also rasterises and compiles; it only makes the next estimate cautious.
                    let fitting = f64::from(count) * SUBMISSION_SECONDS / seconds.max(1e-6);
                    count = (fitting as u32).clamp(1, 4 * count);
                }
            }
        }
        passes.composite.record(&mut frame, context, targets)?;
        times.extend(frame.finish()?);
        self.count(context, &mut counts)?;
        Ok((times, counts))
    }

    /// The counters so far, and a submission that starts them anew.
    fn next_submission(&self, context: &Context, counts: &mut Counts) -> Result<Frame, GpuError> {
        self.count(context, counts)?;
        let mut frame = Frame::begin(&self.gpu)?;
        frame.fill(&context.counters, 0);
        Ok(frame)
    }

    fn count(&self, context: &Context, counts: &mut Counts) -> Result<(), GpuError> {
        let bytes = read_buffer(&self.gpu, &context.counters)?;
        counts.add(&bytemuck::pod_read_unaligned::<CountersData>(&bytes[..size_of::<CountersData>()]));
        Ok(())
    }

    fn picture(&self, image: &Image) -> Result<StereoPicture, GpuError> {
        let (width, height) = image.extent();
        let bytes = read_image(&self.gpu, image)?;
        let texels: Vec<[f32; 3]> = bytes
            .chunks_exact(16)
            .map(|t| [0, 4, 8].map(|i| f32::from_le_bytes([t[i], t[i + 1], t[i + 2], t[i + 3]])))
            .collect();
        let (left, right) = texels.split_at(texels.len() / 2);
        Ok(StereoPicture { width, height, eyes: [left.to_vec(), right.to_vec()] })
    }
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

fn split(bytes: Vec<u8>) -> [Vec<u8>; 2] {
    let (left, right) = bytes.split_at(bytes.len() / 2);
    [left.to_vec(), right.to_vec()]
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

/// The middle, or the mean of the two middle ones; 0 of none.
pub fn median_of_sorted(sorted: &[f64]) -> f64 {
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => (sorted[n / 2 - 1] + sorted[n / 2]) / 2.0,
    }
}
