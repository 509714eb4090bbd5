//! Pass 9: what the other eye knows of the same reflection.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::method::Reprojection;
use super::shaders;
use super::targets::Targets;
use super::upload::{EnvironmentMaps, SceneResources};

/// See `shaders/reproject.comp`.
pub struct ReprojectPass {
    pass: ComputePass,
}

impl ReprojectPass {
    /// # Errors
    /// What the device said.
    pub fn new(gpu: &Rc<Gpu>, how: Reprojection, by_variance: bool) -> Result<ReprojectPass, GpuError> {
        let specialization = [how.filling, how.back_check, how.lobe_tolerance, by_variance].map(u32::from);
        let words = shaders::REPROJECT_COMP.words();
        Ok(ReprojectPass { pass: ComputePass::new(gpu, "reproject", &words, &specialization)? })
    }

    /// `fallback` is what unknown rays see, where the settings want more than black.
    ///
    /// # Errors
    /// What the device said.
    pub fn record(
        &self,
        frame: &mut Frame,
        resources: &SceneResources,
        fallback: &EnvironmentMaps,
        context: &Context,
        targets: &Targets,
    ) -> Result<(), GpuError> {
        let (Some(list), Some(out)) = (&targets.rays, &targets.filtered) else { return Ok(()) };
        let Some(pairs) = &out.pairs else { return Ok(()) };
        // Where the eyes are compared first, only the pixels that may differ visibly are left.
        let list = pairs.visible.as_ref().unwrap_or(list);
        let maps = &resources.environment;
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .read_buffer(&list.rays)
            .read_buffer(&list.arguments)
            .write_buffer(&context.counters)
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.guide, &context.nearest)
            .sampled(&pairs.known, &context.nearest)
            .sampled(&pairs.standing, &context.nearest)
            .sampled(&maps.radiance, &maps.sampler)
            .sampled(&maps.irradiance, &maps.sampler)
            .sampled(&fallback.specular, &fallback.sampler)
            .sampled(&context.brdf_table, &context.linear)
            .read_buffer(&context.lights)
            .write(&out.reflection)
            .dispatch_indirect(&list.arguments, 0)
    }
}
