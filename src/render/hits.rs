//! How the rays of the last sample ended, read back (`Prepared::ray_ends`) to compare traversals. No picture needs it.

use std::rc::Rc;

use crate::gpu::{Gpu, GpuError, Image, read_image};
use crate::scene::Eye;

/// How a ray ended; twin of the status in `shaders/common/hit.glsl`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RayOutcome {
    /// The pixel traced no ray, or its sample fell below the horizon.
    Nothing,
    Hit,
    /// The ray reached infinity inside a view, and went behind nothing on its way.
    Sky,
    /// The ray left the view, went behind something, met a back face, or ran out of steps.
    Unknown,
}

/// One ray's end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayEnd {
    pub end: RayOutcome,
    /// The eye in whose image the ray ended.
    pub eye: Eye,
    /// Place of the hit in that image, 0–1 from the top left.
    pub uv: [f32; 2],
    /// Length of the ray, metres, with a relative precision of 1/4096.
    pub distance_m: f32,
    /// 0–1: how much the hit counts after the fade.
    pub confidence: f32,
}

/// Every pixel of both eyes, row by row.
pub(super) fn read(gpu: &Rc<Gpu>, hits: &Image, guide: &Image) -> Result<[Vec<RayEnd>; 2], GpuError> {
    let (bytes, guides) = (read_image(gpu, hits)?, read_image(gpu, guide)?);
    let word = |t: &[u8], i: usize| u32::from_le_bytes([t[i], t[i + 1], t[i + 2], t[i + 3]]);
    // A pixel that traces no ray has instance 0 in its guide, and its hit was never written.
    let texels = bytes.chunks_exact(16).zip(guides.chunks_exact(16));
    let ends: Vec<RayEnd> = texels
        .map(|(t, g)| match word(g, 8) {
            0 => decode([0; 3]),
            _ => decode([0, 4, 8].map(|i| word(t, i))),
        })
        .collect();
    let (left, right) = ends.split_at(ends.len() / 2);
    Ok([left.to_vec(), right.to_vec()])
}

fn decode([uv, _direction, how]: [u32; 3]) -> RayEnd {
    RayEnd {
        end: [RayOutcome::Nothing, RayOutcome::Hit, RayOutcome::Sky, RayOutcome::Unknown][(how & 3) as usize],
        eye: Eye::BOTH[(how >> 2 & 1) as usize],
        uv: [(uv & 0xffff) as f32 / 65535.0, (uv >> 16) as f32 / 65535.0],
        distance_m: f32::from_bits(how & !0x7ff),
        confidence: (how >> 3 & 0xff) as f32 / 255.0,
    }
}
