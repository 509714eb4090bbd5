//! The device that cases render on, and the pictures that they made there.

use std::rc::Rc;
use std::sync::Arc;

use crate::console::check_interrupted;
use crate::gpu::Gpu;
use crate::picture::StereoPicture;
use crate::render::shared::Counts;
use crate::render::{Method, Prepared, RenderError, Renderer, Settings};
use crate::scene::{Scene, StereoCamera};

/// One picture of a case, kept so that a failure can be looked at.
#[derive(Debug)]
pub struct Shot {
    /// What it shows, and by which method.
    pub label: String,
    pub linear: StereoPicture,
    pub reflection: StereoPicture,
    /// sRGB bytes (RGBA) by eye.
    pub display: [Vec<u8>; 2],
    /// By eye; `None` where ambient light is not occluded.
    pub ambient_visibility: Option<[Vec<f32>; 2]>,
    pub counters: Counts,
    /// Values that the device counted as NaN or infinite, or that were read back as such.
    pub not_finite: u64,
}

/// See the module's documentation.
pub struct Bench {
    gpu: Rc<Gpu>,
    /// The last scene: several methods share its upload.
    renderer: Option<(Arc<Scene>, Renderer)>,
    shots: Vec<Rc<Shot>>,
}

impl Bench {
    pub fn new(gpu: &Rc<Gpu>) -> Bench {
        Bench { gpu: Rc::clone(gpu), renderer: None, shots: Vec::new() }
    }

    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The pictures since [`Bench::forget`].
    pub fn shots(&self) -> &[Rc<Shot>] {
        &self.shots
    }

    /// The first of them that holds a value which is not finite.
    pub fn not_finite(&self) -> Option<Rc<Shot>> {
        self.shots.iter().find(|s| s.not_finite > 0).cloned()
    }

    /// Forgets the pictures.
    pub fn forget(&mut self) {
        self.shots.clear();
    }

    /// Renders the scene's first view. A picture that holds NaN or infinity is kept and counted, not refused.
    ///
    /// # Errors
    /// When a Vulkan call fails, or on Ctrl-C.
    pub fn render(
        &mut self,
        label: &str,
        scene: &Arc<Scene>,
        method: &str,
        settings: &Settings,
    ) -> Result<Rc<Shot>, RenderError> {
        let camera = scene.views[0].stereo_camera(settings.aspect());
        self.render_from(label, scene, method, settings, &camera)
    }

    /// The same from any eyes.
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
    ) -> Result<Rc<Shot>, RenderError> {
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
        let shot = Rc::new(Shot {
            label: format!("{label} {method}"),
            linear,
            reflection,
            display: prepared.display()?,
            ambient_visibility,
            counters,
            not_finite: counted.max(read),
        });
        self.shots.push(Rc::clone(&shot));
        Ok(shot)
    }

    /// A view and a method ready for many frames; their pictures are not kept.
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
