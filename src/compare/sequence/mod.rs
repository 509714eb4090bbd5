//! `compare --path`: compares methods along a path of the head, each frame with a reference of its own.
//!
//! Names of scenes and [`SequenceOptions`] go in. The results are errors and times, flicker, the errors after a cut,
//! and the disagreement between the eyes. They are written as `sequence.json`, `sequence.md` and drawings. The command
//! `compare` calls it. `docs/compare.md` has the definitions.

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

/// Finds the path that a comparison follows through a scene from a view, or says why there is none.
pub type FindPath<'a> = &'a dyn Fn(&Scene, &View) -> Result<HeadPath, String>;

/// Everything that a comparison is asked for besides its scenes.
pub struct SequenceOptions<'a> {
    /// The methods. The first is the baseline, by which the others are divided. A method with a count in its name has
    /// no other count.
    pub methods: Vec<Method>,
    /// The numbers of rays a pixel at which every method is measured.
    pub spp: Vec<u32>,
    /// The method of the reference, with its paths a pixel.
    pub reference: Method,
    pub settings: Settings,
    /// The path as it was asked for.
    pub path_name: String,
    pub path: FindPath<'a>,
    /// How many frames of the path are used, from its beginning; at least two. `None`: all.
    pub frames: Option<u32>,
    /// The view of each scene. `None`: its first.
    pub view: Option<String>,
    pub out: PathBuf,
    /// How the scenes are loaded.
    pub loading: Loading,
}

/// Compares on each scene. After each one, writes `sequence.json`, `sequence.md` and the scene's drawing into
/// `options.out`. A scene that fails is named in the report's `failed`.
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
    // An error with the folder is found before the work, not after it.
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
