//! Pass 3: radiance of every pixel without its traced reflection.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError, Image};

use super::ao::Ao;
use super::context::Context;
use super::needs::Needs;
use super::shaders;
use super::targets::Targets;
use super::upload::SceneResources;

/// Punctual lights, diffuse environment, emission, background.
pub struct LightingPass {
    pass: ComputePass,
}

impl LightingPass {
    /// # Errors
    /// What the device said.
    pub fn new(gpu: &Rc<Gpu>, needs: &Needs) -> Result<LightingPass, GpuError> {
        let words = shaders::LIGHTING_COMP.words();
        // Constants 1 and 2 have no meaning in this shader.
        let specialization = [u32::from(needs.emission), 0, 0, u32::from(needs.ao != Ao::None)];
        Ok(LightingPass { pass: ComputePass::new(gpu, "lighting", &words, &specialization)? })
    }

    /// # Errors
    /// What the device said.
    pub fn record(
        &self,
        frame: &mut Frame,
        resources: &SceneResources,
        context: &Context,
        targets: &Targets,
    ) -> Result<(), GpuError> {
        let emission: &Image = targets.gbuffer.emission.as_ref().unwrap_or(&targets.nothing);
        let visibility = targets.ao.as_ref().map_or(&targets.nothing, |ao| &ao.visibility);
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .read_buffer(&context.lights)
            .write_buffer(&context.counters)
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.gbuffer.depth, &context.nearest)
            .with(|chain| resources.environment.bind(chain, context))
            .write(&targets.radiance)
            .sampled(emission, &context.nearest)
            .sampled(visibility, &context.nearest)
            .dispatch_stereo(targets.radiance.extent())
    }
}
