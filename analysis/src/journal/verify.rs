//! Checks that the lines of a journal agree with each other; the reader has checked each line by itself.

use std::collections::HashMap;

use super::codec::Entry;
use super::record::{Planned, Record};

/// A journal contradicts itself.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {what}")]
pub struct VerifyError {
    /// The line, from 1.
    pub line: u64,
    /// The contradiction, as a sentence.
    pub what: String,
}

/// The latest time that a journal may hold. After a later one, a session could not be resumed.
const LATEST_NS: u64 = i64::MAX as u64;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Attempt {
    Begun,
    Shown { valid: bool },
    Answered,
    Interrupted,
}

/// Checks a session entry by entry: every answer has its presentation, none is doubled, nothing follows the end.
#[derive(Debug, Default)]
pub struct Verifier {
    line: u64,
    last_ns: u64,
    planned: Vec<Planned>,
    conditions: u32,
    stimuli: u32,
    choices: u32,
    announced: Option<u32>,
    ready: bool,
    ended: bool,
    attempts: HashMap<(u32, u32), Attempt>,
    settled: HashMap<u32, &'static str>,
}

impl Verifier {
    /// Takes the next entry.
    ///
    /// # Errors
    /// What it contradicts.
    pub fn check(&mut self, entry: &Entry) -> Result<(), VerifyError> {
        self.line += 1;
        let line = self.line;
        self.judge(entry).map_err(|what| VerifyError { line, what })
    }

    fn judge(&mut self, entry: &Entry) -> Result<(), String> {
        if entry.t_ns < self.last_ns {
            return Err(format!("time goes back from {} to {} ns", self.last_ns, entry.t_ns));
        }
        if entry.t_ns > LATEST_NS {
            return Err(format!("a time of {} ns: no session lasts for 292 years", entry.t_ns));
        }
        self.last_ns = entry.t_ns;
        if self.ended {
            return Err("a record after the end of the session".to_owned());
        }
        let before_ready = matches!(
            entry.record,
            Record::Header(_)
                | Record::Stimulus(_)
                | Record::Condition(_)
                | Record::Order(_)
                | Record::Planned(_)
                | Record::Ready(_)
        );
        if before_ready == self.ready && !matches!(entry.record, Record::Resume(_) | Record::End(_)) {
            let when = if self.ready { "after" } else { "before" };
            return Err(format!("this record stands {when} the `ready` record"));
        }
        match &entry.record {
            Record::Header(header) => {
                if self.line != 1 {
                    return Err("a second header".to_owned());
                }
                self.choices = header.question.choices();
            }
            Record::Stimulus(stimulus) => self.stimuli = in_order("stimulus", stimulus.id, self.stimuli)?,
            Record::Condition(condition) => self.conditions = in_order("condition", condition.id, self.conditions)?,
            Record::Order(order) => self.announced = Some(order.presentations),
            Record::Planned(planned) => self.plan(planned)?,
            Record::Ready(_) => {
                if self.announced != u32::try_from(self.planned.len()).ok() {
                    return Err(format!(
                        "{} presentations are planned, the order announces another number",
                        self.planned.len()
                    ));
                }
                self.ready = true;
            }
            Record::Begin(r) => self.begin((r.presentation, r.attempt))?,
            Record::Presentation(r) => {
                self.step(
                    (r.presentation, r.attempt),
                    &[Attempt::Begun],
                    Attempt::Shown { valid: r.invalid.is_empty() },
                )?;
            }
            Record::Interrupted(r) => {
                let shown = [Attempt::Begun, Attempt::Shown { valid: true }, Attempt::Shown { valid: false }];
                self.step((r.presentation, r.attempt), &shown, Attempt::Interrupted)?;
            }
            Record::Change(r) => self.choice(r.choice)?,
            Record::Answer(r) => {
                self.choice(r.choice)?;
                self.step((r.presentation, r.attempt), &[Attempt::Shown { valid: r.counts }], Attempt::Answered)?;
                if r.counts {
                    self.settle(r.presentation, "answered")?;
                }
            }
            Record::Missing(r) => self.settle(r.presentation, "missing")?,
            Record::End(_) => self.ended = true,
            _ => {}
        }
        Ok(())
    }

    fn plan(&mut self, planned: &Planned) -> Result<(), String> {
        if planned.presentation as usize != self.planned.len() {
            return Err(format!("planned presentation {} out of order", planned.presentation));
        }
        if planned.condition >= self.conditions {
            return Err(format!("condition {} does not exist", planned.condition));
        }
        if planned.stimuli.is_empty() || planned.stimuli.iter().any(|&s| s >= self.stimuli) {
            return Err(format!("presentation {} shows a stimulus that does not exist", planned.presentation));
        }
        self.planned.push(planned.clone());
        Ok(())
    }

    fn begin(&mut self, key: (u32, u32)) -> Result<(), String> {
        if key.0 as usize >= self.planned.len() {
            return Err(format!("presentation {} is not planned", key.0));
        }
        if let Some(how) = self.settled.get(&key.0) {
            return Err(format!("presentation {} is shown again, though it is {how}", key.0));
        }
        if key.1 > 0 && !self.attempts.contains_key(&(key.0, key.1 - 1)) {
            return Err(format!("attempt {} of presentation {} without the one before", key.1, key.0));
        }
        match self.attempts.insert(key, Attempt::Begun) {
            None => Ok(()),
            Some(_) => Err(format!("attempt {} of presentation {} begins twice", key.1, key.0)),
        }
    }

    fn step(&mut self, key: (u32, u32), from: &[Attempt], to: Attempt) -> Result<(), String> {
        match self.attempts.get_mut(&key) {
            Some(state) if from.contains(state) => {
                *state = to;
                Ok(())
            }
            state => Err(format!("presentation {}, attempt {} cannot become {to:?}: it is {state:?}", key.0, key.1)),
        }
    }

    fn settle(&mut self, presentation: u32, how: &'static str) -> Result<(), String> {
        match self.settled.insert(presentation, how) {
            None => Ok(()),
            Some(before) => Err(format!("presentation {presentation} is {how}, though it is {before} already")),
        }
    }

    fn choice(&self, choice: u32) -> Result<(), String> {
        if choice < self.choices { Ok(()) } else { Err(format!("choice {choice}, but there are {}", self.choices)) }
    }
}

fn in_order(what: &str, id: u32, next: u32) -> Result<u32, String> {
    if id == next { Ok(next + 1) } else { Err(format!("{what} {id} out of order, expected {next}")) }
}
