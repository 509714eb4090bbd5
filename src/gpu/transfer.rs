//! Content on its way to the device and back: each of these records a frame of its own and waits for it.

use std::rc::Rc;

use ash::vk;

use super::{Buffer, Frame, Gpu, GpuError, Image, ImageDesc};

impl Buffer {
    /// Device memory with this content; waits for the copy.
    ///
    /// # Errors
    /// As [`Buffer::device`], or the error of the failed copy.
    pub fn with_content<T: bytemuck::NoUninit>(gpu: &Rc<Gpu>, what: &str, content: &[T]) -> Result<Buffer, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(content);
        let buffer = Buffer::device(gpu, what, bytes.len() as u64)?;
        buffer.fill(bytes)?;
        Ok(buffer)
    }

    /// The same for data from which an acceleration structure is built.
    ///
    /// # Errors
    /// As [`Buffer::with_content`].
    pub fn structure_input<T: bytemuck::NoUninit>(
        gpu: &Rc<Gpu>,
        what: &str,
        content: &[T],
    ) -> Result<Buffer, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(content);
        let buffer = Buffer::structure(gpu, what, bytes.len() as u64)?;
        buffer.fill(bytes)?;
        Ok(buffer)
    }

    /// Copies `bytes` to the start of the buffer, and waits.
    fn fill(&self, bytes: &[u8]) -> Result<(), GpuError> {
        let gpu = &self.gpu;
        if !bytes.is_empty() {
            let staging = Buffer::upload(gpu, "staging", bytes.len() as u64)?;
            staging.write(bytes);
            let mut frame = Frame::begin(gpu)?;
            frame.copy_buffer(&staging, self);
            frame.finish()?;
        }
        Ok(())
    }
}

impl Image {
    /// A sampled texture: `levels[mip]` has the texels of one mip, tightly packed.
    ///
    /// # Errors
    /// As [`Image::new`], or the error of the failed copy.
    pub fn with_content(gpu: &Rc<Gpu>, what: &str, desc: ImageDesc, levels: &[Vec<u8>]) -> Result<Image, GpuError> {
        let image = Image::new(gpu, what, desc)?;
        let bytes: Vec<u8> = levels.concat();
        let staging = Buffer::upload(gpu, "staging", bytes.len() as u64)?;
        staging.write(&bytes);
        let mut frame = Frame::begin(gpu)?;
        frame.copy_to_image(&staging, &image, levels);
        frame.finish()?;
        Ok(image)
    }

    /// An image with this content in mip 0: the texels of each layer, tightly packed.
    ///
    /// # Errors
    /// As [`Image::new`], or the error of the failed copy.
    pub fn with_layers(gpu: &Rc<Gpu>, what: &str, desc: ImageDesc, layers: &[&[u8]]) -> Result<Image, GpuError> {
        assert_eq!(layers.len(), desc.layers as usize, "{what}: bytes for every layer");
        let image = Image::new(gpu, what, desc)?;
        image.write_layers(&layers.concat())?;
        Ok(image)
    }

    /// Writes mip 0 of all layers, tightly packed one after the other, and waits. The image's usage must include transfers to it.
    ///
    /// # Errors
    /// When memory for the copy runs out, or the copy fails.
    pub fn write_layers(&self, bytes: &[u8]) -> Result<(), GpuError> {
        let staging = Buffer::upload(&self.gpu, "staging", bytes.len() as u64)?;
        staging.write(bytes);
        let mut frame = Frame::begin(&self.gpu)?;
        frame.copy_to_layers(&staging, self);
        frame.finish()?;
        Ok(())
    }
}

/// Reads a buffer back, by a submission of its own.
pub fn read_buffer(gpu: &Rc<Gpu>, buffer: &Buffer) -> Result<Vec<u8>, GpuError> {
    let host = Buffer::readback(gpu, "readback", buffer.size())?;
    let mut frame = Frame::begin(gpu)?;
    frame.copy_buffer(buffer, &host);
    frame.finish()?;
    Ok(host.read())
}

/// Reads mip 0 of every layer back, tightly packed, by a submission of its own.
pub fn read_image(gpu: &Rc<Gpu>, image: &Image) -> Result<Vec<u8>, GpuError> {
    let ImageDesc { width, height, layers, format, .. } = *image.desc();
    let texel = match format {
        vk::Format::R32G32B32A32_SFLOAT | vk::Format::R32G32B32A32_UINT => 16,
        vk::Format::R16G16B16A16_SFLOAT | vk::Format::R32G32_SFLOAT => 8,
        _ => 4,
    };
    let bytes = u64::from(width) * u64::from(height) * u64::from(layers) * texel;
    let host = Buffer::readback(gpu, "readback", bytes)?;
    let mut frame = Frame::begin(gpu)?;
    frame.copy_image(image, &host);
    frame.finish()?;
    Ok(host.read())
}
