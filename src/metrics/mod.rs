//! How far a picture is from its reference, and how far what one eye sees is from what the other does.
//!
//! Functions of their arguments: no device, no file. Pictures are one eye's pixels, rows from the top; definitions,
//! units and sources are in `docs/compare.md`.

pub mod ambient;
pub mod error;
pub mod fireflies;
pub mod flip;
pub mod jackknife;
pub mod judge;
pub mod lasting;
pub mod moments;
pub mod network;
pub mod pairs;
pub mod sequence;
pub mod ssim;
pub mod stereo;
pub mod tone;

pub use error::{Errors, errors};
pub use fireflies::Fireflies;
pub use flip::Flip;
pub use judge::{Judge, Scores};
pub use lasting::Agreement;
pub use moments::Moments;
pub use network::Networks;
pub use pairs::{Pairs, Surfaces};
pub use ssim::Ssim;

/// Of linear Rec. 709.
pub fn luminance(color: [f32; 3]) -> f64 {
    0.2126 * f64::from(color[0]) + 0.7152 * f64::from(color[1]) + 0.0722 * f64::from(color[2])
}

/// The mean, `None` of nothing.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut n) = (0.0, 0u64);
    for value in values {
        sum += value;
        n += 1;
    }
    (n > 0).then(|| sum / n as f64)
}
