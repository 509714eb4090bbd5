//! A frame: a command buffer into which passes are recorded one after the other, with derived barriers and a time for each pass.
//! `finish` submits it and waits.

use std::ops::Range;
use std::rc::Rc;
use std::time::Instant;

use ash::vk;

use super::access::{Barrier, Use};
use super::{Buffer, Called, Gpu, GpuError, Image};

/// How long one pass took on the device.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PassTime {
    pub name: String,
    pub ms: f64,
}

/// A command buffer being recorded.
///
/// The resources that a frame uses must outlive [`Frame::finish`], which waits for the device. A pass chain only borrows them, so
/// their owners keep them until then.
pub struct Frame {
    pub(super) gpu: Rc<Gpu>,
    pub(super) commands: vk::CommandBuffer,
    pub(super) descriptors: vk::DescriptorPool,
    pool: vk::CommandPool,
    fence: vk::Fence,
    clock: Clock,
    passes: Vec<String>,
}

/// How the passes are timed.
enum Clock {
    /// By two timestamps of the device for each pass.
    Timestamps(vk::QueryPool),
    /// By the host's clock, with a submission for each pass, on software devices. llvmpipe (Mesa 22.3) adds a timestamp to the
    /// raster work that follows it. The timestamp is then sometimes taken after the dispatch that it should precede, and the
    /// pass seems to take no time.
    Host { started: Option<Instant>, ms: Vec<f64> },
}

/// The largest number of passes in a frame; each has two timestamp queries.
const MAX_PASSES: u32 = 128;

