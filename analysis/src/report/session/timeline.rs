//! Turns a journal into spans (what was shown for a while) and marks (what happened at a moment).

use serde::Serialize;

use crate::journal::record::{Header, Planned, Presentation, Record, Shown, Side, Stimulus};
use crate::journal::{Entry, Kind};

/// Something that was shown, or went on, for a while.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Span {
    /// Seconds on the session's clock.
    pub from_s: f64,
    /// Seconds on the session's clock.
    pub to_s: f64,
    /// The kind of the span.
    pub lane: Lane,
    /// In words, such as `trial 7: room by stereo (A)`.
    pub label: String,
    /// Index of the stimulus that was shown.
    pub stimulus: Option<u32>,
    /// Index of the reference that was shown beside it.
    pub reference: Option<u32>,
}

/// The kind of a span.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Lane {
    /// A page, a questionnaire, the screening, practice or trials as a whole.
    Phase,
    /// A segment that shows a stimulus.
    Stimulus,
    /// The panel, from its opening to the confirmed answer.
    Panel,
    /// The session was paused.
    Pause,
}

/// Something that happened at a moment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mark {
    /// Seconds on the session's clock.
    pub at_s: f64,
    /// `answer`, `invalid`, `missed`, `missing`, `interrupted`, `note`, `skip`, `resume` or `end`.
    pub what: &'static str,
    /// In words.
    pub label: String,
}

/// A whole session.
#[derive(Clone, Debug)]
pub struct SessionTimeline {
    /// The study, the program, the display and the device.
    pub header: Box<Header>,
    /// Whose answers these are.
    pub kind: Kind,
    /// The stimuli, in the order of their indices.
    pub stimuli: Vec<Stimulus>,
    /// The spans, sorted by their beginning.
    pub spans: Vec<Span>,
    /// The marks, sorted by their time.
    pub marks: Vec<Mark>,
    /// Seconds on the session's clock.
    pub end_s: f64,
}

/// The name of a presentation: its purpose and number, such as `trial 7`.
fn name(planned: &[Planned], presentation: u32) -> String {
    match planned.iter().find(|p| p.presentation == presentation) {
        Some(p) => format!("{} {presentation}", format!("{:?}", p.purpose).to_lowercase()),
        None => format!("presentation {presentation}"),
    }
}

impl SessionTimeline {
    /// Reads the entries of a journal, in their order. None where they do not begin with a header.
    pub fn of(entries: impl IntoIterator<Item = Entry>) -> Option<SessionTimeline> {
        let mut entries = entries.into_iter();
        let first = entries.next()?;
        let Record::Header(header) = first.record else { return None };
        let mut timeline = SessionTimeline {
            header,
            kind: first.kind,
            stimuli: Vec::new(),
            spans: Vec::new(),
            marks: Vec::new(),
            end_s: 0.0,
        };
        let mut planned = Vec::new();
        let mut open: Vec<(Lane, f64, String)> = Vec::new();
        for entry in entries {
            let at_s = entry.t_ns as f64 / 1e9;
            timeline.end_s = timeline.end_s.max(at_s);
            let said = match entry.record {
                Record::Stimulus(s) => {
                    timeline.stimuli.push(s);
                    None
                }
                Record::Planned(p) => {
                    planned.push(p);
                    None
                }
                Record::Phase(p) => {
                    timeline.begin(&mut open, Lane::Phase, at_s, p.phase);
                    None
                }
                Record::Pause(p) => {
                    timeline.begin(&mut open, Lane::Pause, at_s, format!("pause: {}", p.reason));
                    None
                }
                Record::Continue(_) => {
                    timeline.finish(&mut open, Lane::Pause, at_s);
                    None
                }
                Record::Presentation(p) => {
                    timeline.show(&planned, &p);
                    None
                }
                Record::Answer(a) => {
                    let from_s = at_s - a.after_ns as f64 / 1e9;
                    let label = name(&planned, a.presentation);
                    let counts = if a.counts { "" } else { ", does not count" };
                    let (stimulus, reference) = (None, None);
                    let panel = format!("{label}: the panel");
                    timeline.spans.push(Span {
                        from_s,
                        to_s: at_s,
                        lane: Lane::Panel,
                        label: panel,
                        stimulus,
                        reference,
                    });
                    let choice = timeline.choice(&planned, a.presentation, a.choice);
                    Some(("answer", format!("{label}: {choice}{counts}")))
                }
                Record::Interrupted(i) => {
                    Some(("interrupted", format!("{}: {}", name(&planned, i.presentation), i.reason)))
                }
                Record::Missing(m) => Some(("missing", format!("{}: {}", name(&planned, m.presentation), m.reason))),
                Record::Skip(s) => Some(("skip", s.phase)),
                Record::Note(n) => Some(("note", n.text)),
                Record::Resume(r) => Some(("resume", format!("after {:.1} s", r.gap_ms as f64 / 1e3))),
                Record::End(e) => Some((
                    "end",
                    format!("{:?}, {} answered, {} missing", e.outcome, e.answered, e.missing).to_lowercase(),
                )),
                _ => None,
            };
            timeline.marks.extend(said.map(|(what, label)| Mark { at_s, what, label }));
        }
        let end_s = timeline.end_s;
        for lane in [Lane::Phase, Lane::Pause] {
            timeline.finish(&mut open, lane, end_s);
        }
        timeline.spans.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
        timeline.marks.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        Some(timeline)
    }

