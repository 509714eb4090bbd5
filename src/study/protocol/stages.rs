//! The course of a session: which stage, presentation or break comes next.

use cyclopean_analysis::journal::record::{Begin, Outcome, Phase, Purpose, Record};

use super::machine::{AfterBlank, CurrentAttempt, Machine, State};
use super::setup::Stage;
use super::timing::Timing;
use super::{Action, Page, Screen};

impl Machine {
    pub(super) fn show_page(&mut self, page: Page, out: &mut Vec<Action>) {
        self.state = State::Page(page);
        self.write_phase(page.phase(), out);
        out.push(Action::Show(Screen::Page(page)));
    }

    pub(super) fn write_phase(&self, phase: &str, out: &mut Vec<Action>) {
        out.push(Action::Write(Record::Phase(Phase { phase: phase.to_owned() })));
    }

    /// Goes on after the participant has left a page.
    pub(super) fn leave_page(&mut self, page: Page, now_ns: u64, out: &mut Vec<Action>) {
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

    pub(super) fn next_stage(&mut self, now_ns: u64, out: &mut Vec<Action>) {
        let next = self.stage.map_or(0, |s| s + 1);
        if next >= self.setup.stages.len() {
            self.close(Outcome::Completed, "completed", out);
            return;
        }
        self.stage = Some(next);
        self.cursor = 0;
        self.enter(next, 0, now_ns, out);
    }

    pub(super) fn enter(&mut self, stage: usize, cursor: usize, now_ns: u64, out: &mut Vec<Action>) {
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

    pub(super) fn front_purpose(&self) -> Option<Purpose> {
        self.queue.front().map(|p| self.setup.presentations[p as usize].purpose)
    }

    /// Goes on with the next presentation, or the page before it, or the end of the stage.
    pub(super) fn next_presentation(&mut self, now_ns: u64, out: &mut Vec<Action>) {
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
            self.current = Some(CurrentAttempt { presentation, attempt, valid: false });
            // The journal is synced during the blank frame, so that no disk delays a stimulus.
            out.extend([Action::Write(Record::Begin(Begin { presentation, attempt })), Action::Sync]);
            if self.setup.blank_frames > 0 {
                self.blank(AfterBlank::Stimulus, out);
            } else {
                self.show_segment(0, Timing::new(), out);
            }
        }
    }
}
