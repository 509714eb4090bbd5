//! Stereo-consistent screen-space reflections, shown to people and judged with honest statistics.
//!
//! Data flows one way: study → session → display → render; see ARCHITECTURE.md.

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
