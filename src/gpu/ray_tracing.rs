//! What a device that answers ray queries adds to Vulkan 1.3: extensions, functions, an alignment.

/// What a device with ray queries adds; see [`Gpu::has_ray_query`].
pub(super) struct RayTracing {
    pub(super) functions: ash::khr::acceleration_structure::Device,
    /// Of scratch memory, bytes.
    pub(super) scratch_alignment: u64,
}

/// The extensions that ray queries need, apart from what Vulkan 1.3 has.
pub(super) const EXTENSIONS: [&std::ffi::CStr; 3] =
    [ash::khr::acceleration_structure::NAME, ash::khr::ray_query::NAME, ash::khr::deferred_host_operations::NAME];
