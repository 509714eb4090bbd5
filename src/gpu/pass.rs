//! A compute pass: one shader, whose pipeline is made from what its first dispatch binds.
//!
//! ```ignore
//! frame.compute(&self.trace).sampled(&pyramid).write(&hits).constants(&params).dispatch_stereo(extent)?;
//! ```
//! The chain assigns bindings 0, 1, … of set 0 in its order. The barriers follow from its methods `sampled`, `write`, ….

use std::cell::OnceCell;
use std::rc::Rc;

use ash::vk;

use super::access::Use;
use super::pipelines::{Pipeline, PipelineKey};
use super::texture::set_layout;
use super::{AccelerationStructure, Buffer, Called, Frame, Gpu, GpuError, Image, Sampler};

/// A compute shader with its specialisation constants.
pub struct ComputePass {
    name: &'static str,
    module: vk::ShaderModule,
    specialization: Vec<u32>,
    bound: OnceCell<(PipelineKey, Pipeline)>,
    gpu: Rc<Gpu>,
}

impl ComputePass {
    /// `specialization[i]` is the value of constant id i, as a word (booleans are 0 or 1).
    ///
    /// # Errors
    /// When Vulkan refuses the shader module.
    pub fn new(
        gpu: &Rc<Gpu>,
        name: &'static str,
        spirv: &[u32],
        specialization: &[u32],
    ) -> Result<ComputePass, GpuError> {
        let module = gpu.pipelines.module(&gpu.device, spirv)?;
        let specialization = specialization.to_vec();
        Ok(ComputePass { name, module, specialization, bound: OnceCell::new(), gpu: Rc::clone(gpu) })
    }

    fn pipeline(&self, kinds: &[vk::DescriptorType], constant_bytes: u32) -> Result<Pipeline, GpuError> {
        if let Some((key, pipeline)) = self.bound.get() {
            assert_eq!(key.kinds, kinds, "every dispatch of `{}` binds the same descriptor types", self.name);
            assert_eq!(key.constant_bytes, constant_bytes, "`{}` has constants of another size", self.name);
            return Ok(*pipeline);
        }
        let key = PipelineKey {
            modules: vec![self.module],
            specialization: self.specialization.clone(),
            kinds: kinds.to_vec(),
            constant_bytes,
            raster: None,
        };
        let pipeline = self.gpu.pipelines.get(key.clone(), |key| make(&self.gpu, key))?;
        Ok(self.bound.get_or_init(|| (key, pipeline)).1)
    }
}

fn make(gpu: &Gpu, key: &PipelineKey) -> Result<Pipeline, GpuError> {
    let device = &gpu.device;
    // SAFETY: the device is alive, and infos live for their calls. A failure half-way leaks two small layouts, but ends the
    // program.
    unsafe {
        let set_layout = set_layout(gpu, &key.kinds, vk::ShaderStageFlags::COMPUTE)?;
        let set_layouts = [set_layout];
        let ranges =
            [vk::PushConstantRange { stage_flags: vk::ShaderStageFlags::COMPUTE, offset: 0, size: key.constant_bytes }];
        let layout_info = vk::PipelineLayoutCreateInfo::default()
            .set_layouts(&set_layouts)
            .push_constant_ranges(if key.constant_bytes > 0 { &ranges } else { &[] });
        let layout = device.create_pipeline_layout(&layout_info, None).called("vkCreatePipelineLayout")?;
        let entries = specialization_entries(&key.specialization);
        let specialization =
            vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(&key.specialization));
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(key.modules[0])
            .name(c"main")
            .specialization_info(&specialization);
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout)];
        let raw = device
            .create_compute_pipelines(gpu.pipeline_cache, &info, None)
            .map_err(|(_, result)| result)
            .called("vkCreateComputePipelines")?[0];
        Ok(Pipeline { set_layout, layout, raw })
    }
}

/// Constant id i is word i.
pub(super) fn specialization_entries(words: &[u32]) -> Vec<vk::SpecializationMapEntry> {
    (0..words.len())
        .map(|i| vk::SpecializationMapEntry { constant_id: i as u32, offset: 4 * i as u32, size: 4 })
        .collect()
}

/// A resource, ready to be written into a descriptor set.
pub(super) enum BoundResource {
    Image(vk::DescriptorType, vk::DescriptorImageInfo),
    Buffer(vk::DescriptorType, vk::DescriptorBufferInfo),
    Structure(vk::AccelerationStructureKHR),
}

