//! A whole small session, and the faults that its file can have.

use std::collections::BTreeMap;
use std::path::Path;

use chrono::DateTime;

use super::record::*;
use super::votes::CollectError;
use super::*;

/// A comparison with two presentations in all; in the second one `method` is B.
pub(crate) fn records() -> Vec<Record> {
    let analysis = serde_json::from_str(r#"{"contrasts":[]}"#).unwrap();
    let header = Header {
        format: FORMAT,
        study: Study { id: "s".into(), title: "S".into(), sha256: "00".into(), text: "{}".into(), seed: 1 },
        participant: "p01".into(),
        session: "001".into(),
        row: 0,
        question: Question::Compare { values: PreferenceValues { other: 1, same: 2, method: 3 } },
        analysis,
        program: Program { name: "cyclopean".into(), version: "0".into(), commit: "unknown".into() },
        display: Display {
            kind: "headless".into(),
            system: "none".into(),
            runtime: "virtual".into(),
            trust: Trust::Virtual,
            nominal_hz: 90.0,
            measured_hz: None,
            interval_sd_ms: None,
            width_px: 1,
            height_px: 1,
            fov_deg: None,
            ipd_m: None,
            rendered_ipd_m: 0.063,
        },
        device: None,
        os: "test".into(),
        consent: None,
        frozen_sha256: None,
        poses: None,
    };
    let stimulus = |id| {
        let (key, scene, view) = (format!("{id}"), "pica".to_owned(), "default".to_owned());
        let (files, method) = (BTreeMap::new(), "sssr".to_owned());
        let (scene_sha256, shaders_sha256, renderer, film) = (None, None, None, None);
        Record::Stimulus(Stimulus { id, key, scene, view, method, files, scene_sha256, shaders_sha256, renderer, film })
    };
    let factors = [("scene", "pica"), ("method", "stereo"), ("other", "sssr")];
    let factors = factors.into_iter().map(|(k, v)| (k.to_owned(), v.to_owned())).collect();
    let planned = |presentation, a_is| {
        let stimuli = if a_is == Side::Method { vec![0, 1] } else { vec![1, 0] };
        let (purpose, condition, block, passes) = (Purpose::Trial, 0, 1, Vec::new());
        let (repetition, a_is) = (presentation, Some(a_is));
        Record::Planned(Planned { presentation, purpose, condition, repetition, block, a_is, stimuli, passes })
    };
    let ordering = "fixed".to_owned();
    let order = Order { ordering, procedure: "p".into(), rows: 1, row: 0, presentations: 2, sha256: String::new() };
    let mut out = vec![
        Record::Header(Box::new(header)),
        stimulus(0),
        stimulus(1),
        Record::Condition(Condition { id: 0, factors }),
        Record::Order(order),
        planned(0, Side::Method),
        planned(1, Side::Other),
        Record::Ready(Ready { lines: 7 }),
    ];
    for (presentation, choice) in [(0, 0), (1, 0)] {
        out.extend([
            Record::Begin(Begin { presentation, attempt: 0 }),
            shown(presentation, 0, true),
            Record::Change(Change { presentation, attempt: 0, choice, after_ns: 5 }),
            answer(presentation, 0, choice, true),
        ]);
    }
    out.push(Record::End(End { outcome: Outcome::Completed, answered: 2, missing: 0 }));
    out
}

fn shown(presentation: u32, attempt: u32, valid: bool) -> Record {
    let invalid = if valid { Vec::new() } else { vec!["lost".to_owned()] };
    Record::Presentation(Presentation {
        presentation,
        attempt,
        segments: vec![Segment {
            show: Shown::A,
            frames_asked: 9,
            frames_shown: 9,
            first_ns: 1,
            last_ns: 2,
            film_onsets_ns: Vec::new(),
        }],
        missed: 0,
        unrendered: 0,
        lost_ms: 0.0,
        longest_gap_ms: 11.111,
        duration_ms: 100.0,
        trust: Trust::Virtual,
        invalid,
    })
}

fn answer(presentation: u32, attempt: u32, choice: u32, counts: bool) -> Record {
    Record::Answer(Answer { presentation, attempt, choice, after_ns: 7, changes: 1, counts })
}

pub(crate) fn entries(records: Vec<Record>) -> Vec<Entry> {
    let wall = DateTime::from_timestamp_millis(1_700_000_000_000).unwrap();
    let entry = |(seq, record)| Entry { seq, t_ns: seq * 10, wall, kind: Kind::Pilot, record };
    (0..).zip(records).map(entry).collect()
}

fn text(entries: &[Entry]) -> Vec<u8> {
    let mut out = Vec::new();
    entries.iter().for_each(|e| encode(e, &mut out).unwrap());
    out
}

fn read_text(bytes: &[u8]) -> Result<Vec<Entry>, JournalError> {
    read_from(Path::new("x.jsonl"), bytes).collect()
}

fn verify(records: Vec<Record>) -> Result<(), VerifyError> {
    let mut verifier = Verifier::default();
    entries(records).iter().try_for_each(|e| verifier.check(e))
}

#[test]
fn a_session_comes_back_and_its_choices_become_ratings() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("001.jsonl");
    std::fs::write(&path, text(&entries(records()))).unwrap();
    assert_eq!(read(&path).unwrap().map(Result::unwrap).collect::<Vec<_>>(), entries(records()));
    let votes = collect(&path).unwrap();
    // A was chosen twice: the first time A was the method, the second time the other.
    assert_eq!(votes.votes.iter().map(|v| v.rating).collect::<Vec<_>>(), [3, 1]);
    assert_eq!((votes.kind, votes.outcome), (Kind::Pilot, Some(Outcome::Completed)));
    assert_eq!(votes.level(&votes.votes[0], "other"), Some("sssr"));
}

