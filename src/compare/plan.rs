//! What is compared. [`Options`] say what was asked for, and [`Options::configurations`] lists every method with every
//! sample count and every fallback. `run`, `sheet` and `kept` call it.

use std::path::PathBuf;
use std::sync::Arc;

use crate::metrics::Networks;
use crate::render::{Method, Settings};
use crate::scene::{Fallback, Scene, SceneCache};

/// Everything that a comparison is asked for besides its scenes.
#[derive(Debug, Clone)]
pub struct Options {
    /// The methods. The first is the baseline, by which the others are divided. A method with a count in its name has
    /// no other count.
    pub methods: Vec<Method>,
    /// The numbers of rays a pixel at which every method is measured.
    pub spp: Vec<u32>,
    /// The number of rounds, each with its own random seed; at least two.
    pub seeds: u32,
    /// The method of the reference, with its paths a pixel.
    pub reference: Method,
    /// The reference stops earlier once its relative error is at most this; see `Prepared::set_until`. `None`: it does
    /// not stop earlier.
    pub until: Option<f64>,
    /// Size, fade and everything else that all configurations share. The comparison sets seed and fallback itself.
    pub settings: Settings,
    pub fallback: Fallbacks,
    /// The view of each scene. `None`: its first.
    pub view: Option<String>,
    /// Pixels per degree, for FLIP.
    pub pixels_per_degree: f32,
    /// The networks of LPIPS and DISTS. A measure without its network is left out.
    pub networks: Arc<Networks>,
    /// The folder in which references are kept.
    pub cache: PathBuf,
    /// The folder in which results are kept and looked for. `None`: every scene is measured.
    pub keep: Option<PathBuf>,
    pub out: PathBuf,
    /// Whether sheets are drawn: pictures of every method with enlarged parts.
    pub sheets: bool,
    /// Loads each scene once.
    pub scenes: SceneCache,
}

/// Which fallbacks are compared, that is, what unknown rays see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fallbacks {
    One(Fallback),
    /// Black, and the scene's own fallback where that is another one.
    Both,
}

/// What one row of the results is about: a method with its number of samples and its fallback.
#[derive(Debug, Clone)]
pub struct Configuration {
    /// The name of the method without `@N`.
    pub name: String,
    pub method: Method,
    pub fallback: Fallback,
}

impl Options {
    /// Every configuration once: fallback by fallback, within it method by method, within that in the order of the
    /// sample counts.
    pub fn configurations(&self, scene: &Scene) -> Vec<Configuration> {
        let fallbacks = match self.fallback {
            Fallbacks::One(fallback) => vec![fallback],
            Fallbacks::Both if scene.fallback == Fallback::Black => vec![Fallback::Black],
            Fallbacks::Both => vec![Fallback::Black, scene.fallback],
        };
        let mut all: Vec<Configuration> = Vec::new();
        for fallback in fallbacks {
            for (method, spp) in self.methods.iter().flat_map(|m| self.spp.iter().map(move |spp| (m, *spp))) {
                let method = method.clone().with_samples(Some(spp));
                if !all.iter().any(|c| (&c.method, c.fallback) == (&method, fallback)) {
                    all.push(Configuration { name: base_name(&method), method, fallback });
                }
            }
        }
        all
    }
}

/// A method's name without its count, such as `sssr` for `sssr@4`.
pub fn base_name(method: &Method) -> String {
    let text = method.to_string();
    text.split('@').next().unwrap_or(&text).to_owned()
}
