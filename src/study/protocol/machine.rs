//! The states and what each event does to them.

use cyclopean_analysis::journal::record::{
    Answer, Begin, Change, Continue, End, Interrupted, Item, Missing, Outcome, Pause, Phase, Purpose, Record,
    Screening, Skip,
};

use super::queue::{Queue, Settled};
use super::setup::{SCREENING_PASS, Setup, Stage};
use super::timing::{FrameRun, Timing};
use super::{Action, Event, Input, Page, Screen};

/// Where a session stands.
#[derive(Debug, Clone)]
enum State {
    /// Nothing was shown yet.
    Fresh,
    /// A text waits for the participant.
    Page(Page),
    /// An item of a questionnaire waits for an answer.
    Item(usize),
    /// A stereogram waits for a choice.
    Dots(usize),
    /// The blank frame before a stimulus, or between it and its panel.
    Blank { clock: Clock, then: AfterBlank },
    /// A segment of the stimulus is on the display.
    Showing { clock: Clock, segment: usize, timing: Timing },
    /// The panel waits for an answer; the clock runs to its next reminder or pause.
    Panel { clock: Clock, opened_ns: u64, chosen: Option<u32>, changes: u32, reminded: bool },
    /// The session stands still; then it goes on there.
    Paused { since_ns: u64, then: Box<State> },
    /// Nothing more happens.
    Over,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum AfterBlank {
    Stimulus,
    Panel,
}

/// Counts the display's nominal periods since the first frame of a phase.
#[derive(Debug, Clone, Copy)]
struct Clock {
    asked: u64,
    /// None before its first frame.
    elapsed: Option<u64>,
}

impl Clock {
    fn new(asked: u64) -> Clock {
        Clock { asked, elapsed: None }
    }

    /// Frames that cannot be the first of what follows.
    fn idle(&self) -> u64 {
        self.elapsed.map_or(self.asked, |e| self.asked.saturating_sub(e + 1))
    }

    /// A frame that comes `steps` periods after the last belongs to what follows.
    fn is_over(&self, steps: u64) -> bool {
        self.elapsed.is_some_and(|e| e + steps >= self.asked)
    }

