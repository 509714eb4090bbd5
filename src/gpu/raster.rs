//! A raster pass: one graphics pipeline that draws into one layer at a time.
//!
//! Each eye is drawn separately: multiview draws wrong layers on Mesa 22.3, and would save nothing on a software device.

use std::rc::Rc;

use ash::vk;

use super::access::Use;
use super::pass::{BoundResource, specialization_entries};
use super::pipelines::{Pipeline, PipelineKey, RasterKey};
use super::texture::set_layout;
use super::{Buffer, Called, Frame, Gpu, GpuError, Image, MaterialSets, Sampler};

/// What a raster pipeline is made of.
pub struct RasterPassDesc<'a> {
    pub name: &'static str,
    pub vertex: &'a [u32],
    pub fragment: &'a [u32],
    /// `specialization[i]` is the value of constant id i in both stages.
    pub specialization: &'a [u32],
    /// Bytes from vertex to vertex.
    pub vertex_stride: u32,
    /// Format and offset (bytes) of the attribute at each location.
    pub attributes: &'a [(vk::Format, u32)],
    pub colors: &'a [vk::Format],
    /// Size of the push constants of both stages, bytes.
    pub constant_bytes: u32,
    /// Descriptor types of the inputs, which are set 0.
    pub inputs: &'a [vk::DescriptorType],
    /// The materials' textures, which are set 1.
    pub materials: &'a MaterialSets,
}

/// A resource that the stages of a raster pass read; the n-th one is binding n.
pub enum Input<'a> {
    /// A uniform buffer.
    Uniform(&'a Buffer),
    /// A storage buffer.
    Buffer(&'a Buffer),
    /// A sampled image.
    Image(&'a Image, &'a Sampler),
}

impl Input<'_> {
    /// The descriptor type of [`Input::Uniform`].
    pub const UNIFORM: vk::DescriptorType = vk::DescriptorType::UNIFORM_BUFFER;
    /// The descriptor type of [`Input::Buffer`].
    pub const BUFFER: vk::DescriptorType = vk::DescriptorType::STORAGE_BUFFER;
    /// The descriptor type of [`Input::Image`].
    pub const IMAGE: vk::DescriptorType = vk::DescriptorType::COMBINED_IMAGE_SAMPLER;
}

/// A graphics pipeline with a reverse-Z depth test; the cull mode is set per draw.
pub struct RasterPass {
    name: &'static str,
    pipeline: Pipeline,
}

impl RasterPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, desc: &RasterPassDesc<'_>) -> Result<RasterPass, GpuError> {
        let module = |code| gpu.pipelines.module(&gpu.device, code);
        let key = PipelineKey {
            modules: vec![module(desc.vertex)?, module(desc.fragment)?],
            specialization: desc.specialization.to_vec(),
            kinds: desc.inputs.to_vec(),
            constant_bytes: desc.constant_bytes,
            raster: Some(RasterKey {
                vertex_stride: desc.vertex_stride,
                attributes: desc.attributes.to_vec(),
                colors: desc.colors.to_vec(),
                textures: desc.materials.textures,
            }),
        };
        let pipeline = gpu.pipelines.get(key, |key| make(gpu, desc, &key.modules))?;
        Ok(RasterPass { name: desc.name, pipeline })
    }
}

