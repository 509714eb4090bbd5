//! The scene's geometry for rays: triangles, a BVH or an acceleration structure of the device over them, and textures.
//!
//! `lazy_rays` builds it; every pass that sends rays through the geometry binds it.

use std::rc::Rc;
use std::time::Duration;

use ash::vk;
use glam::{DAffine3, DVec3, Vec3, Vec3A};
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;
use obvhs::{BvhBuildParams, bvh2::Bvh2};

use crate::gpu::{Buffer, Dispatch, Gpu, GpuError, Image, ImageDesc, Shader};
use crate::scene::{Alpha, Scene, Texture, Wrap};

use super::context::Context;
use super::mips::mip_chain;
use super::ray_list::RayList;
use super::ray_structure::{self, RayStructure};
use super::settings::Trace;
use super::shared::{
    COUNT_SHIFT, DOUBLE_SIDED, EmitterData, LEAF, MASKED, NodeData, TRANSMITS, TextureData, TriangleData,
};
use super::targets::GBuffer;
use super::upload::{PrimitiveRange, SceneResources};

/// Marks a triangle of a mirrored instance, whose second and third corner are exchanged (twin in hit_surface.glsl).
pub const EXCHANGED: u32 = 1 << 31;

/// What finds the hits of rays.
pub enum Structure {
    /// The nodes of our BVH.
    Bvh(Box<Image>),
    RayQuery(Box<RayStructure>),
}

/// Geometry for rays, relative to `head`.
pub struct RayScene {
    pub head: DVec3,
    pub structure: Structure,
    pub triangles: Image,
    pub textures: Buffer,
    pub texels: Buffer,
    /// Emissive triangles.
    pub emitters: Vec<EmitterData>,
    /// Σ area × luminance of the material's emissive factor over the emitters.
    pub emitted: f32,
    /// How many times textures were halved in size to fit one storage buffer; usually 0.
    pub halvings: u32,
}

impl RayScene {
    /// Builds and uploads. Building takes about 0.1 s per 150 k triangles on one core.
    ///
    /// # Errors
    /// When device memory runs out.
    /// [`GpuError::Lacks`] when `trace` asks for ray queries and the device has none.
    pub fn new(
        gpu: &Rc<Gpu>,
        (scene, places): (&Scene, &[DAffine3]),
        ranges: &[PrimitiveRange],
        head: DVec3,
        trace: Trace,
    ) -> Result<RayScene, GpuError> {
        let triangles = world_triangles(scene, places, ranges, head);
        let (structure, mut triangles) = match trace {
            Trace::RayQuery => {
                let (structure, triangles) = ray_structure::build(gpu, &triangles)?;
                (Structure::RayQuery(Box::new(structure)), triangles)
            }
            Trace::Auto | Trace::Cpu if takes_ray_query(gpu, trace) => {
                return Self::new(gpu, (scene, places), ranges, head, Trace::RayQuery);
            }
            Trace::Auto | Trace::Cpu | Trace::Bvh => {
                let (nodes, order) = build(&triangles);
                let nodes = upload_rows(gpu, "BVH nodes", &nodes)?;
                (Structure::Bvh(Box::new(nodes)), order.iter().map(|&i| triangles[i as usize]).collect())
            }
        };
        if triangles.is_empty() {
            triangles.push(bytemuck::Zeroable::zeroed());
        }
        let (emitters, emitted) = emitters(scene, &triangles);
        let (textures, texels, halvings) = pack_textures(&scene.textures, gpu.max_storage_bytes());
        Ok(RayScene {
            head,
            structure,
            triangles: upload_rows(gpu, "BVH triangles", &triangles)?,
            textures: Buffer::with_content(gpu, "textures for hits", &textures)?,
            texels: Buffer::with_content(gpu, "texels for hits", &texels)?,
            emitters,
            emitted,
            halvings,
        })
    }
}

/// Whether hardware traces rays through the geometry.
pub fn fast_ray_queries(gpu: &Gpu, trace: Trace) -> bool {
    takes_ray_query(gpu, trace) && !gpu.is_cpu()
}

/// Whether rays go through the device's acceleration structure. A software device has ray queries too (Mesa 25), but they take
/// two to three times as long as the traversal of our BVH.
fn takes_ray_query(gpu: &Gpu, trace: Trace) -> bool {
    match trace {
        Trace::Auto | Trace::Cpu => gpu.has_ray_query() && !gpu.is_cpu(),
        Trace::Bvh => false,
        Trace::RayQuery => true,
    }
}

