//! Traces rays that the views lost through the scene's geometry, for hybrid methods.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::bvh::RayScene;
use super::context::Context;
use super::needs::FrameNeeds;
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
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, needs: &FrameNeeds, rays: Rc<RayScene>) -> Result<TraceGeometryPass, GpuError> {
        let words = rays.variant(&shaders::TRACE_GEOMETRY_COMP, &shaders::TRACE_GEOMETRY_RAY_QUERY_COMP).words();
        let pass = ComputePass::new(gpu, "trace_geometry", &words, &needs.of_hits())?;
        Ok(TraceGeometryPass { pass, rays })
    }

    /// The geometry that it traces through.
    pub fn rays(&self) -> &RayScene {
        &self.rays
    }

    /// Traces sample `sample` of every lost ray that asks the geometry.
    ///
    /// # Errors
    /// When a Vulkan call fails.
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
            .with(|chain| self.rays.bind_geometry_rays(chain, &marched.lost, (resources, context), &targets.gbuffer))
            .read_write(&out.hits)
            .write(ray_radiance)
            .constants(&sample)
            .dispatch_indirect(&marched.lost.arguments, 0)
    }
}