fn make(gpu: &Gpu, desc: &RasterPassDesc<'_>, modules: &[vk::ShaderModule]) -> Result<Pipeline, GpuError> {
    let device = &gpu.device;
    let entries = specialization_entries(desc.specialization);
    let specialization =
        vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(desc.specialization));
    let bindings = [vk::VertexInputBindingDescription {
        binding: 0,
        stride: desc.vertex_stride,
        input_rate: vk::VertexInputRate::VERTEX,
    }];
    let attributes: Vec<_> = desc
        .attributes
        .iter()
        .enumerate()
        .map(|(location, &(format, offset))| vk::VertexInputAttributeDescription {
            location: location as u32,
            binding: 0,
            format,
            offset,
        })
        .collect();
    let vertex_input = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(&bindings)
        .vertex_attribute_descriptions(&attributes);
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let rasterization = vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(vk::PolygonMode::FILL)
        .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
        .line_width(1.0);
    let multisample =
        vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(true)
        .depth_write_enable(true)
        .depth_compare_op(vk::CompareOp::GREATER);
    let blends: Vec<_> = desc
        .colors
        .iter()
        .map(|_| vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA))
        .collect();
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
    let dynamic_states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR, vk::DynamicState::CULL_MODE];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic_states);
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(desc.colors)
        .depth_attachment_format(vk::Format::D32_SFLOAT);
    let stage = |flag, module| {
        vk::PipelineShaderStageCreateInfo::default()
            .stage(flag)
            .module(module)
            .name(c"main")
            .specialization_info(&specialization)
    };
    let stages = [stage(vk::ShaderStageFlags::VERTEX, modules[0]), stage(vk::ShaderStageFlags::FRAGMENT, modules[1])];
    let both_stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
    let set_layout = set_layout(gpu, desc.inputs, both_stages)?;
    let set_layouts = [set_layout, desc.materials.layout];
    let ranges = [vk::PushConstantRange { stage_flags: both_stages, offset: 0, size: desc.constant_bytes }];
    let layout_info = vk::PipelineLayoutCreateInfo::default().set_layouts(&set_layouts).push_constant_ranges(&ranges);
    // SAFETY: everything pointed to lives for these calls.
    unsafe {
        let layout = device.create_pipeline_layout(&layout_info, None).called("vkCreatePipelineLayout")?;
        let info = [vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&rasterization)
            .multisample_state(&multisample)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(layout)
            .push_next(&mut rendering)];
        let raw = device
            .create_graphics_pipelines(gpu.pipeline_cache, &info, None)
            .map_err(|(_, result)| result)
            .called("vkCreateGraphicsPipelines")?[0];
        Ok(Pipeline { set_layout, layout, raw })
    }
}

/// A colour attachment and the value to which it is cleared.
pub struct Target<'a> {
    pub image: &'a Image,
    pub clear: vk::ClearColorValue,
}

impl<'a> Target<'a> {
    /// Cleared to zero, whatever the format.
    pub fn zeroed(image: &'a Image) -> Target<'a> {
        Target { image, clear: vk::ClearColorValue { uint32: [0; 4] } }
    }
}

/// The attachments of a raster pass.
#[derive(Clone, Copy)]
pub struct Targets<'a> {
    pub colors: &'a [Target<'a>],
    pub depth: &'a Image,
}

/// The buffers and textures that the draws of a raster pass use.
#[derive(Clone, Copy)]
pub struct Geometry<'a> {
    pub vertices: &'a Buffer,
    pub indices: &'a Buffer,
    pub materials: &'a MaterialSets,
}

/// Records draws into one layer.
pub struct Draws<'a> {
    gpu: &'a Gpu,
    commands: vk::CommandBuffer,
    layout: vk::PipelineLayout,
    materials: &'a MaterialSets,
    material: Option<usize>,
    cull: Option<vk::CullModeFlags>,
}

