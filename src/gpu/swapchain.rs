//! Presenting to a window: a picture is copied into the swapchain's next image, which is shown in step with the monitor (FIFO).

use std::rc::Rc;

use ash::vk;

use super::access::Use;
use super::{Called, Gpu, GpuError, Image, Surface};

/// What happened to a picture that was presented.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PresentOutcome {
    /// It was queued. The number is for [`Swapchain::wait_until_shown`].
    Queued(u64),
    /// It was not shown, because the window now has another size, or none.
    Stale,
}

/// The largest number of pictures whose copies may be unfinished at the same time.
const IN_FLIGHT: usize = 2;

struct Slot {
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    acquired: vk::Semaphore,
    done: vk::Fence,
}

/// A window's swapchain. [`Swapchain::resize`] makes its images again when the window's size changes.
pub struct Swapchain {
    functions: ash::khr::swapchain::Device,
    waiter: Option<ash::khr::present_wait::Device>,
    raw: vk::SwapchainKHR,
    images: Vec<vk::Image>,
    /// One for each image: signalled when the copy into it is finished.
    drawn: Vec<vk::Semaphore>,
    extent: vk::Extent2D,
    slots: Vec<Slot>,
    next: usize,
    /// Number of pictures presented since the last resize.
    count: u64,
    surface: Surface,
    gpu: Rc<Gpu>,
}

impl Swapchain {
    /// `waits`: see [`super::WithSurface::waits_for_presents`]. There are no images before [`Swapchain::resize`].
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(surface: Surface, waits: bool) -> Result<Swapchain, GpuError> {
        let gpu = Rc::clone(&surface.gpu);
        let functions = ash::khr::swapchain::Device::new(&gpu.instance, &gpu.device);
        let waiter = waits.then(|| ash::khr::present_wait::Device::new(&gpu.instance, &gpu.device));
        let mut chain = Swapchain {
            functions,
            waiter,
            raw: vk::SwapchainKHR::null(),
            images: Vec::new(),
            drawn: Vec::new(),
            extent: vk::Extent2D::default(),
            slots: Vec::new(),
            next: 0,
            count: 0,
            surface,
            gpu,
        };
        for _ in 0..IN_FLIGHT {
            let slot = chain.make_slot()?;
            chain.slots.push(slot);
        }
        Ok(chain)
    }

    fn make_slot(&self) -> Result<Slot, GpuError> {
        let device = &self.gpu.device;
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(self.gpu.queue_family);
        let signalled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        // SAFETY: the device is alive and every info lives for its call. A failure half-way leaks, but ends the program.
        unsafe {
            let pool = device.create_command_pool(&pool, None).called("vkCreateCommandPool")?;
            let allocate = vk::CommandBufferAllocateInfo::default()
                .command_pool(pool)
                .level(vk::CommandBufferLevel::PRIMARY)
                .command_buffer_count(1);
            let commands = device.allocate_command_buffers(&allocate).called("vkAllocateCommandBuffers")?[0];
            let acquired = device.create_semaphore(&Default::default(), None).called("vkCreateSemaphore")?;
            let done = device.create_fence(&signalled, None).called("vkCreateFence")?;
            Ok(Slot { pool, commands, acquired, done })
        }
    }

    /// Width and height of the window's images, pixels; `None` while there are none.
    pub fn extent(&self) -> Option<(u32, u32)> {
        (self.raw != vk::SwapchainKHR::null()).then_some((self.extent.width, self.extent.height))
    }

