//! Shading reuse: pixels of the right eye take the light of the punctual lights from the left eye where both see the same place.

pub mod images;

use std::rc::Rc;

use bytemuck::{Pod, Zeroable};

use crate::gpu::{Buffer, ComputePass, Dispatch, Frame, Gpu, GpuError, Image};
use crate::scene::Scene;

use super::bvh::RayScene;
use super::context::Context;
use super::needs::FrameNeeds;
use super::shaders;
use super::shadows::rays_a_light;
use super::targets::{GBuffer, Targets};
use super::upload::SceneResources;
pub use images::ShadingReuseImages;

/// Lights the left eye's pixels, copies their light to the right eye where it may be shared, and lights the right eye's other
/// pixels. See `shaders/shading_reuse.comp`.
pub struct ShadingReusePass {
    /// `shaders/shadows.comp` with shadows, `shaders/lights.comp` without.
    lights: ComputePass,
    shadows: bool,
    reuse: ComputePass,
    soft_rays: u32,
    /// One word for each instance: 1 if its material lets the eyes share its shading.
    sharing: Buffer,
}

/// Which pixels a dispatch lights.
#[derive(Clone, Copy, PartialEq)]
enum Pixels {
    OfLeftEye,
    /// The right eye's pixels that [`ShadingReuseImages::list`] lists.
    Listed,
}

impl Pixels {
    /// Dispatches as many groups as the pixels need.
    fn dispatch<'f>(self, chain: Dispatch<'f>, images: &'f ShadingReuseImages, lit: &Image) -> Result<(), GpuError> {
        let (width, height) = lit.extent();
        match self {
            Pixels::OfLeftEye => chain.dispatch(width.div_ceil(8), height.div_ceil(8), 1),
            Pixels::Listed => chain.dispatch_indirect(&images.list.arguments, 0),
        }
    }
}

/// What the dispatches of a frame read and write.
#[derive(Clone, Copy)]
struct ShadingBindings<'a> {
    resources: &'a SceneResources,
    rays: Option<&'a RayScene>,
    context: &'a Context,
    targets: &'a Targets,
    images: &'a ShadingReuseImages,
    direct: &'a Image,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ShadowConstants {
    rim_rays: u32,
    soft_rays: u32,
    listed: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct LightConstants {
    listed: u32,
}

impl ShadingReusePass {
    /// `rays` is needed if lights cast shadows. `soft_rays`: see [`super::shadows::ShadowsPass::new`].
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(
        gpu: &Rc<Gpu>,
        scene: &Scene,
        needs: &FrameNeeds,
        rays: Option<&RayScene>,
        soft_rays: u32,
    ) -> Result<ShadingReusePass, GpuError> {
        let lights = match rays.filter(|_| needs.shadows) {
            Some(rays) => {
                let shader = rays.variant(&shaders::SHADOWS_REUSE_COMP, &shaders::SHADOWS_REUSE_RAY_QUERY_COMP);
                let parts = [needs.mask, needs.glass].map(u32::from);
                ComputePass::new(gpu, "shadows", &shader.words(), &parts)?
            }
            None => ComputePass::new(gpu, "lights", &shaders::LIGHTS_COMP.words(), &[])?,
        };
        let sharing: Vec<u32> = scene
            .instances
            .iter()
            .map(|instance| &scene.materials[scene.primitives[instance.primitive].material])
            .map(|material| u32::from(material.shading_reuse))
            .collect();
        let words = shaders::SHADING_REUSE_COMP.words();
        Ok(ShadingReusePass {
            lights,
            shadows: needs.shadows && rays.is_some(),
            reuse: ComputePass::new(gpu, "shading_reuse", &words, &[u32::from(needs.shadows)])?,
            soft_rays,
            sharing: Buffer::with_content(gpu, "instances that share shading", &sharing)?,
        })
    }

    /// Writes `direct` of [`Targets`]. `finer`: see [`super::shadows::ShadowsPass::record`].
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        (resources, rays): (&SceneResources, Option<&RayScene>),
        context: &Context,
        targets: &Targets,
        finer: u32,
    ) -> Result<(), GpuError> {
        let (Some(images), Some(direct)) = (&targets.shading_reuse, &targets.direct) else { return Ok(()) };
        let bindings = ShadingBindings { resources, rays, context, targets, images, direct };
        self.light(frame, bindings, Pixels::OfLeftEye, finer)?;
        images.list.clear(frame);
        let (width, height) = direct.extent();
        frame
            .compute(&self.reuse)
            .uniform(&context.frame)
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.gbuffer.depth, &context.nearest)
            .sampled(&targets.gbuffer.instance, &context.nearest)
            .sampled(&images.diffuse, &context.nearest)
            .read_buffer(&self.sharing)
            .read_write(direct)
            .write_buffer(&images.list.rays)
            .write_buffer(&images.list.arguments)
            .read_write(&images.known)
            .dispatch(width.div_ceil(8), height.div_ceil(8), 1)?;
        self.light(frame, bindings, Pixels::Listed, finer)
    }

    fn light(
        &self,
        frame: &mut Frame,
        bindings: ShadingBindings<'_>,
        pixels: Pixels,
        finer: u32,
    ) -> Result<(), GpuError> {
        let ShadingBindings { resources, rays, context, targets, images, direct } = bindings;
        let listed = u32::from(pixels == Pixels::Listed);
        let GBuffer { surface, depth, .. } = &targets.gbuffer;
        let chain = frame.compute(&self.lights).uniform(&context.frame).read_buffer(&context.lights);
        let chain = match rays.filter(|_| self.shadows) {
            Some(rays) => {
                let (rim_rays, soft_rays) = rays_a_light(self.soft_rays, finer);
                let chain = chain.with(|chain| rays.bind(chain, resources, context));
                chain.constants(&ShadowConstants { rim_rays, soft_rays, listed })
            }
            None => chain.constants(&LightConstants { listed }),
        };
        let chain = chain
            .sampled(surface, &context.nearest)
            .sampled(depth, &context.nearest)
            .read_write(direct)
            .read_write(&images.diffuse)
            .read_buffer(&images.list.rays)
            .read_buffer(&images.list.arguments);
        let chain = if self.shadows { chain.read_write(&images.known) } else { chain };
        pixels.dispatch(chain, images, direct)
    }
}
