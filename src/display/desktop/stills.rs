//! Uploads the stimuli to the device, once, before the first trial.

use std::path::Path;
use std::rc::Rc;

use ash::vk;

use crate::display::{DisplayError, StimulusFiles, memory};
use crate::gpu::{Gpu, Image, ImageDesc};
use crate::picture;

/// Both eyes' display values, layer 0 left and 1 right, by stimulus: one image for a still, one for each frame of a
/// moving stimulus.
pub fn load(gpu: &Rc<Gpu>, stimuli: &[StimulusFiles], display: &'static str) -> Result<Vec<Vec<Image>>, DisplayError> {
    memory::check(gpu, stimuli, memory::MipLevels::One).map_err(|what| DisplayError { display, what })?;
    let frames = |files: &StimulusFiles| files.frames.iter().map(|path| frame(gpu, path, display)).collect();
    stimuli.iter().map(frames).collect()
}

fn frame(gpu: &Rc<Gpu>, path: &Path, display: &'static str) -> Result<Image, DisplayError> {
    let failed = |what: String| DisplayError { display, what };
    let name = path.display();
    let sbs = picture::read_png(path).map_err(|e| failed(e.to_string()))?;
    let (width, height) = (sbs.width() / 2, sbs.height());
    if width == 0 || height == 0 {
        return Err(failed(format!("{name}: has no left and right half")));
    }
    let eye = |i: u32| image::imageops::crop_imm(&sbs, i * width, 0, width, height).to_image().into_raw();
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let desc = ImageDesc { usage, ..ImageDesc::stereo(width, height, vk::Format::R8G8B8A8_SRGB) };
    Image::with_layers(gpu, "still", desc, &[&eye(0), &eye(1)]).map_err(|e| failed(e.to_string()))
}
