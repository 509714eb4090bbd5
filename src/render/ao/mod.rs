//! Ambient occlusion: how much of its surroundings each pixel sees, between the G-buffer and the lighting (seed 001: Wu,
//! adaptive stereo ambient occlusion).

pub mod images;
mod rays;
pub mod settings;
mod views;

use std::rc::Rc;

use super::bvh::RayScene;
use super::method::Ao;
use super::needs::Needs;
use crate::gpu::{Gpu, GpuError};
use settings::AoSettings;

pub use rays::RaysPass;
pub use views::{Seen, ViewsPass};

/// The passes of one way to find it.
pub enum AoPass {
    Views(Box<ViewsPass>),
    Rays(RaysPass),
}

impl AoPass {
    /// `None` where nothing is occluded.
    ///
    /// # Errors
    /// What the device said.
    pub fn new(
        gpu: &Rc<Gpu>,
        needs: &Needs,
        settings: AoSettings,
        rays: Option<&RayScene>,
    ) -> Result<Option<AoPass>, GpuError> {
        Ok(match (settings.method, rays) {
            (Ao::RayTraced, Some(rays)) => Some(AoPass::Rays(RaysPass::new(gpu, needs, settings, rays)?)),
            (ao, _) if ao.is_estimated() => Some(AoPass::Views(Box::new(ViewsPass::new(gpu, settings)?))),
            _ => None,
        })
    }
}
