//! Records, submits and waits for the passes of a frame, in their order.

use std::time::Instant;

use crate::console::Interrupted;
use crate::gpu::{Frame, GpuError, PassTime, read_buffer};

use super::super::ao::{AoBindings, AoPass};
use super::super::context::Context;
use super::super::cpu::Paths;
use super::super::error::RenderError;
use super::super::shared::{CountersData, Counts};
use super::super::targets::{MarchImages, Targets};
use super::super::trace_geometry::TraceGeometryPass;
use super::{Prepared, by_name};

/// The largest number of samples of a screen-space method in one submission. There are fewer if the submission's counts could
/// exceed 32 bits.
const SAMPLES_A_SUBMISSION: u64 = 8;
/// More steps than a march takes on average over an image.
const STEPS_A_RAY: u64 = 128;
/// The intended duration of a submission of the reference, so that progress is visible and no watchdog resets the device.
const SUBMISSION_SECONDS: f64 = 0.5;

impl Prepared {
    pub(super) fn record(
        &self,
        progress: &mut dyn FnMut(u32, u32) -> Result<(), Interrupted>,
    ) -> Result<(Vec<PassTime>, Counts), RenderError> {
        let Prepared { scene, resources, passes, context, targets, .. } = self;
        let samples = self.method.samples();
        // A probe is used only if these settings need one; it may have been made for others.
        let fallback = self.probe.as_deref().filter(|_| self.needs.probe).unwrap_or(&resources.environment);
        let (mut times, mut counts) = (Vec::new(), Counts::default());
        let lights = self.settings.all_passes || !self.is_lighting_current.get();
        if let (true, Some(maps)) = (lights, &self.shadow_maps) {
            times.extend(maps.follow(self.camera.head())?);
        }
        let mut frame = Frame::begin(&self.gpu)?;
        frame.fill(&context.counters, 0);
        passes.gbuffer.record(&mut frame, scene, resources, context, &targets.gbuffer)?;
        if let (Some(pass), Some(marched)) = (&passes.back_face, &targets.marched)
            && let Some(back) = &marched.back_depth
        {
            pass.record(&mut frame, scene, resources, context, &targets.gbuffer, back)?;
        }
        if lights {
            frame = self.record_lights(frame, (context, targets), 1, (&mut times, &mut counts))?;
        }
        frame = self.record_ao(frame, (&mut times, &mut counts), progress)?;
        let visibility = targets.ao.as_ref().map(|ao| &ao.visibility);
        passes.lighting.record(&mut frame, resources, context, targets, visibility)?;
        if let Some(supersampled) = &self.supersampled {
            passes.gbuffer.record(
                &mut frame,
                scene,
                resources,
                &supersampled.context,
                &supersampled.targets.gbuffer,
            )?;
            if lights {
                let of = (&supersampled.context, &supersampled.targets);
                frame = self.record_lights(frame, of, self.settings.antialias, (&mut times, &mut counts))?;
            }
            passes.lighting.record(&mut frame, resources, &supersampled.context, &supersampled.targets, visibility)?;
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
                            // The geometry is built only if a ray was lost, so the frame waits here until the list can be read.
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
            if let (Some(pass), Some(history)) = (&passes.accumulate, &self.history) {
                history.begin(&self.moment(), &self.places, context.head);
                pass.record(&mut frame, resources, fallback, context, (targets, history))?;
            }
            if let Some(reproject) = &passes.reproject {
                reproject.record(&mut frame, resources, fallback, context, (targets, self.history.as_ref()))?;
            }
            if let (Some(pass), Some(world), Some(out)) = (&passes.cpu_path_trace, &self.world, &targets.path_traced) {
                times.extend(frame.finish()?);
                let kept = self.paths.borrow_mut().sums.take().filter(|kept| kept.samples <= samples);
                let mut paths = pass.begin(world, context, (list, &targets.gbuffer), kept.as_ref())?;
                drop(kept);
                let done = self.add_on_the_cpu(&mut paths, &mut counts, progress);
                if self.paths.borrow().kept {
                    self.paths.borrow_mut().sums = Some(paths.sums());
                }
                done?;
                times.push(paths.finish(out, &mut counts)?);
                frame = self.next_submission(&mut counts)?;
            }
            if let (Some(pass), Some(rays)) = (&passes.path_trace, &self.rays) {
                let (mut first, mut count) = (0, 1);
                // Keeps the submission's counts within 32 bits.
                let most_paths = (u64::from(u32::MAX) / self.pixels()).max(1) as u32;
                self.begin_paths();
                while first < samples {
                    count = count.min(self.until_next(first, samples));
                    // Taken before recording, because on software devices recording a pass already submits it and waits.
                    let start = Instant::now();
                    pass.record(&mut frame, resources, rays, context, targets, (first, count))?;
                    times.extend(frame.finish()?);
                    let seconds = start.elapsed().as_secs_f64();
                    frame = self.next_submission(&mut counts)?;
                    first += count;
                    self.paths.borrow_mut().samples = first;
                    progress(first, samples)?;
                    if let Some(out) = &targets.path_traced
                        && self.is_enough(first, || self.error_on_device(list, out))?
                    {
                        break;
                    }
                    // The first submission also rasterises and compiles pipelines, which only makes the estimate cautious.
                    count = next_count(count, seconds).min(most_paths);
                }
            }
        }
        passes.composite.record(&mut frame, context, targets, self.supersampled.as_ref())?;
        times.extend(frame.finish()?);
        self.count(&mut counts)?;
        // Set only at the end, because an interrupted frame may not have computed the light.
        self.is_lighting_current.set(true);
        if let Some(history) = &self.history {
            history.end(context.uniform(), self.moment(), self.places.clone());
        }
        Ok((times, counts))
    }

