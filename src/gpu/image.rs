//! Images: with two layers for data of both eyes, with one layer and mips for textures, and images lent by a compositor.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::access::{AccessState, Use};
use super::{Called, Gpu, GpuError};

/// Size, format and usage of an image.
#[derive(Debug, Clone, Copy)]
pub struct ImageDesc {
    pub width: u32,
    pub height: u32,
    /// 2: one for each eye, the left one first.
    pub layers: u32,
    pub mips: u32,
    pub format: vk::Format,
    pub usage: vk::ImageUsageFlags,
}

impl ImageDesc {
    /// Two layers that a compute pass writes and others read.
    pub fn stereo(width: u32, height: u32, format: vk::Format) -> ImageDesc {
        ImageDesc {
            width,
            height,
            layers: 2,
            mips: 1,
            format,
            usage: vk::ImageUsageFlags::STORAGE | vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_SRC,
        }
    }

    /// Two layers that a raster pass draws into and others read.
    pub fn stereo_target(width: u32, height: u32, format: vk::Format) -> ImageDesc {
        let attachment = match format {
            vk::Format::D32_SFLOAT => vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
            _ => vk::ImageUsageFlags::COLOR_ATTACHMENT,
        };
        let usage = attachment | vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_SRC;
        ImageDesc { usage, ..ImageDesc::stereo(width, height, format) }
    }

    /// One layer with mips, filled by copies and sampled.
    pub fn texture(width: u32, height: u32, mips: u32, format: vk::Format) -> ImageDesc {
        let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
        ImageDesc { width, height, layers: 1, mips, format, usage }
    }
}

/// An image with the views that passes need.
pub struct Image {
    pub(super) raw: vk::Image,
    /// All layers and mips.
    pub(super) view: vk::ImageView,
    /// All layers of one mip, for storage.
    pub(super) mip_views: Vec<vk::ImageView>,
    /// One layer of mip 0, for attachments.
    pub(super) layer_views: Vec<vk::ImageView>,
    pub(super) state: Cell<AccessState>,
    pub(super) aspect: vk::ImageAspectFlags,
    desc: ImageDesc,
    allocation: RefCell<Option<Allocation>>,
    /// `raw` belongs to somebody else, who destroys it.
    lent: bool,
    pub(super) gpu: Rc<Gpu>,
}

