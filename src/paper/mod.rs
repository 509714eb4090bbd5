//! `cyclopean paper`: makes the tables and figures of two publications again, as far as this program can, and shows its
//! own numbers beside the printed ones on one page.
//!
//! A [`Request`] and the analysis of the studies' sessions go in, and `paper.html` and `paper.json` come out. The
//! command `paper` calls it.
//!
//! ```text
//! plan → run (compare, compare::ao; all of it kept) → items (tables, figures) → paper.html, paper.json
//!          sessions, analysed by the caller ────────────┘
//! ```
//! The page follows only from results that are kept. So a finished folder gives the same bytes again.

mod ambient;
mod cost;
mod figures;
mod item;
mod plan;
mod published;
mod run;
mod statistics;
mod tables;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cyclopean_analysis::files::{self, WriteError};
use cyclopean_analysis::report::{self, Block, ReportInput};

use crate::compare::ao::AoReport;
use crate::compare::{CompareError, Report, Row, SceneReport};
use crate::console::Interrupted;
use crate::gpu::DeviceInfo;
use crate::render::method::UnknownMethod;
use crate::scene::survey::Survey;

pub use cost::{Kind, Piece, Speeds, in_words, pieces, speeds, stills};
pub use item::Item;
pub use plan::{Part, Request, Scale};
pub use run::{Progress, run};

