//! Draws the layers of shadow maps: the depth of opaque or of transmitting matter, without face culling.

use std::rc::Rc;

use ash::vk;

use super::super::shaders;
use super::super::shared::Vertex;
use super::super::upload::SceneResources;
use crate::gpu::{Buffer, Frame, Geometry, Gpu, GpuError, Image, Input, RasterPass, RasterPassDesc, Targets};
use crate::scene::{Alpha, Scene};

/// See `shaders/shadow_map.frag`.
pub struct DrawPass {
    pass: RasterPass,
}

/// What the shaders of [`DrawPass`] read besides the scene's materials.
pub struct DrawInputs<'a> {
    pub maps: &'a Buffer,
    pub instances: &'a Buffer,
}

const ATTRIBUTES: [(vk::Format, u32); 4] = [
    (vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, position) as u32),
    (vk::Format::R32G32_SFLOAT, std::mem::offset_of!(Vertex, uv0) as u32),
    (vk::Format::R32G32_SFLOAT, std::mem::offset_of!(Vertex, uv1) as u32),
    (vk::Format::R8G8B8A8_UNORM, std::mem::offset_of!(Vertex, color) as u32),
];

impl DrawPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, scene: &Scene, resources: &SceneResources) -> Result<DrawPass, GpuError> {
        let used = || scene.instances.iter().map(|i| scene.material_of(i));
        let has_mask = used().any(|m| matches!(m.alpha, Alpha::Mask { .. }));
        let has_glass = used().any(|m| m.transmission > 0.0);
        let pass = RasterPass::new(
            gpu,
            &RasterPassDesc {
                name: "shadow_map",
                vertex: &shaders::SHADOW_MAP_VERT.words(),
                fragment: &shaders::SHADOW_MAP_FRAG.words(),
                specialization: &[u32::from(has_mask), u32::from(has_glass)],
                vertex_stride: size_of::<Vertex>() as u32,
                attributes: &ATTRIBUTES,
                colors: &[],
                constant_bytes: 4,
                inputs: &[Input::BUFFER, Input::BUFFER, Input::BUFFER],
                materials: &resources.material_sets,
            },
        )?;
        Ok(DrawPass { pass })
    }

    /// Draws one layer: the instances for which `casts` holds.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        (scene, resources): (&Scene, &SceneResources),
        inputs: &DrawInputs<'_>,
        (image, layer): (&Image, usize),
        casts: impl Fn(usize) -> bool,
    ) -> Result<(), GpuError> {
        let targets = Targets { colors: &[], depth: image };
        let inputs = [Input::Buffer(inputs.maps), Input::Buffer(inputs.instances), Input::Buffer(&resources.materials)];
        let geometry = Geometry {
            vertices: &resources.vertices,
            indices: &resources.indices,
            materials: &resources.material_sets,
        };
        frame.raster(&self.pass, layer, &targets, &inputs, &geometry, |draws| {
            draws.constants(&(layer as u32));
            for (number, instance) in scene.instances.iter().enumerate().filter(|(number, _)| casts(*number)) {
                let range = resources.ranges[instance.primitive];
                draws.indexed(
                    scene.primitives[instance.primitive].material,
                    vk::CullModeFlags::NONE,
                    range.first_index,
                    range.index_count,
                    range.first_vertex as i32,
                    number as u32,
                );
            }
        })
    }
}
