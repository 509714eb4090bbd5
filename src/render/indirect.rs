//! Looks up the baked light of each pixel's surface, for the lighting pass.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError, Image};

use super::bvh::RayScene;
use super::context::Context;
use super::needs::FrameNeeds;
use super::shaders;
use super::targets::Targets;
use super::upload::SceneResources;

/// See `shaders/indirect.comp`.
pub struct IndirectPass {
    pass: ComputePass,
}

impl IndirectPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, needs: &FrameNeeds, rays: &RayScene) -> Result<IndirectPass, GpuError> {
        let words = rays.variant(&shaders::INDIRECT_COMP, &shaders::INDIRECT_RAY_QUERY_COMP).words();
        Ok(IndirectPass { pass: ComputePass::new(gpu, "indirect", &words, &[u32::from(needs.mask)])? })
    }

    /// Writes `indirect` of [`Targets`].
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        resources: &SceneResources,
        rays: &RayScene,
        context: &Context,
        (targets, indirect): (&Targets, &Image),
    ) -> Result<(), GpuError> {
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .with(|chain| rays.bind(chain, resources, context))
            .sampled(&targets.gbuffer.depth, &context.nearest)
            .with(|chain| context.baked.bind(chain, &context.nearest))
            .write(indirect)
            .dispatch_stereo(indirect.extent())
    }
}
