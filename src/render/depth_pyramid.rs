//! Pass 4: the depth pyramid that screen-space rays are marched through. For each cell it holds the nearest front and the
//! farthest back, in seven levels of both eyes, written by one dispatch.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::method::{Method, Reuse};
use super::needs::FrameNeeds;
use super::settings::Settings;
use super::shaders;
use super::targets::{GBuffer, MarchImages, TOP_LEVEL};

/// See `shaders/depth_pyramid.comp`.
pub struct DepthPyramidPass {
    pass: ComputePass,
}

impl DepthPyramidPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(
        gpu: &Rc<Gpu>,
        needs: &FrameNeeds,
        (settings, method): (&Settings, &Method),
    ) -> Result<DepthPyramidPass, GpuError> {
        let words = shaders::DEPTH_PYRAMID_COMP.words();
        // With the published estimator rays are traced as published, through the gaps in slanted surfaces too.
        let close_slopes = settings.reuse(method) == Reuse::Balance;
        let specialization = [needs.back_faces, close_slopes].map(u32::from);
        let pass = ComputePass::new(gpu, "depth_pyramid", &words, &specialization)?;
        Ok(DepthPyramidPass { pass })
    }

    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        context: &Context,
        gbuffer: &GBuffer,
        out: &MarchImages,
    ) -> Result<(), GpuError> {
        let mut chain = frame.compute(&self.pass).uniform(&context.frame).sampled(&gbuffer.depth, &context.nearest);
        for mip in 0..=TOP_LEVEL as usize {
            chain = chain.write_mip(&out.pyramid, mip);
        }
        let (width, height) = out.pyramid.extent();
        let tile = 1 << TOP_LEVEL;
        chain
            .sampled(out.back_depth.as_ref().unwrap_or(&gbuffer.depth), &context.nearest)
            .sampled(&gbuffer.surface, &context.nearest)
            .dispatch(width / tile, height / tile, 2)
    }
}