    /// Makes images for a window of this size. The surface may demand another size; see [`Swapchain::extent`].
    ///
    /// # Errors
    /// [`GpuError::Surface`] when the surface offers none of our formats, else the error of the failed Vulkan call.
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), GpuError> {
        self.rest()?;
        let (surface, physical) = (self.surface.raw, self.gpu.physical);
        // SAFETY: surface and device are alive.
        let (can, formats) = unsafe {
            let can = self.surface.functions.get_physical_device_surface_capabilities(physical, surface);
            let formats = self.surface.functions.get_physical_device_surface_formats(physical, surface);
            (
                can.called("vkGetPhysicalDeviceSurfaceCapabilitiesKHR")?,
                formats.called("vkGetPhysicalDeviceSurfaceFormatsKHR")?,
            )
        };
        // The pictures' bytes are display values already, so the format must not convert them.
        let known = [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM, vk::Format::A8B8G8R8_UNORM_PACK32];
        let format = formats
            .iter()
            .find(|f| known.contains(&f.format) && f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR)
            .ok_or_else(|| GpuError::Surface("it offers no 8-bit format".to_owned()))?;
        let old = std::mem::replace(&mut self.raw, vk::SwapchainKHR::null());
        let extent = match can.current_extent {
            vk::Extent2D { width: u32::MAX, .. } => vk::Extent2D {
                width: width.clamp(can.min_image_extent.width, can.max_image_extent.width),
                height: height.clamp(can.min_image_extent.height, can.max_image_extent.height),
            },
            extent => extent,
        };
        let most = if can.max_image_count == 0 { u32::MAX } else { can.max_image_count };
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface)
            .min_image_count(can.min_image_count.max(2).min(most))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::TRANSFER_DST)
            .pre_transform(can.current_transform)
            .composite_alpha(vk::CompositeAlphaFlagsKHR::OPAQUE)
            .present_mode(vk::PresentModeKHR::FIFO)
            .clipped(true)
            .old_swapchain(old);
        // SAFETY: the device is idle (`rest` above), so the old swapchain and its semaphores are unused.
        unsafe {
            if extent.width > 0 && extent.height > 0 {
                self.raw = self.functions.create_swapchain(&info, None).called("vkCreateSwapchainKHR")?;
            }
            self.functions.destroy_swapchain(old, None);
            for semaphore in self.drawn.drain(..) {
                self.gpu.device.destroy_semaphore(semaphore, None);
            }
            self.images.clear();
            if self.raw != vk::SwapchainKHR::null() {
                self.images = self.functions.get_swapchain_images(self.raw).called("vkGetSwapchainImagesKHR")?;
                for _ in &self.images {
                    let made = self.gpu.device.create_semaphore(&Default::default(), None);
                    self.drawn.push(made.called("vkCreateSemaphore")?);
                }
            }
        }
        (self.extent, self.count) = (extent, 0);
        Ok(())
    }

    /// Queues a copy of layer 0 of `picture` for showing. A picture that has not the size of the window's images is not shown.
    /// Blocks while `IN_FLIGHT` copies are unfinished.
    ///
    /// # Errors
    /// The error of the failed Vulkan call, for example when the window is gone.
    pub fn present(&mut self, picture: &Image) -> Result<PresentOutcome, GpuError> {
        if self.raw == vk::SwapchainKHR::null() || picture.extent() != (self.extent.width, self.extent.height) {
            return Ok(PresentOutcome::Stale);
        }
        let slot = &self.slots[self.next];
        let device = &self.gpu.device;
        // SAFETY: handles are alive; after the wait for the fence the slot's last commands are finished.
        let acquired = unsafe {
            device.wait_for_fences(&[slot.done], true, u64::MAX).called("vkWaitForFences")?;
            self.functions.acquire_next_image(self.raw, 1_000_000_000, slot.acquired, vk::Fence::null())
        };
        let index = match acquired {
            Ok((index, _)) => index as usize,
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR | vk::Result::TIMEOUT | vk::Result::NOT_READY) => {
                return Ok(PresentOutcome::Stale);
            }
            Err(result) => return Err(GpuError::Vulkan { call: "vkAcquireNextImageKHR", result }),
        };
        self.record(slot, picture, self.images[index])?;
        let drawn = self.drawn[index];
        let wait = [vk::SemaphoreSubmitInfo::default()
            .semaphore(slot.acquired)
            .stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)];
        let signal =
            [vk::SemaphoreSubmitInfo::default().semaphore(drawn).stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)];
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(slot.commands)];
        let submit = [vk::SubmitInfo2::default()
            .wait_semaphore_infos(&wait)
            .signal_semaphore_infos(&signal)
            .command_buffer_infos(&commands)];
        let (chains, indices, semaphores) = ([self.raw], [index as u32], [drawn]);
        let ids = [self.count + 1];
        let mut id = vk::PresentIdKHR::default().present_ids(&ids);
        let mut present =
            vk::PresentInfoKHR::default().wait_semaphores(&semaphores).swapchains(&chains).image_indices(&indices);
        if self.waiter.is_some() {
            present = present.push_next(&mut id);
        }
        // SAFETY: everything named is alive, and signalled or waited for once.
        let presented = unsafe {
            device.reset_fences(&[slot.done]).called("vkResetFences")?;
            device.queue_submit2(self.gpu.queue, &submit, slot.done).called("vkQueueSubmit2")?;
            self.functions.queue_present(self.gpu.queue, &present)
        };
        self.next = (self.next + 1) % self.slots.len();
        match presented {
            Ok(_) => {
                self.count += 1;
                Ok(PresentOutcome::Queued(self.count))
            }
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => Ok(PresentOutcome::Stale),
            Err(result) => Err(GpuError::Vulkan { call: "vkQueuePresentKHR", result }),
        }
    }

    fn record(&self, slot: &Slot, picture: &Image, image: vk::Image) -> Result<(), GpuError> {
        let range = vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            level_count: 1,
            layer_count: 1,
            ..Default::default()
        };
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            layer_count: 1,
            ..Default::default()
        };
        let to_target = vk::ImageMemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
            .dst_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
            .dst_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
            .old_layout(vk::ImageLayout::UNDEFINED)
            .new_layout(vk::ImageLayout::TRANSFER_DST_OPTIMAL)
            .image(image)
            .subresource_range(range);
        let to_present = vk::ImageMemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)
            .src_access_mask(vk::AccessFlags2::TRANSFER_WRITE)
            .old_layout(vk::ImageLayout::TRANSFER_DST_OPTIMAL)
            .new_layout(vk::ImageLayout::PRESENT_SRC_KHR)
            .image(image)
            .subresource_range(range);
        let before: Vec<_> = picture.next_use(Use::COPY_SOURCE).into_iter().chain([to_target]).collect();
        let corner = vk::Offset3D { x: self.extent.width as i32, y: self.extent.height as i32, z: 1 };
        let region = vk::ImageBlit::default()
            .src_subresource(layers)
            .src_offsets([vk::Offset3D::default(), corner])
            .dst_subresource(layers)
            .dst_offsets([vk::Offset3D::default(), corner]);
        let (device, commands) = (&self.gpu.device, slot.commands);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the slot's commands are done, the image was acquired, and both images have this size.
        unsafe {
            device.reset_command_pool(slot.pool, vk::CommandPoolResetFlags::empty()).called("vkResetCommandPool")?;
            device.begin_command_buffer(commands, &begin).called("vkBeginCommandBuffer")?;
            device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().image_memory_barriers(&before));
            // A blit between images of equal size copies, and converts the order of red and blue where the formats differ.
            device.cmd_blit_image(
                commands,
                picture.raw,
                vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                image,
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &[region],
                vk::Filter::NEAREST,
            );
            device.cmd_pipeline_barrier2(commands, &vk::DependencyInfo::default().image_memory_barriers(&[to_present]));
            device.end_command_buffer(commands).called("vkEndCommandBuffer")
        }
    }

    /// Blocks until a picture is on the monitor, for at most `at_most`. False: it is not, or the device cannot tell.
    pub fn wait_until_shown(&self, picture: u64, at_most: std::time::Duration) -> bool {
        let Some(waiter) = &self.waiter else { return false };
        // SAFETY: the chain is alive, and the picture was presented to it.
        unsafe { waiter.wait_for_present(self.raw, picture, at_most.as_nanos() as u64) }.is_ok()
    }

    /// Whether the device can tell when a picture is on the monitor.
    pub fn says_when(&self) -> bool {
        self.waiter.is_some()
    }

    /// Waits until the device is idle, so that pictures may be destroyed.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn rest(&self) -> Result<(), GpuError> {
        // SAFETY: the device is alive and used by this thread alone.
        unsafe { self.gpu.device.device_wait_idle() }.called("vkDeviceWaitIdle")
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        if let Err(error) = self.rest() {
            tracing::warn!("could not wait for the window's last pictures: {error}");
        }
        // SAFETY: the device is idle; null handles are ignored.
        unsafe {
            let device = &self.gpu.device;
            for slot in &self.slots {
                device.destroy_fence(slot.done, None);
                device.destroy_semaphore(slot.acquired, None);
                device.destroy_command_pool(slot.pool, None);
            }
            for &semaphore in &self.drawn {
                device.destroy_semaphore(semaphore, None);
            }
            self.functions.destroy_swapchain(self.raw, None);
        }
    }
}
