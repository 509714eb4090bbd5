//! Passes 6 and 7: one reflection ray a listed pixel, marched through its own eye's depth pyramid, and on through the
//! other eye's where its own loses it.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::method::Method;
use super::shaders;
use super::targets::{GBuffer, RayList, ScreenSpace};

/// See `shaders/trace.comp` and `shaders/trace_other_eye.comp`.
pub struct TracePass {
    own_eye: ComputePass,
    other_eye: Option<ComputePass>,
}

impl TracePass {
    /// # Errors
    /// What the device said.
    pub fn new(gpu: &Rc<Gpu>, method: &Method) -> Result<TracePass, GpuError> {
        let fade = u32::from(method.stereo_fade());
        let own = [fade, u32::from(method.other_eye())];
        let other = || ComputePass::new(gpu, "trace_other_eye", &shaders::TRACE_OTHER_EYE_COMP.words(), &[fade]);
        Ok(TracePass {
            own_eye: ComputePass::new(gpu, "trace", &shaders::TRACE_COMP.words(), &own)?,
            other_eye: method.other_eye().then(other).transpose()?,
        })
    }

    /// Traces sample `sample` of every listed pixel.
    ///
    /// # Errors
    /// What the device said.
    pub fn record(
        &self,
        frame: &mut Frame,
        context: &Context,
        gbuffer: &GBuffer,
        list: &RayList,
        out: &ScreenSpace,
        sample: u32,
    ) -> Result<(), GpuError> {
        out.retries.clear(frame);
        frame
            .compute(&self.own_eye)
            .uniform(&context.frame)
            .read_buffer(&list.rays)
            .read_buffer(&list.arguments)
            .write_buffer(&context.counters)
            .sampled(&gbuffer.surface, &context.nearest)
            .sampled(&out.pyramid, &context.nearest)
            .write(&out.hits)
            .write_buffer(&out.retries.rays)
            .write_buffer(&out.retries.arguments)
            .constants(&sample)
            .dispatch_indirect(&list.arguments, 0)?;
        let Some(other_eye) = &self.other_eye else { return Ok(()) };
        frame
            .compute(other_eye)
            .uniform(&context.frame)
            .read_buffer(&out.retries.rays)
            .read_buffer(&out.retries.arguments)
            .write_buffer(&context.counters)
            .sampled(&gbuffer.surface, &context.nearest)
            .sampled(&out.pyramid, &context.nearest)
            .read_write(&out.hits)
            .constants(&sample)
            .dispatch_indirect(&out.retries.arguments, 0)
    }
}
