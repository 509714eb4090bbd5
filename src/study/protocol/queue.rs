//! The queue of presentations: the plan's order, with invalid presentations again at the end of their block.

use std::collections::VecDeque;

use cyclopean_analysis::journal::record::{Planned, Purpose};

/// What became of an attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AttemptResult {
    /// Answered and valid, or practice.
    Done,
    /// To be shown again later.
    Repeat,
    /// All attempts were invalid.
    Exhausted,
}

#[derive(Debug, Clone)]
pub struct Queue {
    upcoming: VecDeque<u32>,
    /// Number of attempts begun, by presentation.
    attempts: Vec<u32>,
    /// Number of invalid attempts, by presentation.
    invalid: Vec<u32>,
    repeats: u32,
}

impl Queue {
    pub fn new(presentations: &[Planned], repeats: u32) -> Queue {
        let n = presentations.len();
        Queue { upcoming: (0..n as u32).collect(), attempts: vec![0; n], invalid: vec![0; n], repeats }
    }

    pub fn front(&self) -> Option<u32> {
        self.upcoming.front().copied()
    }

    /// Takes the first presentation and counts its attempt; returns both numbers.
    pub fn begin(&mut self) -> Option<(u32, u32)> {
        let presentation = self.upcoming.pop_front()?;
        let attempt = &mut self.attempts[presentation as usize];
        *attempt += 1;
        Some((presentation, *attempt - 1))
    }

    /// Puts a presentation whose attempt was cut off at the front again.
    pub fn interrupted(&mut self, presentation: u32) {
        self.upcoming.push_front(presentation);
    }

    /// Removes the first presentation without showing it.
    pub fn drop_front(&mut self) {
        self.upcoming.pop_front();
    }

    /// Decides what becomes of a presentation after an answered attempt.
    pub fn answered(&mut self, plan: &[Planned], presentation: u32, valid: bool) -> AttemptResult {
        let planned = &plan[presentation as usize];
        if valid || planned.purpose == Purpose::Practice {
            return AttemptResult::Done;
        }
        let invalid = &mut self.invalid[presentation as usize];
        *invalid += 1;
        if *invalid > self.repeats {
            return AttemptResult::Exhausted;
        }
        let same_block = |&other: &u32| plan[other as usize].block == planned.block;
        let end = self.upcoming.iter().rposition(same_block).map_or(0, |last| last + 1);
        self.upcoming.insert(end, presentation);
        AttemptResult::Repeat
    }
}
