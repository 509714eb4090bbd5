//! Stereo-consistent screen-space reflections, studies that show them to people, and comparisons with a reference.
//!
//! A study decides what is shown, a session runs it, a display shows it, and the renderer has made it before; see
//! ARCHITECTURE.md.

pub mod commands;
#[cfg(feature = "gpu")]
pub mod compare;
pub mod console;
pub mod display;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod method;
pub mod metrics;
#[cfg(feature = "gpu")]
pub mod paper;
pub mod picture;
#[cfg(feature = "gpu")]
pub mod render;
pub mod scene;
pub mod shard;
#[cfg(feature = "gpu")]
pub mod stress;
pub mod study;
