//! A session: the machine, its journal and a display, brought together.
//!
//! ```text
//! begin (or resume) → run: wait → machine → write, sync, show → present → …
//! ```

use std::path::{Path, PathBuf};

use cyclopean_analysis::journal::record::{self, Kind, Outcome, Record};
use cyclopean_analysis::journal::{Entry, FORMAT, JournalError};

use super::disk::Disk;
use super::observer::{ObserverError, SimulatedObserver};
use super::plan::Plan;
use super::protocol::{Action, Machine, Misfit, Screen, Setup};
use super::sessions::{Place, Sessions, SessionsError};
use super::stimulus::STIMULUS_FILES;
use super::store::{Store, StoreError, Stored};
use super::validate::{Study, StudyError};
use super::writer::{Durability, JournalWriter, WriterError};
use crate::display::headless::Headless;
use crate::display::{Display, DisplayError, DisplayInfo, StimulusFiles};

/// A session cannot begin or go on.
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
    #[error("{}: {what}", journal.display())]
    Resume { journal: PathBuf, what: String },
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
    /// SHA-256 of the manifest of the frozen study it was checked against.
    pub frozen_sha256: Option<String>,
    /// The file system; another one only in tests.
    pub disk: Disk,
}

impl Options {
    /// Synced, on the real disk, not frozen.
    pub fn new(kind: Kind) -> Options {
        Options { kind, durability: Durability::Synced, frozen_sha256: None, disk: Disk::real() }
    }
}

/// How a session stands when [`Session::run`] returns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ended {
    /// None: closed, and can be resumed.
    pub outcome: Option<Outcome>,
    pub journal: PathBuf,
    pub participant: String,
    pub session: String,
    pub row: u64,
    /// Files deleted, when the participant withdrew.
    pub deleted: Vec<PathBuf>,
}

/// What a resumed session went on from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gap {
    /// Wall time since the last line, milliseconds; negative: the clock was set back.
    pub ms: i64,
    /// Bytes of a torn last line, set aside.
    pub cut_bytes: u64,
}

/// See the module's documentation.
#[derive(Debug)]
pub struct Session {
    plan: Plan,
    machine: Machine,
    writer: JournalWriter,
    sessions: Sessions,
    place: Place,
    stored: Vec<Stored>,
    gap: Option<Gap>,
    /// It had ended before; only the books were not closed.
    over: Option<Outcome>,
}

