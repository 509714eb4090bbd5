//! Pass 6 of the methods that filter path-traced rays, the reference's real-time relatives: one reflection ray for each listed
//! pixel through the scene's geometry, whose hit goes to the screen-space methods' filter (`resolve`).

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::bvh::RayScene;
use super::context::Context;
use super::needs::FrameNeeds;
use super::shaders;
use super::targets::Targets;
use super::upload::SceneResources;

/// See `shaders/path_rays.comp`.
pub struct PathRaysPass {
    pass: ComputePass,
}

impl PathRaysPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, needs: &FrameNeeds, rays: &RayScene) -> Result<PathRaysPass, GpuError> {
        let words = rays.variant(&shaders::PATH_RAYS_COMP, &shaders::PATH_RAYS_RAY_QUERY_COMP).words();
        Ok(PathRaysPass { pass: ComputePass::new(gpu, "path_rays", &words, &needs.of_hits())? })
    }

    /// Traces sample `sample` of every listed pixel.
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
        sample: u32,
    ) -> Result<(), GpuError> {
        let (Some(list), Some(out)) = (&targets.rays, &targets.filtered) else { return Ok(()) };
        let Some(ray_radiance) = &out.ray_radiance else { return Ok(()) };
        frame
            .compute(&self.pass)
            .with(|chain| rays.bind_geometry_rays(chain, list, (resources, context), &targets.gbuffer))
            .write(&out.hits)
            .write(ray_radiance)
            .constants(&sample)
            .dispatch_indirect(&list.arguments, 0)
    }
}
