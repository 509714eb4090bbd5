//! Ambient occlusion by rays through the scene's geometry, against which the estimates from the views are judged.

use std::rc::Rc;

use bytemuck::{Pod, Zeroable};

use super::settings::AoSettings;
use super::views::AoBindings;
use crate::gpu::{ComputePass, Frame, Gpu, GpuError};
use crate::render::bvh::RayScene;
use crate::render::needs::FrameNeeds;
use crate::render::shaders;
use crate::render::upload::SceneResources;

/// See `shaders/ao_rays.comp`.
pub struct RaysPass {
    settings: AoSettings,
    pass: ComputePass,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    radius_m: f32,
    first: u32,
    count: u32,
}

impl RaysPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, needs: &FrameNeeds, settings: AoSettings, rays: &RayScene) -> Result<RaysPass, GpuError> {
        let words = rays.variant(&shaders::AO_RAYS_COMP, &shaders::AO_RAYS_RAY_QUERY_COMP).words();
        Ok(RaysPass { settings, pass: ComputePass::new(gpu, "ao_rays", &words, &[u32::from(needs.mask)])? })
    }

    /// The number of rays for each pixel, over all dispatches.
    pub fn count(&self) -> u32 {
        self.settings.rays
    }

    /// Adds rays `first .. first + count` of every pixel.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        (resources, rays): (&SceneResources, &RayScene),
        bindings: AoBindings<'_>,
        (first, count): (u32, u32),
    ) -> Result<(), GpuError> {
        let Some(sum) = &bindings.images.sum else { return Ok(()) };
        let context = bindings.context;
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .with(|chain| rays.bind(chain, resources, context))
            .sampled(&bindings.gbuffer.surface, &context.nearest)
            .sampled(&bindings.gbuffer.depth, &context.nearest)
            .read_write(sum)
            .write(&bindings.images.visibility)
            .constants(&Constants { radius_m: self.settings.radius_m, first, count })
            .dispatch_stereo(bindings.images.visibility.extent())
    }
}
