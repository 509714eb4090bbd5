//! The operator's window beside a headset. It shows what the participant sees, the progress of the session and its
//! timing, and takes the operator's keys.
//!
//! It has a thread and a device of its own, so that it cannot delay the participant's frames. One program has one such
//! window, and none beside a desktop window, because the window system gives a program only one event loop.

mod window;

use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::content::Content;
use super::{Display, DisplayError, DisplayInfo, HeadPose, StimulusFiles, TimedEvent};
use crate::study::protocol::{Event, Input, Screen};

/// What the session tells the window.
#[derive(Debug, Clone)]
enum WindowMessage {
    Stimuli(Vec<StimulusFiles>),
    Status(Box<SessionStatus>),
}

/// The state of a session.
#[derive(Debug, Clone)]
struct SessionStatus {
    screen: Screen,
    health: Health,
}

/// Timing since the session began, and whether the participant looks.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Health {
    frames: u64,
    missed: u64,
    unrendered: u64,
    longest_gap_ms: f64,
    nominal_hz: f64,
    is_unseen: bool,
    is_unfocused: bool,
    last_ns: Option<u64>,
}

impl Health {
    fn record(&mut self, event: &Event) {
        match *event {
            Event::Frame { at_ns, rendered } => {
                self.frames += 1;
                self.unrendered += u64::from(!rendered);
                if let Some(last) = self.last_ns.replace(at_ns) {
                    let gap_ms = at_ns.saturating_sub(last) as f64 / 1e6;
                    self.longest_gap_ms = self.longest_gap_ms.max(gap_ms);
                    self.missed += ((gap_ms * self.nominal_hz / 1e3).round() as u64).saturating_sub(1);
                }
            }
            Event::Frames { count, last_ns, .. } => {
                self.frames += count;
                self.last_ns = Some(last_ns);
            }
            Event::Focus(has) => self.is_unfocused = !has,
            Event::Visible(is) => self.is_unseen = !is,
            Event::RefreshRate(_) | Event::Input(_) => {}
        }
    }
}

/// How often the window is told about the session.
const EVERY: Duration = Duration::from_millis(100);

/// A display with the operator's window beside it.
pub struct WithOperatorWindow<D> {
    display: D,
    status: SessionStatus,
    last_sent: Instant,
    clock: Option<(Instant, u64)>,
    /// None once the operator has closed the window.
    window: Option<(Sender<WindowMessage>, Receiver<Input>)>,
    thread: Option<JoinHandle<()>>,
}

impl<D: Display> WithOperatorWindow<D> {
    /// Opens the window. If that fails, the session goes on without it, and a warning says so.
    pub fn new(display: D, content: &Content) -> WithOperatorWindow<D> {
        let (messages, inbox) = channel();
        let (operator_inputs, inputs) = channel();
        // Stereograms are large, and the operator does not need to see them.
        let content = Content { dots: Vec::new(), ..content.clone() };
        let thread = std::thread::Builder::new().name("operator".to_owned()).spawn(move || {
            if let Err(error) = window::run(&content, &inbox, &operator_inputs) {
                tracing::warn!("the operator's window: {error}");
            }
        });
        let health = Health { nominal_hz: display.info().nominal_hz, ..Health::default() };
        WithOperatorWindow {
            display,
            status: SessionStatus { screen: Screen::Blank, health },
            last_sent: Instant::now(),
            clock: None,
            window: Some((messages, inputs)),
            thread: thread.ok(),
        }
    }

    /// The display that the window belongs to.
    pub fn display(&self) -> &D {
        &self.display
    }

    fn send(&mut self, message: WindowMessage) {
        if self.window.as_ref().is_some_and(|(messages, _)| messages.send(message).is_err()) {
            self.window = None;
        }
    }
}

impl<D: Display> Display for WithOperatorWindow<D> {
    fn info(&self) -> &DisplayInfo {
        self.display.info()
    }

    fn load(&mut self, stimuli: &[StimulusFiles]) -> Result<(), DisplayError> {
        self.send(WindowMessage::Stimuli(stimuli.to_vec()));
        self.display.load(stimuli)
    }

    fn wait(&mut self, idle_frames: u64) -> Result<TimedEvent, DisplayError> {
        if let (Some((_, inputs)), Some((at, ns))) = (&self.window, self.clock)
            && let Ok(input) = inputs.try_recv()
        {
            let now_ns = ns + at.elapsed().as_nanos() as u64;
            return Ok(TimedEvent { now_ns, event: Event::Input(input) });
        }
        let timed = self.display.wait(idle_frames)?;
        self.clock = Some((Instant::now(), timed.now_ns));
        self.status.health.record(&timed.event);
        Ok(timed)
    }

    fn present(&mut self, screen: &Screen) -> Result<(), DisplayError> {
        self.display.present(screen)?;
        // Of moving stimuli the window shows the first frame.
        let screen = screen.first_frame();
        if screen != self.status.screen || self.last_sent.elapsed() > EVERY {
            self.status.screen = screen;
            self.last_sent = Instant::now();
            self.send(WindowMessage::Status(Box::new(self.status.clone())));
        }
        Ok(())
    }

    fn take_poses(&mut self) -> Vec<HeadPose> {
        self.display.take_poses()
    }
}

impl<D> Drop for WithOperatorWindow<D> {
    fn drop(&mut self) {
        // The thread ends when nobody sends to it any more.
        self.window = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
