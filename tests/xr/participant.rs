//! A simulated participant who follows the journal, turns pages, answers items and rates, with the stick and the
//! trigger of a controller.

use std::time::{Duration, Instant};

use cyclopean_analysis::journal::record::{Outcome, Record};

use super::Remote;
use super::journal::Tail;

/// A participant of one session.
pub struct Participant<'a> {
    pub remote: &'a Remote,
    pub tail: Tail,
    /// The choice for a presentation and an attempt.
    pub choice: &'a dyn Fn(u32, u32) -> u32,
    /// The longest time that the journal may stay unchanged.
    pub patience: Duration,
    /// The presentation, the attempt and the choice of each confirmed answer.
    pub answered: Vec<(u32, u32, u32)>,
}

/// The longest time to wait for the effect of the stick, the trigger or a page.
const PATIENCE: Duration = Duration::from_secs(60);

impl<'a> Participant<'a> {
    pub fn new(remote: &'a Remote, tail: Tail, choice: &'a dyn Fn(u32, u32) -> u32) -> Participant<'a> {
        Participant { remote, tail, choice, patience: PATIENCE, answered: Vec::new() }
    }

    /// Takes part until the session ends.
    pub fn take_part(&mut self) -> Outcome {
        self.until(|record| if let Record::End(end) = record { Some(end.outcome) } else { None })
    }

    /// Takes part until there is a record that `stop` accepts.
    pub fn until<T>(&mut self, stop: impl Fn(&Record) -> Option<T>) -> T {
        loop {
            let record = self.tail.next("something in the journal", self.patience, |r| Some(r.clone()));
            if let Some(found) = stop(&record) {
                return found;
            }
            match &record {
                Record::Phase(phase) => match phase.phase.as_str() {
                    "consent" => self.press_until_written(Some(1)),
                    "instructions" | "ready" | "break" | "thanks" | "welcome-back" => self.press_until_written(None),
                    name if name.starts_with("ssq") || name == "person" || name == "screening" => {
                        self.press_until_written(Some(1));
                    }
                    _ => {}
                },
                Record::Item(_) | Record::Screening(_) => self.press_until_written(Some(1)),
                Record::Presentation(p) => self.answer(p.presentation, p.attempt),
                _ => {}
            }
        }
    }

    /// Pulls the trigger until the journal grows. Before each pull the stick is pushed where a choice must be
    /// highlighted first.
    pub fn press_until_written(&mut self, stick: Option<i32>) {
        let before = self.tail.all().len();
        let begun = Instant::now();
        while self.tail.all().len() == before {
            assert!(begun.elapsed() < PATIENCE, "the trigger has no effect");
            if let Some(by) = stick {
                self.remote.stick(by);
            }
            self.remote.trigger();
        }
    }

    fn answer(&mut self, presentation: u32, attempt: u32) {
        let wanted = (self.choice)(presentation, attempt);
        let mut at = None;
        let begun = Instant::now();
        while at != Some(wanted) {
            assert!(begun.elapsed() < PATIENCE, "the stick has no effect");
            self.remote.stick(if at.is_some_and(|at| at > wanted) { -1 } else { 1 });
            for record in self.tail.rest() {
                if let Record::Change(change) = record {
                    at = Some(change.choice);
                }
            }
        }
        loop {
            assert!(begun.elapsed() < PATIENCE, "the choice is not confirmed");
            self.remote.trigger();
            let answer = self.tail.all().iter().rev().find_map(|e| match &e.record {
                Record::Answer(a) if (a.presentation, a.attempt) == (presentation, attempt) => Some(a.choice),
                _ => None,
            });
            if let Some(choice) = answer {
                self.answered.push((presentation, attempt, choice));
                return;
            }
        }
    }
}
