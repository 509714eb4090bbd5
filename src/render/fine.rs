//! For antialiasing, the view's finer twin: surfaces and their light, drawn with several samples along each side of a pixel.
//!
//! Reflections are still computed once for each pixel. `composite.comp` combines the two, in the same way for every method and
//! the reference.

use std::rc::Rc;

use crate::gpu::{Gpu, GpuError};
use crate::scene::{Scene, StereoCamera};

use super::context::Context;
use super::method::Method;
use super::needs::Needs;
use super::settings::Settings;
use super::targets::Targets;

/// See the module's documentation.
pub struct Fine {
    pub context: Context,
    pub targets: Targets,
    finer: u32,
}

impl Fine {
    /// `drawn` with `finer` times the width and height.
    pub fn settings(drawn: &Settings, finer: u32) -> Settings {
        Settings { width: drawn.width * finer, height: drawn.height * finer, ..drawn.clone() }
    }

    /// `context` must have been made for [`Fine::settings`].
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn new(
        gpu: &Rc<Gpu>,
        context: Context,
        drawn: &Settings,
        (needs, method): (&Needs, &Method),
        finer: u32,
    ) -> Result<Fine, GpuError> {
        let targets = Targets::new(gpu, &Fine::settings(drawn, finer), (1, 1), &needs.of_surfaces(), method)?;
        Ok(Fine { context, targets, finer })
    }

    /// As [`Context::update`].
    pub fn update(&self, eyes: &StereoCamera, drawn: &Settings, scene: &Scene) {
        self.context.update(eyes, &Fine::settings(drawn, self.finer), scene);
    }
}
