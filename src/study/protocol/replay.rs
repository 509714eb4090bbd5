//! Replays the journal of a session that was cut off, which brings the machine back to its last state.

use cyclopean_analysis::journal::record::Record;

use super::machine::{CurrentAttempt, JournalMismatch, Machine};
use super::{Action, Page};

impl Machine {
    /// Takes one record of an earlier run of this session. All records come before [`Machine::resume`].
    ///
    /// # Errors
    /// The record cannot have come from this setup.
    pub fn replay(&mut self, record: &Record) -> Result<(), JournalMismatch> {
        let misfit = |what: String| Err(JournalMismatch(what));
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
                    self.current = Some(CurrentAttempt { presentation, attempt, valid: false });
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
            Record::Missing(m) => match self.unwritten_missing.iter().position(|&o| o == m.presentation) {
                Some(at) => {
                    self.unwritten_missing.remove(at);
                }
                None if self.queue.front() == Some(m.presentation) => self.queue.drop_front(),
                None => return misfit(format!("presentation {} cannot be missing", m.presentation)),
            },
            Record::End(_) => return misfit("it has ended".to_owned()),
            _ => {}
        }
        Ok(())
    }

    /// The first actions of a resumed session, after [`Machine::replay`] of every record.
    pub fn resume(&mut self, _now_ns: u64) -> Vec<Action> {
        let mut out = Vec::new();
        self.write_missing(&mut out);
        self.interrupt("killed", &mut out);
        out.push(Action::Sync);
        self.show_page(Page::WelcomeBack, &mut out);
        out
    }
}