impl Frame {
    /// Starts recording.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn begin(gpu: &Rc<Gpu>) -> Result<Frame, GpuError> {
        let device = &gpu.device;
        let mut frame = Frame {
            gpu: Rc::clone(gpu),
            commands: vk::CommandBuffer::null(),
            descriptors: vk::DescriptorPool::null(),
            pool: vk::CommandPool::null(),
            fence: vk::Fence::null(),
            clock: match gpu.is_cpu() {
                true => Clock::Host { started: None, ms: Vec::new() },
                false => Clock::Timestamps(vk::QueryPool::null()),
            },
            passes: Vec::new(),
        };
        let pool_info = vk::CommandPoolCreateInfo::default().queue_family_index(gpu.queue_family);
        let sizes = [
            (vk::DescriptorType::COMBINED_IMAGE_SAMPLER, 1024),
            (vk::DescriptorType::STORAGE_IMAGE, 512),
            (vk::DescriptorType::STORAGE_BUFFER, 1024),
            (vk::DescriptorType::UNIFORM_BUFFER, 256),
            (vk::DescriptorType::ACCELERATION_STRUCTURE_KHR, 64),
        ]
        .map(|(ty, descriptor_count)| vk::DescriptorPoolSize { ty, descriptor_count });
        // The last descriptor type exists only on devices with ray queries.
        let sizes = if gpu.has_ray_query() { &sizes[..] } else { &sizes[..sizes.len() - 1] };
        let descriptor_info = vk::DescriptorPoolCreateInfo::default().max_sets(2 * MAX_PASSES).pool_sizes(sizes);
        let query_info =
            vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2 * MAX_PASSES);
        // SAFETY: the device is alive and every info lives for its call; on an early return `Drop` destroys what
        // was made and ignores what is null.
        unsafe {
            frame.pool = device.create_command_pool(&pool_info, None).called("vkCreateCommandPool")?;
            frame.fence = device.create_fence(&Default::default(), None).called("vkCreateFence")?;
            frame.descriptors =
                device.create_descriptor_pool(&descriptor_info, None).called("vkCreateDescriptorPool")?;
            if let Clock::Timestamps(queries) = &mut frame.clock {
                *queries = device.create_query_pool(&query_info, None).called("vkCreateQueryPool")?;
            }
        }
        frame.begin_commands()?;
        if let Clock::Timestamps(queries) = frame.clock {
            // SAFETY: recording has begun, outside rendering; the pool has this many queries.
            unsafe { device.cmd_reset_query_pool(frame.commands, queries, 0, 2 * MAX_PASSES) };
        }
        Ok(frame)
    }

    /// Begins a new command buffer of the pool.
    fn begin_commands(&mut self) -> Result<(), GpuError> {
        let device = &self.gpu.device;
        let allocate = vk::CommandBufferAllocateInfo::default()
            .command_pool(self.pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool is alive and frees its buffers when it is destroyed.
        unsafe {
            self.commands = device.allocate_command_buffers(&allocate).called("vkAllocateCommandBuffers")?[0];
            device.begin_command_buffer(self.commands, &begin).called("vkBeginCommandBuffer")
        }
    }

    /// Submits what was recorded and waits for it.
    fn submit(&mut self) -> Result<(), GpuError> {
        let device = &self.gpu.device;
        // SAFETY: recording has begun and nothing else uses these handles; the fence is waited for before anything
        // of the frame is destroyed or recorded again.
        unsafe {
            device.end_command_buffer(self.commands).called("vkEndCommandBuffer")?;
            let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(self.commands)];
            let submit = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
            device.queue_submit2(self.gpu.queue, &submit, self.fence).called("vkQueueSubmit2")?;
            device.wait_for_fences(&[self.fence], true, u64::MAX).called("vkWaitForFences")?;
            device.reset_fences(&[self.fence]).called("vkResetFences")
        }
    }

    /// Declares the next use of an image and records the barrier that it needs, if any.
    pub(super) fn use_image(&mut self, image: &Image, next: Use) {
        if let Some(barrier) = image.next_use(next) {
            self.barrier(&vk::DependencyInfo::default().image_memory_barriers(&[barrier]));
        }
    }

    /// The same for a buffer.
    pub(super) fn use_buffer(&mut self, buffer: &Buffer, next: Use) {
        let (barrier, state) = buffer.state.get().then(next, false);
        buffer.state.set(state);
        let Some(Barrier { src_stage, src_access, dst_stage, dst_access, .. }) = barrier else { return };
        let barriers = [vk::BufferMemoryBarrier2::default()
            .src_stage_mask(src_stage)
            .src_access_mask(src_access)
            .dst_stage_mask(dst_stage)
            .dst_access_mask(dst_access)
            .buffer(buffer.raw)
            .size(vk::WHOLE_SIZE)];
        self.barrier(&vk::DependencyInfo::default().buffer_memory_barriers(&barriers));
    }

    fn barrier(&self, dependency: &vk::DependencyInfo<'_>) {
        // SAFETY: recording has begun; the resources named outlive the frame (see the type's documentation).
        unsafe { self.gpu.device.cmd_pipeline_barrier2(self.commands, dependency) };
    }

    /// Starts the clock of a pass. Must be called outside rendering, and before anything of the pass is bound: on software
    /// devices it begins a new command buffer.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub(super) fn start_pass(&mut self, name: &str) -> Result<(), GpuError> {
        let index = self.passes.len() as u32;
        assert!(index < MAX_PASSES, "a frame has at most {MAX_PASSES} passes");
        self.passes.push(name.to_owned());
        match self.clock {
            Clock::Timestamps(queries) => self.stamp(queries, 2 * index),
            Clock::Host { .. } => {
                self.submit()?;
                self.begin_commands()?;
                let now = Instant::now();
                if let Clock::Host { started, .. } = &mut self.clock {
                    *started = Some(now);
                }
            }
        }
        Ok(())
    }

    /// Stops the clock of the pass that was started last. On software devices this waits for the pass.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub(super) fn end_pass(&mut self) -> Result<(), GpuError> {
        let index = self.passes.len() as u32 - 1;
        match self.clock {
            Clock::Timestamps(queries) => self.stamp(queries, 2 * index + 1),
            Clock::Host { .. } => {
                self.submit()?;
                if let Clock::Host { started, ms } = &mut self.clock {
                    ms.push(started.take().map_or(0.0, |s| s.elapsed().as_secs_f64() * 1e3));
                }
                self.begin_commands()?;
            }
        }
        Ok(())
    }

    fn stamp(&self, queries: vk::QueryPool, query: u32) {
        let stage = vk::PipelineStageFlags2::ALL_COMMANDS;
        // SAFETY: the pool has `2 * MAX_PASSES` queries, reset at begin, each written once; never inside rendering.
        unsafe { self.gpu.device.cmd_write_timestamp2(self.commands, stage, queries, query) };
    }

    /// Sets every word of a buffer.
    pub fn fill(&mut self, buffer: &Buffer, word: u32) {
        self.use_buffer(buffer, Use::COPY_TARGET);
        // SAFETY: the whole buffer is filled; WHOLE_SIZE rounds a size that is no multiple of four down.
        unsafe { self.gpu.device.cmd_fill_buffer(self.commands, buffer.raw, 0, vk::WHOLE_SIZE, word) };
    }

    /// Writes words at the start of a buffer.
    pub fn write_words(&mut self, buffer: &Buffer, words: &[u32]) {
        self.use_buffer(buffer, Use::COPY_TARGET);
        // SAFETY: the words are copied into the command buffer; the caller's buffer is large enough, which validation checks.
        unsafe { self.gpu.device.cmd_update_buffer(self.commands, buffer.raw, 0, bytemuck::cast_slice(words)) };
    }

    /// Sets every texel of an image.
    pub fn clear(&mut self, image: &Image, value: [f32; 4]) {
        self.use_image(image, Use::COPY_TARGET);
        let range = vk::ImageSubresourceRange {
            aspect_mask: image.aspect,
            base_mip_level: 0,
            level_count: vk::REMAINING_MIP_LEVELS,
            base_array_layer: 0,
            layer_count: vk::REMAINING_ARRAY_LAYERS,
        };
        let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        let value = vk::ClearColorValue { float32: value };
        // SAFETY: the image is in this layout (barrier above) and outlives the frame.
        unsafe { self.gpu.device.cmd_clear_color_image(self.commands, image.raw, layout, &value, &[range]) };
    }

    /// Copies `from` to the start of `to`, as far as both reach.
    pub fn copy_buffer(&mut self, from: &Buffer, to: &Buffer) {
        self.use_buffer(from, Use::COPY_SOURCE);
        self.use_buffer(to, Use::COPY_TARGET);
        let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: from.size().min(to.size()) };
        // SAFETY: the region lies within both buffers.
        unsafe { self.gpu.device.cmd_copy_buffer(self.commands, from.raw, to.raw, &[region]) };
        self.use_buffer(to, Use::HOST_READ);
    }

    /// Copies tightly packed layers into mip 0, one after the other.
    pub(super) fn copy_to_layers(&mut self, from: &Buffer, to: &Image) {
        let region = vk::BufferImageCopy::default().image_extent(extent_of(to, 0)).image_subresource(layers_of(
            to,
            0,
            0..to.desc().layers,
        ));
        self.copy_regions(from, to, &[region]);
    }

    /// Copies tightly packed mip levels into a single-layer image.
    pub(super) fn copy_to_image(&mut self, from: &Buffer, to: &Image, levels: &[Vec<u8>]) {
        self.copy_to_layer(from, 0, to, 0, levels);
        self.use_image(to, Use::SAMPLED_FRAGMENT);
    }

    /// Copies the mip levels that lie tightly packed in `from`, beginning at byte `offset`, into one layer.
    pub fn copy_to_layer(&mut self, from: &Buffer, mut offset: u64, to: &Image, layer: u32, levels: &[Vec<u8>]) {
        let mut regions = Vec::new();
        for (mip, level) in (0..).zip(levels) {
            let region = vk::BufferImageCopy::default()
                .buffer_offset(offset)
                .image_extent(extent_of(to, mip))
                .image_subresource(layers_of(to, mip, layer..layer + 1));
            regions.push(region);
            offset += level.len() as u64;
        }
        self.copy_regions(from, to, &regions);
    }

    /// The callers' regions lie within the image, and their bytes within the buffer.
    fn copy_regions(&mut self, from: &Buffer, to: &Image, regions: &[vk::BufferImageCopy]) {
        self.use_image(to, Use::COPY_TARGET);
        let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        // SAFETY: the image is in this layout (barrier above); each region is one level of layers that the image has, and the
        // buffer holds the bytes one after the other; validation checks both in tests.
        unsafe { self.gpu.device.cmd_copy_buffer_to_image(self.commands, from.raw, to.raw, layout, regions) };
    }

    /// Copies mip 0 of every layer into another image of the same size and number of layers, texel by texel: values
    /// are not converted between linear and sRGB formats.
    pub fn copy_texels(&mut self, from: &Image, to: &Image) {
        assert_eq!((from.extent(), from.desc().layers), (to.extent(), to.desc().layers), "images of one shape");
        self.use_image(from, Use::COPY_SOURCE);
        self.use_image(to, Use::COPY_TARGET);
        let all = 0..from.desc().layers;
        let region = vk::ImageCopy::default()
            .src_subresource(layers_of(from, 0, all.clone()))
            .dst_subresource(layers_of(to, 0, all))
            .extent(extent_of(from, 0));
        // SAFETY: both images are alive and have these layers (asserted); validation checks formats in tests.
        unsafe {
            self.gpu.device.cmd_copy_image(
                self.commands,
                from.raw,
                vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                to.raw,
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &[region],
            );
        }
    }

    /// Brings a lent image into the layout in which its owner expects it back: that of a colour attachment.
    pub fn return_lent(&mut self, image: &Image) {
        self.use_image(image, Use::COLOR);
    }

    /// Copies mip 0 of every layer into a readback buffer, layer after layer, tightly packed.
    pub fn copy_image(&mut self, from: &Image, to: &Buffer) {
        self.use_image(from, Use::COPY_SOURCE);
        self.use_buffer(to, Use::COPY_TARGET);
        let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        let region = vk::BufferImageCopy::default().image_extent(extent_of(from, 0)).image_subresource(layers_of(
            from,
            0,
            0..from.desc().layers,
        ));
        // SAFETY: the caller sized the buffer for the image; validation checks it in tests.
        unsafe { self.gpu.device.cmd_copy_image_to_buffer(self.commands, from.raw, layout, to.raw, &[region]) };
        self.use_buffer(to, Use::HOST_READ);
    }

    /// Submits, waits, and returns the time of every pass in order.
    ///
    /// # Errors
    /// The error of the failed Vulkan call, such as the loss of the device.
    pub fn finish(mut self) -> Result<Vec<PassTime>, GpuError> {
        self.submit()?;
        let ms = match &self.clock {
            Clock::Host { ms, .. } => ms.clone(),
            Clock::Timestamps(queries) => self.timestamps(*queries)?,
        };
        Ok(self.passes.iter().zip(ms).map(|(name, ms)| PassTime { name: name.clone(), ms }).collect())
    }

    /// Milliseconds of each pass.
    fn timestamps(&self, queries: vk::QueryPool) -> Result<Vec<f64>, GpuError> {
        let mut ticks = vec![0u64; 2 * self.passes.len()];
        if !ticks.is_empty() {
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
            // SAFETY: these queries were written by the commands that have just finished.
            unsafe { self.gpu.device.get_query_pool_results(queries, 0, &mut ticks, flags) }
                .called("vkGetQueryPoolResults")?;
        }
        let period = f64::from(self.gpu.timestamp_period_ns);
        Ok(ticks.chunks_exact(2).map(|t| t[1].saturating_sub(t[0]) as f64 * period * 1e-6).collect())
    }
}

/// Some layers of one mip level.
fn layers_of(image: &Image, mip_level: u32, layers: Range<u32>) -> vk::ImageSubresourceLayers {
    let layer_count = layers.end - layers.start;
    vk::ImageSubresourceLayers { aspect_mask: image.aspect, mip_level, base_array_layer: layers.start, layer_count }
}

/// Texels of one mip level.
fn extent_of(image: &Image, mip_level: u32) -> vk::Extent3D {
    let (width, height) = image.extent();
    vk::Extent3D { width: (width >> mip_level).max(1), height: (height >> mip_level).max(1), depth: 1 }
}

impl Drop for Frame {
    fn drop(&mut self) {
        // SAFETY: whatever was submitted has been waited for (after the loss of the device, destruction is allowed as well);
        // null handles are ignored.
        unsafe {
            let device = &self.gpu.device;
            if let Clock::Timestamps(queries) = self.clock {
                device.destroy_query_pool(queries, None);
            }
            device.destroy_descriptor_pool(self.descriptors, None);
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        }
    }
}
