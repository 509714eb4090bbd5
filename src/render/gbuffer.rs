//! Passes 1 and 2: draw the G-buffer, and the nearest back faces behind it, one eye after the other.

use std::rc::Rc;

use ash::vk;
use glam::DMat3;

use crate::gpu::{Draws, Frame, Geometry, Gpu, GpuError, Image, Input, RasterPass, RasterPassDesc, Target, Targets};
use crate::scene::{Alpha, Eye, Scene};

use super::context::Context;
use super::needs::FrameNeeds;
use super::shaders;
use super::shared::Vertex;
use super::targets::GBuffer;
use super::upload::SceneResources;

/// Draws the G-buffer.
pub struct GBufferPass {
    pass: RasterPass,
}

/// Draws the back faces of closed meshes, behind the front depth only.
pub struct BackFacePass {
    pass: RasterPass,
}

const ATTRIBUTES: [(vk::Format, u32); 6] = [
    (vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, position) as u32),
    (vk::Format::R32G32B32_SFLOAT, std::mem::offset_of!(Vertex, normal) as u32),
    (vk::Format::R32G32B32A32_SFLOAT, std::mem::offset_of!(Vertex, tangent) as u32),
    (vk::Format::R32G32_SFLOAT, std::mem::offset_of!(Vertex, uv0) as u32),
    (vk::Format::R32G32_SFLOAT, std::mem::offset_of!(Vertex, uv1) as u32),
    (vk::Format::R8G8B8A8_UNORM, std::mem::offset_of!(Vertex, color) as u32),
];

impl GBufferPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, resources: &SceneResources, needs: &FrameNeeds) -> Result<GBufferPass, GpuError> {
        let formats = [vk::Format::R32G32B32A32_UINT, vk::Format::R32_UINT, vk::Format::R16G16B16A16_SFLOAT];
        let fragment = if needs.emission { &shaders::GBUFFER_EMISSION_FRAG } else { &shaders::GBUFFER_FRAG };
        let pass = RasterPass::new(
            gpu,
            &RasterPassDesc {
                name: "gbuffer",
                vertex: &shaders::GBUFFER_VERT.words(),
                fragment: &fragment.words(),
                specialization: &[u32::from(needs.mask)],
                vertex_stride: size_of::<Vertex>() as u32,
                attributes: &ATTRIBUTES,
                colors: &formats[..if needs.emission { 3 } else { 2 }],
                constant_bytes: 4,
                inputs: &[Input::UNIFORM, Input::BUFFER, Input::BUFFER],
                materials: &resources.material_sets,
            },
        )?;
        Ok(GBufferPass { pass })
    }

    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        scene: &Scene,
        resources: &SceneResources,
        context: &Context,
        out: &GBuffer,
    ) -> Result<(), GpuError> {
        let mut colors = vec![Target::zeroed(&out.surface), Target::zeroed(&out.instance)];
        colors.extend(out.emission.as_ref().map(Target::zeroed));
        let targets = Targets { colors: &colors, depth: &out.depth };
        let inputs =
            [Input::Uniform(&context.frame), Input::Buffer(&context.instances), Input::Buffer(&resources.materials)];
        for eye in Eye::BOTH {
            frame.raster(&self.pass, eye.layer(), &targets, &inputs, &geometry(resources), |draws| {
                draws.constants(&(eye.layer() as u32));
                draw_instances(draws, scene, resources, Side::Front);
            })?;
        }
        Ok(())
    }
}

impl BackFacePass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, resources: &SceneResources) -> Result<BackFacePass, GpuError> {
        let pass = RasterPass::new(
            gpu,
            &RasterPassDesc {
                name: "backface",
                vertex: &shaders::BACKFACE_VERT.words(),
                fragment: &shaders::BACKFACE_FRAG.words(),
                specialization: &[],
                vertex_stride: size_of::<Vertex>() as u32,
                attributes: &ATTRIBUTES[..1],
                colors: &[],
                constant_bytes: 4,
                inputs: &[Input::UNIFORM, Input::BUFFER, Input::IMAGE],
                materials: &resources.material_sets,
            },
        )?;
        Ok(BackFacePass { pass })
    }

    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        scene: &Scene,
        resources: &SceneResources,
        context: &Context,
        gbuffer: &GBuffer,
        out: &Image,
    ) -> Result<(), GpuError> {
        let targets = Targets { colors: &[], depth: out };
        let inputs = [
            Input::Uniform(&context.frame),
            Input::Buffer(&context.instances),
            Input::Image(&gbuffer.depth, &context.nearest),
        ];
        for eye in Eye::BOTH {
            frame.raster(&self.pass, eye.layer(), &targets, &inputs, &geometry(resources), |draws| {
                draws.constants(&(eye.layer() as u32));
                draw_instances(draws, scene, resources, Side::BackOfClosed);
            })?;
        }
        Ok(())
    }
}

fn geometry(resources: &SceneResources) -> Geometry<'_> {
    Geometry { vertices: &resources.vertices, indices: &resources.indices, materials: &resources.material_sets }
}

#[derive(Clone, Copy, PartialEq)]
enum Side {
    Front,
    BackOfClosed,
}

fn draw_instances(draws: &mut Draws<'_>, scene: &Scene, resources: &SceneResources, side: Side) {
    for (number, instance) in scene.instances.iter().enumerate() {
        let primitive = &scene.primitives[instance.primitive];
        let material = &scene.materials[primitive.material];
        let mirrored = DMat3::determinant(&instance.world_from_object.matrix3) < 0.0;
        let back = if mirrored { vk::CullModeFlags::FRONT } else { vk::CullModeFlags::BACK };
        let front = if mirrored { vk::CullModeFlags::BACK } else { vk::CullModeFlags::FRONT };
        let cull = match side {
            // A cut-out mesh does not count as closed: its back faces have holes as well.
            Side::BackOfClosed if !primitive.closed || matches!(material.alpha, Alpha::Mask { .. }) => continue,
            Side::BackOfClosed => front,
            Side::Front if material.double_sided => vk::CullModeFlags::NONE,
            Side::Front => back,
        };
        let range = resources.ranges[instance.primitive];
        draws.indexed(
            primitive.material,
            cull,
            range.first_index,
            range.index_count,
            range.first_vertex as i32,
            number as u32,
        );
    }
}
