//! Every structure that host and shaders share: the twins of those in `shaders/common/shared.glsl`. A test compares each offset
//! with the compiled shaders.

use bytemuck::{Pod, Zeroable};

/// One eye of a frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct EyeUniform {
    /// Reverse-Z, infinite far plane, y up.
    pub clip_from_render: [f32; 16],
    pub view_from_render: [f32; 16],
    /// Direction in render space through the image's top-left corner, scaled to distance 1 along the view.
    pub ray_first: [f32; 4],
    /// Added to it for each pixel to the right.
    pub ray_across: [f32; 4],
    /// Added to it for each pixel down.
    pub ray_down: [f32; 4],
    /// xyz: the eye in render space, metres; w: near plane, metres.
    pub position_near: [f32; 4],
    /// x: token of the eye's random stream.
    pub stream: [u32; 4],
}

/// The uniforms of a frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct FrameUniform {
    pub eyes: [EyeUniform; 2],
    /// Pixels of one eye.
    pub size: [u32; 2],
    pub seed: u32,
    pub frame: u32,
    /// Perceptual roughness above which no ray is traced.
    pub ray_roughness_limit: f32,
    /// Perceptual roughness below which a surface is a mirror.
    pub delta_roughness: f32,
    /// Metres behind the surface of an open mesh that count as matter.
    pub open_mesh_thickness: f32,
    /// Width of the fade at a view's border, as a fraction of its size.
    pub edge_fade: f32,
    /// Length of rays, metres; nothing of the scene is farther away.
    pub ray_length: f32,
    pub exposure: f32,
    pub light_count: u32,
    pub max_steps: u32,
    /// 0 black, 1 the specular map.
    pub fallback: u32,
    /// The resolve's measure against fireflies: 0 none, 1 tone-mapped weights, 2 bounded shares.
    pub firefly: u32,
    /// Pixels at each side (x, y) that are drawn and never shown.
    pub guard: [u32; 2],
}

/// A punctual light.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct LightData {
    /// Render space, metres.
    pub position: [f32; 3],
    /// 0 directional, 1 point, 2 spot.
    pub kind: u32,
    /// Unit length; the light travels along it.
    pub direction: [f32; 3],
    /// Metres.
    pub range: f32,
    /// Irradiance (directional) or radiant intensity.
    pub color: [f32; 3],
    pub cos_inner: f32,
    pub cos_outer: f32,
    /// Radius, metres; for a directional light the tangent of half its angular diameter.
    pub size: f32,
    /// 0: the light passes through all matter.
    pub casts_shadow: u32,
    pub reserved: u32,
}

/// One texture of a material: which one, and its texture coordinates.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct TextureSlot {
    /// u' = row_u · (u, v, 1).
    pub row_u: [f32; 4],
    pub row_v: [f32; 4],
    /// −1: none.
    pub texture_index: i32,
    pub uv_set: u32,
    pub reserved0: u32,
    pub reserved1: u32,
}

/// A material.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct MaterialData {
    /// Linear, straight alpha.
    pub base_color: [f32; 4],
    pub emissive: [f32; 3],
    pub metallic: f32,
    pub dielectric_f0: [f32; 3],
    /// Perceptual.
    pub roughness: f32,
    pub normal_scale: f32,
    /// Negative: opaque.
    pub alpha_cutoff: f32,
    pub transmission: f32,
    pub double_sided: u32,
    /// Base colour, metallic-roughness, normal, emissive.
    pub slots: [TextureSlot; 4],
}

/// An instance: a primitive with a transform.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct InstanceData {
    /// Rows.
    pub render_from_object: [[f32; 4]; 3],
    /// Rows of the inverse transpose.
    pub normal_matrix: [[f32; 4]; 3],
    pub material: u32,
    pub first_vertex: u32,
    pub first_index: u32,
    pub closed: u32,
}

/// A texture in the texel buffer.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct TextureData {
    /// First texel, in words.
    pub offset: u32,
    pub width: u32,
    pub height: u32,
    /// Bits 0–1 wrap u, 2–3 wrap v (0 repeat, 1 mirror, 2 clamp), 4 sRGB, 5 nearest.
    pub flags: u32,
}

/// A vertex: fifteen words.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Vertex {
    pub position: [f32; 3],
    pub normal: [f32; 3],
    pub tangent: [f32; 4],
    pub uv0: [f32; 2],
    pub uv1: [f32; 2],
    /// unorm 4×8, linear.
    pub color: u32,
}

/// An inner node of the BVH. It holds the bounds of both children, so that a visit reads a single node.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct NodeData {
    pub lower0: [f32; 3],
    /// Inner: index of the node. Leaf: [`LEAF`] | first triangle | (count − 1) << [`COUNT_SHIFT`].
    pub child0: u32,
    pub upper0: [f32; 3],
    pub reserved0: u32,
    pub lower1: [f32; 3],
    pub child1: u32,
    pub upper1: [f32; 3],
    pub reserved1: u32,
}

