//! `compare --effect ao`: ways to occlude ambient light side by side, as seed 001 (Wu, adaptive stereo ambient occlusion)
//! compares them: time by pass, pixels that differ visibly between the eyes, errors, the threshold, a path.
//! Definitions are in `docs/compare.md`.

mod path;
mod plots;
mod report;
mod run;
mod tables;

use std::path::PathBuf;
use std::rc::Rc;

use cyclopean_analysis::files;

use super::{CompareError, file_stem, keep_failure};
use crate::console::Console;
use crate::gpu::Gpu;
use crate::render::Settings;
use crate::scene::Loading;

pub use report::AoReport;
pub use tables::markdown;

/// Everything asked of a comparison besides its scenes.
#[derive(Debug, Clone)]
pub struct AoOptions {
    /// Size, radius, threshold and the oracle's rays; seed and method are set by the plan.
    pub settings: Settings,
    /// Rounds, and so random seeds, at least one.
    pub seeds: u32,
    /// Of the path; 0: none.
    pub poses: u32,
    /// One of each scene's views; its first by default.
    pub view: Option<String>,
    pub out: PathBuf,
    /// How the scenes are loaded.
    pub loading: Loading,
}

/// Compares on each scene, writing `ao.json`, `ao.md` and the scene's drawings into `options.out` after each. A scene that
/// fails is in the report's `failed`.
///
/// # Errors
/// An output that cannot be written, or Ctrl-C.
pub fn compare(
    gpu: &Rc<Gpu>,
    scenes: &[String],
    options: &AoOptions,
    console: &Console,
) -> Result<AoReport, CompareError> {
    let (out, settings) = (&options.out, &options.settings);
    // Fail before the work, not after it.
    std::fs::create_dir_all(out).map_err(|source| CompareError::Folder { path: out.clone(), source })?;
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
                let drawings = [("threshold", plots::threshold(&done)), ("path", plots::path(&done))];
                for (what, svg) in drawings.into_iter().filter_map(|(what, svg)| Some((what, svg?))) {
                    files::write_bytes(&out.join(format!("{stem}_ao_{what}.svg")), svg.as_bytes())?;
                }
                report.scenes.push(done);
            }
            Err(error) => keep_failure(&mut report.failed, name, error, console)?,
        }
        files::write_bytes(&out.join("ao.json"), &serde_json::to_vec_pretty(&report)?)?;
        files::write_bytes(&out.join("ao.md"), markdown(&report).as_bytes())?;
    }
    Ok(report)
}
