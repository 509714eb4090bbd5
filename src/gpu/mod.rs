//! The thin Vulkan 1.3 layer: a device, its memory, and passes whose barriers follow from what they read and write.
//!
//! `render`, `compare`, `stress`, the displays and the commands use it. Nothing here knows of scenes or reflections. There is one
//! queue and one thread, so owners are `Rc` and tracked state is `Cell`.

mod acceleration;
mod access;
mod buffer;
mod context;
mod create;
mod foreign;
mod frame;
mod image;
mod pass;
mod pipelines;
mod raster;
mod ray_tracing;
mod spirv;
mod surface;
mod swapchain;
mod texture;
mod transfer;

pub use acceleration::{AccelerationStructure, StructureInstance, Triangles};
pub use access::Use;
pub use buffer::Buffer;
pub use context::{DeviceInfo, Gpu, GpuOptions};
pub use create::{Creator, OwnDevice, list_devices};
pub use foreign::{Canvas, UploadPool};
pub use frame::{Frame, PassTime};
pub use image::{Image, ImageDesc};
pub use pass::{ComputePass, Dispatch};
pub use raster::{Draws, Geometry, Input, RasterPass, RasterPassDesc, Target, Targets};
pub use spirv::{Aligned, Shader};
pub use surface::{Surface, WithSurface};
pub use swapchain::{PresentOutcome, Swapchain};
pub use texture::{Filter, MaterialSets, Sampler};
pub use transfer::{read_buffer, read_image};

/// The errors of this layer.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// The machine has no Vulkan loader.
    #[error("no Vulkan loader was found ({0}); `./x doctor` names the package that brings it")]
    NoLoader(String),
    /// There is a loader, but no device that can render.
    #[error("no Vulkan 1.3 device was found{0}; `cyclopean doctor` says what is missing")]
    NoDevice(String),
    /// The device lacks something that the renderer cannot do without.
    #[error("device `{device}` lacks {what}, which this renderer needs")]
    Lacks { device: String, what: String },
    /// Validation was asked for and is not installed.
    #[error("the Vulkan validation layer is not installed (Debian: vulkan-validationlayers)")]
    NoValidation,
    /// A window cannot be drawn into.
    #[error("the window cannot be drawn into: {0}")]
    Surface(String),
    /// A Vulkan call failed.
    #[error("{call} failed: {result}")]
    Vulkan { call: &'static str, result: ash::vk::Result },
    /// Another maker of the device, such as an OpenXR runtime, refused.
    #[error("{call} failed: {result}")]
    Runtime { call: &'static str, result: String },
    /// Device memory could not be allocated.
    #[error("no device memory for {what} ({bytes} bytes): {reason}")]
    Memory { what: String, bytes: u64, reason: String },
    /// The validation layer gave messages.
    #[error("the Vulkan validation layer gave {count} message(s); the first: {first}")]
    Validation { count: usize, first: String },
}

/// Adds the name of the Vulkan call to its error.
pub(crate) trait Called<T> {
    fn called(self, call: &'static str) -> Result<T, GpuError>;
}

impl<T> Called<T> for Result<T, ash::vk::Result> {
    fn called(self, call: &'static str) -> Result<T, GpuError> {
        self.map_err(|result| GpuError::Vulkan { call, result })
    }
}
