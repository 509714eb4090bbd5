//! Pass 8: hits to radiance, with spatial reuse.

use std::rc::Rc;

use bytemuck::{Pod, Zeroable};

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::method::Method;
use super::settings::Settings;
use super::shaders;
use super::targets::Targets;
use super::upload::{EnvironmentMaps, SceneResources};

/// See `shaders/resolve.comp`.
pub struct ResolvePass {
    pass: ComputePass,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    first: u32,
    last: u32,
}

impl ResolvePass {
    /// # Errors
    /// What the device said.
    pub fn new(gpu: &Rc<Gpu>, settings: &Settings, method: &Method) -> Result<ResolvePass, GpuError> {
        let sums = method.samples() > 1;
        let specialization = [settings.reuse_radius, u32::from(sums), u32::from(method.reprojection())];
        Ok(ResolvePass { pass: ComputePass::new(gpu, "resolve", &shaders::RESOLVE_COMP.words(), &specialization)? })
    }

    /// Adds the hits of sample `sample` of `samples`; the last one writes the reflection. `fallback` is what unknown
    /// rays see, where the settings want more than black.
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
        (sample, samples): (u32, u32),
    ) -> Result<(), GpuError> {
        let (Some(list), Some(out)) = (&targets.rays, &targets.screen_space) else { return Ok(()) };
        let maps = &resources.environment;
        let (sums, weights) = match &out.sums {
            Some((sums, weights)) => (sums, weights),
            None => (&targets.nothing, &targets.nothing),
        };
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .read_buffer(&list.rays)
            .read_buffer(&list.arguments)
            .write_buffer(&context.counters)
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.guide, &context.nearest)
            .sampled(&out.hits, &context.nearest)
            .sampled(&targets.radiance, &context.nearest)
            .sampled(&maps.radiance, &maps.sampler)
            .sampled(&maps.irradiance, &maps.sampler)
            .sampled(&fallback.specular, &fallback.sampler)
            .sampled(&context.brdf_table, &context.linear)
            .read_buffer(&context.lights)
            .write(&out.reflection)
            .read_write(sums)
            .read_write(weights)
            .constants(&Constants { first: u32::from(sample == 0), last: u32::from(sample + 1 == samples) })
            .dispatch_indirect(&list.arguments, 0)
    }
}
