//! What people do: choices, confirmations, pages.

use cyclopean_analysis::journal::record::{
    Answer, Change, Continue, Item, Missing, Note, Outcome, Purpose, Record, Screening,
};

use super::machine::{CurrentAttempt, Machine, State};
use super::queue::AttemptResult;
use super::setup::{SCREENING_PASS, Stage};
use super::{Action, Input, Page, Screen};

impl Machine {
    pub(super) fn input(&mut self, now_ns: u64, input: Input, out: &mut Vec<Action>) {
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
            Input::Repeat => self.repeat(now_ns, out),
            Input::Note(text) => out.extend([Action::Write(Record::Note(Note { text })), Action::Sync]),
            Input::Continue => match &self.state {
                State::Page(page) => self.leave_page(*page, now_ns, out),
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

    pub(super) fn choose(&mut self, now_ns: u64, choice: u32, out: &mut Vec<Action>) {
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

    pub(super) fn confirm(&mut self, now_ns: u64, out: &mut Vec<Action>) {
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
        self.write_missing(out);
        self.next_presentation(now_ns, out);
    }

    /// Records what an answered attempt means for the order; a replay calls it too.
    pub(super) fn settle(&mut self, current: CurrentAttempt) {
        let settled = self.queue.answered(&self.setup.presentations, current.presentation, current.valid);
        let trial = self.setup.presentations[current.presentation as usize].purpose == Purpose::Trial;
        match settled {
            AttemptResult::Done if trial => self.answered += 1,
            AttemptResult::Done | AttemptResult::Repeat => {}
            AttemptResult::Exhausted => self.unwritten_missing.push(current.presentation),
        }
    }

    pub(super) fn write_missing(&mut self, out: &mut Vec<Action>) {
        for presentation in self.unwritten_missing.drain(..) {
            out.push(Action::Write(Record::Missing(Missing { presentation, reason: "invalid".to_owned() })));
        }
    }

    pub(super) fn answer_item(&mut self, at: usize, answer: Option<String>, now_ns: u64, out: &mut Vec<Action>) {
        let item = &self.setup.items[at];
        let (questionnaire, name) = (item.questionnaire.to_owned(), item.name.to_owned());
        out.push(Action::Write(Record::Item(Item { questionnaire, item: name, answer })));
        out.push(Action::Sync);
        match self.stage.map(|s| self.setup.stages[s]) {
            Some(Stage::Items { to, .. }) if at + 1 < to => self.show_item(at + 1, out),
            _ => self.next_stage(now_ns, out),
        }
    }

    pub(super) fn judge_dots(&mut self, at: usize, chosen: u32) {
        if let Some(trial) = self.setup.screening.get(at)
            && trial.required
            && trial.shown == chosen
        {
            self.right += 1;
        }
    }

    pub(super) fn show_item(&mut self, at: usize, out: &mut Vec<Action>) {
        self.state = State::Item(at);
        out.push(Action::Show(Screen::Item(at)));
    }

    pub(super) fn show_dots(&mut self, at: usize, now_ns: u64, out: &mut Vec<Action>) {
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
}
