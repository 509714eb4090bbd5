//! The renderer. Each technique has one file here and shaders of the same name.
//!
//! A scene, a camera, a method and settings go in ([`Request`], [`Settings`]). `Renderer::prepare` makes a [`Prepared`] of them,
//! whose frames record the passes (`prepared::record`); stereo pictures with times and counters come out
//! ([`Rendered`], [`FrameReport`]). The commands, `compare`, `paper` and `stress` call it. Only the passes that scene, method and
//! settings need run ([`needs`]).

mod accumulate;
pub mod ao;
mod baked;
mod brdf_table;
mod bvh;
mod classify;
mod composite;
mod context;
mod convergence;
pub mod cpu;
mod depth_pyramid;
mod error;
mod framing;
mod gbuffer;
pub mod geometry;
mod history;
pub mod hits;
mod identity;
mod indirect;
mod lazy_rays;
mod lighting;
mod mips;
pub mod needs;
mod path_rays;
mod path_trace;
mod prepared;
mod probe;
mod ray_list;
mod ray_structure;
mod renderer;
mod reproject;
mod resolve;
pub mod settings;
mod supersampled;

pub mod shaders;
mod shading_reuse;
mod shadow_maps;
mod shadows;
pub mod shared;
mod targets;
mod trace;
mod trace_geometry;
mod upload;

pub use crate::method;
pub use ao::settings::AoSettings;
pub use bvh::fast_ray_queries;
pub use error::RenderError;
pub use geometry::Geometry;
pub use identity::identity;
pub use method::{Ao, Method, Reuse, Temporal};
pub use prepared::{FrameReport, Prepared};
pub use renderer::{Rendered, Renderer, Request, SETTLING, median_of_sorted};
pub use settings::{Firefly, Settings, ShadingReuse, Shadows, Streams, Trace};
