//! Buffers in device memory, or mapped for the host to write (upload) or to read (readback).

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::access::AccessState;
use super::{Called, Gpu, GpuError};

/// A buffer that any pass may use.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    pub(super) state: Cell<AccessState>,
    size: u64,
    allocation: RefCell<Option<Allocation>>,
    pub(super) gpu: Rc<Gpu>,
}

impl Buffer {
    /// Device memory, content undefined.
    ///
    /// # Errors
    /// [`GpuError::Memory`] when the device has none left.
    pub fn device(gpu: &Rc<Gpu>, what: &str, bytes: u64) -> Result<Buffer, GpuError> {
        Buffer::check_storage(gpu, what, bytes)?;
        Buffer::new(gpu, what, bytes, MemoryLocation::GpuOnly)
    }

    /// Device memory for an acceleration structure, its input or its scratch. No shader binds it, so it may be larger than the
    /// largest storage buffer.
    pub(super) fn structure(gpu: &Rc<Gpu>, what: &str, bytes: u64) -> Result<Buffer, GpuError> {
        Buffer::new(gpu, what, bytes, MemoryLocation::GpuOnly)
    }

    /// The buffer's device address, by which acceleration structures are built.
    pub(super) fn address(&self) -> u64 {
        let info = vk::BufferDeviceAddressInfo::default().buffer(self.raw);
        // SAFETY: only a device with ray queries asks; all of its buffers are made with an address.
        unsafe { self.gpu.device.get_buffer_device_address(&info) }
    }

    /// Checks the size against the largest storage buffer. Upload and readback buffers are not checked.
    fn check_storage(gpu: &Gpu, what: &str, bytes: u64) -> Result<(), GpuError> {
        if bytes <= gpu.max_storage_bytes() {
            return Ok(());
        }
        let reason = format!("the device's largest storage buffer has {} bytes", gpu.max_storage_bytes());
        Err(GpuError::Memory { what: what.to_owned(), bytes, reason })
    }

    /// Memory that the host writes and the device reads.
    ///
    /// # Errors
    /// As [`Buffer::device`].
    pub fn upload(gpu: &Rc<Gpu>, what: &str, bytes: u64) -> Result<Buffer, GpuError> {
        Buffer::new(gpu, what, bytes, MemoryLocation::CpuToGpu)
    }

    /// Memory that the device writes and the host reads.
    ///
    /// # Errors
    /// As [`Buffer::device`].
    pub fn readback(gpu: &Rc<Gpu>, what: &str, bytes: u64) -> Result<Buffer, GpuError> {
        Buffer::new(gpu, what, bytes, MemoryLocation::GpuToCpu)
    }

    fn new(gpu: &Rc<Gpu>, what: &str, bytes: u64, location: MemoryLocation) -> Result<Buffer, GpuError> {
        // Vulkan has no buffers of size 0, but an empty scene still binds all of its buffers.
        let size = bytes.max(16);
        let mut usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::VERTEX_BUFFER
            | vk::BufferUsageFlags::INDEX_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        if gpu.has_ray_query() {
            usage |= vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS
                | vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR
                | vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR;
        }
        let info = vk::BufferCreateInfo::default().size(size).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: the device is alive; `info` lives for the call.
        let raw = unsafe { gpu.device.create_buffer(&info, None) }.called("vkCreateBuffer")?;
        // SAFETY: `raw` was just made by this device.
        let requirements = unsafe { gpu.device.get_buffer_memory_requirements(raw) };
        let buffer = Buffer {
            raw,
            state: Cell::new(AccessState::NEW),
            size,
            allocation: RefCell::new(None),
            gpu: Rc::clone(gpu),
        };
        let allocation = gpu.allocate(what, requirements, location, true)?;
        // SAFETY: memory and offset come from the allocator for exactly these requirements, bound once.
        unsafe { gpu.device.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) }
            .called("vkBindBufferMemory")?;
        *buffer.allocation.borrow_mut() = Some(allocation);
        Ok(buffer)
    }

    /// Size in bytes: at least 16.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Writes from the start of an upload buffer. Frames that read it must have finished.
    pub fn write(&self, bytes: &[u8]) {
        let mut allocation = self.allocation.borrow_mut();
        let mapped = allocation.as_mut().and_then(Allocation::mapped_slice_mut);
        let mapped = mapped.expect("`write` is for upload buffers, which are mapped");
        mapped[..bytes.len()].copy_from_slice(bytes);
    }

    /// The content of a readback buffer after its frame has finished.
    pub fn read(&self) -> Vec<u8> {
        let allocation = self.allocation.borrow();
        let mapped = allocation.as_ref().and_then(Allocation::mapped_slice);
        let mapped = mapped.expect("`read` is for readback buffers, which are mapped");
        mapped[..self.size as usize].to_vec()
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: frames wait before they return, so nothing on the device uses the buffer any more.
        unsafe { self.gpu.device.destroy_buffer(self.raw, None) };
        if let Some(allocation) = self.allocation.borrow_mut().take() {
            self.gpu.free(allocation);
        }
    }
}
