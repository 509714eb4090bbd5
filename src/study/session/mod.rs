//! A session: brings the state machine, its journal and a display together. `cyclopean run`, `demo` and `paper` call
//! it.
//!
//! ```text
//! begin (or resume) → run: wait → machine → write, sync, show → present → …
//! ```

mod header;
mod replay;
mod run;

use std::path::{Path, PathBuf};

use cyclopean_analysis::journal::record::{self, Kind, Outcome, Record};

use super::definition::Definition;
use super::disk::Disk;
use super::observer::{ObserverError, SimulatedObserver};
use super::plan::Plan;
use super::poses::{PoseWriter, PosesError};
use super::protocol::{Machine, Setup};
use super::sessions::{SessionPlace, Sessions, SessionsError};
use super::store::{Store, StoreError, StoredStimulus};
use super::validate::{Study, StudyError};
use super::writer::{Durability, JournalWriter, WriterError};
use crate::display::{DisplayError, DisplayInfo};

pub use header::program;
use header::{header, stimulus_record};
use replay::Replay;
pub use replay::{Proof, prove_order};
pub use run::{SessionEnd, simulate};

/// Why a session cannot begin or go on.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    #[error(transparent)]
    Sessions(#[from] SessionsError),
    #[error(transparent)]
    Writer(#[from] WriterError),
    #[error("{missing} of {total} stimuli cannot be used; first: {first}. Run `cyclopean prepare {} --store {}`", study.display(), store.display())]
    Stimuli {
        missing: usize,
        total: usize,
        #[source]
        first: StoreError,
        study: PathBuf,
        store: PathBuf,
    },
    #[error(
        "the display runs at {measured:.1} Hz, nominal {nominal:.1}: its compositor is at a reduced rate. Close other programs, or lower the resolution"
    )]
    ReducedRate { measured: f64, nominal: f64 },
    #[error(
        "{label} has {rate_hz} frames a second, the display {display_hz}: frames would be left out. Use a display of {rate_hz} Hz or more, or a path with a lower rate"
    )]
    FilmRate { label: String, rate_hz: f64, display_hz: f64 },
    #[error("{}: {what}", journal.display())]
    Resume { journal: PathBuf, what: String },
    #[error(transparent)]
    Poses(#[from] PosesError),
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error(transparent)]
    Observer(#[from] ObserverError),
    #[error(transparent)]
    Display(#[from] DisplayError),
    #[error(transparent)]
    Interrupted(#[from] crate::console::Interrupted),
}

/// How a session is run.
#[derive(Debug, Clone)]
pub struct Options {
    pub kind: Kind,
    pub durability: Durability,
    /// SHA-256 of the manifest of the frozen study that the session was checked against.
    pub frozen_sha256: Option<String>,
    /// The file system; only tests use another one.
    pub disk: Disk,
}

impl Options {
    /// Options for a synced journal on the real disk, without a frozen study.
    pub fn new(kind: Kind) -> Options {
        Options { kind, durability: Durability::Synced, frozen_sha256: None, disk: Disk::real() }
    }
}

/// The gap before a resumed session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gap {
    /// Wall time since the last line, milliseconds; negative if the clock was set back.
    pub ms: i64,
    /// Bytes of a torn last line that were set aside.
    pub cut_bytes: u64,
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Session {
    plan: Plan,
    machine: Machine,
    writer: JournalWriter,
    sessions: Sessions,
    place: SessionPlace,
    stored: Vec<StoredStimulus>,
    /// Writes head poses; none: no head poses are kept.
    poses: Option<PoseWriter>,
    gap: Option<Gap>,
    /// The outcome, if the session had ended before and only its row was not marked.
    over: Option<Outcome>,
}

impl Session {
    /// Checks every stimulus, reserves a row, and writes and syncs everything that comes before trial 1.
    ///
    /// # Errors
    /// [`SessionError`]; at this point no participant has begun.
    pub fn begin(
        study: &Study,
        store: &Store,
        root: &Path,
        participant: &str,
        display: &DisplayInfo,
        options: &Options,
    ) -> Result<Session, SessionError> {
        if let (true, Some(measured)) = (display.is_at_reduced_rate(), display.measured_hz) {
            return Err(SessionError::ReducedRate { measured, nominal: display.nominal_hz });
        }
        let definition = &study.definition;
        let any_plan = Plan::draw(definition, 0);
        let stored = find_all(study, store, &any_plan)?;
        check_films(&stored, definition, display)?;
        if options.kind == Kind::Simulated {
            // A missing latent quality is reported before a row is reserved.
            let inconsistency: Vec<Option<f64>> = stored.iter().map(|s| s.side_car.info.inconsistency).collect();
            SimulatedObserver::new(definition, &any_plan, &[], participant, &inconsistency)?;
        }
        let sessions = Sessions::new(options.disk.clone(), root, &definition.id);
        let (place, mut writer) = sessions.begin(participant, options.kind, options.durability)?;
        let plan = Plan::draw(definition, place.row);
        let header = header(study, &place, display, options);
        let keeps_poses = header.poses.is_some();
        writer.append(0, Record::Header(Box::new(header)))?;
        for (id, stimulus) in (0..).zip(&stored) {
            writer.append(0, Record::Stimulus(stimulus_record(id, stimulus)))?;
        }
        for condition in &plan.conditions {
            writer.append(0, Record::Condition(condition.clone()))?;
        }
        writer.append(0, Record::Order(plan.order.clone()))?;
        for planned in &plan.presentations {
            writer.append(0, Record::Planned(planned.clone()))?;
        }
        writer.append(0, Record::Ready(record::Ready { lines: writer.lines() }))?;
        writer.sync()?;
        // The journal names the file of poses before the file exists, so that no such file is without a journal that
        // names it.
        let poses = match keeps_poses {
            true => Some(PoseWriter::create(&options.disk, &place.journal, &definition.id, &place.session)?),
            false => None,
        };
        let machine = Machine::new(setup(study, &plan, display)).with_films(films(&stored));
        Ok(Session { plan, machine, writer, sessions, place, stored, poses, gap: None, over: None })
    }

    /// Resumes an unfinished session: the journal is checked line by line and replayed into the machine.
    ///
    /// # Errors
    /// [`SessionError`]; the journal is unchanged, except that a torn last line was set aside.
    pub fn resume(
        study: &Study,
        store: &Store,
        root: &Path,
        participant: &str,
        display: &DisplayInfo,
        options: &Options,
    ) -> Result<Session, SessionError> {
        let sessions = Sessions::new(options.disk.clone(), root, &study.definition.id);
        let place = sessions.unfinished(participant)?;
        let mut replay = Replay::new(study, display, &place.journal);
        let (mut writer, cut_bytes) =
            JournalWriter::reopen(options.disk.clone(), &place.journal, options.durability, |entry| {
                replay.take(entry)
            })?;
        if replay.plan.is_none() || !replay.ready {
            // The program was killed before trial 1, so nothing was shown. The row is freed and a new session begins.
            drop(writer);
            sessions.release(&place.participant, &place.session)?;
            return Session::begin(study, store, root, participant, display, options);
        }
        let (Some(plan), Some(machine)) = (replay.plan, replay.machine) else {
            return Err(SessionError::Resume { journal: place.journal, what: "it has no order".to_owned() });
        };
        if let Some(outcome) = replay.over {
            let over = Some(outcome);
            // This cuts off a torn last line of poses.
            let poses = reopen_poses(study, &place, options, &writer, replay.poses)?;
            let stored = Vec::new();
            return Ok(Session { plan, machine, writer, sessions, place, stored, poses, gap: None, over });
        }
        let stored = find_all(study, store, &plan)?;
        for (was, is) in replay.stimuli.iter().zip(&stored) {
            if was.key != is.side_car.key || was.files != is.side_car.files {
                let what = format!("stimulus {} is no longer the one the session began with", is.folder.display());
                return Err(SessionError::Resume { journal: place.journal, what });
            }
        }
        let machine = machine.with_films(films(&stored));
        let gap = Gap { ms: (chrono::Utc::now() - writer.last_wall()).num_milliseconds(), cut_bytes };
        let resumed = record::Resume { gap_ms: gap.ms, cut_bytes, program: program() };
        writer.append(writer.last_ns() + 1, Record::Resume(resumed))?;
        writer.sync()?;
        let poses = reopen_poses(study, &place, options, &writer, replay.poses)?;
        Ok(Session { plan, machine, writer, sessions, place, stored, poses, gap: Some(gap), over: None })
    }

    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    pub fn setup(&self) -> &Setup {
        self.machine.setup()
    }

    pub fn place(&self) -> &SessionPlace {
        &self.place
    }

    /// The gap before a resumed session; none for a new one.
    pub fn gap(&self) -> Option<Gap> {
        self.gap
    }

    /// The time at which the session clock goes on, nanoseconds.
    pub fn start_ns(&self) -> u64 {
        if self.gap.is_some() { self.writer.last_ns() + 1 } else { 0 }
    }

    /// A simulated observer for this session, as the study's `simulation` describes it.
    ///
    /// # Errors
    /// The study file does not say enough.
    pub fn simulated_observer(&self, study: &Study) -> Result<SimulatedObserver, ObserverError> {
        let inconsistency: Vec<Option<f64>> = self.stored.iter().map(|s| s.side_car.info.inconsistency).collect();
        let screening = &self.setup().screening;
        SimulatedObserver::new(&study.definition, &self.plan, screening, &self.place.participant, &inconsistency)
    }
}

fn reopen_poses(
    study: &Study,
    place: &SessionPlace,
    options: &Options,
    writer: &JournalWriter,
    are_kept: bool,
) -> Result<Option<PoseWriter>, PosesError> {
    let (id, t_ns) = (&study.definition.id, writer.last_ns() + 1);
    let open = || PoseWriter::reopen(&options.disk, &place.journal, id, &place.session, t_ns);
    are_kept.then(open).transpose()
}

/// A random name without meaning, for tombstones.
pub fn token() -> String {
    let mut hash = sha2::Sha256::default();
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    let state = std::hash::BuildHasher::hash_one(&std::hash::RandomState::new(), now);
    sha2::Digest::update(&mut hash, state.to_le_bytes());
    super::hex(&sha2::Digest::finalize(hash)[..8])
}

pub(super) fn setup(study: &Study, plan: &Plan, display: &DisplayInfo) -> Setup {
    Setup::new(&study.definition, plan, display.nominal_hz, display.trust, display.arcsec_per_px)
}

/// For each stimulus its frames, if it moves.
fn films(stored: &[StoredStimulus]) -> Vec<Option<record::Film>> {
    stored.iter().map(|s| s.side_car.info.film).collect()
}

/// Refuses moving stimuli that are faster than the display. Warns of those that will not look even, or that end early.
fn check_films(stored: &[StoredStimulus], definition: &Definition, display: &DisplayInfo) -> Result<(), SessionError> {
    for StoredStimulus { side_car, .. } in stored {
        let Some(film) = side_car.info.film else { continue };
        let label = side_car.request.label();
        let (rate_hz, display_hz) = (film.rate_hz, display.nominal_hz);
        // A display of 59.94 Hz is accepted for 60 frames a second.
        if rate_hz > 1.005 * display_hz {
            return Err(SessionError::FilmRate { label, rate_hz, display_hz });
        }
        let each = display_hz / rate_hz;
        if (each - each.round()).abs() > 0.005 * each {
            tracing::warn!(
                "{label} has {rate_hz} frames a second, the display {display_hz}: some frames stand longer than others"
            );
        }
        let (shown_s, lasts_s) = (side_car.request.seconds.unwrap_or(0.0), f64::from(film.frames) / rate_hz);
        if lasts_s + 1.0 / rate_hz < shown_s {
            let study = &definition.id;
            tracing::warn!(
                "{label} moves for {lasts_s:.1} s, study {study} shows it for {shown_s:.1} s: its last frame stands"
            );
        }
    }
    Ok(())
}

fn find_all(study: &Study, store: &Store, plan: &Plan) -> Result<Vec<StoredStimulus>, SessionError> {
    let mut stored = Vec::new();
    let mut first = None;
    let mut missing = 0;
    for request in &plan.stimuli {
        match store.find(request) {
            Ok(found) => stored.push(found),
            Err(error) => {
                missing += 1;
                first.get_or_insert(error);
            }
        }
    }
    match first {
        None => Ok(stored),
        Some(first) => Err(SessionError::Stimuli {
            missing,
            total: plan.stimuli.len(),
            first,
            study: study.path.clone(),
            store: store.root().to_owned(),
        }),
    }
}