impl Image {
    /// A new image with undefined content.
    ///
    /// # Errors
    /// [`GpuError::Memory`] when the device has none left.
    pub fn new(gpu: &Rc<Gpu>, what: &str, desc: ImageDesc) -> Result<Image, GpuError> {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(desc.format)
            .extent(vk::Extent3D { width: desc.width, height: desc.height, depth: 1 })
            .mip_levels(desc.mips)
            .array_layers(desc.layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(desc.usage)
            .initial_layout(vk::ImageLayout::UNDEFINED);
        // SAFETY: the device is alive; `info` lives for the call.
        let raw = unsafe { gpu.device.create_image(&info, None) }.called("vkCreateImage")?;
        let aspect = match desc.format {
            vk::Format::D32_SFLOAT => vk::ImageAspectFlags::DEPTH,
            _ => vk::ImageAspectFlags::COLOR,
        };
        let mut image = Image {
            raw,
            view: vk::ImageView::null(),
            mip_views: Vec::new(),
            layer_views: Vec::new(),
            state: Cell::new(AccessState::NEW),
            aspect,
            desc,
            allocation: RefCell::new(None),
            lent: false,
            gpu: Rc::clone(gpu),
        };
        // SAFETY: `raw` was just made by this device.
        let requirements = unsafe { gpu.device.get_image_memory_requirements(raw) };
        let allocation = gpu.allocate(what, requirements, MemoryLocation::GpuOnly, false)?;
        // SAFETY: memory and offset come from the allocator for exactly these requirements, bound once.
        unsafe { gpu.device.bind_image_memory(raw, allocation.memory(), allocation.offset()) }
            .called("vkBindImageMemory")?;
        *image.allocation.borrow_mut() = Some(allocation);

        image.view = image.make_view(0..desc.mips, 0..desc.layers)?;
        if desc.usage.contains(vk::ImageUsageFlags::STORAGE) {
            for mip in 0..desc.mips {
                let view = image.make_view(mip..mip + 1, 0..desc.layers)?;
                image.mip_views.push(view);
            }
        }
        let attachment = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        if desc.usage.intersects(attachment) {
            for layer in 0..desc.layers {
                let view = image.make_view(0..1, layer..layer + 1)?;
                image.layer_views.push(view);
            }
        }
        Ok(image)
    }

    /// A colour image of somebody else, such as a compositor, into which frames only copy. Call [`Image::receive_lent`] before each
    /// use and [`super::Frame::return_lent`] after it.
    ///
    /// # Safety
    /// `raw` is an image of this device that matches `desc` and outlives the result.
    pub unsafe fn lent(gpu: &Rc<Gpu>, raw: vk::Image, desc: ImageDesc) -> Image {
        Image {
            raw,
            view: vk::ImageView::null(),
            mip_views: Vec::new(),
            layer_views: Vec::new(),
            state: Cell::new(AccessState::HANDED_OVER),
            aspect: vk::ImageAspectFlags::COLOR,
            desc,
            allocation: RefCell::new(None),
            lent: true,
            gpu: Rc::clone(gpu),
        }
    }

    /// Notes that the owner of a lent image has handed it over, in the layout of a colour attachment.
    pub fn receive_lent(&self) {
        self.state.set(AccessState::HANDED_OVER);
    }

    /// Declares the next use and returns the barrier that it needs, if any.
    pub(super) fn next_use(&self, next: Use) -> Option<vk::ImageMemoryBarrier2<'static>> {
        let (barrier, state) = self.state.get().then(next, true);
        self.state.set(state);
        let barrier = barrier?;
        let range = vk::ImageSubresourceRange {
            aspect_mask: self.aspect,
            base_mip_level: 0,
            level_count: vk::REMAINING_MIP_LEVELS,
            base_array_layer: 0,
            layer_count: vk::REMAINING_ARRAY_LAYERS,
        };
        Some(
            vk::ImageMemoryBarrier2::default()
                .src_stage_mask(barrier.src_stage)
                .src_access_mask(barrier.src_access)
                .dst_stage_mask(barrier.dst_stage)
                .dst_access_mask(barrier.dst_access)
                .old_layout(barrier.old_layout)
                .new_layout(barrier.new_layout)
                .image(self.raw)
                .subresource_range(range),
        )
    }

    fn make_view(&self, mips: std::ops::Range<u32>, layers: std::ops::Range<u32>) -> Result<vk::ImageView, GpuError> {
        let kind = match self.desc.layers {
            1 => vk::ImageViewType::TYPE_2D,
            _ => vk::ImageViewType::TYPE_2D_ARRAY,
        };
        let range = vk::ImageSubresourceRange {
            aspect_mask: self.aspect,
            base_mip_level: mips.start,
            level_count: mips.end - mips.start,
            base_array_layer: layers.start,
            layer_count: layers.end - layers.start,
        };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(kind)
            .format(self.desc.format)
            .subresource_range(range);
        // SAFETY: the image is alive and bound; the range lies within it.
        unsafe { self.gpu.device.create_image_view(&info, None) }.called("vkCreateImageView")
    }

    /// Width and height of mip 0.
    pub fn extent(&self) -> (u32, u32) {
        (self.desc.width, self.desc.height)
    }

    /// The description with which the image was made.
    pub fn desc(&self) -> &ImageDesc {
        &self.desc
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: frames wait before they return, so nothing on the device uses image or views any more;
        // destroying a null view is allowed.
        unsafe {
            for &view in self.mip_views.iter().chain(&self.layer_views) {
                self.gpu.device.destroy_image_view(view, None);
            }
            self.gpu.device.destroy_image_view(self.view, None);
            if !self.lent {
                self.gpu.device.destroy_image(self.raw, None);
            }
        }
        if let Some(allocation) = self.allocation.borrow_mut().take() {
            self.gpu.free(allocation);
        }
    }
}
