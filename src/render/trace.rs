//! Pass 6: one reflection ray a listed pixel, marched through its own eye's depth pyramid.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::shaders;
use super::targets::{GBuffer, RayList, ScreenSpace};

/// See `shaders/trace.comp`.
pub struct TracePass {
    pass: ComputePass,
}

impl TracePass {
    /// # Errors
    /// What the device said.
    pub fn new(gpu: &Rc<Gpu>) -> Result<TracePass, GpuError> {
        Ok(TracePass { pass: ComputePass::new(gpu, "trace", &shaders::TRACE_COMP.words(), &[])? })
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
        frame
            .compute(&self.pass)
            .read_buffer(&context.frame)
            .read_buffer(&list.rays)
            .read_buffer(&list.arguments)
            .write_buffer(&context.counters)
            .sampled(&gbuffer.surface, &context.nearest)
            .sampled(&out.pyramid, &context.nearest)
            .write(&out.hits)
            .constants(&sample)
            .dispatch_indirect(&list.arguments, 0)
    }
}
