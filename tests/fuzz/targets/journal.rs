//! The target for journals. A journal that can be read must be the same after it is written and read again, and its
//! votes must be the same in an export. Recovery must lose no byte, and a session must be able to resume or say why
//! not.

use std::path::{Path, PathBuf};

use cyclopean::study::definition::Definition;
use cyclopean::study::protocol::{Machine, Setup};
use cyclopean::study::session::prove_order;
use cyclopean::study::show::RecordedSession;
use cyclopean::study::{Plan, disk::Disk, recover::recover, sha256_hex, validate};
use cyclopean_analysis::data::tidy::FACTORS;
use cyclopean_analysis::data::{self, Columns, Selection};
use cyclopean_analysis::export::export;
use cyclopean_analysis::inspect::inspect;
use cyclopean_analysis::journal::record::{Record, Trust};
use cyclopean_analysis::journal::{self, Entry, Kind, SessionVotes, collect};
use cyclopean_analysis::report::session::{SessionTimeline, session_page};
use serde_json::Value;

/// Tries the bytes as they are, and then with corrected check sums, so that mutants get past the check sums.
pub fn run(bytes: &[u8]) {
    as_it_is(bytes);
    let mended = mend(bytes);
    if mended != bytes {
        as_it_is(&mended);
    }
}

fn as_it_is(bytes: &[u8]) {
    let path = super::file("j.jsonl", bytes);
    let entries: Vec<Entry> = match journal::read(&path).expect("a file").collect() {
        Ok(entries) => entries,
        Err(error) => {
            super::said(&error);
            assert!(inspect(&path).error.is_some(), "inspecting found no error, but reading did");
            cut(&path, bytes);
            return;
        }
    };
    let written = write(&entries);
    let again: Vec<Entry> =
        journal::read_from(&path, written.as_slice()).collect::<Result<_, _>>().expect("a written journal can be read");
    assert_eq!(again, entries, "the journal changed when it was written and read again");
    let inspection = inspect(&path);
    match collect(&path) {
        Ok(votes) => {
            assert!(inspection.error.is_none(), "{:?}", inspection.error);
            exported(&path, &votes);
        }
        Err(error) => {
            super::said(&error);
            assert!(inspection.error.is_some(), "inspecting found no error, but collecting did");
        }
    }
    let proven = prove_order(&path);
    match RecordedSession::read(&path) {
        Ok(seen) => {
            assert!(proven.is_ok(), "a session is shown whose order cannot be proven");
            for planned in &seen.planned {
                let shown = seen.of(&path, planned.presentation).expect("a presentation that is planned");
                assert!(
                    shown.iter().all(|(_, at)| (*at as usize) < seen.stimuli.len()),
                    "a stimulus that is shown does not exist"
                );
            }
        }
        Err(error) => super::said(&error),
    }
    resume(&entries);
    if let Some(timeline) = SessionTimeline::of(entries) {
        assert!(session_page(&timeline, &Default::default()).ends_with("</html>\n"));
    }
}

fn write(entries: &[Entry]) -> Vec<u8> {
    let mut out = Vec::new();
    for entry in entries {
        journal::encode(entry, &mut out).expect("an entry that was read can be written");
    }
    out
}

/// Checks that recovery cuts the damaged part off, loses no byte, and leaves a journal that can be read.
fn cut(path: &Path, bytes: &[u8]) {
    let aside = path.with_file_name("j.jsonl.aside-1");
    let _ = std::fs::remove_file(&aside);
    match recover(&Disk::real(), path) {
        Ok(recovered) => {
            let kept = std::fs::read(path).expect("the journal");
            let cut = std::fs::read(&aside).unwrap_or_default();
            assert!([kept.as_slice(), &cut].concat() == bytes, "recovery lost bytes");
            assert_eq!(recovered.cut_bytes, cut.len() as u64);
            if !kept.is_empty() {
                let entries: Result<Vec<Entry>, _> = journal::read(path).expect("a file").collect();
                assert_eq!(entries.expect("the recovered journal can be read").len() as u64, recovered.whole_lines);
            }
        }
        Err(error) => super::said(&error),
    }
}

