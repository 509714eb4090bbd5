//! The fallback `probe`: the radiance that arrives at the scene's first view from all around. The renderer traces and prefilters
//! it once for a scene.

use std::rc::Rc;

use ash::vk;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError, Image, ImageDesc, read_image};
use crate::scene::{Environment, Equirect, Scene};

use super::bvh::RayScene;
use super::context::Context;
use super::needs::FrameNeeds;
use super::shaders;
use super::upload::{EnvironmentMaps, SceneResources};

/// Width of the probe, texels; its height is half of it.
const WIDTH: u32 = 128;
/// Rays for each texel.
const SAMPLES: u32 = 16;

/// Traces and prefilters the probe. Whichever view is rendered, the probe is at the head of the scene's first view, so that all
/// pictures of a scene fall back to the same light.
///
/// # Errors
/// When a Vulkan call fails.
pub fn probe(
    gpu: &Rc<Gpu>,
    scene: &Scene,
    resources: &SceneResources,
    rays: &RayScene,
    context: &Context,
    needs: &FrameNeeds,
) -> Result<EnvironmentMaps, GpuError> {
    let place = scene.views.first().map_or(context.head, |v| v.position) - context.head;
    let place = place.as_vec3().extend(SAMPLES as f32).to_array();
    let desc = ImageDesc { layers: 1, ..ImageDesc::stereo(WIDTH, WIDTH / 2, vk::Format::R32G32B32A32_SFLOAT) };
    let image = Image::new(gpu, "probe", desc)?;
    let words = rays.variant(&shaders::PROBE_COMP, &shaders::PROBE_RAY_QUERY_COMP).words();
    let pass = ComputePass::new(gpu, "probe", &words, &needs.of_hits())?;
    let mut frame = Frame::begin(gpu)?;
    frame
        .compute(&pass)
        .uniform(&context.frame)
        .read_buffer(&context.lights)
        .with(|chain| rays.bind(chain, resources, context))
        .with(|chain| context.bind_environment(chain, &resources.environment))
        .with(|chain| context.baked.bind(chain, &context.nearest))
        .write(&image)
        .constants(&place)
        .dispatch(WIDTH / 8, WIDTH / 16, 1)?;
    frame.finish()?;
    let float = |t: &[u8], i: usize| f32::from_le_bytes([t[i], t[i + 1], t[i + 2], t[i + 3]]);
    let texels = read_image(gpu, &image)?.chunks_exact(16).map(|t| [float(t, 0), float(t, 4), float(t, 8)]).collect();
    EnvironmentMaps::new(gpu, &Environment::from_radiance(Equirect { width: WIDTH, height: WIDTH / 2, texels }))
}
