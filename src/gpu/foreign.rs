//! Access for libraries that use Vulkan themselves, such as an OpenXR runtime or egui's renderer: the raw handles, a layer of an
//! image to draw into, and a command pool for their uploads.

use std::rc::Rc;
use std::sync::{Arc, Mutex};

use ash::vk;
use gpu_allocator::vulkan::Allocator;

use super::access::Use;
use super::{Called, Frame, Gpu, GpuError, Image};

impl Gpu {
    /// The device. Whatever is made from it must be destroyed before the [`Gpu`].
    pub fn device(&self) -> &ash::Device {
        &self.device
    }

    /// The instance to which the device belongs.
    pub fn instance(&self) -> &ash::Instance {
        &self.instance
    }

    /// The loader with which the instance was made.
    pub fn entry(&self) -> &ash::Entry {
        &self.entry
    }

    /// The physical device.
    pub fn physical(&self) -> vk::PhysicalDevice {
        self.physical
    }

    /// The only queue, for graphics, compute and presentation; its family; its index within the family.
    pub fn queue(&self) -> (vk::Queue, u32, u32) {
        (self.queue, self.queue_family, 0)
    }

    /// The allocator of all of this device's memory.
    pub fn allocator(&self) -> Arc<Mutex<Allocator>> {
        Arc::clone(&self.allocator)
    }
}

/// A command buffer inside dynamic rendering, for a library to record into.
pub struct Canvas {
    pub commands: vk::CommandBuffer,
    pub extent: vk::Extent2D,
}

impl Frame {
    /// Clears one layer and lets `draw` record commands that draw into it. The library binds its own pipeline and sets viewport
    /// and scissor.
    ///
    /// # Errors
    /// The error of `draw` or of a Vulkan call.
    pub fn draw_foreign<E: From<GpuError>>(
        &mut self,
        name: &str,
        target: &Image,
        layer: usize,
        clear: [f32; 4],
        draw: impl FnOnce(&Canvas) -> Result<(), E>,
    ) -> Result<(), E> {
        self.use_image(target, Use::COLOR);
        let (width, height) = target.extent();
        let extent = vk::Extent2D { width, height };
        let attachments = [vk::RenderingAttachmentInfo::default()
            .image_view(target.layer_views[layer])
            .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(vk::ClearValue { color: vk::ClearColorValue { float32: clear } })];
        let info = vk::RenderingInfo::default()
            .render_area(vk::Rect2D { offset: vk::Offset2D::default(), extent })
            .layer_count(1)
            .color_attachments(&attachments);
        self.start_pass(name)?;
        let gpu = Rc::clone(&self.gpu);
        // SAFETY: recording has begun, the attachment is in the declared layout (barrier above) and outlives the frame.
        unsafe { gpu.device.cmd_begin_rendering(self.commands, &info) };
        let drawn = draw(&Canvas { commands: self.commands, extent });
        // SAFETY: rendering was begun above.
        unsafe { gpu.device.cmd_end_rendering(self.commands) };
        self.end_pass()?;
        drawn
    }
}

/// A command pool for uploads that a library records, submits and waits for itself.
pub struct UploadPool {
    raw: vk::CommandPool,
    gpu: Rc<Gpu>,
}

impl UploadPool {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>) -> Result<UploadPool, GpuError> {
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(gpu.queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the device is alive; `info` lives for the call.
        let raw = unsafe { gpu.device.create_command_pool(&info, None) }.called("vkCreateCommandPool")?;
        Ok(UploadPool { raw, gpu: Rc::clone(gpu) })
    }

    /// The pool.
    pub fn raw(&self) -> vk::CommandPool {
        self.raw
    }
}

impl Drop for UploadPool {
    fn drop(&mut self) {
        // SAFETY: the library waits for each of its uploads, so no command buffer of the pool is in use.
        unsafe { self.gpu.device.destroy_command_pool(self.raw, None) };
    }
}