impl Frame {
    /// Clears one layer of the targets (depth to 0, which is infinitely far) and lets `draw` record draws into it.
    ///
    /// # Errors
    /// When Vulkan cannot make the descriptors.
    pub fn raster(
        &mut self,
        pass: &RasterPass,
        layer: usize,
        targets: &Targets<'_>,
        inputs: &[Input<'_>],
        geometry: &Geometry<'_>,
        draw: impl FnOnce(&mut Draws<'_>),
    ) -> Result<(), GpuError> {
        let Targets { colors, depth } = *targets;
        let mut bound = Vec::new();
        for input in inputs {
            bound.push(match input {
                Input::Uniform(buffer) => {
                    self.use_buffer(buffer, Use::UNIFORM_RASTER);
                    BoundResource::buffer(buffer, Input::UNIFORM)
                }
                Input::Buffer(buffer) => {
                    self.use_buffer(buffer, Use::STORAGE_READ_RASTER);
                    BoundResource::buffer(buffer, Input::BUFFER)
                }
                Input::Image(image, sampler) => {
                    self.use_image(image, Use::SAMPLED_FRAGMENT);
                    BoundResource::sampled(image, sampler)
                }
            });
        }
        let set = self.bind(pass.pipeline.set_layout, &bound)?;
        for target in colors {
            self.use_image(target.image, Use::COLOR);
        }
        self.use_image(depth, Use::DEPTH);
        let (width, height) = depth.extent();
        let area = vk::Rect2D { offset: vk::Offset2D { x: 0, y: 0 }, extent: vk::Extent2D { width, height } };
        let attachments: Vec<_> = colors
            .iter()
            .map(|t| {
                vk::RenderingAttachmentInfo::default()
                    .image_view(t.image.layer_views[layer])
                    .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
                    .load_op(vk::AttachmentLoadOp::CLEAR)
                    .store_op(vk::AttachmentStoreOp::STORE)
                    .clear_value(vk::ClearValue { color: t.clear })
            })
            .collect();
        let far = vk::ClearValue { depth_stencil: vk::ClearDepthStencilValue { depth: 0.0, stencil: 0 } };
        let depth_attachment = vk::RenderingAttachmentInfo::default()
            .image_view(depth.layer_views[layer])
            .image_layout(vk::ImageLayout::DEPTH_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(far);
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&attachments)
            .depth_attachment(&depth_attachment);
        // The negative height makes y point up in clip space, with row 0 at the image's top.
        let viewport = vk::Viewport {
            x: 0.0,
            y: height as f32,
            width: width as f32,
            height: -(height as f32),
            min_depth: 0.0,
            max_depth: 1.0,
        };
        self.start_pass(pass.name)?;
        let gpu = Rc::clone(&self.gpu);
        let device = &gpu.device;
        let commands = self.commands;
        // SAFETY: attachments are in the declared layouts (barriers above), handles outlive the frame.
        unsafe {
            device.cmd_begin_rendering(commands, &info);
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, pass.pipeline.raw);
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_set_scissor(commands, 0, &[area]);
            device.cmd_bind_vertex_buffers(commands, 0, &[geometry.vertices.raw], &[0]);
            device.cmd_bind_index_buffer(commands, geometry.indices.raw, 0, vk::IndexType::UINT32);
            device.cmd_bind_descriptor_sets(
                commands,
                vk::PipelineBindPoint::GRAPHICS,
                pass.pipeline.layout,
                0,
                &[set],
                &[],
            );
        }
        let mut draws = Draws {
            gpu: &gpu,
            commands,
            layout: pass.pipeline.layout,
            materials: geometry.materials,
            material: None,
            cull: None,
        };
        draw(&mut draws);
        // SAFETY: rendering was begun above.
        unsafe { device.cmd_end_rendering(commands) };
        self.end_pass()
    }
}

impl Draws<'_> {
    /// Push constants for the draws that follow.
    pub fn constants<T: bytemuck::NoUninit>(&mut self, constants: &T) {
        let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        // SAFETY: inside rendering with the pipeline bound; validation checks the size in tests.
        unsafe {
            self.gpu.device.cmd_push_constants(self.commands, self.layout, stages, 0, bytemuck::bytes_of(constants));
        }
    }

    /// Draws `count` indices from index `first` on. `vertex` is added to each index; `instance` arrives as `gl_InstanceIndex`.
    pub fn indexed(
        &mut self,
        material: usize,
        cull: vk::CullModeFlags,
        first: u32,
        count: u32,
        vertex: i32,
        instance: u32,
    ) {
        // SAFETY: inside rendering with the pipeline bound; ranges come from the same upload that made the buffers.
        unsafe {
            let device = &self.gpu.device;
            if self.material != Some(material) {
                self.material = Some(material);
                device.cmd_bind_descriptor_sets(
                    self.commands,
                    vk::PipelineBindPoint::GRAPHICS,
                    self.layout,
                    1,
                    &[self.materials.sets[material]],
                    &[],
                );
            }
            if self.cull != Some(cull) {
                self.cull = Some(cull);
                device.cmd_set_cull_mode(self.commands, cull);
            }
            device.cmd_draw_indexed(self.commands, count, 1, first, vertex, instance);
        }
    }
}
