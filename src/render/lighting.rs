//! Pass 3: radiance of every pixel without its traced reflection.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError, Image};

use super::context::Context;
use super::method::Ao;
use super::needs::FrameNeeds;
use super::shaders;
use super::targets::Targets;
use super::upload::SceneResources;

/// Punctual lights, diffuse environment, emission, background.
pub struct LightingPass {
    pass: ComputePass,
}

impl LightingPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, needs: &FrameNeeds) -> Result<LightingPass, GpuError> {
        let words = shaders::LIGHTING_COMP.words();
        let parts = [needs.emission, needs.direct(), needs.indirect, needs.ao != Ao::None].map(u32::from);
        Ok(LightingPass { pass: ComputePass::new(gpu, "lighting", &words, &parts)? })
    }

    /// `visibility`: how much of its surroundings each pixel sees, if ambient light is occluded. A finer view (antialiasing) uses
    /// its view's.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        resources: &SceneResources,
        context: &Context,
        targets: &Targets,
        visibility: Option<&Image>,
    ) -> Result<(), GpuError> {
        let direct: &Image = targets.direct.as_ref().unwrap_or(&targets.placeholder);
        let indirect: &Image = targets.indirect.as_ref().unwrap_or(&targets.placeholder);
        let emission: &Image = targets.gbuffer.emission.as_ref().unwrap_or(&targets.placeholder);
        let visibility = visibility.unwrap_or(&targets.placeholder);
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .read_buffer(&context.lights)
            .write_buffer(&context.counters)
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.gbuffer.depth, &context.nearest)
            .with(|chain| context.bind_environment(chain, &resources.environment))
            .write(&targets.radiance)
            .sampled(emission, &context.nearest)
            .sampled(direct, &context.nearest)
            .sampled(indirect, &context.nearest)
            .sampled(visibility, &context.nearest)
            .dispatch_stereo(targets.radiance.extent())
    }
}
