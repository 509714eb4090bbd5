//! Rays that the views lost, through the scene's geometry.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::bvh::RayScene;
use super::context::Context;
use super::needs::Needs;
use super::shaders;
use super::targets::Targets;
use super::upload::SceneResources;

/// See `shaders/trace_geometry.comp`.
pub struct TraceGeometryPass {
    pass: ComputePass,
    rays: Rc<RayScene>,
}

impl TraceGeometryPass {
    /// # Errors
    /// What the device said.
    pub fn new(gpu: &Rc<Gpu>, needs: &Needs, rays: Rc<RayScene>) -> Result<TraceGeometryPass, GpuError> {
        let words = rays.variant(&shaders::TRACE_GEOMETRY_COMP, &shaders::TRACE_GEOMETRY_RAY_QUERY_COMP).words();
        let pass = ComputePass::new(gpu, "trace_geometry", &words, &[u32::from(needs.mask)])?;
        Ok(TraceGeometryPass { pass, rays })
    }

    /// What it asks.
    pub fn rays(&self) -> &RayScene {
        &self.rays
    }

    /// Answers sample `sample` of every lost ray.
    ///
    /// # Errors
    /// What the device said.
    pub fn record(
        &self,
        frame: &mut Frame,
        resources: &SceneResources,
        context: &Context,
        targets: &Targets,
        sample: u32,
    ) -> Result<(), GpuError> {
        let (Some(marched), Some(out)) = (&targets.marched, &targets.filtered) else { return Ok(()) };
        let Some(ray_radiance) = &out.ray_radiance else { return Ok(()) };
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .read_buffer(&marched.lost.rays)
            .read_buffer(&marched.lost.arguments)
            .write_buffer(&context.counters)
            .read_buffer(&context.lights)
            .with(|chain| self.rays.bind(chain, resources, context))
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.gbuffer.depth, &context.nearest)
            .with(|chain| resources.environment.bind(chain, context))
            .read_write(&out.hits)
            .write(ray_radiance)
            .constants(&sample)
            .dispatch_indirect(&marched.lost.arguments, 0)
    }
}
