//! The table of the specular lobe's albedo F0·A + B, integrated on the device from the BRDF that every pass uses. The renderer
//! makes it once for each roughness limit of mirrors.

use std::rc::Rc;

use ash::vk;
use bytemuck::{Pod, Zeroable};

use crate::gpu::{ComputePass, Frame, Gpu, GpuError, Image, ImageDesc};

use super::shaders;

/// Width and height, texels. A and B are so smooth that bilinear interpolation errs by less than 1e-3.
const SIZE: u32 = 64;
/// Owen-scrambled samples for each texel, which keep errors below 1e-3.
const SAMPLES: u32 = 1024;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    delta_roughness: f32,
    samples: u32,
}

/// The table: A in red, B in green. x is n·v and y is perceptual roughness, both from 0 at the first texel's centre to 1 at the
/// last one's.
///
/// # Errors
/// When a Vulkan call fails.
pub fn brdf_table(gpu: &Rc<Gpu>, delta_roughness: f32) -> Result<Image, GpuError> {
    let desc = ImageDesc { layers: 1, ..ImageDesc::stereo(SIZE, SIZE, vk::Format::R16G16B16A16_SFLOAT) };
    let table = Image::new(gpu, "BRDF table", desc)?;
    let pass = ComputePass::new(gpu, "brdf_table", &shaders::BRDF_TABLE_COMP.words(), &[])?;
    let mut frame = Frame::begin(gpu)?;
    let constants = Constants { delta_roughness, samples: SAMPLES };
    frame.compute(&pass).write(&table).constants(&constants).dispatch(SIZE / 8, SIZE / 8, 1)?;
    frame.finish()?;
    Ok(table)
}
