//! Reads a journal back, to resume its session or to prove its order.

use std::path::Path;

use cyclopean_analysis::journal::record::{self, Outcome, Record};
use cyclopean_analysis::journal::{Entry, JournalError};

use super::{SessionError, setup};
use crate::display::DisplayInfo;
use crate::study::plan::Plan;
use crate::study::protocol::{JournalMismatch, Machine};
use crate::study::validate::Study;
use crate::study::writer::WriterError;

/// Feeds a journal to a machine and checks that both belong together.
pub(super) struct Replay<'a> {
    study: &'a Study,
    display: &'a DisplayInfo,
    journal: &'a Path,
    pub(super) plan: Option<Plan>,
    pub(super) machine: Option<Machine>,
    pub(super) stimuli: Vec<record::Stimulus>,
    pub(super) ready: bool,
    /// Whether the session keeps head poses.
    pub(super) poses: bool,
    pub(super) over: Option<Outcome>,
}

impl<'a> Replay<'a> {
    pub(super) fn new(study: &'a Study, display: &'a DisplayInfo, journal: &'a Path) -> Replay<'a> {
        Replay {
            study,
            display,
            journal,
            plan: None,
            machine: None,
            stimuli: Vec::new(),
            ready: false,
            poses: false,
            over: None,
        }
    }

    fn refuse<T>(&self, what: impl Into<String>) -> Result<T, SessionError> {
        Err(SessionError::Resume { journal: self.journal.to_owned(), what: what.into() })
    }

    pub(super) fn take(&mut self, entry: Entry) -> Result<(), SessionError> {
        match (entry.record, &mut self.plan, &mut self.machine) {
            (Record::Header(header), ..) => self.header(&header)?,
            (Record::Stimulus(stimulus), ..) => self.stimuli.push(stimulus),
            (Record::Order(order), Some(plan), _) if order != plan.order => {
                return self.refuse("its order does not follow from its study and row");
            }
            (Record::Planned(planned), Some(plan), _)
                if plan.presentations.get(planned.presentation as usize) != Some(&planned) =>
            {
                return self.refuse("its order does not follow from its study and row");
            }
            (Record::Ready(_), ..) => self.ready = true,
            (Record::End(end), ..) => self.over = Some(end.outcome),
            (record, _, Some(machine)) if self.ready => {
                if let Err(JournalMismatch(what)) = machine.replay(&record) {
                    return self.refuse(what);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn header(&mut self, header: &record::Header) -> Result<(), SessionError> {
        if header.study.sha256 != self.study.sha256 {
            return self.refuse("the study file has changed since the session began; give the file of that day");
        }
        if (header.display.nominal_hz - self.display.nominal_hz).abs() > 0.01 {
            let (was, is) = (header.display.nominal_hz, self.display.nominal_hz);
            return self.refuse(format!("the session began at {was} Hz, this display has {is} Hz"));
        }
        let plan = Plan::draw(&self.study.definition, header.row);
        self.machine = Some(Machine::new(setup(self.study, &plan, self.display)));
        self.plan = Some(plan);
        self.poses = header.poses.is_some();
        Ok(())
    }
}

/// The proof that a journal's order follows from its study and row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Proof {
    pub study: String,
    pub row: u64,
    pub presentations: usize,
    pub sha256: String,
}

/// Derives the order of a journal again from the study text and the row that it names, and compares every presentation.
///
/// # Errors
/// The journal cannot be read, or its order is another.
pub fn prove_order(journal: &Path) -> Result<Proof, SessionError> {
    let refuse = |what: String| SessionError::Resume { journal: journal.to_owned(), what };
    let read = |e: JournalError| SessionError::Writer(WriterError::Journal(e));
    let mut plan: Option<(Plan, record::Header)> = None;
    let mut seen = 0;
    for entry in cyclopean_analysis::journal::read(journal).map_err(read)? {
        match entry.map_err(read)?.record {
            Record::Header(header) => {
                let study = crate::study::validate::parse(journal, header.study.text.clone())?;
                if study.sha256 != header.study.sha256 || study.definition.seed != header.study.seed {
                    return Err(refuse("the study text in its header has another SHA-256 or seed".to_owned()));
                }
                plan = Some((Plan::draw(&study.definition, header.row), *header));
            }
            Record::Order(order) => match &plan {
                Some((plan, _)) if plan.order == order => {}
                _ => return Err(refuse("the order does not follow from study and row".to_owned())),
            },
            Record::Planned(planned) => {
                let expected = plan.as_ref().and_then(|(p, _)| p.presentations.get(seen));
                if expected != Some(&planned) {
                    return Err(refuse(format!("presentation {seen} is not what study and row give: {expected:?}")));
                }
                seen += 1;
            }
            Record::Ready(_) => break,
            _ => {}
        }
    }
    match plan {
        Some((plan, header)) if plan.presentations.len() == seen => {
            Ok(Proof { study: header.study.id, row: header.row, presentations: seen, sha256: plan.order.sha256 })
        }
        _ => Err(refuse("it ends before its order is complete".to_owned())),
    }
}
