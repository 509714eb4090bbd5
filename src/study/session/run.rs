//! Runs a session: the display's events go in, the journal is written, the next screen comes out.

use std::path::{Path, PathBuf};

use cyclopean_analysis::journal::record::Outcome;

use super::{Options, Session, SessionError, token};
use crate::display::headless::Headless;
use crate::display::{Display, StimulusFiles};
use crate::study::protocol::{Action, Screen};
use crate::study::sessions::{SessionPlace, Sessions};
use crate::study::stimulus::STIMULUS_FILES;
use crate::study::store::Store;
use crate::study::validate::Study;

/// The state of a session when [`Session::run`] returns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SessionEnd {
    /// None: the session was closed and can be resumed.
    pub outcome: Option<Outcome>,
    pub journal: PathBuf,
    pub participant: String,
    pub session: String,
    pub row: u64,
    /// The files that were deleted, if the participant withdrew.
    pub deleted: Vec<PathBuf>,
}

impl Session {
    /// Runs to the end, to a `quit`, or to a failure. The journal is whole in each case.
    ///
    /// # Errors
    /// The display or the disk failed; the session can be resumed.
    pub fn run(mut self, display: &mut dyn Display) -> Result<SessionEnd, SessionError> {
        if self.over.is_some() {
            let outcome = self.over;
            return self.close(outcome);
        }
        let driven = self.drive(display);
        if let Some(poses) = &mut self.poses {
            let written = poses.write_out();
            // The failure that stopped the session is reported first.
            if driven.is_ok() {
                written?;
            }
        }
        let outcome = driven?;
        self.close(outcome)
    }

    /// Runs from the first screen until the session is closed.
    fn drive(&mut self, display: &mut dyn Display) -> Result<Option<Outcome>, SessionError> {
        let files: Vec<StimulusFiles> = self
            .stored
            .iter()
            .map(|s| StimulusFiles {
                frames: s.frame_paths(),
                exr: s.folder.join(STIMULUS_FILES[1]),
                fov_deg: s.side_car.info.horizontal_fov_deg,
            })
            .collect();
        display.load(&files)?;
        let mut screen = Screen::Blank;
        let start_ns = self.start_ns();
        let first = if self.gap.is_some() { self.machine.resume(start_ns) } else { self.machine.start(start_ns) };
        let mut closed = self.perform(start_ns, first, &mut screen)?;
        display.present(&screen)?;
        loop {
            if let Some(outcome) = closed {
                return Ok(outcome);
            }
            crate::console::check_interrupted()?;
            let timed = display.wait(self.machine.idle_frames())?;
            if let Some(poses) = &mut self.poses {
                // Poses are taken in any case, so that none from before the consent are recorded later.
                let taken = display.take_poses();
                if self.machine.is_past_consent() {
                    poses.take(taken)?;
                }
            }
            let actions = self.machine.handle(timed.now_ns, timed.event);
            closed = self.perform(timed.now_ns, actions, &mut screen)?;
            display.present(&screen)?;
        }
    }

    /// Carries out the machine's actions. `Some`: the session is closed, with an outcome if it is over.
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
                Action::Sync => {
                    self.writer.sync()?;
                    if let Some(poses) = &mut self.poses {
                        poses.write_out()?;
                    }
                }
                Action::Show(next) => *screen = next,
                Action::Close(outcome) => closed = Some(outcome),
            }
        }
        Ok(closed)
    }

    fn close(self, outcome: Option<Outcome>) -> Result<SessionEnd, SessionError> {
        let Session { writer, sessions, place, .. } = self;
        let journal = writer.path().to_owned();
        // Dropping the writer releases the lock.
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
        let SessionPlace { participant, session, row, .. } = place;
        Ok(SessionEnd { outcome, journal, participant, session, row, deleted })
    }
}

/// Runs one simulated participant from start to end on a virtual clock. It resumes a session that an earlier call left
/// unfinished.
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
) -> Result<SessionEnd, SessionError> {
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
