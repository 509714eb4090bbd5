//! Uploads a scene: geometry, materials, textures, environment. Instances and lights are relative to the head, so `Context`
//! uploads them for each prepared view.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::rc::Rc;

use ash::vk;
use glam::{DAffine3, DMat3, DVec3};

use crate::gpu::{Buffer, Filter, Gpu, GpuError, Image, ImageDesc, MaterialSets, Sampler};
use crate::scene::{Alpha, Environment, Equirect, LightSource, Material, Scene, Texture, TextureRef, Wrap};

use super::mips::mip_chain;
use super::shared::{InstanceData, LightData, MaterialData, TextureSlot, Vertex};

/// Where a primitive lies in the buffers of all vertices and indices.
#[derive(Debug, Clone, Copy)]
pub struct PrimitiveRange {
    pub first_vertex: u32,
    pub first_index: u32,
    pub index_count: u32,
}

/// The maps of an environment, or of a probe, with their sampler.
pub struct EnvironmentMaps {
    pub radiance: Image,
    pub irradiance: Image,
    /// The prefiltered levels one below the other, each twice as wide as high.
    pub specular: Image,
    pub sampler: Sampler,
}

/// A scene's resources on the device.
pub struct SceneResources {
    pub vertices: Buffer,
    pub indices: Buffer,
    pub materials: Buffer,
    pub ranges: Vec<PrimitiveRange>,
    pub material_sets: MaterialSets,
    pub environment: EnvironmentMaps,
    // Kept alive because the descriptor sets refer to them.
    _textures: Vec<Image>,
    _samplers: HashMap<Filter, Sampler>,
    _plain: Image,
}

impl SceneResources {
    /// Uploads everything that does not depend on the head.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn new(gpu: &Rc<Gpu>, scene: &Scene) -> Result<SceneResources, GpuError> {
        let (vertices, indices, ranges) = geometry(scene);
        let materials: Vec<MaterialData> = scene.materials.iter().map(material_data).collect();

        let mut textures = Vec::new();
        for texture in &scene.textures {
            textures.push(upload_texture(gpu, texture)?);
        }
        let mut samplers = HashMap::new();
        for texture in &scene.textures {
            let filter = filter_of(gpu, texture);
            if let Entry::Vacant(place) = samplers.entry(filter) {
                place.insert(Sampler::new(gpu, filter)?);
            }
        }
        let plain_desc = ImageDesc::texture(1, 1, 1, vk::Format::R8G8B8A8_UNORM);
        let plain = Image::with_content(gpu, "plain", plain_desc, &[vec![255; 4]])?;
        if samplers.is_empty() {
            samplers.insert(Filter::LINEAR, Sampler::new(gpu, Filter::LINEAR)?);
        }
        let any = samplers.values().next().expect("one was put in above");
        let bound: Vec<[(&Image, &Sampler); 4]> = scene
            .materials
            .iter()
            .map(|m| {
                slots(m).map(|slot| match slot {
                    Some(t) => (&textures[t.texture], &samplers[&filter_of(gpu, &scene.textures[t.texture])]),
                    None => (&plain, any),
                })
            })
            .collect();
        let material_sets = MaterialSets::new(gpu, &bound)?;
        Ok(SceneResources {
            vertices: Buffer::with_content(gpu, "vertices", &vertices)?,
            indices: Buffer::with_content(gpu, "indices", &indices)?,
            materials: Buffer::with_content(gpu, "materials", &materials)?,
            ranges,
            material_sets,
            environment: EnvironmentMaps::new(gpu, &scene.environment)?,
            _textures: textures,
            _samplers: samplers,
            _plain: plain,
        })
    }
}

impl EnvironmentMaps {
    /// Uploads an environment; also a probe's.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn new(gpu: &Rc<Gpu>, environment: &Environment) -> Result<EnvironmentMaps, GpuError> {
        let levels = environment.specular.len().max(1) as u32;
        let first = environment.specular.first().unwrap_or(&environment.irradiance);
        let stacked = Equirect {
            width: first.width,
            height: first.height * levels,
            texels: match environment.specular.is_empty() {
                true => environment.irradiance.texels.clone(),
                false => environment.specular.iter().flat_map(|l| l.texels.iter().copied()).collect(),
            },
        };
        Ok(EnvironmentMaps {
            radiance: upload_equirect(gpu, "environment", &environment.radiance)?,
            irradiance: upload_equirect(gpu, "irradiance", &environment.irradiance)?,
            specular: upload_equirect(gpu, "specular environment", &stacked)?,
            sampler: Sampler::new(gpu, Filter::EQUIRECT)?,
        })
    }
}

