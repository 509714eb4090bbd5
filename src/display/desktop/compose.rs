//! Composes the window's picture from the two eyes' views, by `shaders/display/desk.comp`, once for each change.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use ash::vk;
use bytemuck::{Pod, Zeroable};

use super::options::Mode;
use crate::display::shaders::DESK_COMP;
use crate::gpu::{ComputePass, Filter, Frame, Gpu, GpuError, Image, ImageDesc, Sampler};

/// Push constants of `desk.comp`.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct ComposeConstants {
    picture: [i32; 4],
    patch: [i32; 4],
    window: [i32; 2],
    eye: i32,
    apart: i32,
    ground: f32,
    patch_value: f32,
}

const _: () = assert!(size_of::<ComposeConstants>() == 56, "as the shader has it, and at most 128 bytes");

/// The picture in an eye's view.
#[derive(Clone, Copy)]
pub enum Picture<'a> {
    None,
    /// Two layers, one for each eye. `is_encoded`: the texels are display values, although the format does not say so.
    Stereo {
        image: &'a Image,
        is_encoded: bool,
    },
    /// Both eyes see layer `eye` of the reference, and beside it that of the mirrored test image.
    Pair {
        reference: &'a Image,
        test: &'a Image,
        eye: usize,
    },
}

/// Everything that one picture of the window is composed of.
pub struct Composition<'a> {
    pub mode: Mode,
    pub picture: Picture<'a>,
    /// Place of the picture: x, y, width, height within an eye's view, pixels; see [`fit`].
    pub place: [u32; 4],
    /// The words: two layers of the view's size, premultiplied, sRGB.
    pub words: &'a Image,
    pub apart_px: i32,
    /// Grey of the background, linear.
    pub ground: f32,
    /// Display value of the square for a photodiode; none: there is no square.
    pub patch: Option<f32>,
}

/// Composes pictures into an image of the window's size.
pub struct Composer {
    /// One pass for each mode, kind, sampling and encoding, because a software device pays for every branch in a
    /// shader.
    passes: RefCell<BTreeMap<[u32; 4], Rc<ComputePass>>>,
    sampler: Sampler,
    gpu: Rc<Gpu>,
}

impl Composer {
    /// # Errors
    /// What Vulkan said.
    pub fn new(gpu: &Rc<Gpu>) -> Result<Composer, GpuError> {
        Ok(Composer { passes: RefCell::default(), sampler: Sampler::new(gpu, Filter::NEAREST)?, gpu: Rc::clone(gpu) })
    }

    /// Makes an image to compose into, which is grey at first.
    ///
    /// # Errors
    /// There is no memory for it.
    pub fn image(&self, (width, height): (u32, u32)) -> Result<Image, GpuError> {
        let format = vk::Format::R8G8B8A8_UNORM;
        let desc = ImageDesc::stereo(width, height, format);
        let desc = ImageDesc { layers: 1, usage: desc.usage | vk::ImageUsageFlags::TRANSFER_DST, ..desc };
        let image = Image::new(&self.gpu, "window", desc)?;
        let mut frame = Frame::begin(&self.gpu)?;
        frame.clear(&image, [128.0 / 255.0, 128.0 / 255.0, 128.0 / 255.0, 1.0]);
        frame.finish()?;
        Ok(image)
    }

    fn pass(&self, key: [u32; 4]) -> Result<Rc<ComputePass>, GpuError> {
        if let Some(pass) = self.passes.borrow().get(&key) {
            return Ok(Rc::clone(pass));
        }
        let made = Rc::new(ComputePass::new(&self.gpu, "desk", &DESK_COMP.words(), &key)?);
        self.passes.borrow_mut().insert(key, Rc::clone(&made));
        Ok(made)
    }

    /// # Errors
    /// What Vulkan said.
    pub fn compose(&self, parts: &Composition<'_>, into: &Image) -> Result<(), GpuError> {
        let (width, height) = into.extent();
        let (kind, still, reference, eye, is_encoded) = match parts.picture {
            Picture::None => (0, parts.words, parts.words, 0, false),
            Picture::Stereo { image, is_encoded } => (1, image, image, 0, is_encoded),
            Picture::Pair { reference, test, eye } => (2, test, reference, eye as i32, false),
        };
        let [_, _, wide, high] = parts.place;
        let shown = (if kind == 2 { wide / 2 } else { wide }, high);
        let texels = still.extent();
        let sampling = match kind {
            0 => 0,
            _ if shown == texels => 0,
            _ if shown.0 >= texels.0 && shown.1 >= texels.1 => 1,
            _ => 2,
        };
        let pass = self.pass([parts.mode as u32, kind, sampling, u32::from(is_encoded)])?;
        let side = (height / 12).max(16) as i32;
        let desk = ComposeConstants {
            picture: parts.place.map(|v| v as i32),
            patch: [0, height as i32 - side, if parts.patch.is_some() { side } else { 0 }, side],
            window: [width as i32, height as i32],
            eye,
            apart: parts.apart_px,
            ground: parts.ground,
            patch_value: parts.patch.unwrap_or(0.0),
        };
        let mut frame = Frame::begin(&self.gpu)?;
        frame
            .compute(&pass)
            .sampled(still, &self.sampler)
            .sampled(reference, &self.sampler)
            .sampled(parts.words, &self.sampler)
            .write(into)
            .constants(&desk)
            .dispatch(width.div_ceil(8), height.div_ceil(8), 1)?;
        frame.finish()?;
        Ok(())
    }
}

/// The largest place in the middle of a view for a picture of this shape, at most `most` pixels wide, with `below`
/// pixels left free for its letter.
pub fn fit((width, height): (u32, u32), shape: (u32, u32), most: u32, below: u32) -> [u32; 4] {
    let room = (f64::from(width.min(most)), f64::from(height.saturating_sub(2 * below).max(1)));
    let mut scale = (room.0 / f64::from(shape.0)).min(room.1 / f64::from(shape.1));
    // The scale becomes exactly 1 where it is nearly 1.
    if (0.97..1.03).contains(&scale) {
        let fits =
            f64::from(shape.0) <= f64::from(width) && f64::from(shape.1) <= f64::from(height - below.min(height));
        scale = if fits { 1.0 } else { scale };
    }
    let size = [shape.0, shape.1].map(|s| ((f64::from(s) * scale).round() as u32).max(1));
    [(width.saturating_sub(size[0])) / 2, (height.saturating_sub(size[1])) / 2, size[0], size[1]]
}

#[cfg(test)]
mod tests {
    use super::fit;

    #[test]
    fn a_picture_is_centred_and_no_wider_than_allowed() {
        assert_eq!(fit((1920, 1080), (1920, 1080), 5000, 0), [0, 0, 1920, 1080]);
        assert_eq!(fit((960, 1080), (1920, 1080), 5000, 0), [0, 270, 960, 540]);
        assert_eq!(fit((1920, 1080), (1920, 1080), 960, 0), [480, 270, 960, 540]);
        let [_, y, w, h] = fit((1920, 1080), (1920, 1080), 5000, 100);
        assert!(y >= 100 && h <= 880 && w * 9 / 16 <= h + 1);
    }
}
