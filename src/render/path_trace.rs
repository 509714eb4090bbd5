//! The reference: reflection rays through the scene's geometry. Each dispatch adds samples to the mean and its standard error.

use std::rc::Rc;

use bytemuck::{Pod, Zeroable};

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::bvh::RayScene;
use super::context::Context;
use super::needs::FrameNeeds;
use super::shaders;
use super::targets::Targets;
use super::upload::SceneResources;

/// See `shaders/path_trace.comp`.
pub struct PathTracePass {
    pass: ComputePass,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    first_sample: u32,
    sample_count: u32,
}

impl PathTracePass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, needs: &FrameNeeds, rays: &RayScene) -> Result<PathTracePass, GpuError> {
        let words = rays.variant(&shaders::PATH_TRACE_COMP, &shaders::PATH_TRACE_RAY_QUERY_COMP).words();
        Ok(PathTracePass { pass: ComputePass::new(gpu, "path_trace", &words, &needs.of_hits())? })
    }

    /// Adds samples `first .. first + count`.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        resources: &SceneResources,
        rays: &RayScene,
        context: &Context,
        targets: &Targets,
        (first, count): (u32, u32),
    ) -> Result<(), GpuError> {
        let (Some(list), Some(out)) = (&targets.rays, &targets.path_traced) else { return Ok(()) };
        let Some(sums) = &out.sums else { return Ok(()) };
        frame
            .compute(&self.pass)
            .with(|chain| rays.bind_geometry_rays(chain, list, (resources, context), &targets.gbuffer))
            .read_write(&sums.sum)
            .read_write(&sums.compensation)
            .read_write(&sums.squares)
            .write(&out.reflection)
            .write(&out.error)
            .constants(&Constants { first_sample: first, sample_count: count })
            .dispatch_indirect(&list.arguments, 0)
    }
}
