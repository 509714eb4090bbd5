//! Compares methods by error against run time: every method with every sample count, on several scenes, against the
//! path-traced reference.
//!
//! Names of scenes and [`Options`] go in. A [`Report`] comes out and is written as `compare.json`, `compare.md`, plots
//! and sheets. The command `compare` and `paper` call it. `docs/compare.md` has the definitions.
//!
//! The frames of a scene are interleaved. Each round renders every configuration once, with the number of the round as
//! its seed, and begins one configuration later than the round before. So changes in the machine's speed affect all
//! configurations alike.

pub mod ao;
mod checkpoint;
mod equal_time;
mod kept;
mod plan;
mod plot;
mod ratios;
mod reference;
mod report;
mod run;
#[cfg(test)]
mod sample;
pub mod sequence;
mod sheet;
mod subject;
mod summary;
mod tables;
mod times;

use std::path::{Path, PathBuf};
use std::rc::Rc;

use cyclopean_analysis::escape;
use cyclopean_analysis::files::{self, WriteError};
use cyclopean_analysis::parts;
use sha2::{Digest, Sha256};

use crate::console::{Console, Interrupted};
use crate::gpu::{Gpu, GpuError};
use crate::metrics::network::NetworkError;
use crate::picture::{self, PictureError};
use crate::render::RenderError;
use crate::scene::SceneError;

use kept::{KeptContent, KeptScene};
use subject::Subject;

pub use kept::PROGRAM;
pub use plan::{Fallbacks, Options};
pub use report::{Failure, Overhead, Report, Row, SceneReport};

/// A scene could not be compared, or its results could not be written.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error("scene `{scene}` has no view `{view}`; it has: {known}")]
    NoView { scene: String, view: String, known: String },
    #[error("{0}")]
    Path(String),
    #[error("scene `{0}`: nothing in view reflects, so there is nothing to compare")]
    NoReflection(String),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error("a network gave no distance: {0}")]
    Network(#[from] NetworkError),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("cannot make the folder {}: {source}", path.display())]
    Folder { path: PathBuf, source: std::io::Error },
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl CompareError {
    /// Whether Ctrl-C was pressed. Then no further scene is begun.
    fn is_interruption(&self) -> bool {
        matches!(self, CompareError::Interrupted(_) | CompareError::Render(RenderError::Interrupted(_)))
    }
}

/// The results of one scene.
#[derive(Debug)]
pub struct SceneComparison {
    pub report: SceneReport,
    /// One sheet for each fallback. It is empty unless sheets were asked for.
    pub sheets: Vec<Sheet>,
}

/// A picture that shows what the methods show, side by side.
#[derive(Debug)]
pub struct Sheet {
    /// The fallback in it, that is, what unknown rays see.
    pub fallback: String,
    pub png: Vec<u8>,
}

/// Compares on one scene. If `options.keep` already holds its results, these are taken, a note says so, and nothing is
/// rendered. New results are kept there as soon as the scene is measured. `options.out` is not used.
///
/// # Errors
/// The scene cannot be compared, or its results cannot be kept.
pub fn scene(gpu: &Rc<Gpu>, name: &str, options: &Options, console: &Console) -> Result<SceneComparison, CompareError> {
    let subject = Subject::load(name, options)?;
    let kept = options.keep.as_ref().map(|folder| KeptScene::new(folder, gpu, &subject, options)).transpose()?;
    let content = match kept.as_ref().and_then(|kept| kept.find(options, console)) {
        Some(content) => content,
        None => {
            let content = KeptContent::new(run::scene(gpu, &subject, options, console)?);
            kept.as_ref().map_or(Ok(()), |kept| kept.keep(&content, console))?;
            content
        }
    };
    if !options.sheets {
        return Ok(SceneComparison { report: content.scene, sheets: Vec::new() });
    }
    if let Some(sheets) = kept.as_ref().and_then(|kept| kept.find_sheets(&content, console)) {
        return Ok(SceneComparison { report: content.scene, sheets });
    }
    let drawn = sheet::sheets(gpu, &subject, options, console)?.into_iter().map(|(fallback, canvas)| {
        let png = picture::encode_png(Path::new(name), canvas.width, canvas.height, &canvas.rgb)?;
        Ok(Sheet { fallback, png })
    });
    let sheets = drawn.collect::<Result<Vec<_>, CompareError>>()?;
    let report = content.scene.clone();
    kept.map_or(Ok(()), |kept| kept.keep_sheets(content, &sheets, console))?;
    Ok(SceneComparison { report, sheets })
}

/// What [`run_part`] leaves behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartOutput {
    /// Results in `options.keep`, and the references that they need.
    Results,
    /// References in `options.cache`.
    References,
}

/// Does the work of a comparison on some of its scenes, without a report. Another run finds that work done and writes
/// the report. Returns the scenes that failed.
///
/// # Errors
/// A folder that cannot be made, or Ctrl-C.
pub fn run_part(
    gpu: &Rc<Gpu>,
    scenes: &[String],
    options: &Options,
    output: PartOutput,
    console: &Console,
) -> Result<Vec<Failure>, CompareError> {
    make_folder(&options.cache)?;
    let mut failed = Vec::new();
    for name in scenes {
        let done = match output {
            PartOutput::Results => scene(gpu, name, options, console).map(drop),
            PartOutput::References => {
                Subject::load(name, options).and_then(|s| s.reference(gpu, options, console)).map(drop)
            }
        };
        match done {
            Ok(()) => console.line(format!("{name}: done")),
            Err(error) => keep_failure(&mut failed, name, error, console)?,
        }
    }
    Ok(failed)
}