impl Session {
    /// Checks every stimulus, reserves a row, and writes everything that stands before trial 1; synced.
    ///
    /// # Errors
    /// [`SessionError`]; nobody has sat down yet.
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
        let stored = find_all(study, store, &Plan::draw(definition, 0))?;
        let sessions = Sessions::new(options.disk.clone(), root, &definition.id);
        let (place, mut writer) = sessions.begin(participant, options.kind, options.durability)?;
        let plan = Plan::draw(definition, place.row);
        writer.append(0, Record::Header(Box::new(header(study, &place, display, options))))?;
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
        let machine = Machine::new(setup(study, &plan, display));
        Ok(Session { plan, machine, writer, sessions, place, stored, gap: None, over: None })
    }

    /// Takes up an unfinished session: the journal is checked line by line and replayed into the machine.
    ///
    /// # Errors
    /// [`SessionError`]; the journal is as it was, but for a torn last line that was set aside.
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
            // Killed before trial 1: nothing was shown, so the row goes back and a new session begins.
            drop(writer);
            sessions.release(&place.participant, &place.session)?;
            return Session::begin(study, store, root, participant, display, options);
        }
        let (Some(plan), Some(machine)) = (replay.plan, replay.machine) else {
            return Err(SessionError::Resume { journal: place.journal, what: "it has no order".to_owned() });
        };
        if let Some(outcome) = replay.over {
            let over = Some(outcome);
            return Ok(Session { plan, machine, writer, sessions, place, stored: Vec::new(), gap: None, over });
        }
        let stored = find_all(study, store, &plan)?;
        for (was, is) in replay.stimuli.iter().zip(&stored) {
            if was.key != is.side_car.key || was.files != is.side_car.files {
                let what = format!("stimulus {} is no longer the one the session began with", is.folder.display());
                return Err(SessionError::Resume { journal: place.journal, what });
            }
        }
        let gap = Gap { ms: (chrono::Utc::now() - writer.last_wall()).num_milliseconds(), cut_bytes };
        let resumed = record::Resume { gap_ms: gap.ms, cut_bytes, program: program() };
        writer.append(writer.last_ns() + 1, Record::Resume(resumed))?;
        writer.sync()?;
        Ok(Session { plan, machine, writer, sessions, place, stored, gap: Some(gap), over: None })
    }

    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    pub fn setup(&self) -> &Setup {
        self.machine.setup()
    }

    pub fn place(&self) -> &Place {
        &self.place
    }

    /// None for a new session.
    pub fn gap(&self) -> Option<Gap> {
        self.gap
    }

    /// The session clock from which the display goes on, nanoseconds.
    pub fn start_ns(&self) -> u64 {
        if self.gap.is_some() { self.writer.last_ns() + 1 } else { 0 }
    }

    /// An observer for this session, as the study's `simulation` describes.
    ///
    /// # Errors
    /// The study does not say enough.
    pub fn simulated_observer(&self, study: &Study) -> Result<SimulatedObserver, ObserverError> {
        let inconsistency: Vec<Option<f64>> = self.stored.iter().map(|s| s.side_car.info.inconsistency).collect();
        let screening = &self.setup().screening;
        SimulatedObserver::new(&study.definition, &self.plan, screening, &self.place.participant, &inconsistency)
    }

    /// Runs to the end, to a `quit`, or to a failure; the journal is whole in each case.
    ///
    /// # Errors
    /// The display or the disk failed; the session can be resumed.
    pub fn run(mut self, display: &mut dyn Display) -> Result<Ended, SessionError> {
        if self.over.is_some() {
            let outcome = self.over;
            return self.close(outcome);
        }
        let files: Vec<StimulusFiles> = self
            .stored
            .iter()
            .map(|s| StimulusFiles { sbs_png: s.folder.join(STIMULUS_FILES[0]), exr: s.folder.join(STIMULUS_FILES[1]) })
            .collect();
        display.load(&files)?;
        let mut screen = Screen::Blank;
        let start_ns = self.start_ns();
        let first = if self.gap.is_some() { self.machine.resume(start_ns) } else { self.machine.start(start_ns) };
        let mut closed = self.perform(start_ns, first, &mut screen)?;
        display.present(&screen)?;
        while closed.is_none() {
            crate::console::check_interrupted()?;
            let timed = display.wait(self.machine.idle_frames())?;
            let actions = self.machine.handle(timed.now_ns, timed.event);
            closed = self.perform(timed.now_ns, actions, &mut screen)?;
            display.present(&screen)?;
        }
        self.close(closed.flatten())
    }

    /// Some: the session is closed, with an outcome when it is over.
    fn perform(
        &mut self,
        now_ns: u64,
        actions: Vec<Action>,
        screen: &mut Screen,
    ) -> Result<Option<Option<Outcome>>, SessionError> {
        let mut closed = None;
        for action in actions {
            match action {
                Action::Write(record) => self.writer.append(now_ns, record)?,
                Action::Sync => self.writer.sync()?,
                Action::Show(next) => *screen = next,
                Action::Close(outcome) => closed = Some(outcome),
            }
        }
        Ok(closed)
    }

    fn close(self, outcome: Option<Outcome>) -> Result<Ended, SessionError> {
        let Session { writer, sessions, place, .. } = self;
        let journal = writer.path().to_owned();
        // The lock goes with the writer.
        drop(writer);
        let mut deleted = Vec::new();
        match outcome {
            Some(Outcome::Completed) => sessions.complete(&place.participant, &place.session)?,
            Some(Outcome::Withdrawn) => deleted = sessions.withdraw(&place.participant, &token())?,
            Some(Outcome::Declined | Outcome::Screened | Outcome::Abandoned) => {
                sessions.release(&place.participant, &place.session)?;
            }
            None => {}
        }
        let Place { participant, session, row, .. } = place;
        Ok(Ended { outcome, journal, participant, session, row, deleted })
    }
}

