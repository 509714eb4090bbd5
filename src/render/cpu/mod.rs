//! The reference's paths and the shadows in the views, traced by the processor: a second implementation of the passes
//! `path_trace` and `shadows`, for software devices. `prepared::record` runs it.
//!
//! The device draws the G-buffer and lists the pixels that reflect. Both are read back, all cores trace the paths, and the
//! mean and its standard error are written into the images that the shader would have written. Each file is the twin of one or
//! a few shader includes and computes the same: materials, lights, shadows, the environment, baked light, and the random
//! numbers of each pixel and sample. The pictures agree except for rounding, which `tests/cpu.rs` checks.

mod baked;
mod brdf;
mod environment;
mod hit_surface;
mod inputs;
mod lights;
mod math;
mod parallel;
mod pass;
mod path_trace;
mod random;
mod shade;
mod shadows;
mod surface;
mod texture;
mod tree;
mod world;

pub(super) use pass::{CpuPathTrace, Paths};
pub use path_trace::{KeptPixel, KeptSums};
pub(super) use shadows::CpuShadows;
pub(super) use world::{StaticScene, World};

use super::method::{HitSource, Method};
use super::settings::Trace;

/// Must be changed with every change of this folder that changes a picture. It is part of the picture's address.
pub const VERSION: u32 = 2;

/// Whether the processor traces a method's paths, on a device of this kind (see `DeviceInfo::kind`).
pub fn traces(method: &Method, trace: Trace, device_kind: &str) -> bool {
    let technique = method.technique();
    let is_reference = technique.hit_source == HitSource::PathTraced && !technique.resolved;
    is_reference && is_chosen(trace, device_kind)
}

/// Whether the processor traces what it can trace, on a device of this kind.
pub fn is_chosen(trace: Trace, device_kind: &str) -> bool {
    match trace {
        Trace::Auto => device_kind == "cpu",
        Trace::Cpu => true,
        Trace::Bvh | Trace::RayQuery => false,
    }
}