    fn begin_paths(&self) {
        let mut paths = self.paths.borrow_mut();
        paths.checks.clear();
        paths.samples = 0;
    }

    /// Adds samples until there are enough, in portions of about [`SUBMISSION_SECONDS`].
    fn add_on_the_cpu(
        &self,
        paths: &mut Paths<'_>,
        counts: &mut Counts,
        progress: &mut dyn FnMut(u32, u32) -> Result<(), Interrupted>,
    ) -> Result<(), RenderError> {
        let samples = self.method.samples();
        self.begin_paths();
        let mut count = 1;
        while paths.samples() < samples {
            count = count.min(self.until_next(paths.samples(), samples));
            let start = Instant::now();
            paths.add(count, counts);
            progress(paths.samples(), samples)?;
            if self.is_enough(paths.samples(), || Ok(paths.relative_error()))? {
                break;
            }
            count = next_count(count, start.elapsed().as_secs_f64());
        }
        self.paths.borrow_mut().samples = paths.samples();
        Ok(())
    }

    /// Records the passes of the punctual lights and of baked light. `finer`: samples along each side of a pixel.
    fn record_lights(
        &self,
        mut frame: Frame,
        (context, targets): (&Context, &Targets),
        finer: u32,
        (times, counts): (&mut Vec<PassTime>, &mut Counts),
    ) -> Result<Frame, GpuError> {
        let Prepared { resources, passes, .. } = self;
        if let (Some(pass), Some(world), Some(direct)) = (&passes.cpu_shadows, &self.world, &targets.direct) {
            times.extend(frame.finish()?);
            times.push(pass.run(world, context, (&targets.gbuffer, direct), finer)?);
            frame = self.next_submission(counts)?;
        }
        if let (Some(pass), Some(maps), Some(direct)) = (&passes.mapped_shadows, &self.shadow_maps, &targets.direct) {
            pass.record(&mut frame, maps, context, (targets, direct))?;
        }
        if let Some(pass) = &passes.shading_reuse {
            pass.record(&mut frame, (resources, self.rays.as_deref()), context, targets, finer)?;
        }
        let Some(rays) = &self.rays else { return Ok(frame) };
        if let (Some(pass), Some(direct)) = (&passes.shadows, &targets.direct) {
            pass.record(&mut frame, resources, rays, context, (targets, direct), finer)?;
        }
        if let (Some(pass), Some(indirect)) = (&passes.indirect, &targets.indirect) {
            pass.record(&mut frame, resources, rays, context, (targets, indirect))?;
        }
        Ok(frame)
    }

    /// Records the passes of ambient occlusion, if there are any. Its rays are divided over several submissions.
    fn record_ao(
        &self,
        mut frame: Frame,
        (times, counts): (&mut Vec<PassTime>, &mut Counts),
        progress: &mut dyn FnMut(u32, u32) -> Result<(), Interrupted>,
    ) -> Result<Frame, RenderError> {
        let (Some(pass), Some(images)) = (&self.passes.ao, &self.targets.ao) else { return Ok(frame) };
        let bindings = AoBindings { context: &self.context, gbuffer: &self.targets.gbuffer, images };
        match (pass, &self.rays) {
            (AoPass::Views(pass), _) => pass.record(&mut frame, bindings)?,
            (AoPass::Rays(pass), Some(rays)) => {
                let (mut first, mut count) = (0, 1);
                while first < pass.count() {
                    count = count.min(pass.count() - first);
                    let start = Instant::now();
                    pass.record(&mut frame, (&self.resources, rays), bindings, (first, count))?;
                    times.extend(frame.finish()?);
                    first += count;
                    count = next_count(count, start.elapsed().as_secs_f64());
                    frame = self.next_submission(counts)?;
                    // Called for Ctrl-C; none of the method's own samples is done yet.
                    progress(0, self.method.samples())?;
                }
            }
            (AoPass::Rays(_), None) => {}
        }
        Ok(frame)
    }

    /// Builds the geometry for lost rays, if the list of `marched` holds any.
    fn make_trace_geometry(&self, marched: &MarchImages) -> Result<(), GpuError> {
        if marched.lost.read_count(&self.gpu)? > 0 {
            let rays = self.lazy_rays.obtain(self.context.head, self.settings.trace)?;
            let pass = TraceGeometryPass::new(&self.gpu, &self.needs, rays)?;
            // The cell is empty: the caller has checked it, and nothing else fills it.
            let _ = self.trace_geometry.set(pass);
        }
        Ok(())
    }

    /// The number of pixels that are drawn, in both eyes.
    fn pixels(&self) -> u64 {
        let (width, height) = self.targets.linear.extent();
        2 * u64::from(width) * u64::from(height)
    }

    /// Adds the device's counters to `counts`, and begins a submission with counters of 0.
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

    /// Renders only the G-buffer and ambient occlusion, for callers that need nothing else.
    ///
    /// # Errors
    /// When a Vulkan call fails, or on Ctrl-C.
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
}

/// The number of samples for the next submission, after `count` samples took `seconds`.
fn next_count(count: u32, seconds: f64) -> u32 {
    let fitting = f64::from(count) * SUBMISSION_SECONDS / seconds.max(1e-6);
    (fitting as u32).clamp(1, 4 * count)
}
