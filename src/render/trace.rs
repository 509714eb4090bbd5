//! Passes 6 and 7: one reflection ray for each listed pixel. It is marched through its own eye's depth pyramid, and goes on in
//! the other eye's where its own eye loses it.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::method::{Method, Reuse, Traversal};
use super::ray_list::RayList;
use super::settings::Settings;
use super::shaders;
use super::targets::{FilterImages, GBuffer, MarchImages};

/// See `shaders/trace.comp`, `shaders/trace_other_eye.comp` and, for the oracle, `shaders/trace_one_loop.comp`.
pub struct TracePass {
    first: ComputePass,
    traversal: Traversal,
    other_eye: Option<ComputePass>,
}

impl TracePass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, (settings, method): (&Settings, &Method)) -> Result<TracePass, GpuError> {
        let technique = method.technique();
        let fade = u32::from(technique.stereo_fade);
        let traversal = technique.traversal;
        let two_stages = traversal == Traversal::TwoStages;
        let lost_share = (method.lost_share() * 255.0).round() as u32;
        let [camera_rays, one_eye] = [technique.camera_rays, technique.one_eye].map(u32::from);
        // With the published estimator rays are traced as published: each one that goes behind matter goes on in the other eye.
        let by_disparity = u32::from(two_stages && settings.reuse(method) == Reuse::Balance);
        let own = [fade, u32::from(two_stages), camera_rays, one_eye, lost_share, by_disparity];
        // Both stages get the same constants; the second one declares only some of them.
        let other = || ComputePass::new(gpu, "trace_other_eye", &shaders::TRACE_OTHER_EYE_COMP.words(), &own);
        let first = match traversal {
            Traversal::OneLoop => ComputePass::new(gpu, "trace", &shaders::TRACE_ONE_LOOP_COMP.words(), &[fade])?,
            _ => ComputePass::new(gpu, "trace", &shaders::TRACE_COMP.words(), &own)?,
        };
        Ok(TracePass { first, traversal, other_eye: two_stages.then(other).transpose()? })
    }

    /// Traces sample `sample` of every listed pixel.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        context: &Context,
        gbuffer: &GBuffer,
        list: &RayList,
        (marched, out): (&MarchImages, &FilterImages),
        sample: u32,
    ) -> Result<(), GpuError> {
        marched.retries.clear(frame);
        marched.lost.clear(frame);
        let chain = frame
            .compute(&self.first)
            .uniform(&context.frame)
            .read_buffer(&list.rays)
            .read_buffer(&list.arguments)
            .write_buffer(&context.counters)
            .sampled(&gbuffer.surface, &context.nearest)
            .sampled(&marched.pyramid, &context.nearest)
            .write(&out.hits);
        match self.traversal {
            Traversal::OneLoop => chain,
            _ => chain
                .write_buffer(&marched.retries.rays)
                .write_buffer(&marched.retries.arguments)
                .write_buffer(&marched.lost.rays)
                .write_buffer(&marched.lost.arguments),
        }
        .constants(&sample)
        .dispatch_indirect(&list.arguments, 0)?;
        let Some(other_eye) = &self.other_eye else { return Ok(()) };
        frame
            .compute(other_eye)
            .uniform(&context.frame)
            .read_buffer(&marched.retries.rays)
            .read_buffer(&marched.retries.arguments)
            .write_buffer(&context.counters)
            .sampled(&gbuffer.surface, &context.nearest)
            .sampled(&marched.pyramid, &context.nearest)
            .read_write(&out.hits)
            .write_buffer(&marched.lost.rays)
            .write_buffer(&marched.lost.arguments)
            .constants(&sample)
            .dispatch_indirect(&marched.retries.arguments, 0)
    }
}
