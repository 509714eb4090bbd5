//! The outgoing light of the punctual lights at each pixel, with shadows traced by rays through the scene's geometry. The
//! lighting pass adds it.

use std::rc::Rc;

use bytemuck::{Pod, Zeroable};

use crate::gpu::{ComputePass, Frame, Gpu, GpuError, Image};

use super::bvh::RayScene;
use super::context::Context;
use super::needs::{FrameNeeds, RIM_RAYS};
use super::shaders;
use super::targets::Targets;
use super::upload::SceneResources;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    rim_rays: u32,
    soft_rays: u32,
}

/// See `shaders/shadows.comp`.
pub struct ShadowsPass {
    pass: ComputePass,
    soft_rays: u32,
}

impl ShadowsPass {
    /// `soft_rays`: rays to a light that has a size, for each pixel in its penumbra.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, needs: &FrameNeeds, rays: &RayScene, soft_rays: u32) -> Result<ShadowsPass, GpuError> {
        let words = rays.variant(&shaders::SHADOWS_COMP, &shaders::SHADOWS_RAY_QUERY_COMP).words();
        let pass = ComputePass::new(gpu, "shadows", &words, &[u32::from(needs.mask), u32::from(needs.glass)])?;
        Ok(ShadowsPass { pass, soft_rays })
    }

    /// Writes `direct` of [`Targets`]. `finer`: the number of samples along each side of a pixel (antialiasing), among which the
    /// pixel's rays are divided.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        resources: &SceneResources,
        rays: &RayScene,
        context: &Context,
        (targets, direct): (&Targets, &Image),
        finer: u32,
    ) -> Result<(), GpuError> {
        let (rim_rays, soft_rays) = rays_a_light(self.soft_rays, finer);
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .read_buffer(&context.lights)
            .with(|chain| rays.bind(chain, resources, context))
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.gbuffer.depth, &context.nearest)
            .write(direct)
            .constants(&Constants { rim_rays, soft_rays })
            .dispatch_stereo(direct.extent())
    }
}

/// The numbers of rays of one sample to a light that has a size: to its rim, and in its penumbra. A pixel's rays are divided
/// among its `finer` × `finer` samples.
pub fn rays_a_light(soft_rays: u32, finer: u32) -> (u32, u32) {
    (RIM_RAYS.div_ceil(finer).max(2), soft_rays.div_ceil(finer * finer))
}
