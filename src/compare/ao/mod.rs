//! `compare --effect ao`: compares methods of ambient occlusion as seed 001 does (Wu, adaptive stereo ambient
//! occlusion).
//!
//! Names of scenes and [`AoOptions`] go in. The results are the time of each pass, the share of pixels that differ
//! visibly between the eyes, errors, the effect of the threshold, and all this along a path of the head. They are
//! written as `ao.json`, `ao.md` and drawings. The command `compare` and `paper` call it. `docs/compare.md` has the
//! definitions.

mod configuration;
mod kept;
mod path;
mod plots;
mod report;
mod run;
mod tables;

use std::path::PathBuf;
use std::rc::Rc;

use cyclopean_analysis::files;

use super::{CompareError, file_stem, keep_failure, make_folder, sweep_folder};
use crate::console::Console;
use crate::gpu::Gpu;
use crate::render::{AoSettings, Settings};
use crate::scene::SceneCache;

pub use report::{AoPath, AoPathRow, AoReport, AoRow, AoScene};
pub use run::scene;
pub use tables::markdown;

/// Everything that a comparison is asked for besides its scenes.
#[derive(Debug, Clone)]
pub struct AoOptions {
    /// Size, radius, threshold, and the number of rays of `ray-traced`. The comparison sets seed and method itself.
    pub settings: Settings,
    /// The number of rounds, each with its own random seed; at least one.
    pub seeds: u32,
    /// The number of poses along the path of the head. 0: no path is measured.
    pub poses: u32,
    /// The view of each scene. `None`: its first.
    pub view: Option<String>,
    /// The folder in which results are kept and looked for. `None`: every scene is measured.
    pub keep: Option<PathBuf>,
    pub out: PathBuf,
    /// Loads each scene once.
    pub scenes: SceneCache,
}

/// Compares on each scene. After each one, writes `ao.json`, `ao.md` and the scene's drawings into `options.out`. A
/// scene that fails is named in the report's `failed`.
///
/// # Errors
/// An output that cannot be written, or Ctrl-C.
pub fn compare(
    gpu: &Rc<Gpu>,
    scenes: &[String],
    options: &AoOptions,
    console: &Console,
) -> Result<AoReport, CompareError> {
    compare_and_show(gpu, scenes, options, &mut |_| (), console)
}

/// [`compare`], which calls `show` with each scene's name as soon as the scene is done or has failed.
///
/// # Errors
/// As [`compare`].
pub fn compare_and_show(
    gpu: &Rc<Gpu>,
    scenes: &[String],
    options: &AoOptions,
    show: &mut dyn FnMut(&str),
    console: &Console,
) -> Result<AoReport, CompareError> {
    let (out, settings) = (&options.out, &options.settings);
    // An error with the folders is found before the work, not after it.
    make_folder(out)?;
    if let Some(folder) = &options.keep {
        make_folder(folder)?;
        sweep_folder(folder)?;
    }
    let mut report = AoReport {
        device: gpu.info().clone(),
        width: settings.width,
        height: settings.height,
        seeds: options.seeds,
        radius_m: settings.ao.radius_m,
        threshold: settings.ao.threshold,
        rays: settings.ao.rays,
        scenes: Vec::new(),
        failed: Vec::new(),
    };
    for name in scenes {
        match run::scene(gpu, name, options, console) {
            Ok(done) => {
                let before = report.scenes.iter().filter(|s| s.scene == done.scene).count();
                let stem = file_stem(&done.scene, before);
                for (what, svg) in drawings(&done) {
                    files::write_bytes(&out.join(format!("{stem}_ao_{what}.svg")), svg.as_bytes())?;
                }
                report.scenes.push(done);
            }
            Err(error) => keep_failure(&mut report.failed, name, error, console)?,
        }
        show(name);
        files::write_bytes(&out.join("ao.json"), &serde_json::to_vec_pretty(&report)?)?;
        files::write_bytes(&out.join("ao.md"), markdown(&report).as_bytes())?;
    }
    Ok(report)
}

/// The scene's drawings by name: `threshold` and `path`, each only where there is something to draw.
pub fn drawings(scene: &AoScene) -> Vec<(&'static str, String)> {
    let all = [("threshold", plots::threshold(scene)), ("path", plots::path(scene))];
    all.into_iter().filter_map(|(what, svg)| Some((what, svg?))).collect()
}

/// The number of configurations of a comparison, which is the number of frames in a round.
pub fn configuration_count(asked: AoSettings) -> usize {
    configuration::configurations(asked).len()
}
