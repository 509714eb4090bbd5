//! Display frames as events. The frames of a phase are counted; the next phase begins with the frame after its last
//! one.

use cyclopean_analysis::journal::record::{Record, Shown};

use super::machine::{AfterBlank, Clock, CurrentAttempt, Machine, State};
use super::setup::Setup;
use super::timing::{FrameRun, Timing};
use super::{Action, Screen};

impl Machine {
    /// Divides a run of frames, which may be longer than was announced, wherever something happens; the frames are
    /// taken to be at even intervals.
    pub(super) fn split(&mut self, count: u64, first_ns: u64, last_ns: u64, out: &mut Vec<Action>) {
        let span = u128::from(last_ns.saturating_sub(first_ns));
        let at = |i: u64| first_ns + (span * u128::from(i) / u128::from(count.max(2) - 1)) as u64;
        let mut done = 0;
        while done < count && !self.is_over() {
            let run = self.idle_frames().clamp(1, count - done);
            self.frames(run, at(done), at(done + run - 1), true, out);
            done += run;
        }
    }

    pub(super) fn frames(&mut self, count: u64, first_ns: u64, last_ns: u64, rendered: bool, out: &mut Vec<Action>) {
        let period = self.setup.period_ns();
        let periods = |ns: u64| ((ns as f64 / period).round() as u64).max(1);
        let steps = self.last_frame_ns.map_or(1, |before| periods(first_ns.saturating_sub(before)));
        let inner_steps = if count > 1 { periods(last_ns.saturating_sub(first_ns) / (count - 1)) } else { 1 };
        self.last_frame_ns = Some(last_ns.max(first_ns));
        self.pass_deadline(first_ns, steps, out);
        let seen = self.focus && self.visible;
        let run = FrameRun { count, first_ns, last_ns, steps, inner_steps, seen, rendered };
        match &mut self.state {
            State::Showing { clock, segment, timing } => {
                let spec = self.setup.segments[*segment];
                if clock.elapsed.is_none() {
                    timing.open(spec, first_ns);
                }
                clock.add(&run);
                timing.frames(run);
                let Some(current) = self.current else { return };
                if let Some(film) = self.setup.film_of(current.presentation, spec.show) {
                    let frame = self.setup.film_frame(film, clock.elapsed.unwrap_or(0));
                    if timing.film_frame(frame, &run) && frame > 0 {
                        out.push(Action::Show(stimulus_screen(&self.setup, current, spec.show, frame)));
                    }
                }
            }
            State::Panel { clock, opened_ns, .. } => {
                if clock.elapsed.is_none() && clock.asked == self.setup.reminder_frames {
                    *opened_ns = first_ns;
                }
                clock.add(&run);
            }
            State::Blank { clock, .. } => clock.add(&run),
            _ => {}
        }
    }

    /// Changes the state if this frame is the first of the next phase. This happens before the frame is counted.
    pub(super) fn pass_deadline(&mut self, at_ns: u64, steps: u64, out: &mut Vec<Action>) {
        let over = |clock: &Clock| clock.is_over(steps);
        match &mut self.state {
            State::Blank { clock, then } if over(clock) => match then {
                AfterBlank::Stimulus => self.show_segment(0, Timing::new(), out),
                AfterBlank::Panel => self.open_panel(at_ns, out),
            },
            State::Showing { clock, segment, timing } if over(clock) => {
                let (next, timing) = (*segment + 1, timing.clone());
                if next < self.setup.segments.len() {
                    self.show_segment(next, timing, out);
                } else {
                    self.finish_showing(timing, at_ns, steps, out);
                }
            }
            State::Panel { clock, chosen, reminded, .. } if over(clock) => {
                if *reminded {
                    self.pause(at_ns, "no-answer", out);
                } else {
                    *reminded = true;
                    // The count goes on from the panel's first frame.
                    clock.asked = self.setup.pause_frames.max(clock.asked + 1);
                    let chosen = *chosen;
                    self.show_panel(chosen, true, out);
                }
            }
            _ => {}
        }
    }

    pub(super) fn show_segment(&mut self, segment: usize, timing: Timing, out: &mut Vec<Action>) {
        let Some(current) = self.current else { return };
        let spec = self.setup.segments[segment];
        self.state = State::Showing { clock: Clock::new(spec.frames), segment, timing };
        out.push(Action::Show(stimulus_screen(&self.setup, current, spec.show, 0)));
    }

    /// Whether a film is running in this segment, so that coming frames change what is shown.
    pub(super) fn plays(&self, segment: usize, timing: &Timing) -> bool {
        let film = self.current.and_then(|c| self.setup.film_of(c.presentation, self.setup.segments[segment].show));
        film.is_some_and(|film| !timing.film_is_over(segment, film))
    }

    pub(super) fn finish_showing(&mut self, timing: Timing, at_ns: u64, steps: u64, out: &mut Vec<Action>) {
        let Some(current) = &mut self.current else { return };
        let record = timing.finish(&self.setup, (current.presentation, current.attempt), at_ns, steps);
        current.valid = record.invalid.is_empty();
        out.push(Action::Write(Record::Presentation(record)));
        if self.setup.blank_frames > 0 {
            self.blank(AfterBlank::Panel, out);
        } else {
            self.open_panel(at_ns, out);
        }
    }

    pub(super) fn blank(&mut self, then: AfterBlank, out: &mut Vec<Action>) {
        self.state = State::Blank { clock: Clock::new(self.setup.blank_frames), then };
        out.push(Action::Show(Screen::Blank));
    }

    pub(super) fn open_panel(&mut self, now_ns: u64, out: &mut Vec<Action>) {
        let clock = Clock::new(self.setup.reminder_frames);
        self.state = State::Panel { clock, opened_ns: now_ns, chosen: None, changes: 0, reminded: false };
        self.show_panel(None, false, out);
    }

    pub(super) fn show_panel(&self, chosen: Option<u32>, reminder: bool, out: &mut Vec<Action>) {
        if let Some(CurrentAttempt { presentation, attempt, .. }) = self.current {
            out.push(Action::Show(Screen::Panel { presentation, attempt, chosen, reminder }));
        }
    }
}

/// The screen that is shown during a segment.
fn stimulus_screen(setup: &Setup, current: CurrentAttempt, show: Shown, frame: u32) -> Screen {
    let CurrentAttempt { presentation, attempt, .. } = current;
    match setup.stimulus(presentation, show) {
        None => Screen::Blank,
        Some((stimulus, reference)) => Screen::Stimulus { presentation, attempt, show, stimulus, reference, frame },
    }
}
