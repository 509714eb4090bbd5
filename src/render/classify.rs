//! Pass 5: which pixels trace a ray.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::shaders;
use super::targets::{GBuffer, RayList};

/// See `shaders/classify.comp`.
pub struct ClassifyPass {
    pass: ComputePass,
}

impl ClassifyPass {
    /// # Errors
    /// What the device said.
    pub fn new(gpu: &Rc<Gpu>) -> Result<ClassifyPass, GpuError> {
        Ok(ClassifyPass { pass: ComputePass::new(gpu, "classify", &shaders::CLASSIFY_COMP.words(), &[])? })
    }

    /// # Errors
    /// What the device said.
    pub fn record(
        &self,
        frame: &mut Frame,
        context: &Context,
        gbuffer: &GBuffer,
        out: &RayList,
    ) -> Result<(), GpuError> {
        out.clear(frame);
        frame
            .compute(&self.pass)
            .read_buffer(&context.frame)
            .sampled(&gbuffer.surface, &context.nearest)
            .sampled(&gbuffer.depth, &context.nearest)
            .write_buffer(&out.rays)
            .write_buffer(&out.arguments)
            .dispatch_stereo(gbuffer.depth.extent())
    }
}