#[test]
fn every_choice_has_its_rating_and_no_other_has_one() {
    let Record::Header(header) = records().remove(0) else { panic!("no header") };
    let rating = |choice, a_is| header.question.rating(choice, Some(a_is));
    assert_eq!([0, 1, 2, 3].map(|c| rating(c, Side::Method)), [Some(3), Some(2), Some(1), None]);
    assert_eq!([0, 1, 2, 3].map(|c| rating(c, Side::Other)), [Some(1), Some(2), Some(3), None]);
    assert_eq!(header.question.rating(0, None), None);
}

#[test]
fn what_is_wrong_with_a_file_is_named_with_its_line() {
    let good = entries(records());
    let bytes = text(&good);
    assert!(matches!(read_text(b""), Err(JournalError::NoHeader { .. })));
    assert!(matches!(read_text(b"hello\n"), Err(JournalError::Line { line: 1, .. })));
    assert!(matches!(read_text(&text(&good[1..])), Err(JournalError::Sequence { line: 1, expected: 0, found: 1, .. })));
    assert!(matches!(read_text(&bytes[..bytes.len() - 1]), Err(JournalError::Torn { line: 17, .. })));
    let without = [&good[..9], &good[10..]].concat();
    assert!(matches!(read_text(&text(&without)), Err(JournalError::Sequence { line: 10, .. })));
    let doubled = [&good[..9], &good[8..]].concat();
    assert!(matches!(read_text(&text(&doubled)), Err(JournalError::Sequence { line: 10, .. })));
    let mut mixed = good.clone();
    mixed[12].kind = Kind::Real;
    assert!(matches!(read_text(&text(&mixed)), Err(JournalError::Kind { line: 13, .. })));
    let mut newer = good.clone();
    if let Record::Header(header) = &mut newer[0].record {
        header.format = FORMAT + 1;
    }
    assert!(matches!(read_text(&text(&newer)), Err(JournalError::Version { found, .. }) if found == FORMAT + 1));
    let headless = [Entry { record: good[8].record.clone(), ..good[0].clone() }];
    assert!(matches!(read_text(&text(&headless)), Err(JournalError::NoHeader { .. })));
    // After an error nothing more comes.
    assert_eq!(read_from(Path::new("x"), &text(&without)[..]).count(), 10);
}