/// Compares on each scene. After each one, writes `compare.json`, `compare.md`, the scene's plots and, if asked for,
/// its sheets into `options.out`, so that what is done stays whatever happens to the next scene. A scene that fails is
/// named in the report's `failed`. [`scene`] says what is kept.
///
/// # Errors
/// An output that cannot be written, or Ctrl-C.
pub fn compare(gpu: &Rc<Gpu>, scenes: &[String], options: &Options, console: &Console) -> Result<Report, CompareError> {
    compare_and_show(gpu, scenes, options, &mut |_, _| (), console)
}

/// [`compare`], which calls `show` with each scene's name and results as soon as its drawings and sheets are written.
/// For a scene that failed there are no results.
///
/// # Errors
/// As [`compare`].
pub fn compare_and_show(
    gpu: &Rc<Gpu>,
    scenes: &[String],
    options: &Options,
    show: &mut dyn FnMut(&str, Option<&SceneComparison>),
    console: &Console,
) -> Result<Report, CompareError> {
    // An error with the folders is found before the work, not after it.
    [&options.out, &options.cache].into_iter().chain(&options.keep).try_for_each(|folder| make_folder(folder))?;
    sweep(options)?;
    let mut report = Report::new(gpu.info().clone(), options);
    for name in scenes {
        match scene(gpu, name, options, console) {
            Ok(done) => {
                let before = report.scenes.iter().filter(|s| s.scene == done.report.scene).count();
                draw(&options.out, &done, before)?;
                show(name, Some(&done));
                report.scenes.push(done.report);
            }
            Err(error) => {
                keep_failure(&mut report.failed, name, error, console)?;
                show(name, None);
            }
        }
        report.summary = summary::over_scenes(&report.scenes);
        write(&options.out, &report)?;
    }
    Ok(report)
}

/// Writes a scene's plots and sheets.
fn draw(folder: &Path, done: &SceneComparison, before: usize) -> Result<(), CompareError> {
    let scene = &done.report;
    for (fallback, svg) in plot::plots(scene) {
        files::write_bytes(&folder.join(format!("{}.svg", stem(scene, &fallback, before))), svg.as_bytes())?;
    }
    for plot in plot::family_plots(scene) {
        let family = plot.family.replace(['/', '\\', ' '], "-");
        let file = format!("{}_{family}_knob.svg", stem(scene, &plot.fallback, before));
        files::write_bytes(&folder.join(file), plot.svg.as_bytes())?;
    }
    for sheet in &done.sheets {
        files::write_bytes(&folder.join(sheet_name(scene, &sheet.fallback, before)), &sheet.png)?;
    }
    Ok(())
}

/// The name of a sheet's file, where `before` scenes of the report have the same name.
pub fn sheet_name(scene: &SceneReport, fallback: &str, before: usize) -> String {
    format!("{}_steps.png", stem(scene, fallback, before))
}

/// The drawings of error over time of a scene, one for each fallback, with its name. `SCENE.svg` holds such a drawing.
pub fn plots(scene: &SceneReport) -> Vec<(String, String)> {
    plot::plots(scene)
}

fn make_folder(folder: &Path) -> Result<(), CompareError> {
    std::fs::create_dir_all(folder).map_err(|source| CompareError::Folder { path: folder.to_owned(), source })
}

/// Removes unfinished files that runs left behind when they were killed.
fn sweep(options: &Options) -> Result<(), WriteError> {
    let kept = ["paths", "light"].map(|name| options.cache.join(name));
    [&options.cache].into_iter().chain(&kept).chain(&options.keep).try_for_each(|folder| sweep_folder(folder))
}

fn sweep_folder(folder: &Path) -> Result<(), WriteError> {
    parts::sweep(folder).map(drop).map_err(|source| WriteError { path: folder.to_owned(), source })
}

fn write(folder: &Path, report: &Report) -> Result<(), CompareError> {
    files::write_bytes(&folder.join("compare.json"), &serde_json::to_vec_pretty(report)?)?;
    files::write_bytes(&folder.join("compare.md"), tables::markdown(report).as_bytes())?;
    Ok(())
}

/// The name of a plot without its extension. It names the fallback where the scene has several, and has a number at its
/// end where `before` scenes of the report have the same name.
fn stem(scene: &SceneReport, fallback: &str, before: usize) -> String {
    let mut stem = scene.scene.clone();
    if scene.results.iter().any(|r| r.fallback != fallback) {
        stem += &format!("_{fallback}");
    }
    file_stem(&stem, before)
}

/// A scene's name made fit for a file's name, with a number at its end where `before` scenes have the same name.
fn file_stem(name: &str, before: usize) -> String {
    let stem = escape::file_name(name);
    if before > 0 { format!("{stem}_{}", before + 1) } else { stem }
}

/// Prints that a scene failed, and adds it to `failed`. An interruption is handed to the caller instead.
///
/// # Errors
/// The interruption.
fn keep_failure(
    failed: &mut Vec<Failure>,
    name: &str,
    error: CompareError,
    console: &Console,
) -> Result<(), CompareError> {
    if error.is_interruption() {
        return Err(error);
    }
    console.note(format!("{name}: {error}"));
    failed.push(Failure { scene: name.to_owned(), error: error.to_string() });
    Ok(())
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// A report as Markdown, which is the content of `compare.md`.
pub fn markdown(report: &Report) -> String {
    tables::markdown(report)
}
