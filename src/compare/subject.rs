//! The subject of a comparison on one scene: the scene, one of its views, and the cameras of both eyes. The name of a
//! scene goes in. `super::scene`, `run`, `sheet` and the other comparisons use it.

use std::rc::Rc;
use std::sync::Arc;

use super::CompareError;
use super::plan::Options;
use super::reference::Reference;
use crate::console::Console;
use crate::gpu::Gpu;
use crate::render::Renderer;
use crate::scene::{Scene, StereoCamera, View};

/// A scene, one of its views, and the cameras of both eyes.
pub struct Subject {
    pub scene: Arc<Scene>,
    pub view: View,
    pub camera: StereoCamera,
}

impl Subject {
    /// Loads a scene and takes the view that the options name.
    ///
    /// # Errors
    /// The scene cannot be loaded, or it does not have the view.
    pub fn load(name: &str, options: &Options) -> Result<Subject, CompareError> {
        let scene = options.scenes.load(name)?;
        let view = view(&scene, options.view.as_deref())?.clone();
        let camera = view.stereo_camera(options.settings.aspect());
        Ok(Subject { scene, view, camera })
    }

    /// A renderer of the scene, and the reference of the view, which is the stored one or a new one.
    ///
    /// # Errors
    /// A failure of the device or of the disk.
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

/// The scene's view of this name. Without a name, its first view.
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
