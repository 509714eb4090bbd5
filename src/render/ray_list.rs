//! A compacted list of pixels on the device: which of them trace, or are worked on again.

use std::rc::Rc;

use crate::gpu::{Buffer, Frame, Gpu, GpuError, read_buffer};

/// Pixels that trace, compacted.
pub struct RayList {
    pub rays: Buffer,
    /// Groups of 64 as indirect arguments, then the count.
    pub arguments: Buffer,
}

impl RayList {
    /// Room for so many.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn new(gpu: &Rc<Gpu>, pixels: u64) -> Result<RayList, GpuError> {
        Ok(RayList {
            rays: Buffer::device(gpu, "ray list", pixels * 4)?,
            arguments: Buffer::device(gpu, "ray list arguments", 16)?,
        })
    }

    /// The listed pixels, packed as `pack_pixel` has it, in the order in which the device's threads wrote; it has been
    /// waited for.
    ///
    /// # Errors
    /// What the device said.
    pub fn read(&self, gpu: &Rc<Gpu>) -> Result<Vec<u32>, GpuError> {
        let count = self.read_count(gpu)? as usize;
        let rays = read_buffer(gpu, &self.rays)?;
        Ok(rays.chunks_exact(4).take(count).map(bytemuck::pod_read_unaligned).collect())
    }

    /// How many are listed; as [`RayList::read`].
    ///
    /// # Errors
    /// What the device said.
    pub fn read_count(&self, gpu: &Rc<Gpu>) -> Result<u32, GpuError> {
        let [_, _, _, count]: [u32; 4] = bytemuck::pod_read_unaligned(&read_buffer(gpu, &self.arguments)?[..16]);
        Ok(count)
    }

    /// Column, row and eye of a listed pixel.
    pub fn place(packed: u32) -> [u32; 3] {
        [packed & 0x3fff, packed >> 14 & 0x3fff, packed >> 28]
    }

    /// A listed pixel's texel in the layers of both eyes, tightly packed one after the other.
    pub fn texel(packed: u32, (width, height): (u32, u32)) -> usize {
        let [x, y, eye] = RayList::place(packed).map(|n| n as usize);
        (eye * height as usize + y) * width as usize + x
    }

    /// No rays yet, in 0×1×1 groups.
    pub fn clear(&self, frame: &mut Frame) {
        frame.write_words(&self.arguments, &[0, 1, 1, 0]);
    }
}
