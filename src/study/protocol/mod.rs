//! The session as a pure state machine: events in, actions out; no clock, no file, no display.
//!
//! ```text
//! consent → person → ssq → screening → instructions → practice → ready → trials ⇄ break → ssq → thanks
//!                          a presentation: segments → blank → panel → blank
//! ```
//! In every state the session can be paused or ended, and the operator can skip every state but the consent. Time comes
//! in with each event; the duration of phases is counted in display frames. `study::session` drives the machine.

mod frames;
mod interruption;
mod machine;
mod people;
mod queue;
mod replay;
mod setup;
mod stages;
mod timing;

#[cfg(test)]
mod tests;

pub use machine::{JournalMismatch, Machine};
pub use setup::{Item, ScreeningTrial, Setup, Stage};

use cyclopean_analysis::journal::record::{Outcome, Record, Shown};

/// Something that happens to a session. Times are nanoseconds on the session's clock.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A frame will be displayed at this time. It shows what the machine showed last, or shows in answer to this event.
    Frame {
        at_ns: u64,
        /// False: the runtime asked not to draw it.
        rendered: bool,
    },
    /// Regular, drawn frames during which nothing changed, at most [`Machine::idle_frames`] of them.
    Frames { count: u64, first_ns: u64, last_ns: u64 },
    /// Keyboard or controller input goes to another program (false), or comes back (true).
    Focus(bool),
    /// The headset was taken off or the window was hidden (false), or it is back (true).
    Visible(bool),
    /// The display's refresh rate changed, Hz.
    RefreshRate(f64),
    /// A person did something.
    Input(Input),
}

/// What a person can do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Input {
    /// A choice on the panel, an alternative of the screening, or an option of an item.
    Choose(u32),
    /// Confirm the choice.
    Confirm,
    /// Go on from a page, a break or a pause.
    Continue,
    /// Do not agree, or do not answer.
    Decline,
    /// Pause the session; by the operator or the participant.
    Pause { by_operator: bool },
    /// Skip this state (operator).
    Skip,
    /// Show this presentation from its beginning (operator).
    Repeat,
    /// Write a note into the journal (operator).
    Note(String),
    /// Withdraw from the study, together with the data (participant).
    Withdraw,
    /// Give the session up for good (operator).
    Abandon,
    /// Close the program; the session can be resumed.
    Quit,
}

/// What the machine wants to be done, in this order.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Append to the journal.
    Write(Record),
    /// Everything written so far must be on the disk before the next action.
    Sync,
    /// Show this screen from the next frame on.
    Show(Screen),
    /// Close the session: it is over with this outcome, or (none) it can be resumed.
    Close(Option<Outcome>),
}

/// What the display shows.
#[derive(Debug, Clone, PartialEq)]
pub enum Screen {
    Page(Page),
    /// One item of a questionnaire; the index is into [`Setup::items`].
    Item(usize),
    /// A random-dot stereogram; the index is into [`Setup::screening`].
    Dots(usize),
    Stimulus {
        presentation: u32,
        attempt: u32,
        show: Shown,
        /// Index of the plan's stimulus.
        stimulus: u32,
        /// The reference that is shown beside it (mirrored pair).
        reference: Option<u32>,
        /// Which frame of a moving stimulus, from 0; 0 for a still.
        frame: u32,
    },
    Blank,
    Panel {
        presentation: u32,
        attempt: u32,
        chosen: Option<u32>,
        /// Whether the panel reminds the participant, who has not answered for long.
        reminder: bool,
    },
}

impl Screen {
    /// The screen with the first frame of a moving stimulus: what is written over the stimulus is the same for all of
    /// its frames.
    pub fn first_frame(&self) -> Screen {
        let mut first = self.clone();
        if let Screen::Stimulus { frame, .. } = &mut first {
            *frame = 0;
        }
        first
    }
}

/// A page of text that waits for the participant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Page {
    Consent,
    Instructions,
    /// Practice is over, the trials begin.
    Ready,
    Break,
    Paused,
    /// The session was resumed after the program had ended.
    WelcomeBack,
    Thanks,
}

impl Page {
    pub const ALL: [Page; 7] =
        [Page::Consent, Page::Instructions, Page::Ready, Page::Break, Page::Paused, Page::WelcomeBack, Page::Thanks];

    /// The journal's name for the page.
    pub fn phase(self) -> &'static str {
        match self {
            Page::Consent => "consent",
            Page::Instructions => "instructions",
            Page::Ready => "ready",
            Page::Break => "break",
            Page::Paused => "paused",
            Page::WelcomeBack => "welcome-back",
            Page::Thanks => "thanks",
        }
    }
}
