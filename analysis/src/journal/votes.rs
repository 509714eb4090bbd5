//! Turns a session into its ratings. This is the one place where a choice becomes a number.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::codec::Entry;
use super::reader::{self, JournalError};
use super::record::{Answer, Condition, Header, Kind, Outcome, Planned, Purpose, Record};
use super::verify::{Verifier, VerifyError};

/// One answer that counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Vote {
    /// Position in the order; unique within a session.
    pub presentation: u32,
    /// The attempt that was answered.
    pub attempt: u32,
    /// Index into [`SessionVotes::conditions`].
    pub condition: u32,
    /// Which showing of the condition, from 0.
    pub repetition: u32,
    /// `trial` or `catch`; practice never gets here.
    pub purpose: Purpose,
    /// The rating, by the study's mapping.
    pub rating: i32,
    /// Whether a catch trial was passed; none for trials.
    pub passed: Option<bool>,
    /// Time from the opening of the panel to the confirmation, nanoseconds.
    pub after_ns: u64,
}

/// A session, reduced to what the analysis needs.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionVotes {
    /// The journal.
    pub path: PathBuf,
    /// Its first line.
    pub header: Header,
    /// Real, pilot or simulated.
    pub kind: Kind,
    /// Every condition's factors.
    pub conditions: Vec<Condition>,
    /// Answers that count, in the order they were given.
    pub votes: Vec<Vote>,
    /// Trials that will stay without an answer: presentation and reason.
    pub missing: Vec<(u32, String)>,
    /// How it ended; none: it has not ended (or the program was killed).
    pub outcome: Option<Outcome>,
}

impl SessionVotes {
    /// A level of a factor of a vote's condition, such as `scene` or `method`.
    pub fn level(&self, vote: &Vote, factor: &str) -> Option<&str> {
        self.factors(vote)?.get(factor).map(String::as_str)
    }

    /// All factors of a vote's condition.
    pub fn factors(&self, vote: &Vote) -> Option<&BTreeMap<String, String>> {
        self.conditions.get(vote.condition as usize).map(|c| &c.factors)
    }
}

/// A journal cannot be turned into votes.
#[derive(Debug, thiserror::Error)]
pub enum CollectError {
    /// A line cannot be read.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// The lines contradict each other.
    #[error("{}: {source}. Restore the file from a copy", path.display())]
    Verify {
        /// The file.
        path: PathBuf,
        /// The contradiction and its line.
        #[source]
        source: VerifyError,
    },
}

/// Reads, verifies and reduces one journal. Memory grows with its answers only.
///
/// # Errors
/// [`CollectError`] with file and line; a journal is taken whole or not at all.
pub fn collect(path: &Path) -> Result<SessionVotes, CollectError> {
    let mut verifier = Verifier::default();
    let mut session: Option<Collector> = None;
    for entry in reader::read(path)? {
        let entry = entry?;
        verifier.check(&entry).map_err(|source| CollectError::Verify { path: path.to_owned(), source })?;
        match &mut session {
            Some(collector) => collector.take(entry),
            None => {
                if let Record::Header(header) = entry.record {
                    session = Some(Collector::new(path, *header, entry.kind));
                }
            }
        }
    }
    session.map(|c| c.votes).ok_or_else(|| JournalError::NoHeader { path: path.to_owned() }.into())
}

struct Collector {
    votes: SessionVotes,
    planned: Vec<Planned>,
}

impl Collector {
    fn new(path: &Path, header: Header, kind: Kind) -> Collector {
        let votes = SessionVotes {
            path: path.to_owned(),
            header,
            kind,
            conditions: Vec::new(),
            votes: Vec::new(),
            missing: Vec::new(),
            outcome: None,
        };
        Collector { votes, planned: Vec::new() }
    }

    fn take(&mut self, entry: Entry) {
        match entry.record {
            Record::Condition(condition) => self.votes.conditions.push(condition),
            Record::Planned(planned) => self.planned.push(planned),
            Record::Answer(answer) if answer.counts => self.votes.votes.extend(self.vote(&answer)),
            Record::Missing(missing) if self.is_trial(missing.presentation) => {
                self.votes.missing.push((missing.presentation, missing.reason));
            }
            Record::End(end) => self.votes.outcome = Some(end.outcome),
            _ => {}
        }
    }

    fn is_trial(&self, presentation: u32) -> bool {
        self.planned.get(presentation as usize).is_some_and(|p| p.purpose == Purpose::Trial)
    }

    fn vote(&self, answer: &Answer) -> Option<Vote> {
        let planned = self.planned.get(answer.presentation as usize)?;
        let rating = self.votes.header.question.rating(answer.choice, planned.a_is)?;
        (planned.purpose != Purpose::Practice).then(|| Vote {
            presentation: answer.presentation,
            attempt: answer.attempt,
            condition: planned.condition,
            repetition: planned.repetition,
            purpose: planned.purpose,
            rating,
            passed: (planned.purpose == Purpose::Catch).then(|| planned.passes.contains(&rating)),
            after_ns: answer.after_ns,
        })
    }
}
