//! What is compared: every method at every sample count, with every fallback.

use std::path::PathBuf;
use std::sync::Arc;

use crate::metrics::Networks;
use crate::render::{Method, Settings};
use crate::scene::{Fallback, Scene, Shelf};

/// Everything asked of a comparison besides its scenes.
#[derive(Debug, Clone)]
pub struct Options {
    /// The first is the baseline: what the others are divided by. A count in a name is that method's only one.
    pub methods: Vec<Method>,
    /// Rays a pixel.
    pub spp: Vec<u32>,
    /// Rounds, and so random seeds, at least two.
    pub seeds: u32,
    /// The reference with its paths a pixel.
    pub reference: Method,
    /// It stops earlier where its relative error is at most this; see `Prepared::set_until`.
    pub until: Option<f64>,
    /// Size, fade and whatever else; seed and fallback are set by the plan.
    pub settings: Settings,
    pub fallback: Fallbacks,
    /// One of each scene's views; its first by default.
    pub view: Option<String>,
    /// Of FLIP.
    pub pixels_per_degree: f32,
    /// Of LPIPS and DISTS; none: these are not measured.
    pub networks: Arc<Networks>,
    /// Where references are kept.
    pub cache: PathBuf,
    /// Where results are kept, and taken from; none: every scene is measured.
    pub keep: Option<PathBuf>,
    pub out: PathBuf,
    /// Pictures and enlarged crops of every method as well.
    pub sheets: bool,
    /// Where the scenes are loaded, once each.
    pub scenes: Shelf,
}

/// What unknown rays see.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fallbacks {
    One(Fallback),
    /// Black, and the scene's own where that is another.
    Both,
}

/// One line of the result: a method with its samples and its fallback.
#[derive(Debug, Clone)]
pub struct Configuration {
    /// Without `@N`.
    pub name: String,
    pub method: Method,
    pub fallback: Fallback,
}

impl Options {
    /// Every configuration once, in the order of methods, then samples, fallback by fallback.
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

/// `sssr` of `sssr@4`.
pub fn base_name(method: &Method) -> String {
    let text = method.to_string();
    text.split('@').next().unwrap_or(&text).to_owned()
}
