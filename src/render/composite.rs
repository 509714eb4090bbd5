//! Pass 10: adds the reflections to the other light, and writes the linear images for stills and the tone-mapped picture.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::method::Method;
use super::needs::FrameNeeds;
use super::settings::Settings;
use super::shaders;
use super::supersampled::SupersampledView;
use super::targets::Targets;

/// See `shaders/composite.comp`.
pub struct CompositePass {
    pass: ComputePass,
}

impl CompositePass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(
        gpu: &Rc<Gpu>,
        needs: &FrameNeeds,
        (settings, method): (&Settings, &Method),
    ) -> Result<CompositePass, GpuError> {
        let specialization = [u32::from(needs.rays), 1, u32::from(method.technique().unrelated), settings.antialias];
        let words = shaders::COMPOSITE_COMP.words();
        Ok(CompositePass { pass: ComputePass::new(gpu, "composite", &words, &specialization)? })
    }

    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        context: &Context,
        targets: &Targets,
        supersampled: Option<&SupersampledView>,
    ) -> Result<(), GpuError> {
        let surfaces = supersampled.map_or(targets, |f| &f.targets);
        let screen_space = targets.filtered.as_ref().map(|s| &s.reflection);
        let path_traced = targets.path_traced.as_ref().map(|p| &p.reflection);
        let reflection = screen_space.or(path_traced).unwrap_or(&targets.placeholder);
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .write_buffer(&context.counters)
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.gbuffer.depth, &context.nearest)
            .sampled(&targets.radiance, &context.nearest)
            .sampled(reflection, &context.nearest)
            .write(&targets.display)
            .write(&targets.linear)
            .write(&targets.reflection_out)
            .sampled(&targets.gbuffer.instance, &context.nearest)
            .sampled(&surfaces.gbuffer.surface, &context.nearest)
            .sampled(&surfaces.gbuffer.depth, &context.nearest)
            .sampled(&surfaces.gbuffer.instance, &context.nearest)
            .sampled(&surfaces.radiance, &context.nearest)
            .dispatch_stereo(targets.linear.extent())
    }
}
