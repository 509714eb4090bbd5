//! The ways out of a state: pause, skip, repeat, and the end of the session.

use cyclopean_analysis::journal::record::{End, Interrupted, Missing, Outcome, Pause, Purpose, Record, Skip};

use super::machine::{AfterBlank, Clock, CurrentAttempt, Machine, State, UNSEEN_PAUSE_NS};
use super::{Action, Page, Screen};

impl Machine {
    /// Cuts off the attempt that is under way, if there is one. Its presentation will be the next to be shown.
    pub(super) fn interrupt(&mut self, reason: &str, out: &mut Vec<Action>) {
        if let Some(CurrentAttempt { presentation, attempt, .. }) = self.current.take() {
            self.queue.interrupted(presentation);
            let reason = reason.to_owned();
            out.push(Action::Write(Record::Interrupted(Interrupted { presentation, attempt, reason })));
        }
    }

    pub(super) fn pause(&mut self, now_ns: u64, reason: &str, out: &mut Vec<Action>) {
        // A stimulus that was seen as a whole can still be judged. One that was cut off cannot.
        let judged = matches!(self.state, State::Panel { .. } | State::Blank { then: AfterBlank::Panel, .. });
        if !judged {
            self.interrupt("pause", out);
        }
        let then = Box::new(std::mem::replace(&mut self.state, State::Over));
        self.state = State::Paused { since_ns: now_ns, then };
        out.extend([Action::Write(Record::Pause(Pause { reason: reason.to_owned() })), Action::Sync]);
        out.push(Action::Show(Screen::Page(Page::Paused)));
    }

    /// Pauses a state that goes on by itself when nobody has looked for long. Texts and questions wait anyway.
    pub(super) fn watch(&mut self, now_ns: u64, out: &mut Vec<Action>) {
        if self.focus && self.visible {
            self.unseen_since_ns = None;
            return;
        }
        let since_ns = *self.unseen_since_ns.get_or_insert(now_ns);
        let runs = matches!(self.state, State::Blank { .. } | State::Showing { .. } | State::Panel { .. });
        if runs && now_ns.saturating_sub(since_ns) >= UNSEEN_PAUSE_NS {
            self.pause(now_ns, "not-seen", out);
        }
    }

    pub(super) fn unpause(&mut self, then: State, now_ns: u64, out: &mut Vec<Action>) {
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

    pub(super) fn skip(&mut self, now_ns: u64, out: &mut Vec<Action>) {
        let write = |phase: &str| Action::Write(Record::Skip(Skip { phase: phase.to_owned() }));
        match self.state {
            // The operator cannot skip the consent: nobody can consent for somebody else.
            State::Page(Page::Consent) | State::Fresh | State::Paused { .. } | State::Over => {}
            State::Page(page) => {
                out.push(write(page.phase()));
                self.leave_page(page, now_ns, out);
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
                let Some(CurrentAttempt { presentation, .. }) = self.current else { return };
                out.push(write("presentation"));
                self.interrupt("skip", out);
                self.queue.drop_front();
                let reason = "skipped".to_owned();
                out.push(Action::Write(Record::Missing(Missing { presentation, reason })));
                self.next_presentation(now_ns, out);
            }
        }
    }

    /// Cuts off the attempt that is under way; its presentation is shown again as a new attempt.
    pub(super) fn repeat(&mut self, now_ns: u64, out: &mut Vec<Action>) {
        let is_under_way = matches!(self.state, State::Blank { .. } | State::Showing { .. } | State::Panel { .. });
        if is_under_way && self.current.is_some() {
            self.interrupt("repeat", out);
            self.next_presentation(now_ns, out);
        }
    }

    pub(super) fn close(&mut self, outcome: Outcome, reason: &str, out: &mut Vec<Action>) {
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