impl BoundResource {
    pub(super) fn sampled(image: &Image, sampler: &Sampler) -> BoundResource {
        let info = vk::DescriptorImageInfo {
            sampler: sampler.raw,
            image_view: image.view,
            image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        };
        BoundResource::Image(vk::DescriptorType::COMBINED_IMAGE_SAMPLER, info)
    }

    pub(super) fn buffer(buffer: &Buffer, kind: vk::DescriptorType) -> BoundResource {
        BoundResource::Buffer(kind, vk::DescriptorBufferInfo { buffer: buffer.raw, offset: 0, range: vk::WHOLE_SIZE })
    }

    pub(super) fn kind(&self) -> vk::DescriptorType {
        match self {
            BoundResource::Image(kind, _) | BoundResource::Buffer(kind, _) => *kind,
            BoundResource::Structure(_) => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
        }
    }
}

impl Frame {
    /// Allocates a descriptor set from the frame's pool and writes these descriptors into it. It lives as long as the frame.
    pub(super) fn bind(
        &self,
        layout: vk::DescriptorSetLayout,
        bound: &[BoundResource],
    ) -> Result<vk::DescriptorSet, GpuError> {
        let layouts = [layout];
        let allocate = vk::DescriptorSetAllocateInfo::default().descriptor_pool(self.descriptors).set_layouts(&layouts);
        // SAFETY: pool and layout are alive.
        let set = unsafe { self.gpu.device.allocate_descriptor_sets(&allocate) }.called("vkAllocateDescriptorSets")?[0];
        let mut structures: Vec<_> = bound
            .iter()
            .map(|bound| match bound {
                BoundResource::Structure(raw) => vk::WriteDescriptorSetAccelerationStructureKHR::default()
                    .acceleration_structures(std::slice::from_ref(raw)),
                _ => vk::WriteDescriptorSetAccelerationStructureKHR::default(),
            })
            .collect();
        let writes: Vec<_> = bound
            .iter()
            .zip(&mut structures)
            .enumerate()
            .map(|(i, (bound, structure))| {
                let write = vk::WriteDescriptorSet::default().dst_set(set).dst_binding(i as u32);
                match bound {
                    BoundResource::Image(kind, info) => {
                        write.descriptor_type(*kind).image_info(std::slice::from_ref(info))
                    }
                    BoundResource::Buffer(kind, info) => {
                        write.descriptor_type(*kind).buffer_info(std::slice::from_ref(info))
                    }
                    BoundResource::Structure(_) => {
                        write.descriptor_type(bound.kind()).descriptor_count(1).push_next(structure)
                    }
                }
            })
            .collect();
        // SAFETY: the set is new, so no command uses it yet; the infos live for the call.
        unsafe { self.gpu.device.update_descriptor_sets(&writes, &[]) };
        Ok(set)
    }
}

/// A dispatch being declared.
#[must_use = "a pass does nothing until it is dispatched"]
pub struct Dispatch<'f> {
    frame: &'f mut Frame,
    pass: &'f ComputePass,
    bound: Vec<BoundResource>,
    constants: Vec<u8>,
}

impl Frame {
    /// Declares a dispatch of `pass`.
    pub fn compute<'f>(&'f mut self, pass: &'f ComputePass) -> Dispatch<'f> {
        Dispatch { frame: self, pass, bound: Vec::new(), constants: Vec::new() }
    }
}

impl<'f> Dispatch<'f> {
    /// A `sampler2D`/`sampler2DArray` (or its integer kinds) that is fetched or filtered.
    pub fn sampled(mut self, image: &'f Image, sampler: &'f Sampler) -> Self {
        self.frame.use_image(image, Use::SAMPLED);
        self.bound.push(BoundResource::sampled(image, sampler));
        self
    }

    /// A storage image, mip 0, that the pass only writes.
    pub fn write(self, image: &'f Image) -> Self {
        self.storage(image, 0, Use::STORAGE_WRITE)
    }

    /// One mip of a storage image that the pass only writes.
    pub fn write_mip(self, image: &'f Image, mip: usize) -> Self {
        self.storage(image, mip, Use::STORAGE_WRITE)
    }

    /// A storage image, mip 0, that the pass reads and writes.
    pub fn read_write(self, image: &'f Image) -> Self {
        self.storage(image, 0, Use::STORAGE_READ_WRITE)
    }