    fn begin(&mut self, open: &mut Vec<(Lane, f64, String)>, lane: Lane, at_s: f64, label: String) {
        self.finish(open, lane, at_s);
        open.push((lane, at_s, label));
    }

    fn finish(&mut self, open: &mut Vec<(Lane, f64, String)>, lane: Lane, to_s: f64) {
        if let Some(at) = open.iter().position(|(of, ..)| *of == lane) {
            let (lane, from_s, label) = open.remove(at);
            self.spans.push(Span { from_s, to_s, lane, label, stimulus: None, reference: None });
        }
    }

    /// Adds the segments of a presentation, and marks for what was wrong with it.
    fn show(&mut self, planned: &[Planned], p: &Presentation) {
        let of = planned.iter().find(|q| q.presentation == p.presentation);
        let name = name(planned, p.presentation);
        // The reference of a mirrored pair stands before A and B.
        let has_reference = of.is_some_and(|q| q.stimuli.len() == 3);
        for segment in &p.segments {
            let at = match segment.show {
                Shown::Blank => continue,
                Shown::Stimulus | Shown::A => 0,
                Shown::B => 1,
            };
            let stimulus = of.and_then(|q| q.stimuli.get(at + usize::from(has_reference)).copied());
            let reference = of.filter(|_| has_reference).and_then(|q| q.stimuli.first().copied());
            let what = stimulus.and_then(|s| self.stimuli.get(s as usize));
            let what = what.map_or_else(|| "?".to_owned(), |s| format!("{} by {}", s.scene, s.method));
            let letter = match segment.show {
                Shown::A => " (A)",
                Shown::B => " (B)",
                _ => "",
            };
            let (from_s, to_s) = (segment.first_ns as f64 / 1e9, segment.last_ns as f64 / 1e9);
            let label = format!("{name}: {what}{letter}");
            self.spans.push(Span { from_s, to_s, lane: Lane::Stimulus, label, stimulus, reference });
        }
        let at_s = p.segments.last().map_or(0.0, |s| s.last_ns as f64 / 1e9);
        if p.missed > 0 {
            let label = format!("{name}: {} frames, the longest gap {:.1} ms", p.missed, p.longest_gap_ms);
            self.marks.push(Mark { at_s, what: "missed", label });
        }
        if !p.invalid.is_empty() {
            self.marks.push(Mark { at_s, what: "invalid", label: format!("{name}: {}", p.invalid.join("; ")) });
        }
    }

    /// A choice in words: the step of the scale, or the method that was preferred.
    fn choice(&self, planned: &[Planned], presentation: u32, choice: u32) -> String {
        let a_is = planned.iter().find(|p| p.presentation == presentation).and_then(|p| p.a_is);
        let side = match (choice, a_is) {
            (0, Some(side)) => Some(side),
            (2, Some(side)) => Some(side.opposite()),
            _ => None,
        };
        let words = match (&self.header.question, side) {
            (crate::journal::record::Question::Rate { options }, _) => {
                options.get(choice as usize).map_or_else(|| "?".to_owned(), |o| o.label.clone())
            }
            (_, None) => "no difference".to_owned(),
            (_, Some(Side::Method)) => "the method".to_owned(),
            (_, Some(Side::Other)) => "the other".to_owned(),
        };
        match self.header.question.rating(choice, a_is) {
            Some(rating) => format!("{words} ({rating})"),
            None => words,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::journal::tests::{entries, records};

    #[test]
    fn a_session_is_told_in_order() {
        let timeline = SessionTimeline::of(entries(records())).expect("a header");
        assert_eq!(timeline.stimuli.len(), 2);
        let stimuli: Vec<_> = timeline.spans.iter().filter(|s| s.lane == Lane::Stimulus).collect();
        // Presentation 0 shows the method as A, presentation 1 the other.
        assert_eq!(stimuli.iter().map(|s| s.stimulus).collect::<Vec<_>>(), [Some(0), Some(1)]);
        assert_eq!(stimuli[0].label, "trial 0: pica by sssr (A)");
        let answers: Vec<_> = timeline.marks.iter().filter(|m| m.what == "answer").map(|m| m.label.as_str()).collect();
        assert_eq!(answers, ["trial 0: the method (3)", "trial 1: the other (1)"]);
        assert!(timeline.marks.iter().any(|m| m.what == "end" && m.label.starts_with("completed")));
        assert!(SessionTimeline::of(Vec::new()).is_none());
    }
}