#[test]
fn fields_of_a_later_program_are_ignored_and_unknown_records_refused() {
    let line = |record: &str| {
        let body = format!(
            r#"{{"seq":0,"t_ns":0,"wall":"2026-01-31T10:15:02.417Z","kind":"real","later":1,"record":{record}"#
        );
        format!(r#"{body},"crc":"{:08x}"}}"#, crc32fast::hash(body.as_bytes()))
    };
    let known = codec::decode(line(r#"{"begin":{"presentation":1,"attempt":0,"more":[1,2]}}"#).as_bytes());
    assert_eq!(known.unwrap().record, Record::Begin(Begin { presentation: 1, attempt: 0 }));
    let unknown = codec::decode(line(r#"{"dance":{}}"#).as_bytes()).unwrap_err();
    assert!(matches!(unknown, LineError::Syntax { .. }) && unknown.to_string().contains("dance"));
    let time = line(r#"{"begin":{"presentation":1,"attempt":0}}"#).replace("01-31", "02-31");
    assert!(codec::decode(time.as_bytes()).is_err());
}

#[test]
fn lines_that_contradict_each_other_are_found() {
    assert_eq!(verify(records()), Ok(()));
    type Change = Box<dyn Fn(&mut Vec<Record>)>;
    let cases: Vec<(&str, Change)> = vec![
        (
            "is missing, though it is answered already",
            Box::new(|r| r.insert(12, Record::Missing(Missing { presentation: 0, reason: "skipped".into() }))),
        ),
        ("cannot become", Box::new(|r| drop(r.remove(9)))),
        ("it is None", Box::new(|r| drop(r.remove(8)))),
        ("begins twice", Box::new(|r| r.insert(9, r[8].clone()))),
        (
            "is shown again, though it is answered",
            Box::new(|r| r[12] = Record::Begin(Begin { presentation: 0, attempt: 1 })),
        ),
        ("without the one before", Box::new(|r| r[8] = Record::Begin(Begin { presentation: 0, attempt: 1 }))),
        ("is not planned", Box::new(|r| r[8] = Record::Begin(Begin { presentation: 2, attempt: 0 }))),
        ("choice 3, but there are 3", Box::new(|r| r[11] = answer(0, 0, 3, true))),
        ("cannot become Answered", Box::new(|r| r[9] = shown(0, 0, false))),
        ("after the end", Box::new(|r| r.push(r[10].clone()))),
        ("a second header", Box::new(|r| r.insert(1, r[0].clone()))),
        ("before the `ready` record", Box::new(|r| drop(r.remove(7)))),
        ("after the `ready` record", Box::new(|r| r.insert(8, r[3].clone()))),
        ("another number", Box::new(|r| drop(r.remove(6)))),
        ("condition 0 does not exist", Box::new(|r| drop(r.remove(3)))),
        ("a stimulus that does not exist", Box::new(|r| drop(r.remove(2)))),
        ("out of order", Box::new(|r| r.swap(1, 2))),
    ];
    for (words, change) in cases {
        let mut changed = records();
        change(&mut changed);
        let error = verify(changed).expect_err(words).to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
    let mut back = entries(records());
    back[5].t_ns = 1;
    let mut verifier = Verifier::default();
    let error = back.iter().try_for_each(|e| verifier.check(e)).unwrap_err();
    assert_eq!((error.line, error.what.contains("time goes back")), (6, true));
    // A resumed session goes on one nanosecond later.
    let mut late = entries(records());
    late.iter_mut().skip(5).for_each(|e| e.t_ns = u64::MAX);
    let mut verifier = Verifier::default();
    let error = late.iter().try_for_each(|e| verifier.check(e)).unwrap_err();
    assert_eq!((error.line, error.what.contains("292 years")), (6, true));
}

#[test]
fn a_journal_is_taken_whole_or_not_at_all() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("001.jsonl");
    let mut contradiction = records();
    contradiction.remove(9);
    std::fs::write(&path, text(&entries(contradiction))).unwrap();
    let error = collect(&path).unwrap_err();
    assert!(matches!(error, CollectError::Verify { .. }));
    assert!(error.to_string().contains("001.jsonl: line 11"), "{error}");
    assert!(collect(&dir.path().join("none.jsonl")).unwrap_err().to_string().contains("cannot read journal"));
}
