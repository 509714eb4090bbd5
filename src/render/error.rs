//! Why a picture could not be made.

use cyclopean_analysis::files::WriteError;

use crate::console::Interrupted;
use crate::gpu::GpuError;

/// The largest width and height, pixels (twin: `pack_pixel` in ray_list.glsl).
pub const MOST_PIXELS: u32 = 1 << 14;

/// A picture could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// Baked light could not be written to its folder.
    #[error(transparent)]
    Kept(#[from] WriteError),
    /// A ray list has only fourteen bits each for column and row.
    #[error(
        "a picture of {width}×{height} pixels an eye (a guard band included) is too large: at most {MOST_PIXELS} a side"
    )]
    TooLarge { width: u32, height: u32 },
    /// The picture contains NaNs or infinities.
    #[error(
        "scene `{scene}`, method `{method}`: {nan} values are not numbers and {inf} are infinite; the picture is refused"
    )]
    NotFinite { scene: String, method: String, nan: u64, inf: u64 },
}
