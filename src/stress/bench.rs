//! The bench that cases render on: it has the device and keeps the pictures of a case. Scenes and settings go in and a
//! [`CasePicture`] comes out. The cases and sweeps call it; the command `stress` writes the pictures of those that fail.

use std::rc::Rc;
use std::sync::Arc;

use crate::console::check_interrupted;
use crate::gpu::Gpu;
use crate::picture::StereoPicture;
use crate::render::shared::Counts;
use crate::render::{Method, Prepared, RenderError, Renderer, Settings};
use crate::scene::{Scene, StereoCamera};

/// One picture of a case. It is kept so that somebody can look at it if the case fails.
#[derive(Debug)]
pub struct CasePicture {
    /// What the picture shows, and the method.
    pub label: String,
    pub linear: StereoPicture,
    pub reflection: StereoPicture,
    /// What a display shows, as sRGB bytes (RGBA) by eye.
    pub display: [Vec<u8>; 2],
    /// The visibility of each pixel by eye. `None`: there is no ambient occlusion.
    pub ambient_visibility: Option<[Vec<f32>; 2]>,
    pub counters: Counts,
    /// The number of values that the device counted as NaN or infinite, or of those that were read back as such,
    /// whichever is larger.
    pub not_finite: u64,
}

/// A device, and the pictures that a case has made on it.
pub struct Bench {
    gpu: Rc<Gpu>,
    /// The last scene with its renderer, so that several methods need only one upload.
    renderer: Option<(Arc<Scene>, Renderer)>,
    shots: Vec<Rc<CasePicture>>,
}

impl Bench {
    pub fn new(gpu: &Rc<Gpu>) -> Bench {
        Bench { gpu: Rc::clone(gpu), renderer: None, shots: Vec::new() }
    }

    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The pictures since the last [`Bench::forget`].
    pub fn shots(&self) -> &[Rc<CasePicture>] {
        &self.shots
    }

    /// The first picture with a value that is not finite.
    pub fn not_finite(&self) -> Option<Rc<CasePicture>> {
        self.shots.iter().find(|s| s.not_finite > 0).cloned()
    }

    /// Forgets all pictures.
    pub fn forget(&mut self) {
        self.shots.clear();
    }

    /// Renders the scene's first view. A picture with NaN or infinity is no error: it is kept, and the values are
    /// counted.
    ///
    /// # Errors
    /// When a Vulkan call fails, or on Ctrl-C.
    pub fn render(
        &mut self,
        label: &str,
        scene: &Arc<Scene>,
        method: &str,
        settings: &Settings,
    ) -> Result<Rc<CasePicture>, RenderError> {
        let camera = scene.views[0].stereo_camera(settings.aspect());
        self.render_from(label, scene, method, settings, &camera)
    }

    /// Renders the scene from any pair of eyes, as [`Bench::render`] does.
    ///
    /// # Errors
    /// As [`Bench::render`].
    pub fn render_from(
        &mut self,
        label: &str,
        scene: &Arc<Scene>,
        method: &str,
        settings: &Settings,
        camera: &StereoCamera,
    ) -> Result<Rc<CasePicture>, RenderError> {
        let prepared = self.prepare(scene, method, settings, camera)?;
        let (counters, counted) = match prepared.frame(&mut |_, _| check_interrupted()) {
            Ok(report) => (report.counters, 0),
            Err(RenderError::NotFinite { nan, inf, .. }) => (Counts { nan, inf, ..Counts::default() }, nan + inf),
            Err(other) => return Err(other),
        };
        let (linear, reflection) = (prepared.linear()?, prepared.reflection()?);
        let values = [&linear, &reflection].into_iter().flat_map(|p| p.eyes.iter().flatten().flatten());
        let ambient_visibility = prepared.ambient_visibility()?;
        let values = values.chain(ambient_visibility.iter().flatten().flatten());
        let read = values.filter(|v| !v.is_finite()).count() as u64;
        let rendered = Rc::new(CasePicture {
            label: format!("{label} {method}"),
            linear,
            reflection,
            display: prepared.display()?,
            ambient_visibility,
            counters,
            not_finite: counted.max(read),
        });
        self.shots.push(Rc::clone(&rendered));
        Ok(rendered)
    }

    /// Prepares a view and a method for many frames. Their pictures are not kept.
    ///
    /// # Errors
    /// As [`Bench::render`].
    pub fn prepare(
        &mut self,
        scene: &Arc<Scene>,
        method: &str,
        settings: &Settings,
        camera: &StereoCamera,
    ) -> Result<Prepared, RenderError> {
        check_interrupted()?;
        let method = Method::parse(method).expect("cases name methods that exist");
        let renderer = match self.renderer.take() {
            Some((held, renderer)) if Arc::ptr_eq(&held, scene) => renderer,
            Some((_, renderer)) => renderer.with_scene(Arc::clone(scene))?,
            None => Renderer::new(&self.gpu, Arc::clone(scene))?,
        };
        let (_, renderer) = self.renderer.insert((Arc::clone(scene), renderer));
        renderer.prepare(camera, &method, settings)
    }
}
