//! Renders stereo-consistent screen-space reflections, compares them with a reference, and shows them to people in
//! studies.
//!
//! The renderer makes the stimuli before the first participant comes. A study says what is shown to whom, a session
//! runs the study, and a display shows the stimuli. ARCHITECTURE.md describes the modules.

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
