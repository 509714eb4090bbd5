//! `compare --path`: methods along a path of the head, each frame against its own reference: error against time, flicker,
//! what is wrong after a cut, and what the eyes disagree on. Definitions are in `docs/compare.md`.

mod plots;
mod report;
mod run;
mod summary;
mod tables;

use std::path::PathBuf;
use std::rc::Rc;

use cyclopean_analysis::files;

use super::{CompareError, file_stem, keep_failure};
use crate::console::Console;
use crate::gpu::Gpu;
use crate::render::{Method, Settings};
use crate::scene::{HeadPath, Loading, Scene, View};

pub use report::SequenceReport;
pub use tables::markdown;

/// The path that a comparison follows through a scene from a view, or why there is none.
pub type FindPath<'a> = &'a dyn Fn(&Scene, &View) -> Result<HeadPath, String>;

/// Everything asked of a comparison besides its scenes.
pub struct SequenceOptions<'a> {
    /// The first is the baseline: what the others are divided by. A count in a name is that method's only one.
    pub methods: Vec<Method>,
    /// Rays a pixel.
    pub spp: Vec<u32>,
    /// The reference with its paths a pixel.
    pub reference: Method,
    pub settings: Settings,
    /// As it was asked for.
    pub path_name: String,
    pub path: FindPath<'a>,
    /// The first ones of the path, at least two; `None`: all.
    pub frames: Option<u32>,
    /// One of each scene's views; its first by default.
    pub view: Option<String>,
    pub out: PathBuf,
    /// How the scenes are loaded.
    pub loading: Loading,
}

/// Compares on each scene, writing `sequence.json`, `sequence.md` and the scene's drawing into `options.out` after each. A
/// scene that fails is in the report's `failed`.
///
/// # Errors
/// An output that cannot be written, or Ctrl-C.
pub fn compare(
    gpu: &Rc<Gpu>,
    scenes: &[String],
    options: &SequenceOptions<'_>,
    console: &Console,
) -> Result<SequenceReport, CompareError> {
    let (out, settings) = (&options.out, &options.settings);
    // Fail before the work, not after it.
    std::fs::create_dir_all(out).map_err(|source| CompareError::Folder { path: out.clone(), source })?;
    let mut report = SequenceReport {
        device: gpu.info().clone(),
        width: settings.width,
        height: settings.height,
        path: options.path_name.clone(),
        reference_spp: options.reference.samples(),
        settings: settings.clone(),
        scenes: Vec::new(),
        summary: Vec::new(),
        failed: Vec::new(),
    };
    for name in scenes {
        match run::scene(gpu, name, options, console) {
            Ok(done) => {
                let before = report.scenes.iter().filter(|s| s.scene == done.scene).count();
                let stem = file_stem(&done.scene, before);
                if let Some(svg) = plots::over_time(&done, &report.path) {
                    files::write_bytes(&out.join(format!("{stem}_sequence.svg")), svg.as_bytes())?;
                }
                report.scenes.push(done);
            }
            Err(error) => keep_failure(&mut report.failed, name, error, console)?,
        }
        report.summary = summary::over_scenes(&report.scenes);
        files::write_bytes(&out.join("sequence.json"), &serde_json::to_vec_pretty(&report)?)?;
        files::write_bytes(&out.join("sequence.md"), markdown(&report).as_bytes())?;
    }
    Ok(report)
}
