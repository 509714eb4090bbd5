//! Pass 8: turns the hits of rays into reflected radiance, with spatial reuse.

use std::rc::Rc;

use bytemuck::{Pod, Zeroable};

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::method::{Method, Reuse};
use super::needs::FrameNeeds;
use super::settings::Settings;
use super::shaders;
use super::targets::Targets;
use super::upload::{EnvironmentMaps, SceneResources};

/// See `shaders/resolve.comp`.
pub struct ResolvePass {
    pass: ComputePass,
    weber: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    first: u32,
    last: u32,
    /// The largest difference between the eyes, relative to the pixel's composited light, at which a pixel is finished without
    /// the other eye.
    weber: f32,
}

impl ResolvePass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(
        gpu: &Rc<Gpu>,
        needs: &FrameNeeds,
        (settings, method): (&Settings, &Method),
    ) -> Result<ResolvePass, GpuError> {
        let technique = method.technique();
        let radius_squared =
            technique.reuse_radius_squared.unwrap_or(2 * settings.reuse_radius * settings.reuse_radius);
        let weber = method.weber_share();
        let specialization = [
            radius_squared,
            u32::from(method.samples() > 1),
            u32::from(needs.pairs),
            u32::from(technique.one_eye),
            u32::from(technique.resolved),
            u32::from(settings.reuse(method) == Reuse::Balance),
            u32::from(needs.geometry),
            u32::from(needs.moments),
            u32::from(weber.is_some()),
            (2 * radius_squared.isqrt() + 1).pow(2),
        ];
        let pass = ComputePass::new(gpu, "resolve", &shaders::RESOLVE_COMP.words(), &specialization)?;
        Ok(ResolvePass { pass, weber: weber.unwrap_or(0.0) })
    }

    /// Adds the hits of sample `sample` of `samples`. The last sample writes the reflection, or what blending with the other eye
    /// or with earlier frames needs. `fallback` stands in for unknown rays, unless the settings say black.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        resources: &SceneResources,
        fallback: &EnvironmentMaps,
        context: &Context,
        targets: &Targets,
        (sample, samples): (u32, u32),
    ) -> Result<(), GpuError> {
        let (Some(list), Some(out)) = (&targets.rays, &targets.filtered) else { return Ok(()) };
        let (sums, weights) = match &out.sums {
            Some((sums, weights)) => (sums, weights),
            None => (&targets.placeholder, &targets.placeholder),
        };
        let (known, statistics) = match &out.pairs {
            Some(pairs) => (&pairs.known, &pairs.statistics),
            None => (&out.reflection, &targets.placeholder),
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
            .with(|chain| context.bind_surroundings(chain, &resources.environment, fallback))
            .write(known)
            .read_write(sums)
            .read_write(weights)
            .read_write(statistics)
            .sampled(out.ray_radiance.as_ref().unwrap_or(&targets.radiance), &context.nearest)
            .write(&out.reflection)
            .constants(&Constants {
                first: u32::from(sample == 0),
                last: u32::from(sample + 1 == samples),
                weber: self.weber,
            })
            .dispatch_indirect(&list.arguments, 0)
    }
}