/// The paper cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    #[error(transparent)]
    Compare(#[from] CompareError),
    #[error(transparent)]
    Method(#[from] UnknownMethod),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("cannot make or empty the folder {}: {source}", path.display())]
    Folder { path: PathBuf, source: std::io::Error },
    #[error("cannot write JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error("{first} and {second} are both called `{name}`, and the tables name scenes; leave one of them out")]
    SameName { name: String, first: String, second: String },
    #[error("the page would have a gap, which is a fault of this program: {0}")]
    Gap(String),
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// A scene that was asked for.
#[derive(Debug)]
pub struct RequestedScene {
    pub asked: String,
    /// The scene's name in the reports.
    pub name: String,
    /// What the scene contains, or why it cannot be loaded.
    pub survey: Result<Survey, String>,
}

/// A sheet of a comparison.
#[derive(Debug)]
pub struct Sheet {
    pub comparison: &'static str,
    pub scene: String,
    /// The file's path below the folder of the page.
    pub file: String,
    pub png: Vec<u8>,
}

/// Everything that was measured.
#[derive(Debug)]
pub struct Measurements {
    pub scenes: Vec<RequestedScene>,
    /// The reports by comparison. There are none for a part that was left out.
    pub reports: BTreeMap<&'static str, Report>,
    pub sheets: Vec<Sheet>,
    pub ao: Option<AoReport>,
}

/// The analysis of the sessions, or why there is none.
pub type Sessions = Result<ReportInput, String>;

impl Measurements {
    /// A scene's part of a comparison.
    fn scene(&self, comparison: &str, scene: &str) -> Option<&SceneReport> {
        self.reports.get(comparison)?.scenes.iter().find(|s| s.scene == scene)
    }

    /// The row of a method in a scene's part of a comparison.
    fn row(&self, comparison: &str, scene: &str, method: &str, spp: u32) -> Option<&Row> {
        self.scene(comparison, scene)?.results.iter().find(|r| (r.method.as_str(), r.spp) == (method, spp))
    }

    /// Why a comparison has no number for a scene.
    fn why(&self, comparison: &str, scene: &str) -> String {
        let asked = self.scenes.iter().find(|s| s.name == scene).map_or(scene, |s| &s.asked);
        match self.reports.get(comparison) {
            None => "left out by --parts".to_owned(),
            Some(report) => match report.failed.iter().find(|f| f.scene == asked) {
                Some(failure) => format!("failed: {}", failure.error),
                None if report.scenes.iter().any(|s| s.scene == scene) => "undefined".to_owned(),
                None => "not among the scenes".to_owned(),
            },
        }
    }

    /// The scenes that failed, with one sentence for each.
    pub fn failures(&self) -> Vec<String> {
        let reports = self.reports.iter().map(|(id, report)| (*id, &report.failed));
        let all = reports.chain(self.ao.iter().map(|ao| ("ao", &ao.failed)));
        all.flat_map(|(id, failed)| failed.iter().map(move |f| format!("{id}, {}: {}", f.scene, f.error))).collect()
    }
}

/// All tables and figures, in the order of the publications.
fn items(request: &Request, measurements: &Measurements, sessions: &Sessions) -> Vec<Item> {
    let mut all = vec![tables::scenes(measurements)];
    all.push(figures::overview(request, measurements));
    all.push(tables::quality(request, measurements));
    all.push(figures::equal_samples(request, measurements));
    all.push(tables::times(request, measurements));
    all.push(tables::error_against_time(request, measurements));
    all.extend(figures::steps(request, measurements));
    all.push(tables::modules(request, measurements));
    all.extend(statistics::items(request, sessions));
    all.extend(ambient::items(request, measurements));
    all
}

/// The content of `paper.json`. Other programs may read its keys, so keys are added but never renamed.
#[derive(serde::Serialize)]
struct Paper<'a> {
    format: u32,
    program: &'static str,
    device: &'a DeviceInfo,
    scale: Scale,
    scenes: Vec<&'a str>,
    /// The kind of the sessions, if they are not people's answers to the study.
    stamp: Option<&'a str>,
    items: &'a [Item],
    /// The analysis of the studies, as `mos report` writes it.
    studies: Option<serde_json::Value>,
    failed: Vec<String>,
}

/// Writes `paper.html` and `paper.json` into the folder, and returns their paths.
///
/// # Errors
/// A file that cannot be written, or a table with a gap.
pub fn write(
    request: &Request,
    device: &DeviceInfo,
    measurements: &Measurements,
    sessions: &Sessions,
) -> Result<[PathBuf; 2], PaperError> {
    let items = items(request, measurements, sessions);
    if let Some(fault) = items.iter().flat_map(|i| &i.tables).find_map(item::Grid::fault) {
        return Err(PaperError::Gap(fault));
    }
    let input = sessions.as_ref().ok();
    let stamp = input.and_then(|i| i.stamp.as_deref());
    let mut blocks = introduction(request, device, measurements, stamp);
    blocks.extend(items.iter().flat_map(Item::blocks));
    blocks.extend(last(measurements));
    let page = report::page("The publications' tables and figures, made again", None, &blocks);
    let paper = Paper {
        format: 1,
        program: concat!("cyclopean ", env!("CARGO_PKG_VERSION")),
        device,
        scale: request.scale,
        scenes: measurements.scenes.iter().map(|s| s.name.as_str()).collect(),
        stamp,
        items: &items,
        studies: input.map(report::json),
        failed: measurements.failures(),
    };
    let files = ["paper.html", "paper.json"].map(|name| request.out.join(name));
    // If no comparison was asked for, the folder does not exist yet.
    make_folder(&request.out)?;
    files::write_bytes(&files[0], page.as_bytes())?;
    files::write_bytes(&files[1], &serde_json::to_vec_pretty(&paper)?)?;
    Ok(files)
}

fn introduction(
    request: &Request,
    device: &DeviceInfo,
    measurements: &Measurements,
    stamp: Option<&str>,
) -> Vec<Block> {
    let [width, height] = request.scale.size;
    let names: Vec<&str> = measurements.scenes.iter().map(|s| s.name.as_str()).collect();
    let mut notes = vec![
        format!("{} ({}, {}).", device.name, device.kind, device.driver),
        format!(
            "Size {}: {width}×{height} pixels an eye, a reference of {} paths a pixel, {} rounds for Table 2 and {} \
             for Table 3. The publication: {}.",
            request.scale.name,
            request.scale.reference_paths,
            request.scale.seeds[0],
            request.scale.seeds[1],
            published::SETTING
        ),
        format!(
            "Scenes: {}. They are this program's own and stand for the publication's scenes, which are not published. \
            For that reason alone every absolute number differs, and only directions and ratios can be compared.",
            names.join(", ")
        ),
        "The estimator is the publication's. The spatial reuse has ratio weights, bright taps are not bounded, unknown \
         rays see black, there are no shadows, and paths have two bounces."
            .to_owned(),
        "Some figures are not made again. Figures 2 to 8 are drawings of the method. Figure 15 shows a failure that \
         belongs to one view of the publication's scene. Figures 16 and 17 show how the studies' pictures are laid \
         out, which cyclopean run shows."
            .to_owned(),
    ];
    if device.kind == "cpu" {
        notes.push(
            "This is a software device. Its times say how much work a method does. They do not say how long a graphics \
             card takes."
                .to_owned(),
        );
    }
    if let Some(stamp) = stamp {
        notes.push(format!(
            "{} data: the votes in Figures 18 and 19 are not people's answers, and their statistics say nothing about \
             people.",
            stamp.to_uppercase()
        ));
    }
    vec![Block::Notes(notes), Block::Contents]
}

fn last(measurements: &Measurements) -> Vec<Block> {
    let failures = measurements.failures();
    if failures.is_empty() {
        return Vec::new();
    }
    vec![Block::Heading(1, "What failed".to_owned()), Block::Notes(failures)]
}

fn make_folder(folder: &Path) -> Result<(), PaperError> {
    std::fs::create_dir_all(folder).map_err(|source| PaperError::Folder { path: folder.to_owned(), source })
}