/// One simulated participant from start to end on a virtual clock; goes on where an earlier call was cut off.
///
/// `hz`: the display rate to pretend, such as 90.
///
/// # Errors
/// As [`Session::begin`], [`Session::resume`] and [`Session::run`].
pub fn simulate(
    study: &Study,
    store: &Store,
    root: &Path,
    participant: &str,
    hz: f64,
    options: &Options,
) -> Result<Ended, SessionError> {
    let info = Headless::information(hz);
    let sessions = Sessions::new(options.disk.clone(), root, &study.definition.id);
    let session = match sessions.unfinished(participant) {
        Ok(_) => Session::resume(study, store, root, participant, &info, options)?,
        Err(_) => Session::begin(study, store, root, participant, &info, options)?,
    };
    let observer = session.simulated_observer(study)?;
    let mut display = Headless::new(hz, session.start_ns(), Box::new(observer));
    session.run(&mut display)
}

/// A random name without meaning, for tombstones.
pub fn token() -> String {
    let mut hash = sha2::Sha256::default();
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    let state = std::hash::BuildHasher::hash_one(&std::hash::RandomState::new(), now);
    sha2::Digest::update(&mut hash, state.to_le_bytes());
    super::hex(&sha2::Digest::finalize(hash)[..8])
}

/// The program as journals name it.
pub fn program() -> record::Program {
    record::Program {
        name: env!("CARGO_PKG_NAME").to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: option_env!("CYCLOPEAN_COMMIT").unwrap_or("unknown").to_owned(),
    }
}

fn setup(study: &Study, plan: &Plan, display: &DisplayInfo) -> Setup {
    Setup::new(&study.definition, plan, display.nominal_hz, display.trust, display.arcsec_per_px)
}

fn find_all(study: &Study, store: &Store, plan: &Plan) -> Result<Vec<Stored>, SessionError> {
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

fn stimulus_record(id: u32, stored: &Stored) -> record::Stimulus {
    let side_car = &stored.side_car;
    record::Stimulus {
        id,
        key: side_car.key.clone(),
        scene: side_car.request.scene.clone(),
        view: side_car.request.view.clone().unwrap_or_else(|| "default".to_owned()),
        method: side_car.request.method.clone(),
        files: side_car.files.clone(),
        scene_sha256: side_car.info.scene_sha256.clone(),
        shaders_sha256: side_car.info.shaders_sha256.clone(),
        renderer: Some(side_car.info.renderer.clone()),
    }
}

fn header(study: &Study, place: &Place, display: &DisplayInfo, options: &Options) -> record::Header {
    let d = &study.definition;
    record::Header {
        format: FORMAT,
        study: record::Study {
            id: d.id.clone(),
            title: d.title.clone(),
            sha256: study.sha256.clone(),
            text: study.text.clone(),
            seed: d.seed,
        },
        participant: place.participant.clone(),
        session: place.session.clone(),
        row: place.row,
        question: d.journal_question(),
        analysis: d.analysis.clone(),
        program: program(),
        display: record::Display {
            kind: display.kind.clone(),
            system: display.system.clone(),
            runtime: display.runtime.clone(),
            trust: display.trust,
            nominal_hz: display.nominal_hz,
            measured_hz: display.measured_hz,
            interval_sd_ms: display.interval_sd_ms,
            width_px: display.width_px,
            height_px: display.height_px,
            fov_deg: display.fov_deg,
            ipd_m: display.ipd_m,
            rendered_ipd_m: d.stimuli.ipd_m,
        },
        device: display.device.clone(),
        os: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        consent: d.consent.as_ref().map(|c| record::Consent {
            version: c.version.clone(),
            purpose: c.purpose.clone(),
            retain_until: c.retain_until.clone(),
        }),
        frozen_sha256: options.frozen_sha256.clone(),
    }
}

/// Feeds a journal to a machine, checking that both belong together.
struct Replay<'a> {
    study: &'a Study,
    display: &'a DisplayInfo,
    journal: &'a Path,
    plan: Option<Plan>,
    machine: Option<Machine>,
    stimuli: Vec<record::Stimulus>,
    ready: bool,
    over: Option<Outcome>,
}

