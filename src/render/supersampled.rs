//! For antialiasing, the view's finer twin: surfaces and their light, drawn with several samples along each side of a pixel.
//!
//! Reflections are still computed once for each pixel. `composite.comp` combines the two, in the same way for every method and
//! the reference.

use std::rc::Rc;

use crate::gpu::{Gpu, GpuError};
use crate::scene::{Scene, StereoCamera};

use super::context::Context;
use super::method::Method;
use super::needs::FrameNeeds;
use super::settings::Settings;
use super::targets::Targets;

/// See the module's documentation.
pub struct SupersampledView {
    pub context: Context,
    pub targets: Targets,
    finer: u32,
}

impl SupersampledView {
    /// `drawn` with `finer` times the width and height.
    pub fn settings(drawn: &Settings, finer: u32) -> Settings {
        Settings { width: drawn.width * finer, height: drawn.height * finer, ..drawn.clone() }
    }

    /// `context` must have been made for [`SupersampledView::settings`].
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn new(
        gpu: &Rc<Gpu>,
        context: Context,
        drawn: &Settings,
        (needs, method): (&FrameNeeds, &Method),
        finer: u32,
    ) -> Result<SupersampledView, GpuError> {
        let targets =
            Targets::new(gpu, &SupersampledView::settings(drawn, finer), (1, 1), &needs.of_surfaces(), method)?;
        Ok(SupersampledView { context, targets, finer })
    }

    /// As [`Context::update`].
    pub fn update(&self, eyes: &StereoCamera, drawn: &Settings, scene: &Scene) {
        self.context.update(eyes, &SupersampledView::settings(drawn, self.finer), scene);
    }
}
