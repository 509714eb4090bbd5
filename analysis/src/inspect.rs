//! Checks a journal without analysing its answers: form, order, gaps and timing. `mos check` and reports show the
//! result.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::data::sessions_in_parallel;
use crate::journal::record::{Display, Outcome, Purpose, Record, Trust};
use crate::journal::{Kind, Verifier, read};

/// Timing of one session's presentations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Timing {
    /// Attempts shown.
    pub shown: u64,
    /// Attempts that do not count.
    pub invalid: u64,
    /// Why attempts do not count, with the number of attempts for each reason.
    pub reasons: BTreeMap<String, u64>,
    /// Frames shown.
    pub frames: u64,
    /// Frames that the study asked for.
    pub frames_asked: u64,
    /// Missed frames, Σ round(Δ/period) − 1.
    pub missed: u64,
    /// Frames that the runtime asked the program not to draw.
    pub unrendered: u64,
    /// Longest gap between two frames, milliseconds.
    pub longest_gap_ms: f64,
    /// Longest loss of focus, visibility or drawing in one presentation, milliseconds.
    pub longest_lost_ms: f64,
    /// How far the times can be trusted: the lowest trust of any presentation.
    pub trust: Option<Trust>,
}

/// The result of checking one journal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    /// The journal.
    pub path: PathBuf,
    /// The error that stopped the reading; `None`: the journal is whole.
    pub error: Option<String>,
    /// Lines that are whole and whose check sums are right.
    pub lines: u64,
    /// Bytes of these lines.
    pub bytes: u64,
    /// Study id.
    pub study: String,
    /// Pseudonym.
    pub participant: String,
    /// Session id.
    pub session: String,
    /// Real, pilot or simulated.
    pub kind: Option<Kind>,
    /// How it ended; `None`: it has not.
    pub outcome: Option<Outcome>,
    /// Trials planned.
    pub planned: u64,
    /// Trials with an answer that counts.
    pub answered: u64,
    /// Trials that will stay without such an answer.
    pub missing: u64,
    /// For each time the file was opened again, the gap in wall time, milliseconds.
    pub resumes_ms: Vec<i64>,
    /// Bytes of torn lines that were set aside on resuming.
    pub cut_bytes: u64,
    /// Answers slower than two minutes, which pause the session.
    pub pauses: u64,
    /// Median time from the panel's opening to the confirmation, milliseconds.
    pub median_answer_ms: Option<f64>,
    /// The display, as the header describes it.
    #[serde(skip)]
    pub display: Option<Display>,
    /// Timing of the presentations.
    pub timing: Timing,
}

/// Inspects journals on all cores, in the order of `files`.
pub fn inspect_all(files: &[PathBuf], mut take: impl FnMut(Inspection)) {
    sessions_in_parallel(files, inspect, |i| {
        take(i);
        Ok::<(), std::convert::Infallible>(())
    })
    .unwrap_or_else(|never| match never {});
}

/// Reads one journal to its end or its first fault.
pub fn inspect(path: &Path) -> Inspection {
    let mut out = Inspection {
        path: path.to_owned(),
        error: None,
        lines: 0,
        bytes: 0,
        study: String::new(),
        participant: String::new(),
        session: String::new(),
        kind: None,
        outcome: None,
        planned: 0,
        answered: 0,
        missing: 0,
        resumes_ms: Vec::new(),
        cut_bytes: 0,
        pauses: 0,
        median_answer_ms: None,
        display: None,
        timing: Timing {
            shown: 0,
            invalid: 0,
            reasons: BTreeMap::new(),
            frames: 0,
            frames_asked: 0,
            missed: 0,
            unrendered: 0,
            longest_gap_ms: 0.0,
            longest_lost_ms: 0.0,
            trust: None,
        },
    };
    let mut reader = match read(path) {
        Ok(reader) => reader,
        Err(e) => {
            out.error = Some(e.to_string());
            return out;
        }
    };
    let mut verifier = Verifier::default();
    let mut trials: Vec<bool> = Vec::new();
    let mut answers_ms: Vec<f64> = Vec::new();
    for entry in reader.by_ref() {
        let entry = match entry {
            Ok(entry) => entry,
            Err(e) => {
                out.error = Some(e.to_string());
                break;
            }
        };
        if let Err(e) = verifier.check(&entry) {
            out.error = Some(format!("{}: {e}; restore the file from a copy", path.display()));
            break;
        }
        out.kind = Some(entry.kind);
        match entry.record {
            Record::Header(h) => {
                (out.study, out.participant, out.session) = (h.study.id, h.participant, h.session);
                out.display = Some(h.display);
            }
            Record::Planned(p) => {
                trials.push(p.purpose == Purpose::Trial);
                out.planned += u64::from(p.purpose == Purpose::Trial);
            }
            Record::Presentation(p) => {
                let t = &mut out.timing;
                t.shown += 1;
                t.invalid += u64::from(!p.invalid.is_empty());
                p.invalid.iter().for_each(|r| *t.reasons.entry(r.clone()).or_default() += 1);
                t.frames += p.segments.iter().map(|s| s.frames_shown).sum::<u64>();
                t.frames_asked += p.segments.iter().map(|s| s.frames_asked).sum::<u64>();
                t.missed += p.missed;
                t.unrendered += p.unrendered;
                t.longest_gap_ms = t.longest_gap_ms.max(p.longest_gap_ms);
                t.longest_lost_ms = t.longest_lost_ms.max(p.lost_ms);
                t.trust = Some(t.trust.map_or(p.trust, |before| least(before, p.trust)));
            }
            Record::Answer(a) if a.counts => {
                let trial = trials.get(a.presentation as usize).copied().unwrap_or(false);
                out.answered += u64::from(trial);
                answers_ms.push(a.after_ns as f64 / 1e6);
            }
            Record::Missing(_) => out.missing += 1,
            Record::Resume(r) => {
                out.resumes_ms.push(r.gap_ms);
                out.cut_bytes += r.cut_bytes;
            }
            Record::Pause(_) => out.pauses += 1,
            Record::End(e) => out.outcome = Some(e.outcome),
            _ => {}
        }
    }
    out.bytes = reader.good_bytes();
    out.lines = reader.line() - u64::from(out.error.is_some() && reader.line() > 0);
    answers_ms.sort_unstable_by(f64::total_cmp);
    out.median_answer_ms = (!answers_ms.is_empty())
        .then(|| 0.5 * (answers_ms[(answers_ms.len() - 1) / 2] + answers_ms[answers_ms.len() / 2]));
    out
}

/// The lower of two levels of trust.
fn least(a: Trust, b: Trust) -> Trust {
    let rank = |t: Trust| match t {
        Trust::Virtual => 0,
        Trust::Predicted => 1,
        Trust::Reported => 2,
        Trust::Measured => 3,
    };
    if rank(a) <= rank(b) { a } else { b }
}

/// The word for a level of trust in a journal.
pub fn trust_name(trust: Trust) -> &'static str {
    match trust {
        Trust::Virtual => "virtual",
        Trust::Predicted => "predicted",
        Trust::Reported => "reported",
        Trust::Measured => "measured",
    }
}
