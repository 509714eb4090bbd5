//! What a device that answers ray queries adds to Vulkan 1.3: extensions, functions, an alignment.

/// What a [`Gpu`] holds only if it has ray queries; see [`Gpu::has_ray_query`].
pub(super) struct RayTracing {
    pub(super) functions: ash::khr::acceleration_structure::Device,
    /// Required alignment of scratch memory, bytes.
    pub(super) scratch_alignment: u64,
}

/// The extensions that ray queries need besides Vulkan 1.3.
pub(super) const EXTENSIONS: [&std::ffi::CStr; 3] =
    [ash::khr::acceleration_structure::NAME, ash::khr::ray_query::NAME, ash::khr::deferred_host_operations::NAME];
