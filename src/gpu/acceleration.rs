//! Acceleration structures for ray queries, which not every device has.
//!
//! `render::ray_structure` builds bottom-level structures of triangles and one top-level structure that refers to them; compute
//! passes bind the latter (`Dispatch::structure`).

use std::rc::Rc;

use ash::vk;
use bytemuck::{Pod, Zeroable};

use super::access::Use;
use super::ray_tracing::RayTracing;
use super::{Buffer, Called, Frame, Gpu, GpuError};

/// A run of triangles in a buffer of positions, nine floats each.
#[derive(Debug, Clone, Copy)]
pub struct Triangles {
    pub first: u32,
    pub count: u32,
    /// Every triangle that a ray meets is a hit. Otherwise the shader decides whether it is one.
    pub opaque: bool,
}

/// One instance of the top-level structure: a bottom-level structure and how rays see it.
pub struct StructureInstance<'a> {
    pub structure: &'a AccelerationStructure,
    /// The instance's custom index, as the shader reads it; 24 bits.
    pub custom: u32,
    /// Rays hit both sides of the triangles, whatever their culling flags say.
    pub two_sided: bool,
}

/// An acceleration structure with its memory.
pub struct AccelerationStructure {
    pub(super) raw: vk::AccelerationStructureKHR,
    pub(super) memory: Buffer,
    gpu: Rc<Gpu>,
}

/// VkAccelerationStructureInstanceKHR.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct InstanceWords {
    transform: [[f32; 4]; 3],
    custom_and_mask: u32,
    offset_and_flags: u32,
    structure: u64,
}

const IDENTITY: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

