//! Ambient occlusion: how much of its surroundings each pixel sees (seed 001: Wu, adaptive stereo ambient occlusion). Its passes
//! read the G-buffer and write the visibility that the lighting pass reads.

pub mod images;
mod rays;
pub mod settings;
mod views;

use std::rc::Rc;

use super::bvh::RayScene;
use super::method::Ao;
use super::needs::FrameNeeds;
use crate::gpu::{Gpu, GpuError};
use settings::AoSettings;

pub use rays::RaysPass;
pub use views::{AoBindings, ViewsPass};

/// The passes of one method.
pub enum AoPass {
    Views(Box<ViewsPass>),
    Rays(Box<RaysPass>),
}

impl AoPass {
    /// `None` without ambient occlusion.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(
        gpu: &Rc<Gpu>,
        needs: &FrameNeeds,
        settings: AoSettings,
        rays: Option<&RayScene>,
    ) -> Result<Option<AoPass>, GpuError> {
        Ok(match (settings.method, rays) {
            (Ao::RayTraced, Some(rays)) => Some(AoPass::Rays(Box::new(RaysPass::new(gpu, needs, settings, rays)?))),
            (ao, _) if ao.is_estimated() => Some(AoPass::Views(Box::new(ViewsPass::new(gpu, settings)?))),
            _ => None,
        })
    }
}
