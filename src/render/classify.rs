//! Pass 5: lists the pixels that trace a reflection ray, and writes the guide for the resolve.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::needs::FrameNeeds;
use super::ray_list::RayList;
use super::shaders;
use super::targets::Targets;

/// See `shaders/classify.comp`.
pub struct ClassifyPass {
    pass: ComputePass,
}

impl ClassifyPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, needs: &FrameNeeds) -> Result<ClassifyPass, GpuError> {
        let specialization = [u32::from(needs.resolve)];
        Ok(ClassifyPass { pass: ComputePass::new(gpu, "classify", &shaders::CLASSIFY_COMP.words(), &specialization)? })
    }

    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        context: &Context,
        targets: &Targets,
        out: &RayList,
    ) -> Result<(), GpuError> {
        out.clear(frame);
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.gbuffer.depth, &context.nearest)
            .write_buffer(&out.rays)
            .write_buffer(&out.arguments)
            .sampled(&targets.gbuffer.instance, &context.nearest)
            .write(&targets.guide)
            .dispatch_stereo(targets.gbuffer.depth.extent())
    }
}
