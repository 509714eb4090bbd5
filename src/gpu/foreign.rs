//! Libraries that record their own commands: handles for them to make things with, and one layer to draw into.

use std::rc::Rc;
use std::sync::{Arc, Mutex};

use ash::vk;
use gpu_allocator::vulkan::Allocator;

use super::access::Use;
use super::{Called, Frame, Gpu, GpuError, Image};

impl Gpu {
    /// The device. Whatever is made from it must go before the [`Gpu`].
    pub fn device(&self) -> &ash::Device {
        &self.device
    }

    /// The instance the device came from.
    pub fn instance(&self) -> &ash::Instance {
        &self.instance
    }

    /// The loader the instance came from.
    pub fn entry(&self) -> &ash::Entry {
        &self.entry
    }

    /// The physical device.
    pub fn physical(&self) -> vk::PhysicalDevice {
        self.physical
    }

    /// The one queue, for graphics, compute and presentation; its family, and its index within.
    pub fn queue(&self) -> (vk::Queue, u32, u32) {
        (self.queue, self.queue_family, 0)
    }

    /// The allocator that all of this device's memory comes from.
    pub fn allocator(&self) -> Arc<Mutex<Allocator>> {
        Arc::clone(&self.allocator)
    }
}

/// Commands being recorded by a library, inside dynamic rendering.
pub struct Canvas {
    pub commands: vk::CommandBuffer,
    pub extent: vk::Extent2D,
}

impl Frame {
    /// Clears one layer and lets `draw` record into it; pipeline, viewport and scissor are the library's business.
    ///
    /// # Errors
    /// What `draw` or Vulkan said.
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

/// Command buffers for uploads that a library submits and waits for itself.
pub struct UploadPool {
    raw: vk::CommandPool,
    gpu: Rc<Gpu>,
}

impl UploadPool {
    /// # Errors
    /// What Vulkan said.
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
        // SAFETY: who uploads with it waits for the upload.
        unsafe { self.gpu.device.destroy_command_pool(self.raw, None) };
    }
}
