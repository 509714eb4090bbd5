//! What the punctual lights put on each pixel, in the shadows of all matter.

use std::rc::Rc;

use bytemuck::{Pod, Zeroable};

use crate::gpu::{ComputePass, Frame, Gpu, GpuError, Image};

use super::bvh::RayScene;
use super::context::Context;
use super::needs::{Needs, RIM_RAYS};
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
    /// `soft_rays`: rays to a light that has a size, a pixel.
    ///
    /// # Errors
    /// What the device said.
    pub fn new(gpu: &Rc<Gpu>, needs: &Needs, rays: &RayScene, soft_rays: u32) -> Result<ShadowsPass, GpuError> {
        let words = rays.variant(&shaders::SHADOWS_COMP, &shaders::SHADOWS_RAY_QUERY_COMP).words();
        let pass = ComputePass::new(gpu, "shadows", &words, &[u32::from(needs.mask), u32::from(needs.glass)])?;
        Ok(ShadowsPass { pass, soft_rays })
    }

    /// Writes `direct` of [`Targets`]. `finer` samples along a side of a pixel share the pixel's rays among them.
    ///
    /// # Errors
    /// What the device said.
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

/// Rays of a pixel to a light that has a size, of the first question and in a penumbra, where `soft_rays` of a pixel are
/// shared by `finer` samples along each of its sides.
pub fn rays_a_light(soft_rays: u32, finer: u32) -> (u32, u32) {
    (RIM_RAYS.div_ceil(finer).max(2), soft_rays.div_ceil(finer * finer))
}
