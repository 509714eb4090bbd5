//! The shader modules and pipelines of a device. Passes ask for theirs here.
//!
//! Each is made once and kept as long as the device. A program makes the same passes again for every scene and method, and
//! compiling their shaders takes most of the time of a small picture.

use std::cell::RefCell;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

use ash::vk;

use super::{Called, GpuError};

/// Everything that a pipeline is made of.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct PipelineKey {
    /// The modules of the stages, in their order.
    pub modules: Vec<vk::ShaderModule>,
    /// `specialization[i]` is the value of constant id i in every stage.
    pub specialization: Vec<u32>,
    /// The types of the descriptors of set 0.
    pub kinds: Vec<vk::DescriptorType>,
    pub constant_bytes: u32,
    /// `None`: a compute pipeline.
    pub raster: Option<RasterKey>,
}

/// What only raster pipelines have.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct RasterKey {
    pub vertex_stride: u32,
    /// Format and offset (bytes) of the attribute at each location.
    pub attributes: Vec<(vk::Format, u32)>,
    pub colors: Vec<vk::Format>,
    /// The number of textures of a material, which are set 1.
    pub textures: usize,
}

/// A pipeline, its layout and the layout of its set 0. They live as long as the device.
#[derive(Clone, Copy)]
pub(super) struct Pipeline {
    pub set_layout: vk::DescriptorSetLayout,
    pub layout: vk::PipelineLayout,
    pub raw: vk::Pipeline,
}

/// What was made so far.
#[derive(Default)]
pub(super) struct Pipelines {
    modules: RefCell<HashMap<Vec<u32>, vk::ShaderModule>>,
    made: RefCell<HashMap<PipelineKey, Pipeline>>,
}

impl Pipelines {
    /// The module of a shader.
    ///
    /// # Errors
    /// When Vulkan refuses the shader.
    pub fn module(&self, device: &ash::Device, spirv: &[u32]) -> Result<vk::ShaderModule, GpuError> {
        if let Some(&module) = self.modules.borrow().get(spirv) {
            return Ok(module);
        }
        let info = vk::ShaderModuleCreateInfo::default().code(spirv);
        // SAFETY: `spirv` is what the shader compiler made at build time.
        let module = unsafe { device.create_shader_module(&info, None) }.called("vkCreateShaderModule")?;
        self.modules.borrow_mut().insert(spirv.to_vec(), module);
        Ok(module)
    }

    /// The pipeline of a key, which `make` makes the first time.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn get(
        &self,
        key: PipelineKey,
        make: impl FnOnce(&PipelineKey) -> Result<Pipeline, GpuError>,
    ) -> Result<Pipeline, GpuError> {
        match self.made.borrow_mut().entry(key) {
            Entry::Occupied(made) => Ok(*made.get()),
            Entry::Vacant(place) => {
                let pipeline = make(place.key())?;
                Ok(*place.insert(pipeline))
            }
        }
    }

    /// Destroys everything.
    ///
    /// # Safety
    /// `device` is the one that made all of it, and it is idle. Nothing may be asked for afterwards.
    pub unsafe fn destroy(&self, device: &ash::Device) {
        // SAFETY: the caller vouches for it.
        unsafe {
            for (_, pipeline) in self.made.borrow_mut().drain() {
                device.destroy_pipeline(pipeline.raw, None);
                device.destroy_pipeline_layout(pipeline.layout, None);
                device.destroy_descriptor_set_layout(pipeline.set_layout, None);
            }
            for (_, module) in self.modules.borrow_mut().drain() {
                device.destroy_shader_module(module, None);
            }
        }
    }
}
