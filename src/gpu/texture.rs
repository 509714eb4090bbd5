//! Samplers, and descriptor sets with the textures of each material for raster passes.

use std::rc::Rc;

use ash::vk;

use super::{Called, Gpu, GpuError, Image};

/// How a texture is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Filter {
    pub linear: bool,
    pub wrap_u: vk::SamplerAddressMode,
    pub wrap_v: vk::SamplerAddressMode,
    /// Up to 16 taps along the longer axis of the footprint.
    pub anisotropic: bool,
}

impl Filter {
    /// Texel fetches, clamped.
    pub const NEAREST: Filter = Filter {
        linear: false,
        wrap_u: vk::SamplerAddressMode::CLAMP_TO_EDGE,
        wrap_v: vk::SamplerAddressMode::CLAMP_TO_EDGE,
        anisotropic: false,
    };
    /// Bilinear, clamped.
    pub const LINEAR: Filter = Filter { linear: true, ..Filter::NEAREST };
    /// Bilinear, repeated around the horizon and clamped at the poles.
    pub const EQUIRECT: Filter = Filter { wrap_u: vk::SamplerAddressMode::REPEAT, ..Filter::LINEAR };
}

/// An immutable sampler.
pub struct Sampler {
    pub(super) raw: vk::Sampler,
    gpu: Rc<Gpu>,
}

impl Sampler {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, filter: Filter) -> Result<Sampler, GpuError> {
        let (taps, mips) = match filter.linear {
            true => (vk::Filter::LINEAR, vk::SamplerMipmapMode::LINEAR),
            false => (vk::Filter::NEAREST, vk::SamplerMipmapMode::NEAREST),
        };
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(taps)
            .min_filter(taps)
            .mipmap_mode(mips)
            .address_mode_u(filter.wrap_u)
            .address_mode_v(filter.wrap_v)
            .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE)
            .anisotropy_enable(filter.anisotropic)
            .max_anisotropy(if filter.anisotropic { gpu.limits.max_sampler_anisotropy.min(16.0) } else { 1.0 })
            .max_lod(vk::LOD_CLAMP_NONE);
        // SAFETY: the device is alive; `info` lives for the call.
        let raw = unsafe { gpu.device.create_sampler(&info, None) }.called("vkCreateSampler")?;
        Ok(Sampler { raw, gpu: Rc::clone(gpu) })
    }
}

impl Drop for Sampler {
    fn drop(&mut self) {
        // SAFETY: frames wait before they return, so nothing uses the sampler any more.
        unsafe { self.gpu.device.destroy_sampler(self.raw, None) };
    }
}

/// For each material a descriptor set with its textures, which is set 1 of raster passes.
pub struct MaterialSets {
    pub(super) layout: vk::DescriptorSetLayout,
    pub(super) sets: Vec<vk::DescriptorSet>,
    /// The number of textures in each set.
    pub(super) textures: usize,
    pool: vk::DescriptorPool,
    gpu: Rc<Gpu>,
}

impl MaterialSets {
    /// `materials[m][i]` becomes binding i of material m's set. The caller must keep images and samplers alive as long as the
    /// sets.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new<const TEXTURES: usize>(
        gpu: &Rc<Gpu>,
        materials: &[[(&Image, &Sampler); TEXTURES]],
    ) -> Result<MaterialSets, GpuError> {
        let device = &gpu.device;
        let kind = vk::DescriptorType::COMBINED_IMAGE_SAMPLER;
        let layout = set_layout(gpu, &[kind; TEXTURES], vk::ShaderStageFlags::FRAGMENT)?;
        let pool = vk::DescriptorPool::null();
        let mut made = MaterialSets { layout, sets: Vec::new(), textures: TEXTURES, pool, gpu: Rc::clone(gpu) };
        if materials.is_empty() {
            return Ok(made);
        }
        let descriptor_count = (TEXTURES * materials.len()) as u32;
        let sizes = [vk::DescriptorPoolSize { ty: kind, descriptor_count }];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(materials.len() as u32).pool_sizes(&sizes);
        // SAFETY: the device is alive; infos and what they point to live for their calls; the sets are new, so no
        // command buffer uses them while they are written.
        unsafe {
            made.pool = device.create_descriptor_pool(&info, None).called("vkCreateDescriptorPool")?;
            let layouts = vec![layout; materials.len()];
            let allocate = vk::DescriptorSetAllocateInfo::default().descriptor_pool(made.pool).set_layouts(&layouts);
            made.sets = device.allocate_descriptor_sets(&allocate).called("vkAllocateDescriptorSets")?;
            for (&set, textures) in made.sets.iter().zip(materials) {
                for (binding, (image, sampler)) in textures.iter().enumerate() {
                    let info = [vk::DescriptorImageInfo {
                        sampler: sampler.raw,
                        image_view: image.view,
                        image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
                    }];
                    let write = vk::WriteDescriptorSet::default()
                        .dst_set(set)
                        .dst_binding(binding as u32)
                        .descriptor_type(kind)
                        .image_info(&info);
                    device.update_descriptor_sets(&[write], &[]);
                }
            }
        }
        Ok(made)
    }
}

impl Drop for MaterialSets {
    fn drop(&mut self) {
        // SAFETY: frames wait before they return, so no command buffer uses the sets. Pipeline layouts may outlive the set layout
        // from which they were made. Null handles are ignored.
        unsafe {
            self.gpu.device.destroy_descriptor_pool(self.pool, None);
            self.gpu.device.destroy_descriptor_set_layout(self.layout, None);
        }
    }
}

/// A descriptor set layout with bindings 0, 1, … of these types.
pub(super) fn set_layout(
    gpu: &Gpu,
    kinds: &[vk::DescriptorType],
    stages: vk::ShaderStageFlags,
) -> Result<vk::DescriptorSetLayout, GpuError> {
    let bindings: Vec<_> = kinds
        .iter()
        .enumerate()
        .map(|(binding, &kind)| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding as u32)
                .descriptor_type(kind)
                .descriptor_count(1)
                .stage_flags(stages)
        })
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
    // SAFETY: the device is alive; `info` lives for the call.
    unsafe { gpu.device.create_descriptor_set_layout(&info, None) }.called("vkCreateDescriptorSetLayout")
}
