//! A compacted list of pixels on the device: which of them trace, or are worked on again.

use std::rc::Rc;

use crate::gpu::{Buffer, Frame, Gpu, GpuError, read_buffer};

/// A compacted list of pixels, and the indirect arguments of dispatches over it.
pub struct RayList {
    pub rays: Buffer,
    /// The number of groups of 64 in x, y and z, then the number of listed pixels.
    pub arguments: Buffer,
}

impl RayList {
    /// A list with room for this many pixels.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn new(gpu: &Rc<Gpu>, pixels: u64) -> Result<RayList, GpuError> {
        Ok(RayList {
            rays: Buffer::device(gpu, "ray list", pixels * 4)?,
            arguments: Buffer::device(gpu, "ray list arguments", 16)?,
        })
    }

    /// Reads the listed pixels back, packed as by `pack_pixel` of ray_list.glsl. Their order is that in which the device's
    /// threads wrote them. The frame that wrote them must have finished.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn read(&self, gpu: &Rc<Gpu>) -> Result<Vec<u32>, GpuError> {
        let count = self.read_count(gpu)? as usize;
        let rays = read_buffer(gpu, &self.rays)?;
        Ok(rays.chunks_exact(4).take(count).map(bytemuck::pod_read_unaligned).collect())
    }

    /// Reads the number of listed pixels back; otherwise as [`RayList::read`].
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn read_count(&self, gpu: &Rc<Gpu>) -> Result<u32, GpuError> {
        let [_, _, _, count]: [u32; 4] = bytemuck::pod_read_unaligned(&read_buffer(gpu, &self.arguments)?[..16]);
        Ok(count)
    }

    /// Column, row and eye of a listed pixel.
    pub fn place(packed: u32) -> [u32; 3] {
        [packed & 0x3fff, packed >> 14 & 0x3fff, packed >> 28]
    }

    /// The index of a listed pixel's texel in both eyes' layers, tightly packed one after the other.
    pub fn texel(packed: u32, (width, height): (u32, u32)) -> usize {
        let [x, y, eye] = RayList::place(packed).map(|n| n as usize);
        (eye * height as usize + y) * width as usize + x
    }

    /// Empties the list: no pixels, in 0×1×1 groups.
    pub fn clear(&self, frame: &mut Frame) {
        frame.write_words(&self.arguments, &[0, 1, 1, 0]);
    }
}