/// Marks a child that is a leaf.
pub const LEAF: u32 = 1 << 31;
/// The lowest bit of a leaf's triangle count.
pub const COUNT_SHIFT: u32 = 28;
/// [`TriangleData::flags`]: seen from both sides.
pub const DOUBLE_SIDED: u32 = 1;
/// [`TriangleData::flags`]: cut out by its texture.
pub const MASKED: u32 = 2;
/// [`TriangleData::flags`]: lets light through.
pub const TRANSMITS: u32 = 4;

/// A triangle of the BVH, in render space.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct TriangleData {
    pub v0: [f32; 3],
    pub instance: u32,
    pub edge1: [f32; 3],
    /// Position of the triangle's first index in the index buffer. The highest bit is set if the second and third corner are
    /// exchanged.
    pub first_index: u32,
    pub edge2: [f32; 3],
    /// [`DOUBLE_SIDED`], [`MASKED`], [`TRANSMITS`].
    pub flags: u32,
}

/// An emissive triangle.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct EmitterData {
    /// Its index among the triangles for rays.
    pub triangle: u32,
    /// Share of all emitted light that comes from this emitter and those before it; 1 for the last one.
    pub cumulative: f32,
}

/// The view of a shadow map, in the maps' space.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct ShadowMapData {
    /// xyz: unit axis; w: minus the dot product of the axis and the place that the map looks from.
    pub right: [f32; 4],
    pub up: [f32; 4],
    pub forward: [f32; 4],
    /// Takes metres (in a perspective: metres a metre ahead) to ±1 at the map's border.
    pub scale: [f32; 2],
    /// Metres ahead.
    pub near: f32,
    /// Metres ahead; 0: the map is a perspective from the light, without an end.
    pub far: f32,
}

/// The layers of one light: none, one (a narrow spot), six (a cube), or cascades in order from the finest. Where there is
/// transmitting matter, as many layers of transmitting matter follow after those of opaque matter.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct LightMapsData {
    pub first: u32,
    /// Number of layers of opaque matter.
    pub count: u32,
    /// Added to the index of a layer of opaque matter to find the one of transmitting matter; 0: there is none.
    pub dimming: u32,
}

/// What the device counts during a submission.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct CountersData {
    pub nan: u32,
    pub inf: u32,
    /// Radiance beyond fp16.
    pub clamped: u32,
    pub rays: u32,
    pub hits: u32,
    pub sky: u32,
    pub left_view: u32,
    pub behind: u32,
    pub back_facing: u32,
    /// Marches that ran out of steps.
    pub budget: u32,
    /// Samples below the horizon, which count as zero.
    pub below_horizon: u32,
    pub steps: u32,
    /// Lost rays that asked the geometry.
    pub asked: u32,
    /// Lost rays that did not ask the geometry; the weights of those that asked make up for them.
    pub skipped: u32,
}

/// [`CountersData`] summed over a frame's submissions. 32 bits would not suffice for 1,024 paths per pixel in a large image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counts {
    pub nan: u64,
    pub inf: u64,
    /// Radiance beyond fp16.
    pub clamped: u64,
    pub rays: u64,
    pub hits: u64,
    pub sky: u64,
    pub left_view: u64,
    pub behind: u64,
    pub back_facing: u64,
    /// Marches that ran out of steps.
    pub budget: u64,
    /// Samples below the horizon: no ray, counted as zero.
    pub below_horizon: u64,
    pub steps: u64,
    /// Lost rays that asked the geometry; their results are counted under `hits` and `sky`.
    pub asked: u64,
    /// Lost rays that did not ask the geometry; the weights of those that asked make up for them.
    pub skipped: u64,
}

impl Counts {
    /// Adds what one submission counted.
    pub fn add(&mut self, c: &CountersData) {
        let pairs = [
            (&mut self.nan, c.nan),
            (&mut self.inf, c.inf),
            (&mut self.clamped, c.clamped),
            (&mut self.rays, c.rays),
            (&mut self.hits, c.hits),
            (&mut self.sky, c.sky),
            (&mut self.left_view, c.left_view),
            (&mut self.behind, c.behind),
            (&mut self.back_facing, c.back_facing),
            (&mut self.budget, c.budget),
            (&mut self.below_horizon, c.below_horizon),
            (&mut self.steps, c.steps),
            (&mut self.asked, c.asked),
            (&mut self.skipped, c.skipped),
        ];
        for (sum, n) in pairs {
            *sum += u64::from(n);
        }
    }

    /// Rays whose answer is unknown.
    pub fn missed(&self) -> u64 {
        self.left_view + self.behind + self.back_facing + self.budget
    }
}

const _: () = {
    assert!(size_of::<EyeUniform>() == 208);
    assert!(size_of::<FrameUniform>() == 480);
    assert!(size_of::<LightData>() == 64);
    assert!(size_of::<TextureSlot>() == 48);
    assert!(size_of::<MaterialData>() == 256);
    assert!(size_of::<InstanceData>() == 112);
    assert!(size_of::<Vertex>() == 60);
    assert!(size_of::<NodeData>() == 64);
    assert!(size_of::<TriangleData>() == 48);
    assert!(size_of::<ShadowMapData>() == 64);
    assert!(size_of::<LightMapsData>() == 12);
};