    fn storage(mut self, image: &'f Image, mip: usize, how: Use) -> Self {
        // Several mips of one image in one pass are a single use of the image.
        let again = self.bound.iter().any(|b| match b {
            BoundResource::Image(_, info) => image.mip_views.contains(&info.image_view),
            BoundResource::Buffer(..) | BoundResource::Structure(_) => false,
        });
        if !again {
            self.frame.use_image(image, how);
        }
        let info = vk::DescriptorImageInfo {
            sampler: vk::Sampler::null(),
            image_view: image.mip_views[mip],
            image_layout: vk::ImageLayout::GENERAL,
        };
        self.bound.push(BoundResource::Image(vk::DescriptorType::STORAGE_IMAGE, info));
        self
    }

    /// A storage buffer that is read.
    pub fn read_buffer(self, buffer: &'f Buffer) -> Self {
        self.buffer(buffer, vk::DescriptorType::STORAGE_BUFFER, Use::STORAGE_READ)
    }

    /// A storage buffer that is written, or read and written.
    pub fn write_buffer(self, buffer: &'f Buffer) -> Self {
        self.buffer(buffer, vk::DescriptorType::STORAGE_BUFFER, Use::STORAGE_READ_WRITE)
    }

    /// An acceleration structure through which the pass traces rays.
    pub fn structure(mut self, structure: &'f AccelerationStructure) -> Self {
        self.frame.use_buffer(&structure.memory, Use::STRUCTURE_READ);
        self.bound.push(BoundResource::Structure(structure.raw));
        self
    }

    /// A uniform buffer.
    pub fn uniform(self, buffer: &'f Buffer) -> Self {
        self.buffer(buffer, vk::DescriptorType::UNIFORM_BUFFER, Use::UNIFORM)
    }

    fn buffer(mut self, buffer: &'f Buffer, kind: vk::DescriptorType, how: Use) -> Self {
        self.frame.use_buffer(buffer, how);
        self.bound.push(BoundResource::buffer(buffer, kind));
        self
    }

    /// Adds bindings that several passes have in common, at this place of the chain.
    pub fn with(self, bind: impl FnOnce(Self) -> Self) -> Self {
        bind(self)
    }

    /// Push constants, at most 128 bytes.
    pub fn constants<T: bytemuck::NoUninit>(mut self, constants: &T) -> Self {
        self.constants = bytemuck::bytes_of(constants).to_vec();
        self
    }

    /// Dispatches one invocation for each pixel of each eye, in groups of 8×8×1 (the shader's local size).
    ///
    /// # Errors
    /// When Vulkan cannot make the pipeline or its descriptors.
    pub fn dispatch_stereo(self, (width, height): (u32, u32)) -> Result<(), GpuError> {
        self.dispatch(width.div_ceil(8), height.div_ceil(8), 2)
    }

    /// Dispatches this many groups.
    ///
    /// # Errors
    /// As [`Dispatch::dispatch_stereo`].
    pub fn dispatch(self, x: u32, y: u32, z: u32) -> Result<(), GpuError> {
        self.record(|device, commands| {
            // SAFETY: pipeline and descriptors were bound just before (see `record`).
            unsafe { device.cmd_dispatch(commands, x, y, z) }
        })
    }

    /// Dispatches as many groups as the three words at byte `offset` of `arguments` say.
    ///
    /// # Errors
    /// As [`Dispatch::dispatch_stereo`].
    pub fn dispatch_indirect(self, arguments: &'f Buffer, offset: u64) -> Result<(), GpuError> {
        self.frame.use_buffer(arguments, Use::INDIRECT);
        let raw = arguments.raw;
        self.record(|device, commands| {
            // SAFETY: as above; a pass of ours has written three words at `offset`.
            unsafe { device.cmd_dispatch_indirect(commands, raw, offset) }
        })
    }

    fn record(self, dispatch: impl FnOnce(&ash::Device, vk::CommandBuffer)) -> Result<(), GpuError> {
        let kinds: Vec<_> = self.bound.iter().map(BoundResource::kind).collect();
        let pipeline = self.pass.pipeline(&kinds, self.constants.len() as u32)?;
        let gpu = Rc::clone(&self.frame.gpu);
        let device = &gpu.device;
        let set = self.frame.bind(pipeline.set_layout, &self.bound)?;
        self.frame.start_pass(self.pass.name)?;
        let commands = self.frame.commands;
        // SAFETY: handles are alive and the layout is the pipeline's own.
        unsafe {
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, pipeline.raw);
            device.cmd_bind_descriptor_sets(commands, vk::PipelineBindPoint::COMPUTE, pipeline.layout, 0, &[set], &[]);
            if !self.constants.is_empty() {
                let stages = vk::ShaderStageFlags::COMPUTE;
                device.cmd_push_constants(commands, pipeline.layout, stages, 0, &self.constants);
            }
        }
        dispatch(device, commands);
        self.frame.end_pass()
    }
}
