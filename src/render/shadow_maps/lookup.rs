//! The outgoing light of the punctual lights at each pixel, with shadows looked up in shadow maps. The lighting pass adds it.

use std::rc::Rc;

use glam::DVec3;

use super::super::context::Context;
use super::super::needs::FrameNeeds;
use super::super::shaders;
use super::super::targets::Targets;
use super::ShadowMaps;
use crate::gpu::{ComputePass, Frame, Gpu, GpuError, Image};

/// See `shaders/shadows_mapped.comp`.
pub struct MappedShadowsPass {
    pass: ComputePass,
}

impl MappedShadowsPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, needs: &FrameNeeds) -> Result<MappedShadowsPass, GpuError> {
        let words = shaders::SHADOWS_MAPPED_COMP.words();
        Ok(MappedShadowsPass { pass: ComputePass::new(gpu, "shadows_mapped", &words, &[u32::from(needs.glass)])? })
    }

    /// Writes `direct` of [`Targets`].
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        maps: &ShadowMaps,
        context: &Context,
        (targets, direct): (&Targets, &Image),
    ) -> Result<(), GpuError> {
        let DVec3 { x, y, z } = context.head - maps.origin;
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .read_buffer(&context.lights)
            .read_buffer(&maps.views)
            .read_buffer(&maps.lights)
            .sampled(&maps.image, &context.nearest)
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.gbuffer.depth, &context.nearest)
            .write(direct)
            .constants(&[x as f32, y as f32, z as f32, 0.0])
            .dispatch_stereo(direct.extent())
    }
}
