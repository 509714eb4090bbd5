//! What one scene's comparison is about: the scene, one of its views, and both eyes' cameras.

use std::rc::Rc;
use std::sync::Arc;

use super::CompareError;
use super::plan::Options;
use super::reference::Reference;
use crate::console::Console;
use crate::gpu::Gpu;
use crate::render::Renderer;
use crate::scene::{Scene, StereoCamera, View};

/// See the module's documentation.
pub struct Subject {
    pub scene: Arc<Scene>,
    pub view: View,
    pub camera: StereoCamera,
}

impl Subject {
    /// Loads a scene and looks at it as the options say.
    ///
    /// # Errors
    /// A scene that cannot be loaded, or lacks the view.
    pub fn load(name: &str, options: &Options) -> Result<Subject, CompareError> {
        let scene = options.scenes.load(name)?;
        let view = view(&scene, options.view.as_deref())?.clone();
        let camera = view.stereo_camera(options.settings.aspect());
        Ok(Subject { scene, view, camera })
    }

    /// A renderer of the scene, and the view's reference: the kept one, or a new one.
    ///
    /// # Errors
    /// What the device or the disk said.
    pub fn reference(
        &self,
        gpu: &Rc<Gpu>,
        options: &Options,
        console: &Console,
    ) -> Result<(Renderer, Reference), CompareError> {
        let mut renderer = Renderer::new(gpu, Arc::clone(&self.scene))?.keep_light_in(options.cache.join("light"));
        let reference = Reference::obtain(gpu, &mut renderer, &self.camera, options, console)?;
        Ok((renderer, reference))
    }
}

/// The scene's view of this name; its first by default.
///
/// # Errors
/// [`CompareError::NoView`].
pub fn view<'a>(scene: &'a Scene, name: Option<&str>) -> Result<&'a View, CompareError> {
    let found = match name {
        None => scene.views.first(),
        Some(name) => scene.views.iter().find(|v| v.name == name),
    };
    found.ok_or_else(|| CompareError::NoView {
        scene: scene.name.clone(),
        view: name.unwrap_or("").to_owned(),
        known: scene.views.iter().map(|v| v.name.as_str()).collect::<Vec<_>>().join(", "),
    })
}
