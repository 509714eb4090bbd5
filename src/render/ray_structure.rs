//! The scene's triangles as an acceleration structure of the device, for `VK_KHR_ray_query`. `RayScene::new` builds it.

use std::rc::Rc;

use crate::gpu::{AccelerationStructure, Buffer, Gpu, GpuError, StructureInstance, Triangles};

use super::shared::{DOUBLE_SIDED, MASKED, TriangleData};

/// An instance's custom index is the index of its first triangle divided by this, so that 24 bits suffice for more triangles than
/// the texture of triangles holds (twin: INSTANCE_STEP in ray_query.glsl).
const STEP: usize = 16;

/// Single-sided, single-sided and cut out, double-sided, double-sided and cut out. Each kind has a bottom-level structure,
/// because Vulkan sets culling for an instance and opacity for a geometry.
const KINDS: [u32; 4] = [0, MASKED, DOUBLE_SIDED, DOUBLE_SIDED | MASKED];

/// The top-level structure that shaders trace through, with the bottom-level ones to which it refers.
pub struct RayStructure {
    pub top: AccelerationStructure,
    _below: Vec<AccelerationStructure>,
}

/// Builds the structure, and returns the triangles in the order by which it numbers them.
///
/// # Errors
/// [`GpuError::Lacks`] on a device without ray queries, or when a Vulkan call fails.
pub fn build(gpu: &Rc<Gpu>, triangles: &[TriangleData]) -> Result<(RayStructure, Vec<TriangleData>), GpuError> {
    let mut sorted: Vec<TriangleData> = Vec::with_capacity(triangles.len() + KINDS.len() * STEP);
    let mut runs = Vec::new();
    for kind in KINDS {
        sorted.resize(sorted.len().next_multiple_of(STEP), bytemuck::Zeroable::zeroed());
        let first = sorted.len();
        sorted.extend(triangles.iter().filter(|t| t.flags & (DOUBLE_SIDED | MASKED) == kind));
        if sorted.len() > first {
            runs.push((kind, first, sorted.len() - first));
        }
    }
    let corners: Vec<[[f32; 3]; 3]> = sorted.iter().map(corners).collect();
    let positions = Buffer::structure_input(gpu, "corners for rays", &corners)?;
    let mut below = Vec::new();
    for &(kind, first, count) in &runs {
        let run = Triangles { first: first as u32, count: count as u32, opaque: kind & MASKED == 0 };
        below.push(AccelerationStructure::of_triangles(gpu, &positions, run)?);
    }
    let placed: Vec<StructureInstance<'_>> = below
        .iter()
        .zip(&runs)
        .map(|(structure, &(kind, first, _))| StructureInstance {
            structure,
            custom: (first / STEP) as u32,
            two_sided: kind & DOUBLE_SIDED != 0,
        })
        .collect();
    let top = AccelerationStructure::of_structures(gpu, &placed)?;
    Ok((RayStructure { top, _below: below }, sorted))
}

fn corners(t: &TriangleData) -> [[f32; 3]; 3] {
    let add = |e: [f32; 3]| [t.v0[0] + e[0], t.v0[1] + e[1], t.v0[2] + e[2]];
    [t.v0, add(t.edge1), add(t.edge2)]
}