/// The four textures of a material, in the order of its descriptor set.
pub fn slots(m: &Material) -> [Option<&TextureRef>; 4] {
    [
        m.base_color_texture.as_ref(),
        m.metallic_roughness_texture.as_ref(),
        m.normal_texture.as_ref(),
        m.emissive_texture.as_ref(),
    ]
}

/// The vertices and indices of all primitives, and where each primitive lies among them.
pub fn geometry(scene: &Scene) -> (Vec<Vertex>, Vec<u32>, Vec<PrimitiveRange>) {
    let (mut vertices, mut indices, mut ranges) = (Vec::new(), Vec::new(), Vec::new());
    for p in &scene.primitives {
        ranges.push(PrimitiveRange {
            first_vertex: vertices.len() as u32,
            first_index: indices.len() as u32,
            index_count: p.indices.len() as u32,
        });
        for i in 0..p.positions.len() {
            let c = p.colors[i].to_array().map(|x| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
            vertices.push(Vertex {
                position: p.positions[i].to_array(),
                normal: p.normals[i].to_array(),
                tangent: p.tangents[i].to_array(),
                uv0: p.uv0[i].to_array(),
                uv1: p.uv1[i].to_array(),
                color: u32::from_le_bytes(c),
            });
        }
        indices.extend_from_slice(&p.indices);
    }
    (vertices, indices, ranges)
}

/// A material as shaders read it.
pub fn material_data(m: &Material) -> MaterialData {
    MaterialData {
        base_color: m.base_color.to_array(),
        // Kept finite, because infinity times a texture's 0 would be NaN.
        emissive: m.emissive.min(glam::Vec3::MAX).to_array(),
        metallic: m.metallic,
        dielectric_f0: m.dielectric_f0.to_array(),
        roughness: m.roughness,
        normal_scale: m.normal_scale,
        alpha_cutoff: match m.alpha {
            Alpha::Opaque => -1.0,
            Alpha::Mask { cutoff } => cutoff,
        },
        transmission: m.transmission,
        double_sided: u32::from(m.double_sided),
        slots: slots(m).map(|slot| match slot {
            None => TextureSlot {
                row_u: [1.0, 0.0, 0.0, 0.0],
                row_v: [0.0, 1.0, 0.0, 0.0],
                texture_index: -1,
                uv_set: 0,
                reserved0: 0,
                reserved1: 0,
            },
            Some(t) => TextureSlot {
                row_u: t.transform.row(0).extend(0.0).to_array(),
                row_v: t.transform.row(1).extend(0.0).to_array(),
                texture_index: t.texture as i32,
                uv_set: t.uv_set,
                reserved0: 0,
                reserved1: 0,
            },
        }),
    }
}

fn filter_of(gpu: &Gpu, t: &Texture) -> Filter {
    let wrap = |w| match w {
        Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
        Wrap::Mirror => vk::SamplerAddressMode::MIRRORED_REPEAT,
        Wrap::Clamp => vk::SamplerAddressMode::CLAMP_TO_EDGE,
    };
    // Not on software devices, where sixteen taps cost a hundred times as much as the rest of the pass.
    let anisotropic = !t.nearest && !gpu.is_cpu();
    Filter { linear: !t.nearest, wrap_u: wrap(t.wrap_u), wrap_v: wrap(t.wrap_v), anisotropic }
}

fn upload_texture(gpu: &Rc<Gpu>, texture: &Texture) -> Result<Image, GpuError> {
    let levels = mip_chain(&texture.rgba8, texture.width, texture.height, texture.srgb);
    let format = if texture.srgb { vk::Format::R8G8B8A8_SRGB } else { vk::Format::R8G8B8A8_UNORM };
    let desc = ImageDesc::texture(texture.width, texture.height, levels.len() as u32, format);
    Image::with_content(gpu, &texture.name, desc, &levels)
}

/// Uploads a map as fp16, in which the radiance of reflection rays is stored as well.
fn upload_equirect(gpu: &Rc<Gpu>, what: &str, map: &Equirect) -> Result<Image, GpuError> {
    let half = |x: f32| half::f16::from_f32(x.clamp(0.0, 65504.0)).to_le_bytes();
    let one = half(1.0);
    let bytes: Vec<u8> = map.texels.iter().flat_map(|t| [half(t[0]), half(t[1]), half(t[2]), one]).flatten().collect();
    let desc = ImageDesc::texture(map.width, map.height, 1, vk::Format::R16G16B16A16_SFLOAT);
    Image::with_content(gpu, what, desc, &[bytes])
}

/// The instances relative to `head`, which is subtracted in f64.
pub fn instances(scene: &Scene, places: &[DAffine3], ranges: &[PrimitiveRange], head: DVec3) -> Vec<InstanceData> {
    let row = |m: &DMat3, t: DVec3, i: usize| {
        let r = m.row(i);
        [r.x as f32, r.y as f32, r.z as f32, t[i] as f32]
    };
    scene
        .instances
        .iter()
        .zip(places)
        .map(|(instance, place)| {
            let m = place.matrix3;
            let t = place.translation - head;
            // Scaled to a largest element of 1, because the inverse for a scene in millimetres may exceed f32.
            let n = m.inverse().transpose();
            let largest = n.to_cols_array().iter().fold(0.0f64, |a, x| a.max(x.abs()));
            let n = if largest.is_finite() && largest > 0.0 { n * (1.0 / largest) } else { DMat3::IDENTITY };
            let range = ranges[instance.primitive];
            InstanceData {
                render_from_object: [row(&m, t, 0), row(&m, t, 1), row(&m, t, 2)],
                normal_matrix: [row(&n, DVec3::ZERO, 0), row(&n, DVec3::ZERO, 1), row(&n, DVec3::ZERO, 2)],
                material: scene.primitives[instance.primitive].material as u32,
                first_vertex: range.first_vertex,
                first_index: range.first_index,
                closed: u32::from(scene.primitives[instance.primitive].closed),
            }
        })
        .collect()
}

/// Uploads [`instances`]. In a scene with motions the buffer can be written again.
///
/// # Errors
/// When device memory runs out.
pub fn instance_buffer(
    gpu: &Rc<Gpu>,
    scene: &Scene,
    places: &[DAffine3],
    ranges: &[PrimitiveRange],
    head: DVec3,
) -> Result<Buffer, GpuError> {
    let instances = instances(scene, places, ranges, head);
    if scene.motions.is_empty() {
        return Buffer::with_content(gpu, "instances", &instances);
    }
    let buffer = Buffer::upload(gpu, "instances", size_of_val(instances.as_slice()) as u64)?;
    buffer.write(bytemuck::cast_slice(&instances));
    Ok(buffer)
}

/// Lights relative to `head`.
pub fn lights(scene: &Scene, head: DVec3) -> Vec<LightData> {
    let local = |p: DVec3| (p - head).as_vec3().to_array();
    let none = LightData {
        position: [0.0; 3],
        kind: 0,
        direction: [0.0, -1.0, 0.0],
        range: f32::MAX,
        color: [0.0; 3],
        cos_inner: 1.0,
        cos_outer: 0.0,
        size: 0.0,
        casts_shadow: 1,
        reserved: 0,
    };
    // The square of the range must be finite in the shader.
    let range = |r: f32| r.min(1e18);
    scene
        .lights
        .iter()
        .map(|light| {
            let data = match light.source {
                LightSource::Directional { direction, irradiance } => LightData {
                    direction: direction.to_array(),
                    color: irradiance.to_array(),
                    size: light.size.tan(),
                    ..none
                },
                LightSource::Point { position, intensity, range_m } => LightData {
                    position: local(position),
                    kind: 1,
                    range: range(range_m),
                    color: intensity.to_array(),
                    size: light.size,
                    ..none
                },
                LightSource::Spot { position, direction, intensity, range_m, inner_rad, outer_rad } => LightData {
                    position: local(position),
                    kind: 2,
                    direction: direction.to_array(),
                    range: range(range_m),
                    color: intensity.to_array(),
                    cos_inner: inner_rad.cos(),
                    cos_outer: outer_rad.cos(),
                    size: light.size,
                    ..none
                },
            };
            LightData { casts_shadow: u32::from(light.casts_shadow), ..data }
        })
        .collect()
}
