//! The states of a session, and what each event does to them.

use cyclopean_analysis::journal::record::Film;

use super::queue::Queue;
use super::setup::{Setup, Stage};
use super::timing::{FrameRun, Timing};
use super::{Action, Event, Page};

/// The state of a session.
#[derive(Debug, Clone)]
pub(super) enum State {
    /// Nothing was shown yet.
    Fresh,
    /// A page of text waits for the participant.
    Page(Page),
    /// An item of a questionnaire waits for an answer.
    Item(usize),
    /// A stereogram waits for a choice.
    Dots(usize),
    /// The blank frame before a stimulus, or between it and its panel.
    Blank { clock: Clock, then: AfterBlank },
    /// A segment of the stimulus is on the display.
    Showing { clock: Clock, segment: usize, timing: Timing },
    /// The panel waits for an answer. The clock runs to its next reminder or pause.
    Panel { clock: Clock, opened_ns: u64, chosen: Option<u32>, changes: u32, reminded: bool },
    /// The session is paused; afterwards it goes on with `then`.
    Paused { since_ns: u64, then: Box<State> },
    /// Nothing more happens.
    Over,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AfterBlank {
    Stimulus,
    Panel,
}

/// Counts the display's nominal periods since the first frame of a phase.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    pub(super) asked: u64,
    /// Periods since the first frame; none before it.
    pub(super) elapsed: Option<u64>,
}

impl Clock {
    pub(super) fn new(asked: u64) -> Clock {
        Clock { asked, elapsed: None }
    }

    /// Number of coming frames that certainly belong to this phase.
    pub(super) fn idle(&self) -> u64 {
        self.elapsed.map_or(self.asked, |e| self.asked.saturating_sub(e + 1))
    }

    /// Whether a frame that comes `steps` periods after the last one belongs to the next phase.
    pub(super) fn is_over(&self, steps: u64) -> bool {
        self.elapsed.is_some_and(|e| e + steps >= self.asked)
    }

    pub(super) fn add(&mut self, run: &FrameRun) {
        let inner = run.inner_steps * (run.count - 1);
        self.elapsed = Some(self.elapsed.map_or(inner, |e| e + run.steps + inner));
    }
}

/// The attempt that is under way.
#[derive(Debug, Clone, Copy)]
pub(super) struct CurrentAttempt {
    pub(super) presentation: u32,
    pub(super) attempt: u32,
    pub(super) valid: bool,
}

/// A journal does not belong to this study and row.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the journal does not follow from its study and row: {0}")]
pub struct JournalMismatch(pub String);

/// A session. See the module's documentation.
#[derive(Debug, Clone)]
pub struct Machine {
    pub(super) setup: Setup,
    pub(super) state: State,
    pub(super) stage: Option<usize>,
    /// Number of items or stereograms that were answered within the stage.
    pub(super) cursor: usize,
    pub(super) right: u32,
    pub(super) queue: Queue,
    pub(super) current: Option<CurrentAttempt>,
    /// Presentations without attempts left whose `missing` record is not written yet.
    pub(super) unwritten_missing: Vec<u32>,
    pub(super) ready_shown: bool,
    pub(super) answered: u32,
    pub(super) last_break_ns: Option<u64>,
    pub(super) last_frame_ns: Option<u64>,
    pub(super) focus: bool,
    pub(super) visible: bool,
    /// The time since which focus or visibility has been lost.
    pub(super) unseen_since_ns: Option<u64>,
}

/// When nobody has looked for this long, the session pauses until somebody goes on. Shorter losses are judged only by
/// the study's rule of validity.
pub(super) const UNSEEN_PAUSE_NS: u64 = 1_000_000_000;

impl Machine {
    pub fn new(setup: Setup) -> Machine {
        let queue = Queue::new(&setup.presentations, setup.validity.repeats);
        Machine {
            queue,
            setup,
            state: State::Fresh,
            stage: None,
            cursor: 0,
            right: 0,
            current: None,
            unwritten_missing: Vec::new(),
            ready_shown: false,
            answered: 0,
            last_break_ns: None,
            last_frame_ns: None,
            focus: true,
            visible: true,
            unseen_since_ns: None,
        }
    }

    /// The same machine, with the frames of those stimuli that move.
    pub fn with_films(mut self, films: Vec<Option<Film>>) -> Machine {
        self.setup.films = films;
        self
    }

    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    pub fn is_over(&self) -> bool {
        matches!(self.state, State::Over)
    }

    /// Whether the participant has agreed or is not asked; false before the first page.
    pub fn is_past_consent(&self) -> bool {
        self.stage.is_some_and(|s| self.setup.stages.get(s) != Some(&Stage::Page(Page::Consent)))
    }

    /// Number of coming frames that change nothing unless somebody does something; `u64::MAX`: any number.
    pub fn idle_frames(&self) -> u64 {
        match &self.state {
            // A film may change with every frame.
            State::Showing { segment, timing, .. } if self.plays(*segment, timing) => 0,
            State::Blank { clock, .. } | State::Showing { clock, .. } | State::Panel { clock, .. } => clock.idle(),
            _ => u64::MAX,
        }
    }

    /// The first actions of a new session.
    pub fn start(&mut self, now_ns: u64) -> Vec<Action> {
        let mut out = Vec::new();
        if matches!(self.state, State::Fresh) {
            self.next_stage(now_ns, &mut out);
        }
        out
    }

    /// The actions that follow from an event at `now_ns`.
    pub fn handle(&mut self, now_ns: u64, event: Event) -> Vec<Action> {
        let mut out = Vec::new();
        match event {
            _ if self.is_over() => {}
            Event::Frame { at_ns, rendered } => {
                self.frames(1, at_ns, at_ns, rendered, &mut out);
                self.watch(at_ns, &mut out);
            }
            Event::Frames { count, first_ns, last_ns } => {
                self.split(count, first_ns, last_ns, &mut out);
                self.watch(last_ns, &mut out);
            }
            Event::Focus(focus) => {
                self.focus = focus;
                self.watch(now_ns, &mut out);
            }
            Event::Visible(visible) => {
                self.visible = visible;
                self.watch(now_ns, &mut out);
            }
            Event::RefreshRate(hz) => {
                if let State::Showing { timing, .. } = &mut self.state
                    && (hz - self.setup.nominal_hz).abs() > 0.5
                {
                    timing.rate_changed();
                }
            }
            Event::Input(input) => self.input(now_ns, input, &mut out),
        }
        out
    }
}
