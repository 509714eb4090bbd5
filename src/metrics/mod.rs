//! Measures how far a picture is from its reference, and how far the picture of one eye is from that of the other.
//!
//! Pictures go in, each as the pixels of one eye with the rows from the top. Numbers come out. Nothing here uses a
//! graphics device or reads a file. `compare` and the command that compares two pictures call it. `docs/compare.md` has
//! the definitions, units and sources.

pub mod ambient;
pub mod error;
pub mod fireflies;
pub mod flip;
pub mod jackknife;
pub mod judge;
pub mod lasting_contrast;
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
pub use lasting_contrast::ReferenceAgreement;
pub use moments::Moments;
pub use network::Networks;
pub use pairs::{Pairs, Surfaces};
pub use ssim::Ssim;

/// The luminance of a linear Rec. 709 colour.
pub fn luminance(color: [f32; 3]) -> f64 {
    0.2126 * f64::from(color[0]) + 0.7152 * f64::from(color[1]) + 0.0722 * f64::from(color[2])
}

/// The mean of some values. `None` without any.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut n) = (0.0, 0u64);
    for value in values {
        sum += value;
        n += 1;
    }
    (n > 0).then(|| sum / n as f64)
}