    fn add(&mut self, run: &FrameRun) {
        let inner = run.inner_steps * (run.count - 1);
        self.elapsed = Some(self.elapsed.map_or(inner, |e| e + run.steps + inner));
    }
}

/// The attempt that is under way.
#[derive(Debug, Clone, Copy)]
struct Current {
    presentation: u32,
    attempt: u32,
    valid: bool,
}

/// A journal does not belong to this study and row.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the journal does not follow from its study and row: {0}")]
pub struct Misfit(pub String);

/// A session. See the module's documentation.
#[derive(Debug, Clone)]
pub struct Machine {
    setup: Setup,
    state: State,
    stage: Option<usize>,
    /// Items answered within the stage, stereograms answered.
    cursor: usize,
    right: u32,
    queue: Queue,
    current: Option<Current>,
    /// Exhausted presentations whose `missing` record is not written.
    owed: Vec<u32>,
    ready_shown: bool,
    answered: u32,
    last_break_ns: Option<u64>,
    last_frame_ns: Option<u64>,
    focus: bool,
    visible: bool,
}

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
            owed: Vec::new(),
            ready_shown: false,
            answered: 0,
            last_break_ns: None,
            last_frame_ns: None,
            focus: true,
            visible: true,
        }
    }

    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    pub fn is_over(&self) -> bool {
        matches!(self.state, State::Over)
    }

    /// Coming frames that change nothing unless somebody does something; `u64::MAX`: any number.
    pub fn idle_frames(&self) -> u64 {
        match &self.state {
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

    /// Takes one record of an earlier run of this session; before [`Machine::resume`].
    ///
    /// # Errors
    /// The record cannot have come from this setup.
    pub fn replay(&mut self, record: &Record) -> Result<(), Misfit> {
        let misfit = |what: String| Err(Misfit(what));
        match record {
            Record::Phase(phase) => {
                let name = if phase.phase == "practice" { "trials" } else { phase.phase.as_str() };
                self.ready_shown |= name == "ready";
                if let Some(at) = self.setup.stages.iter().position(|s| s.phase() == name)
                    && self.stage != Some(at)
                {
                    (self.stage, self.cursor) = (Some(at), 0);
                }
            }
            Record::Item(_) => self.cursor += 1,
            Record::Screening(s) => {
                self.judge_dots(self.cursor, s.chosen);
                self.cursor += 1;
            }
            Record::Begin(b) => match self.queue.begin() {
                Some((presentation, attempt)) if (presentation, attempt) == (b.presentation, b.attempt) => {
                    self.current = Some(Current { presentation, attempt, valid: false });
                }
                next => return misfit(format!("({}, {}) begins where {next:?} is next", b.presentation, b.attempt)),
            },
            Record::Presentation(p) => match &mut self.current {
                Some(c) if (c.presentation, c.attempt) == (p.presentation, p.attempt) => {
                    c.valid = p.invalid.is_empty();
                }
                _ => return misfit(format!("presentation {} was not begun", p.presentation)),
            },
            Record::Interrupted(i) => match self.current.take() {
                Some(c) if c.presentation == i.presentation => self.queue.interrupted(i.presentation),
                _ => return misfit(format!("presentation {} was not begun", i.presentation)),
            },
            Record::Answer(a) => match self.current.take() {
                Some(c) if (c.presentation, c.attempt) == (a.presentation, a.attempt) => self.settle(c),
                _ => return misfit(format!("presentation {} was not begun", a.presentation)),
            },
            Record::Missing(m) => match self.owed.iter().position(|&o| o == m.presentation) {
                Some(at) => {
                    self.owed.remove(at);
                }
                None if self.queue.front() == Some(m.presentation) => self.queue.drop_front(),
                None => return misfit(format!("presentation {} cannot be missing", m.presentation)),
            },
            Record::End(_) => return misfit("it has ended".to_owned()),
            _ => {}
        }
        Ok(())
    }

    /// The first actions after [`Machine::replay`] of everything there was.
    pub fn resume(&mut self, _now_ns: u64) -> Vec<Action> {
        let mut out = Vec::new();
        self.write_owed(&mut out);
        self.interrupt("killed", &mut out);
        out.push(Action::Sync);
        self.show_page(Page::WelcomeBack, &mut out);
        out
    }

    /// What an event at `now_ns` leads to.
    pub fn handle(&mut self, now_ns: u64, event: Event) -> Vec<Action> {
        let mut out = Vec::new();
        match event {
            _ if self.is_over() => {}
            Event::Frame { at_ns, rendered } => self.frames(1, at_ns, at_ns, rendered, &mut out),
            Event::Frames { count, first_ns, last_ns } => self.split(count, first_ns, last_ns, &mut out),
            Event::Focus(focus) => self.focus = focus,
            Event::Visible(visible) => self.visible = visible,
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

    // ---- frames -------------------------------------------------------------------------------------------------

    /// Runs longer than promised are cut where something happens, at even intervals.
    fn split(&mut self, count: u64, first_ns: u64, last_ns: u64, out: &mut Vec<Action>) {
        let span = u128::from(last_ns.saturating_sub(first_ns));
        let at = |i: u64| first_ns + (span * u128::from(i) / u128::from(count.max(2) - 1)) as u64;
        let mut done = 0;
        while done < count && !self.is_over() {
            let run = self.idle_frames().clamp(1, count - done);
            self.frames(run, at(done), at(done + run - 1), true, out);
            done += run;
        }
    }

    fn frames(&mut self, count: u64, first_ns: u64, last_ns: u64, rendered: bool, out: &mut Vec<Action>) {
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
                if clock.elapsed.is_none() {
                    timing.open(self.setup.segments[*segment], first_ns);
                }
                clock.add(&run);
                timing.frames(run);
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

    /// A frame that is the first of what follows changes the state before it is counted.
    fn pass_deadline(&mut self, at_ns: u64, steps: u64, out: &mut Vec<Action>) {
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
                    // Counted on from the panel's first frame.
                    clock.asked = self.setup.pause_frames.max(clock.asked + 1);
                    let chosen = *chosen;
                    self.show_panel(chosen, true, out);
                }
            }
            _ => {}
        }
    }

    fn show_segment(&mut self, segment: usize, timing: Timing, out: &mut Vec<Action>) {
        let Some(current) = self.current else { return };
        let spec = self.setup.segments[segment];
        self.state = State::Showing { clock: Clock::new(spec.frames), segment, timing };
        out.push(Action::Show(match self.setup.stimulus(current.presentation, spec.show) {
            None => Screen::Blank,
            Some((stimulus, reference)) => Screen::Stimulus {
                presentation: current.presentation,
                attempt: current.attempt,
                show: spec.show,
                stimulus,
                reference,
            },
        }));
    }

    fn finish_showing(&mut self, timing: Timing, at_ns: u64, steps: u64, out: &mut Vec<Action>) {
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

    fn blank(&mut self, then: AfterBlank, out: &mut Vec<Action>) {
        self.state = State::Blank { clock: Clock::new(self.setup.blank_frames), then };
        out.push(Action::Show(Screen::Blank));
    }

    fn open_panel(&mut self, now_ns: u64, out: &mut Vec<Action>) {
        let clock = Clock::new(self.setup.reminder_frames);
        self.state = State::Panel { clock, opened_ns: now_ns, chosen: None, changes: 0, reminded: false };
        self.show_panel(None, false, out);
    }

    fn show_panel(&self, chosen: Option<u32>, reminder: bool, out: &mut Vec<Action>) {
        if let Some(Current { presentation, attempt, .. }) = self.current {
            out.push(Action::Show(Screen::Panel { presentation, attempt, chosen, reminder }));
        }
    }

    // ---- people -------------------------------------------------------------------------------------------------

    fn input(&mut self, now_ns: u64, input: Input, out: &mut Vec<Action>) {
        match input {
            Input::Pause { by_operator } if !matches!(self.state, State::Paused { .. }) => {
                self.pause(now_ns, if by_operator { "operator" } else { "participant" }, out);
            }
            Input::Withdraw => self.close(Outcome::Withdrawn, "withdraw", out),
            Input::Abandon => self.close(Outcome::Abandoned, "abandon", out),
            Input::Quit => {
                self.interrupt("quit", out);
                self.state = State::Over;
                out.extend([Action::Sync, Action::Close(None)]);
            }
            Input::Skip => self.skip(now_ns, out),
            Input::Continue => match &self.state {
                State::Page(page) => self.turn(*page, now_ns, out),
                State::Paused { since_ns, then } => {
                    let (after_ns, then) = (now_ns.saturating_sub(*since_ns), (**then).clone());
                    out.push(Action::Write(Record::Continue(Continue { after_ns })));
                    self.unpause(then, now_ns, out);
                }
                _ => {}
            },
            Input::Decline => match self.state {
                State::Page(Page::Consent) => self.close(Outcome::Declined, "declined", out),
                State::Item(at) => self.answer_item(at, None, now_ns, out),
                _ => {}
            },
            Input::Choose(choice) => self.choose(now_ns, choice, out),
            Input::Confirm => self.confirm(now_ns, out),
            Input::Pause { .. } => {}
        }
    }

    fn choose(&mut self, now_ns: u64, choice: u32, out: &mut Vec<Action>) {
        match &mut self.state {
            State::Panel { opened_ns, chosen, changes, reminded, .. } => {
                let Some(c) = self.current else { return };
                if choice >= self.setup.choices || *chosen == Some(choice) {
                    return;
                }
                *chosen = Some(choice);
                *changes += 1;
                let (after_ns, reminder) = (now_ns.saturating_sub(*opened_ns), *reminded);
                let (presentation, attempt) = (c.presentation, c.attempt);
                out.push(Action::Write(Record::Change(Change { presentation, attempt, choice, after_ns })));
                self.show_panel(Some(choice), reminder, out);
            }
            State::Item(at) => {
                let at = *at;
                if let Some(option) = self.setup.items[at].options.get(choice as usize) {
                    self.answer_item(at, Some((*option).to_owned()), now_ns, out);
                }
            }
            State::Dots(at) if choice < 4 => {
                let at = *at;
                let trial = &self.setup.screening[at];
                out.push(Action::Write(Record::Screening(Screening {
                    disparity_arcsec: trial.disparity_arcsec,
                    arcsec_per_px: trial.arcsec_per_px,
                    trial: trial.trial,
                    shown: trial.shown,
                    chosen: choice,
                })));
                self.judge_dots(at, choice);
                self.show_dots(at + 1, now_ns, out);
            }
            _ => {}
        }
    }

    fn confirm(&mut self, now_ns: u64, out: &mut Vec<Action>) {
        let State::Panel { opened_ns, chosen: Some(choice), changes, .. } = self.state else { return };
        let Some(current) = self.current.take() else { return };
        out.push(Action::Write(Record::Answer(Answer {
            presentation: current.presentation,
            attempt: current.attempt,
            choice,
            after_ns: now_ns.saturating_sub(opened_ns),
            changes,
            counts: current.valid,
        })));
        self.settle(current);
        self.write_owed(out);
        self.next_presentation(now_ns, out);
    }

    /// What an answered attempt means for the order; the same in a replay.
    fn settle(&mut self, current: Current) {
        let settled = self.queue.answered(&self.setup.presentations, current.presentation, current.valid);
        let trial = self.setup.presentations[current.presentation as usize].purpose == Purpose::Trial;
        match settled {
            Settled::Done if trial => self.answered += 1,
            Settled::Done | Settled::Repeat => {}
            Settled::Exhausted => self.owed.push(current.presentation),
        }
    }

    fn write_owed(&mut self, out: &mut Vec<Action>) {
        for presentation in self.owed.drain(..) {
            out.push(Action::Write(Record::Missing(Missing { presentation, reason: "invalid".to_owned() })));
        }
    }

    fn answer_item(&mut self, at: usize, answer: Option<String>, now_ns: u64, out: &mut Vec<Action>) {
        let item = &self.setup.items[at];
        let (questionnaire, name) = (item.questionnaire.to_owned(), item.name.to_owned());
        out.push(Action::Write(Record::Item(Item { questionnaire, item: name, answer })));
        out.push(Action::Sync);
        match self.stage.map(|s| self.setup.stages[s]) {
            Some(Stage::Items { to, .. }) if at + 1 < to => self.show_item(at + 1, out),
            _ => self.next_stage(now_ns, out),
        }
    }

    fn judge_dots(&mut self, at: usize, chosen: u32) {
        if let Some(trial) = self.setup.screening.get(at)
            && trial.required
            && trial.shown == chosen
        {
            self.right += 1;
        }
    }

    fn show_item(&mut self, at: usize, out: &mut Vec<Action>) {
        self.state = State::Item(at);
        out.push(Action::Show(Screen::Item(at)));
    }

    fn show_dots(&mut self, at: usize, now_ns: u64, out: &mut Vec<Action>) {
        if at < self.setup.screening.len() {
            self.state = State::Dots(at);
            out.push(Action::Show(Screen::Dots(at)));
            return;
        }
        out.push(Action::Sync);
        if self.right < SCREENING_PASS {
            self.close(Outcome::Screened, "screened", out);
        } else {
            self.next_stage(now_ns, out);
        }
    }

    // ---- the way through ----------------------------------------------------------------------------------------

    fn show_page(&mut self, page: Page, out: &mut Vec<Action>) {
        self.state = State::Page(page);
        self.write_phase(page.phase(), out);
        out.push(Action::Show(Screen::Page(page)));
    }

    fn write_phase(&self, phase: &str, out: &mut Vec<Action>) {
        out.push(Action::Write(Record::Phase(Phase { phase: phase.to_owned() })));
    }

    /// The participant turned a page.
    fn turn(&mut self, page: Page, now_ns: u64, out: &mut Vec<Action>) {
        match page {
            Page::Consent | Page::Instructions | Page::Thanks => self.next_stage(now_ns, out),
            Page::Break => {
                self.last_break_ns = Some(now_ns);
                self.next_presentation(now_ns, out);
            }
            Page::Ready => {
                self.write_phase("trials", out);
                self.next_presentation(now_ns, out);
            }
            Page::WelcomeBack => {
                self.last_break_ns = Some(now_ns);
                match self.stage {
                    None => self.next_stage(now_ns, out),
                    Some(stage) => self.enter(stage, self.cursor, now_ns, out),
                }
            }
            Page::Paused => {}
        }
    }

    fn next_stage(&mut self, now_ns: u64, out: &mut Vec<Action>) {
        let next = self.stage.map_or(0, |s| s + 1);
        if next >= self.setup.stages.len() {
            self.close(Outcome::Completed, "completed", out);
            return;
        }
        self.stage = Some(next);
        self.cursor = 0;
        self.enter(next, 0, now_ns, out);
    }

    fn enter(&mut self, stage: usize, cursor: usize, now_ns: u64, out: &mut Vec<Action>) {
        match self.setup.stages[stage] {
            Stage::Page(page) => self.show_page(page, out),
            Stage::Items { name, from, to } if from + cursor < to => {
                self.write_phase(name, out);
                self.show_item(from + cursor, out);
            }
            Stage::Items { .. } => self.next_stage(now_ns, out),
            Stage::Screening => {
                self.write_phase("screening", out);
                self.show_dots(cursor, now_ns, out);
            }
            Stage::Presentations => {
                let practice = self.front_purpose() == Some(Purpose::Practice);
                self.write_phase(if practice { "practice" } else { "trials" }, out);
                self.last_break_ns.get_or_insert(now_ns);
                self.next_presentation(now_ns, out);
            }
        }
    }

    fn front_purpose(&self) -> Option<Purpose> {
        self.queue.front().map(|p| self.setup.presentations[p as usize].purpose)
    }

    /// The next presentation, or the page that stands before it, or the end of the stage.
    fn next_presentation(&mut self, now_ns: u64, out: &mut Vec<Action>) {
        let Some(purpose) = self.front_purpose() else {
            out.push(Action::Sync);
            self.next_stage(now_ns, out);
            return;
        };
        let had_practice = self.setup.presentations.first().is_some_and(|p| p.purpose == Purpose::Practice);
        let waited_ns = now_ns.saturating_sub(self.last_break_ns.unwrap_or(now_ns));
        if purpose != Purpose::Practice && had_practice && !self.ready_shown {
            self.ready_shown = true;
            out.push(Action::Sync);
            self.show_page(Page::Ready, out);
        } else if purpose != Purpose::Practice && self.setup.break_ns > 0 && waited_ns >= self.setup.break_ns {
            out.push(Action::Sync);
            self.show_page(Page::Break, out);
        } else if let Some((presentation, attempt)) = self.queue.begin() {
            self.current = Some(Current { presentation, attempt, valid: false });
            // Synced while the blank stands, so that no disk delays a stimulus.
            out.extend([Action::Write(Record::Begin(Begin { presentation, attempt })), Action::Sync]);
            if self.setup.blank_frames > 0 {
                self.blank(AfterBlank::Stimulus, out);
            } else {
                self.show_segment(0, Timing::new(), out);
            }
        }
    }

    // ---- ways out -----------------------------------------------------------------------------------------------

    /// Cuts off the attempt that is under way, if there is one; it will come again first.
    fn interrupt(&mut self, reason: &str, out: &mut Vec<Action>) {
        if let Some(Current { presentation, attempt, .. }) = self.current.take() {
            self.queue.interrupted(presentation);
            let reason = reason.to_owned();
            out.push(Action::Write(Record::Interrupted(Interrupted { presentation, attempt, reason })));
        }
    }

    fn pause(&mut self, now_ns: u64, reason: &str, out: &mut Vec<Action>) {
        // What was seen whole can still be judged; what was cut off cannot.
        let judged = matches!(self.state, State::Panel { .. } | State::Blank { then: AfterBlank::Panel, .. });
        if !judged {
            self.interrupt("pause", out);
        }
        let then = Box::new(std::mem::replace(&mut self.state, State::Over));
        self.state = State::Paused { since_ns: now_ns, then };
        out.extend([Action::Write(Record::Pause(Pause { reason: reason.to_owned() })), Action::Sync]);
        out.push(Action::Show(Screen::Page(Page::Paused)));
    }

    fn unpause(&mut self, then: State, now_ns: u64, out: &mut Vec<Action>) {
        match then {
            State::Page(page) => {
                self.state = State::Page(page);
                out.push(Action::Show(Screen::Page(page)));
            }
            State::Item(at) => self.show_item(at, out),
            State::Dots(at) => self.show_dots(at, now_ns, out),
            State::Panel { opened_ns, chosen, changes, .. } => {
                let clock = Clock::new(self.setup.reminder_frames);
                self.state = State::Panel { clock, opened_ns, chosen, changes, reminded: false };
                self.show_panel(chosen, false, out);
            }
            State::Blank { then: AfterBlank::Panel, .. } => self.blank(AfterBlank::Panel, out),
            State::Fresh | State::Blank { .. } | State::Showing { .. } => self.next_presentation(now_ns, out),
            State::Paused { .. } | State::Over => {}
        }
    }

    fn skip(&mut self, now_ns: u64, out: &mut Vec<Action>) {
        let write = |phase: &str| Action::Write(Record::Skip(Skip { phase: phase.to_owned() }));
        match self.state {
            // Nobody can consent for somebody else.
            State::Page(Page::Consent) | State::Fresh | State::Paused { .. } | State::Over => {}
            State::Page(page) => {
                out.push(write(page.phase()));
                self.turn(page, now_ns, out);
            }
            State::Item(at) => {
                out.push(write(self.setup.items[at].questionnaire));
                self.answer_item(at, None, now_ns, out);
            }
            State::Dots(_) => {
                out.extend([write("screening"), Action::Sync]);
                self.next_stage(now_ns, out);
            }
            State::Blank { .. } | State::Showing { .. } | State::Panel { .. } => {
                let Some(Current { presentation, .. }) = self.current else { return };
                out.push(write("presentation"));
                self.interrupt("skip", out);
                self.queue.drop_front();
                let reason = "skipped".to_owned();
                out.push(Action::Write(Record::Missing(Missing { presentation, reason })));
                self.next_presentation(now_ns, out);
            }
        }
    }

    fn close(&mut self, outcome: Outcome, reason: &str, out: &mut Vec<Action>) {
        self.interrupt(reason, out);
        self.state = State::Over;
        let trials = self.setup.presentations.iter().filter(|p| p.purpose == Purpose::Trial).count() as u32;
        let (answered, missing) = (self.answered, trials - self.answered.min(trials));
        out.extend([
            Action::Write(Record::End(End { outcome, answered, missing })),
            Action::Sync,
            Action::Close(Some(outcome)),
        ]);
    }
}
