//! The specular lobe's albedo F0·A + B, integrated on the device from the BRDF that every pass uses.

use std::rc::Rc;

use ash::vk;
use bytemuck::{Pod, Zeroable};

use crate::gpu::{ComputePass, Frame, Gpu, GpuError, Image, ImageDesc};

use super::shaders;

/// Texels a side; A and B are smooth, bilinear reading errs by less than 1e-3.
const SIZE: u32 = 64;
/// Owen-scrambled samples a texel: errors below 1e-3.
const SAMPLES: u32 = 1024;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    delta_roughness: f32,
    samples: u32,
}

/// A in red, B in green; x = n·v, y = perceptual roughness, both 0–1 from centre to centre.
///
/// # Errors
/// What the device said.
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