impl<'a> Replay<'a> {
    fn new(study: &'a Study, display: &'a DisplayInfo, journal: &'a Path) -> Replay<'a> {
        Replay { study, display, journal, plan: None, machine: None, stimuli: Vec::new(), ready: false, over: None }
    }

    fn refuse<T>(&self, what: impl Into<String>) -> Result<T, SessionError> {
        Err(SessionError::Resume { journal: self.journal.to_owned(), what: what.into() })
    }

    fn take(&mut self, entry: Entry) -> Result<(), SessionError> {
        match (entry.record, &mut self.plan, &mut self.machine) {
            (Record::Header(header), ..) => self.header(&header)?,
            (Record::Stimulus(stimulus), ..) => self.stimuli.push(stimulus),
            (Record::Order(order), Some(plan), _) if order != plan.order => {
                return self.refuse("its order does not follow from its study and row");
            }
            (Record::Planned(planned), Some(plan), _)
                if plan.presentations.get(planned.presentation as usize) != Some(&planned) =>
            {
                return self.refuse("its order does not follow from its study and row");
            }
            (Record::Ready(_), ..) => self.ready = true,
            (Record::End(end), ..) => self.over = Some(end.outcome),
            (record, _, Some(machine)) if self.ready => {
                if let Err(Misfit(what)) = machine.replay(&record) {
                    return self.refuse(what);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn header(&mut self, header: &record::Header) -> Result<(), SessionError> {
        if header.study.sha256 != self.study.sha256 {
            return self.refuse("the study file has changed since the session began; give the file of that day");
        }
        if (header.display.nominal_hz - self.display.nominal_hz).abs() > 0.01 {
            let (was, is) = (header.display.nominal_hz, self.display.nominal_hz);
            return self.refuse(format!("the session began at {was} Hz, this display has {is} Hz"));
        }
        let plan = Plan::draw(&self.study.definition, header.row);
        self.machine = Some(Machine::new(setup(self.study, &plan, self.display)));
        self.plan = Some(plan);
        Ok(())
    }
}

/// An order is what study and row say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Proof {
    pub study: String,
    pub row: u64,
    pub presentations: usize,
    pub sha256: String,
}

/// Derives the order of a journal again from the study text and the row it names, and compares every presentation.
///
/// # Errors
/// The journal cannot be read, or its order is another.
pub fn prove_order(journal: &Path) -> Result<Proof, SessionError> {
    let refuse = |what: String| SessionError::Resume { journal: journal.to_owned(), what };
    let read = |e: JournalError| SessionError::Writer(WriterError::Journal(e));
    let mut plan: Option<(Plan, record::Header)> = None;
    let mut seen = 0;
    for entry in cyclopean_analysis::journal::read(journal).map_err(read)? {
        match entry.map_err(read)?.record {
            Record::Header(header) => {
                let study = super::validate::parse(journal, header.study.text.clone())?;
                if study.sha256 != header.study.sha256 || study.definition.seed != header.study.seed {
                    return Err(refuse("the study text in its header has another SHA-256 or seed".to_owned()));
                }
                plan = Some((Plan::draw(&study.definition, header.row), *header));
            }
            Record::Order(order) => match &plan {
                Some((plan, _)) if plan.order == order => {}
                _ => return Err(refuse("the order does not follow from study and row".to_owned())),
            },
            Record::Planned(planned) => {
                let expected = plan.as_ref().and_then(|(p, _)| p.presentations.get(seen));
                if expected != Some(&planned) {
                    return Err(refuse(format!("presentation {seen} is not what study and row give: {expected:?}")));
                }
                seen += 1;
            }
            Record::Ready(_) => break,
            _ => {}
        }
    }
    match plan {
        Some((plan, header)) if plan.presentations.len() == seen => {
            Ok(Proof { study: header.study.id, row: header.row, presentations: seen, sha256: plan.order.sha256 })
        }
        _ => Err(refuse("it ends before its order is complete".to_owned())),
    }
}
