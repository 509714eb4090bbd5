//! Makes all comparisons, or takes their results from those that an earlier run has kept, and prints how far it has
//! come. A [`Request`] goes in, and everything that was measured ([`Measurements`]) comes out. The command `paper` calls it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::rc::Rc;
use std::time::Instant;

use cyclopean_analysis::files;

use super::cost::{Piece, Speeds, in_words};
use super::plan::{Part, Request};
use super::{Measurements, PaperError, RequestedScene, Sheet};
use crate::compare::ao;
use crate::compare::{self, PROGRAM, SceneComparison};
use crate::console::{Console, check_interrupted};
use crate::gpu::Gpu;
use crate::scene::survey::survey;

/// The most bytes of the list of finished pieces that is read.
const MOST_FINISHED: u64 = 16 << 20;

/// Which pieces are finished, also by earlier runs. It is used only to print the time that is left. The results of
/// earlier runs are found by their content, whatever this list says.
pub struct Progress<'a> {
    file: PathBuf,
    pieces: &'a [Piece],
    /// The expected seconds of each piece. `None`: no speeds were measured.
    expected: Option<Vec<f64>>,
    finished: BTreeSet<String>,
    /// The program and the device. With another program or device a piece is a different one.
    by: String,
    done: usize,
    started: Instant,
    /// The expected and the real seconds of the pieces that this run has made.
    spent: (f64, f64),
    console: Console,
}

impl<'a> Progress<'a> {
    pub fn new(
        gpu: &Gpu,
        request: &Request,
        pieces: &'a [Piece],
        speeds: Option<&Speeds>,
        console: &Console,
    ) -> Progress<'a> {
        let file = request.work().join("finished.json");
        let finished = files::read(&file, MOST_FINISHED).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
        Progress {
            file,
            pieces,
            expected: speeds.map(|speeds| pieces.iter().map(|p| speeds.of(p)).collect()),
            finished: finished.unwrap_or_default(),
            by: format!("{} {} on {}, {}", PROGRAM[0], PROGRAM[1], gpu.info().name, gpu.info().driver),
            done: 0,
            started: Instant::now(),
            spent: (0.0, 0.0),
            console: *console,
        }
    }

    fn key(&self, piece: &Piece) -> String {
        format!("{}: {} ({})", piece.name, piece.call, self.by)
    }

    /// Whether an earlier run has finished a piece.
    pub fn is_kept(&self, piece: &Piece) -> bool {
        self.finished.contains(&self.key(piece))
    }

    /// The number of pieces that earlier runs have finished.
    pub fn kept(&self) -> usize {
        self.pieces.iter().filter(|piece| self.is_kept(piece)).count()
    }

    /// The seconds that are left, by the speeds that were measured beforehand. `None`: there are none.
    pub fn left(&self) -> Option<f64> {
        let expected = self.expected.as_ref()?;
        let left = (self.done..self.pieces.len())
            .filter(|at| !self.is_kept(&self.pieces[*at]))
            .map(|at| expected[at])
            .sum::<f64>();
        // The times of the pieces so far show how wrong the probe was, and the estimate is corrected by that.
        let (thought, took) = self.spent;
        Some(if thought > 0.0 && took > 1.0 { left * took / thought } else { left })
    }

    /// Says that the next piece is finished, and prints it.
    ///
    /// # Errors
    /// The list cannot be written.
    pub fn step(&mut self) -> Result<(), PaperError> {
        let Some(piece) = self.pieces.get(self.done) else { return Ok(()) };
        let took = self.started.elapsed().as_secs_f64();
        let was_kept = self.is_kept(piece);
        if let Some(expected) = self.expected.as_ref().filter(|_| !was_kept) {
            self.spent = (self.spent.0 + expected[self.done], self.spent.1 + took);
        }
        self.started = Instant::now();
        self.done += 1;
        let left = self.left().filter(|s| *s > 0.0).map_or(String::new(), |s| format!("; {} left", in_words(s)));
        let verb = if was_kept { "taken from what is kept" } else { "made" };
        self.console.note(format!(
            "{} of {}: {} {verb} in {took:.1} s{left}",
            self.done,
            self.pieces.len(),
            piece.name
        ));
        if self.finished.insert(self.key(piece)) {
            files::write_bytes(&self.file, &serde_json::to_vec_pretty(&self.finished)?)?;
        }
        Ok(())
    }
}

/// Makes everything but the sessions. A scene that fails is no error; its cells say so.
///
/// # Errors
/// An output that cannot be written, or Ctrl-C.
pub fn run(
    gpu: &Rc<Gpu>,
    request: &Request,
    progress: &mut Progress<'_>,
    console: &Console,
) -> Result<Measurements, PaperError> {
    let scenes = requested_scenes(request)?;
    let mut measurements = Measurements { scenes, reports: BTreeMap::new(), sheets: Vec::new(), ao: None };
    for comparison in request.comparisons() {
        let options = request.options(&comparison)?;
        let mut stepped = Ok(());
        let mut show = |_: &str, done: Option<&SceneComparison>| {
            let sheets = done.iter().flat_map(|done| {
                done.sheets.iter().map(|sheet| Sheet {
                    comparison: comparison.id,
                    scene: done.report.scene.clone(),
                    file: format!("{}/{}", comparison.id, compare::sheet_name(&done.report, &sheet.fallback, 0)),
                    png: sheet.png.clone(),
                })
            });
            measurements.sheets.extend(sheets);
            if stepped.is_ok() {
                stepped = progress.step();
            }
        };
        let report = compare::compare_and_show(gpu, &comparison.scenes, &options, &mut show, console)?;
        stepped?;
        measurements.reports.insert(comparison.id, report);
    }
    if request.parts.contains(&Part::Ao) {
        let mut stepped = Ok(());
        let mut show = |_: &str| {
            if stepped.is_ok() {
                stepped = progress.step();
            }
        };
        measurements.ao = Some(ao::compare_and_show(gpu, &request.scenes, &request.ao_options(), &mut show, console)?);
        stepped?;
    }
    Ok(measurements)
}

/// Loads every scene and surveys it.
///
/// # Errors
/// Two scenes with the same name, which a table could not tell apart, or Ctrl-C.
fn requested_scenes(request: &Request) -> Result<Vec<RequestedScene>, PaperError> {
    let mut all: Vec<RequestedScene> = Vec::new();
    for asked in &request.scenes {
        check_interrupted()?;
        let survey = request.scene_cache.load(asked).map(|scene| survey(&scene)).map_err(|e| e.to_string());
        let name = survey.as_ref().map_or_else(|_| asked.clone(), |s| s.name.clone());
        if let Some(other) = all.iter().find(|other| other.name == name) {
            return Err(PaperError::SameName { name, first: other.asked.clone(), second: asked.clone() });
        }
        all.push(RequestedScene { asked: asked.clone(), name, survey });
    }
    Ok(all)
}
