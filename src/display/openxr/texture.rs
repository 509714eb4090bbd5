//! Textures in OpenXR swapchains, which the compositor reads.

use std::rc::Rc;

use ash::vk::{self, Handle as _};
use openxr as xr;

use super::mips;
use super::runtime::{CallContext, failure};
use crate::display::DisplayError;
use crate::gpu::{Buffer, Frame, Gpu, GpuError, Image, ImageDesc};

/// The format of every swapchain; its bytes are display values.
pub(super) const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;

/// A picture that the compositor shows. A texture with two layers has one for each eye.
pub(super) struct Texture {
    // The swapchain owns the images, and they end with it.
    images: Vec<Image>,
    swapchain: xr::Swapchain<xr::Vulkan>,
    width: u32,
    height: u32,
    layers: u32,
}

/// Size of a texture, and whether it changes.
#[derive(Debug, Clone, Copy)]
pub(super) struct TextureDesc {
    pub width: u32,
    pub height: u32,
    pub layers: u32,
    /// Whether it is written only once; it then has smaller levels.
    pub is_still: bool,
}

pub(super) fn from_gpu(error: GpuError) -> DisplayError {
    failure(error.to_string())
}

impl Texture {
    /// Makes a texture with undefined content.
    pub fn new(session: &xr::Session<xr::Vulkan>, gpu: &Rc<Gpu>, shape: TextureDesc) -> Result<Texture, DisplayError> {
        let TextureDesc { width, height, layers, is_still } = shape;
        let mip_count = if is_still { mips::count(width, height) } else { 1 };
        let flags = xr::SwapchainUsageFlags::COLOR_ATTACHMENT
            | xr::SwapchainUsageFlags::SAMPLED
            | xr::SwapchainUsageFlags::TRANSFER_DST;
        let info = xr::SwapchainCreateInfo {
            create_flags: match is_still {
                true => xr::SwapchainCreateFlags::STATIC_IMAGE,
                false => xr::SwapchainCreateFlags::EMPTY,
            },
            usage_flags: flags,
            format: FORMAT.as_raw() as u32,
            sample_count: 1,
            width,
            height,
            face_count: 1,
            array_size: layers,
            mip_count,
        };
        let swapchain = session.create_swapchain(&info).in_call("xrCreateSwapchain")?;
        let usage = vk::ImageUsageFlags::TRANSFER_DST;
        let desc = ImageDesc { width, height, layers, mips: mip_count, format: FORMAT, usage };
        let raw = swapchain.enumerate_images().in_call("xrEnumerateSwapchainImages")?;
        // SAFETY: the runtime made these images on our device as the create info says; the swapchain, which owns them,
        // is dropped after them (declaration order).
        let lend = |image: u64| unsafe { Image::lent(gpu, vk::Image::from_raw(image), desc) };
        Ok(Texture { images: raw.into_iter().map(lend).collect(), swapchain, width, height, layers })
    }

    /// Makes a still picture: `layers[l]` are the RGBA bytes of layer l. It is written once, with its smaller levels.
    pub fn still(
        session: &xr::Session<xr::Vulkan>,
        gpu: &Rc<Gpu>,
        (width, height): (u32, u32),
        layers: Vec<Vec<u8>>,
    ) -> Result<Texture, DisplayError> {
        let shape = TextureDesc { width, height, layers: layers.len() as u32, is_still: true };
        let mut texture = Texture::new(session, gpu, shape)?;
        let chains: Vec<_> = layers.into_iter().map(|texels| mips::chain(width, height, texels)).collect();
        let bytes = chains.concat().concat();
        let staging = Buffer::upload(gpu, "stimulus", bytes.len() as u64).map_err(from_gpu)?;
        staging.write(&bytes);
        texture.write(gpu, |frame, image| {
            let mut offset = 0;
            for (layer, levels) in (0..).zip(&chains) {
                frame.copy_to_layer(&staging, offset, image, layer, levels);
                offset += levels.iter().map(|l| l.len() as u64).sum::<u64>();
            }
        })?;
        Ok(texture)
    }

    /// Records commands that write the next image, submits them, waits, and gives the image to the compositor.
    pub fn write(&mut self, gpu: &Rc<Gpu>, record: impl FnOnce(&mut Frame, &Image)) -> Result<(), DisplayError> {
        let index = self.swapchain.acquire_image().in_call("xrAcquireSwapchainImage")?;
        self.swapchain.wait_image(xr::Duration::INFINITE).in_call("xrWaitSwapchainImage")?;
        let image = &self.images[index as usize];
        image.receive_lent();
        let mut frame = Frame::begin(gpu).map_err(from_gpu)?;
        record(&mut frame, image);
        frame.return_lent(image);
        frame.finish().map_err(from_gpu)?;
        self.swapchain.release_image().in_call("xrReleaseSwapchainImage")
    }

    /// Width and height, pixels.
    pub fn extent(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The number of layers.
    pub fn layers(&self) -> u32 {
        self.layers
    }

    /// The part of the swapchain that is the whole of one layer.
    pub fn layer(&self, layer: u32) -> xr::SwapchainSubImage<'_, xr::Vulkan> {
        let extent = xr::Extent2Di { width: self.width as i32, height: self.height as i32 };
        xr::SwapchainSubImage::new()
            .swapchain(&self.swapchain)
            .image_array_index(layer)
            .image_rect(xr::Rect2Di { offset: xr::Offset2Di { x: 0, y: 0 }, extent })
    }
}