impl RayScene {
    /// The name in `render.json`: `bvh` or `ray-query`.
    pub fn structure_name(&self) -> &'static str {
        match self.structure {
            Structure::Bvh(_) => "bvh",
            Structure::RayQuery(_) => "ray-query",
        }
    }

    /// Whether this is what `trace` selects on the device.
    pub fn answers(&self, gpu: &Gpu, trace: Trace) -> bool {
        takes_ray_query(gpu, trace) == matches!(self.structure, Structure::RayQuery(_))
    }

    /// The variant of a shader that fits what [`RayScene::bind`] binds.
    pub fn variant(&self, bvh: &'static Shader, ray_query: &'static Shader) -> &'static Shader {
        match self.structure {
            Structure::Bvh(_) => bvh,
            Structure::RayQuery(_) => ray_query,
        }
    }

    /// Binds what `shaders/common/geometry_rays.glsl` declares, for the rays of `list`.
    pub fn bind_geometry_rays<'f>(
        &'f self,
        chain: Dispatch<'f>,
        list: &'f RayList,
        (resources, context): (&'f SceneResources, &'f Context),
        gbuffer: &'f GBuffer,
    ) -> Dispatch<'f> {
        chain
            .uniform(&context.frame)
            .read_buffer(&list.rays)
            .read_buffer(&list.arguments)
            .write_buffer(&context.counters)
            .read_buffer(&context.lights)
            .with(|chain| self.bind(chain, resources, context))
            .sampled(&gbuffer.surface, &context.nearest)
            .sampled(&gbuffer.depth, &context.nearest)
            .with(|chain| context.bind_environment(chain, &resources.environment))
            .with(|chain| context.baked.bind(chain, &context.nearest))
    }

    /// Binds what `rays.glsl` and `hit_surface.glsl` read.
    pub fn bind<'f>(
        &'f self,
        chain: Dispatch<'f>,
        resources: &'f SceneResources,
        context: &'f Context,
    ) -> Dispatch<'f> {
        let chain = match &self.structure {
            Structure::Bvh(nodes) => chain.sampled(nodes, &context.nearest),
            Structure::RayQuery(structure) => chain.structure(&structure.top),
        };
        chain
            .sampled(&self.triangles, &context.nearest)
            .read_buffer(&context.instances)
            .read_buffer(&resources.materials)
            .read_buffer(&self.textures)
            .read_buffer(&self.texels)
            .read_buffer(&resources.vertices)
            .read_buffer(&resources.indices)
    }
}

/// Texels in a row, of sixteen bytes each (twin: `row` in rays.glsl).
const ROW_WIDTH: usize = 4096;

/// Uploads structures as texels. On software devices a texel fetch is cheaper than lane by lane reads of a buffer; elsewhere it
/// costs no more.
pub fn upload_rows<T: bytemuck::NoUninit>(gpu: &Rc<Gpu>, what: &str, content: &[T]) -> Result<Image, GpuError> {
    let mut bytes = bytemuck::cast_slice::<T, u8>(content).to_vec();
    let rows = bytes.len().div_ceil(16 * ROW_WIDTH).max(1);
    bytes.resize(rows * 16 * ROW_WIDTH, 0);
    let desc = ImageDesc::texture(ROW_WIDTH as u32, rows as u32, 1, vk::Format::R32G32B32A32_UINT);
    Image::with_content(gpu, what, desc, &[bytes])
}

/// The scene's triangles relative to `head`, instance by instance.
pub fn world_triangles(
    scene: &Scene,
    places: &[DAffine3],
    ranges: &[PrimitiveRange],
    head: DVec3,
) -> Vec<TriangleData> {
    let mut out = Vec::with_capacity(scene.triangle_count());
    for (number, (instance, place)) in scene.instances.iter().zip(places).enumerate() {
        let p = &scene.primitives[instance.primitive];
        let mirrored = place.matrix3.determinant() < 0.0;
        let material = &scene.materials[p.material];
        let flags = if material.double_sided { DOUBLE_SIDED } else { 0 }
            | if matches!(material.alpha, Alpha::Mask { .. }) { MASKED } else { 0 }
            | if material.transmission > 0.0 { TRANSMITS } else { 0 };
        let at = |i: u32| -> Vec3 {
            let world = place.transform_point3(p.positions[i as usize].as_dvec3());
            (world - head).as_vec3()
        };
        for (k, corner) in p.indices.chunks_exact(3).enumerate() {
            let (v0, mut v1, mut v2) = (at(corner[0]), at(corner[1]), at(corner[2]));
            let mut first_index = ranges[instance.primitive].first_index + 3 * k as u32;
            if mirrored {
                std::mem::swap(&mut v1, &mut v2);
                first_index |= EXCHANGED;
            }
            out.push(TriangleData {
                v0: v0.to_array(),
                instance: number as u32,
                edge1: (v1 - v0).to_array(),
                first_index,
                edge2: (v2 - v0).to_array(),
                flags,
            });
        }
    }
    out
}