impl AccelerationStructure {
    /// Builds a bottom-level structure over `triangles` of `positions`, and waits for it.
    ///
    /// # Errors
    /// [`GpuError::Lacks`] on a device without ray queries; else the error of the failed Vulkan call.
    pub fn of_triangles(gpu: &Rc<Gpu>, positions: &Buffer, triangles: Triangles) -> Result<Self, GpuError> {
        // First, because without ray queries buffers have no addresses.
        gpu.ray_tracing()?;
        // The first triangle goes into the address, because Mesa 25.0's lavapipe adds the range's `firstVertex` twice.
        let first = positions.address() + 36 * u64::from(triangles.first);
        let data = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
            .vertex_format(vk::Format::R32G32B32_SFLOAT)
            .vertex_data(vk::DeviceOrHostAddressConstKHR { device_address: first })
            .vertex_stride(12)
            .max_vertex(3 * triangles.count - 1)
            .index_type(vk::IndexType::NONE_KHR);
        let flags = match triangles.opaque {
            // Rays to lights test opaque triangles too where some triangle transmits light.
            true => vk::GeometryFlagsKHR::OPAQUE | vk::GeometryFlagsKHR::NO_DUPLICATE_ANY_HIT_INVOCATION,
            // Each triangle is tested once per ray: the shader looks at its cut-out texture.
            false => vk::GeometryFlagsKHR::NO_DUPLICATE_ANY_HIT_INVOCATION,
        };
        let geometry = vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { triangles: data })
            .flags(flags);
        let range = vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(triangles.count);
        Self::build(gpu, vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL, geometry, range, positions, &[])
    }

    /// Builds a top-level structure over others, none of which is transformed, and waits for it.
    ///
    /// # Errors
    /// As [`AccelerationStructure::of_triangles`].
    pub fn of_structures(gpu: &Rc<Gpu>, placed: &[StructureInstance<'_>]) -> Result<Self, GpuError> {
        let functions = &gpu.ray_tracing()?.functions;
        let words = |p: &StructureInstance<'_>| {
            let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(p.structure.raw);
            let flags = match p.two_sided {
                true => vk::GeometryInstanceFlagsKHR::TRIANGLE_FACING_CULL_DISABLE,
                false => vk::GeometryInstanceFlagsKHR::empty(),
            };
            InstanceWords {
                transform: IDENTITY,
                custom_and_mask: p.custom & 0x00ff_ffff | 0xff00_0000,
                offset_and_flags: flags.as_raw() << 24,
                // SAFETY: the structure is alive: `placed` borrows it.
                structure: unsafe { functions.get_acceleration_structure_device_address(&info) },
            }
        };
        let instances: Vec<InstanceWords> = placed.iter().map(words).collect();
        let buffer = Buffer::structure_input(gpu, "instances of the ray structure", &instances)?;
        let data = vk::AccelerationStructureGeometryInstancesDataKHR::default()
            .data(vk::DeviceOrHostAddressConstKHR { device_address: buffer.address() });
        let geometry = vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::INSTANCES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data });
        let range = vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(instances.len() as u32);
        let below: Vec<&Buffer> = placed.iter().map(|p| &p.structure.memory).collect();
        Self::build(gpu, vk::AccelerationStructureTypeKHR::TOP_LEVEL, geometry, range, &buffer, &below)
    }

    /// Asks for the sizes, allocates the memory, builds, and waits for the build.
    fn build(
        gpu: &Rc<Gpu>,
        kind: vk::AccelerationStructureTypeKHR,
        geometry: vk::AccelerationStructureGeometryKHR<'_>,
        range: vk::AccelerationStructureBuildRangeInfoKHR,
        input: &Buffer,
        below: &[&Buffer],
    ) -> Result<Self, GpuError> {
        let RayTracing { functions, scratch_alignment } = gpu.ray_tracing()?;
        let geometries = [geometry];
        let mut info = vk::AccelerationStructureBuildGeometryInfoKHR::default()
            .ty(kind)
            .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
            .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
            .geometries(&geometries);
        let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
        let device_build = vk::AccelerationStructureBuildTypeKHR::DEVICE;
        // SAFETY: `info` names one geometry and the counts are for it.
        unsafe {
            functions.get_acceleration_structure_build_sizes(device_build, &info, &[range.primitive_count], &mut sizes);
        }
        let memory = Buffer::structure(gpu, "ray structure", sizes.acceleration_structure_size)?;
        let create = vk::AccelerationStructureCreateInfoKHR::default()
            .buffer(memory.raw)
            .size(sizes.acceleration_structure_size)
            .ty(kind);
        // SAFETY: the buffer is as large as asked for and lives as long as the structure, which goes first.
        let raw = unsafe { functions.create_acceleration_structure(&create, None) }
            .called("vkCreateAccelerationStructureKHR")?;
        let made = AccelerationStructure { raw, memory, gpu: Rc::clone(gpu) };
        let scratch =
            Buffer::structure(gpu, "scratch of a ray structure", sizes.build_scratch_size + scratch_alignment)?;
        info.dst_acceleration_structure = raw;
        info.scratch_data =
            vk::DeviceOrHostAddressKHR { device_address: scratch.address().next_multiple_of(*scratch_alignment) };
        let mut frame = Frame::begin(gpu)?;
        frame.use_buffer(input, Use::STRUCTURE_INPUT);
        below.iter().for_each(|b| frame.use_buffer(b, Use::STRUCTURE_BUILD_READ));
        frame.use_buffer(&made.memory, Use::STRUCTURE_BUILD);
        frame.use_buffer(&scratch, Use::STRUCTURE_BUILD);
        // SAFETY: input, scratch and memory outlive the frame, which is waited for below; one range for one geometry.
        unsafe { functions.cmd_build_acceleration_structures(frame.commands, &[info], &[&[range]]) };
        frame.finish()?;
        Ok(made)
    }

    /// Bytes on the device.
    pub fn size(&self) -> u64 {
        self.memory.size()
    }
}

impl Drop for AccelerationStructure {
    fn drop(&mut self) {
        if let Ok(ray_tracing) = self.gpu.ray_tracing() {
            // SAFETY: frames wait before they return, so nothing on the device uses it; its memory goes after it.
            unsafe { ray_tracing.functions.destroy_acceleration_structure(self.raw, None) };
        }
    }
}