/// Checks that the exported table has the same answers as the journal. Answers are compared only if all names are like
/// those that the program writes.
fn exported(path: &Path, votes: &SessionVotes) {
    let folder = super::path("exported");
    match export(&[path.to_owned()], &Selection::default(), &folder) {
        Ok(written) => {
            assert_eq!(written.rows as usize, votes.votes.len(), "the table does not have one row for each answer");
            let selection = Selection {
                columns: Columns { by_repetition: true, ..Columns::default() },
                allow_kinds: [Kind::Real, Kind::Pilot, Kind::Simulated].into(),
                ..Selection::default()
            };
            let load = |path: PathBuf| data::load(&[path], &selection).map(|loaded| loaded.data.responses());
            let plain = |text: &str| !text.is_empty() && text.trim() == text;
            let usual = |(name, level): (&String, &String)| FACTORS.contains(&name.as_str()) && plain(level);
            let of_program = plain(&votes.header.participant)
                && plain(&votes.header.study.id)
                && votes.conditions.iter().flat_map(|c| &c.factors).all(usual);
            if !of_program {
                return;
            }
            match (load(path.to_owned()), load(folder.join("responses.csv"))) {
                (Ok(of_journal), Ok(of_table)) => assert_eq!(of_journal, of_table, "the answers differ"),
                // Both may refuse the answers, for example because a presentation was answered twice.
                (Err(_), Err(_)) => {}
                (of_journal, of_table) => panic!("only one can be read: {of_journal:?}, {of_table:?}"),
            }
        }
        Err(error) => super::said(&error),
    }
}

/// Replays the journal in the state machine and resumes the session, unless the journal does not fit its study.
fn resume(entries: &[Entry]) {
    let Some(Record::Header(header)) = entries.first().map(|e| &e.record) else { return };
    let Ok(study) = validate::parse("study.json".as_ref(), header.study.text.clone()) else { return };
    let definition: &Definition = &study.definition;
    let rate_hz = header.display.nominal_hz;
    if !(1.0..=1000.0).contains(&rate_hz) {
        return;
    }
    let plan = Plan::draw(definition, header.row);
    let mut machine = Machine::new(Setup::new(definition, &plan, rate_hz, Trust::Virtual, 60.0));
    let after = entries.iter().skip_while(|e| !matches!(e.record, Record::Ready(_))).skip(1);
    for entry in after {
        if let Err(misfit) = machine.replay(&entry.record) {
            return super::said(&misfit);
        }
    }
    machine.resume(entries.last().map_or(0, |e| e.t_ns));
}

/// Renumbers the lines and corrects their check sums and the SHA-256 of the study's text.
fn mend(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for (seq, line) in (0u64..).zip(bytes.split(|b| *b == b'\n').filter(|line| !line.is_empty())) {
        let body = line.strip_suffix(b"\"}").and_then(|l| l.get(..l.len().checked_sub(16)?)).unwrap_or(line);
        let text = String::from_utf8_lossy(body);
        let body = match serde_json::from_str::<Value>(&format!("{text}}}")) {
            Ok(mut value) => {
                value["seq"] = seq.into();
                let study = value.pointer_mut("/record/header/study");
                if let Some(study) = study.filter(|s| s.is_object()) {
                    let of = study["text"].as_str().map(|text| sha256_hex(text.as_bytes()));
                    study["sha256"] = of.into();
                }
                let text = value.to_string();
                text.strip_suffix('}').unwrap_or(&text).to_owned()
            }
            Err(_) => text.into_owned(),
        };
        out.extend_from_slice(body.as_bytes());
        out.extend_from_slice(format!(",\"crc\":\"{:08x}\"}}\n", crc32fast::hash(body.as_bytes())).as_bytes());
    }
    out
}