/// The emissive triangles, and Σ area × luminance over them.
fn emitters(scene: &Scene, triangles: &[TriangleData]) -> (Vec<EmitterData>, f32) {
    let mut sum = 0.0f64;
    let mut powers = Vec::new();
    for (number, t) in triangles.iter().enumerate() {
        let Some(instance) = scene.instances.get(t.instance as usize) else { continue };
        let emissive = scene.materials[scene.primitives[instance.primitive].material].emissive;
        let luminance = f64::from(emissive.dot(Vec3::new(0.2126, 0.7152, 0.0722)).min(1e12));
        let area = 0.5 * f64::from(Vec3::from(t.edge1).cross(Vec3::from(t.edge2)).length());
        if luminance * area > 0.0 {
            sum += luminance * area;
            powers.push((number as u32, sum));
        }
    }
    let share = |&(triangle, upto): &(u32, f64)| EmitterData { triangle, cumulative: (upto / sum) as f32 };
    (powers.iter().map(share).collect(), sum as f32)
}

/// The BVH's nodes, and the order of the triangles to which its leaves refer.
fn build(triangles: &[TriangleData]) -> (Vec<NodeData>, Vec<u32>) {
    let bvh = binary_tree(triangles, 8);
    (pair_children(&bvh), bvh.primitive_indices)
}

/// A binary BVH over triangles, with at most `most_in_a_leaf` of them in a leaf. Without triangles it has no nodes.
pub(super) fn binary_tree(triangles: &[TriangleData], most_in_a_leaf: u32) -> Bvh2 {
    let shapes: Vec<Triangle> = triangles
        .iter()
        .map(|t| {
            let (v0, e1, e2) = (Vec3A::from(t.v0), Vec3A::from(t.edge1), Vec3A::from(t.edge2));
            Triangle { v0, v1: v0 + e1, v2: v0 + e2 }
        })
        .collect();
    let params = BvhBuildParams { max_prims_per_leaf: most_in_a_leaf, ..BvhBuildParams::medium_build() };
    match shapes.is_empty() {
        true => Bvh2::default(),
        false => build_bvh2_from_tris(&shapes, params, &mut Duration::default()),
    }
}

/// Converts a BVH whose nodes hold their own bounds into nodes that hold the bounds of both children. The root is node 0.
fn pair_children(bvh: &Bvh2) -> Vec<NodeData> {
    let inner: Vec<usize> = (0..bvh.nodes.len()).filter(|&i| bvh.nodes[i].prim_count == 0).collect();
    let mut number = vec![0u32; bvh.nodes.len()];
    for (k, &i) in inner.iter().enumerate() {
        number[i] = k as u32;
    }
    let child = |i: usize| {
        let n = &bvh.nodes[i];
        let reference = match n.prim_count {
            0 => number[i],
            count => LEAF | (count - 1) << COUNT_SHIFT | n.first_index,
        };
        ([n.aabb.min.x, n.aabb.min.y, n.aabb.min.z], [n.aabb.max.x, n.aabb.max.y, n.aabb.max.z], reference)
    };
    let pair = |(lower0, upper0, child0), (lower1, upper1, child1)| NodeData {
        lower0,
        child0,
        upper0,
        reserved0: 0,
        lower1,
        child1,
        upper1,
        reserved1: 0,
    };
    // An empty child. No ray enters it, because its lower corner lies beyond its upper one.
    let nothing = ([f32::MAX; 3], [f32::MIN; 3], LEAF);
    match (inner.is_empty(), bvh.nodes.is_empty()) {
        (false, _) => inner
            .iter()
            .map(|&i| {
                let first = bvh.nodes[i].first_index as usize;
                pair(child(first), child(first + 1))
            })
            .collect(),
        (true, false) => vec![pair(child(0), nothing)],
        (true, true) => vec![pair(nothing, nothing)],
    }
}

/// All textures in one buffer of words. All of them are halved in size until they fit `limit` bytes; returns how many times.
fn pack_textures(textures: &[Texture], limit: u64) -> (Vec<TextureData>, Vec<u32>, u32) {
    let words = |halvings: u32| -> u64 {
        textures
            .iter()
            .map(|t| u64::from((t.width >> halvings).max(1)) * u64::from((t.height >> halvings).max(1)))
            .sum()
    };
    let halvings = (0..16).find(|&h| words(h) * 4 <= limit).unwrap_or(16);
    let mut data = Vec::with_capacity(textures.len());
    let mut texels: Vec<u32> = Vec::new();
    let wrap = |w| match w {
        Wrap::Repeat => 0u32,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    for t in textures {
        let flags = wrap(t.wrap_u) | wrap(t.wrap_v) << 2 | u32::from(t.srgb) << 4 | u32::from(t.nearest) << 5;
        let (width, height) = ((t.width >> halvings).max(1), (t.height >> halvings).max(1));
        data.push(TextureData { offset: texels.len() as u32, width, height, flags });
        let mut push = |bytes: &[u8]| {
            texels.extend(bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])));
        };
        if halvings == 0 {
            push(&t.rgba8);
        } else {
            let levels = mip_chain(&t.rgba8, t.width, t.height, t.srgb);
            push(&levels[(halvings as usize).min(levels.len() - 1)]);
        }
    }
    (data, texels, halvings)
}
