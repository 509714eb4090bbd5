//! Journals: what is read is written again and reads the same, and what votes it holds survive an export.

use std::path::{Path, PathBuf};

use cyclopean::study::definition::Definition;
use cyclopean::study::protocol::{Machine, Setup};
use cyclopean::study::session::prove_order;
use cyclopean::study::show::Seen;
use cyclopean::study::{Plan, disk::Disk, recover::recover, sha256_hex, validate};
use cyclopean_analysis::data::tidy::FACTORS;
use cyclopean_analysis::data::{self, Columns, Selection};
use cyclopean_analysis::export::export;
use cyclopean_analysis::inspect::inspect;
use cyclopean_analysis::journal::record::{Record, Trust};
use cyclopean_analysis::journal::{self, Entry, Kind, SessionVotes, collect};
use cyclopean_analysis::report::session::{Told, session_page};
use serde_json::Value;

/// The bytes as they are, and then as somebody would have them who knows how to make a check sum.
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
            assert!(inspect(&path).error.is_some(), "an inspection says what reading says");
            cut(&path, bytes);
            return;
        }
    };
    let written = write(&entries);
    let again: Vec<Entry> =
        journal::read_from(&path, written.as_slice()).collect::<Result<_, _>>().expect("what was written is read");
    assert_eq!(again, entries, "written and read again");
    let inspection = inspect(&path);
    match collect(&path) {
        Ok(votes) => {
            assert!(inspection.error.is_none(), "{:?}", inspection.error);
            exported(&path, &votes);
        }
        Err(error) => {
            super::said(&error);
            assert!(inspection.error.is_some(), "an inspection says what collecting says");
        }
    }
    let proven = prove_order(&path);
    match Seen::read(&path) {
        Ok(seen) => {
            assert!(proven.is_ok(), "what is shown has a proven order");
            for planned in &seen.planned {
                let shown = seen.of(&path, planned.presentation).expect("a presentation that is planned");
                assert!(shown.iter().all(|(_, at)| (*at as usize) < seen.stimuli.len()), "stimuli that are there");
            }
        }
        Err(error) => super::said(&error),
    }
    resume(&entries);
    if let Some(told) = Told::of(entries) {
        assert!(session_page(&told, &Default::default()).ends_with("</html>\n"));
    }
}

fn write(entries: &[Entry]) -> Vec<u8> {
    let mut out = Vec::new();
    for entry in entries {
        journal::encode(entry, &mut out).expect("what JSON gave JSON takes");
    }
    out
}

/// What is damaged is cut off, nothing is lost, and what is left is whole.
fn cut(path: &Path, bytes: &[u8]) {
    let aside = path.with_file_name("j.jsonl.aside-1");
    let _ = std::fs::remove_file(&aside);
    match recover(&Disk::real(), path) {
        Ok(recovered) => {
            let kept = std::fs::read(path).expect("the journal");
            let cut = std::fs::read(&aside).unwrap_or_default();
            assert!([kept.as_slice(), &cut].concat() == bytes, "every byte is here or there");
            assert_eq!(recovered.cut_bytes, cut.len() as u64);
            if !kept.is_empty() {
                let entries: Result<Vec<Entry>, _> = journal::read(path).expect("a file").collect();
                assert_eq!(entries.expect("what is kept is whole").len() as u64, recovered.whole_lines);
            }
        }
        Err(error) => super::said(&error),
    }
}

/// The table that is made of a journal says what the journal says, where the names are such as the program writes.
fn exported(path: &Path, votes: &SessionVotes) {
    let folder = super::path("exported");
    match export(&[path.to_owned()], &Selection::default(), &folder) {
        Ok(written) => {
            assert_eq!(written.rows as usize, votes.votes.len(), "a row an answer");
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
                (Ok(of_journal), Ok(of_table)) => assert_eq!(of_journal, of_table, "every answer is read"),
                // Such as a showing that was answered twice.
                (Err(_), Err(_)) => {}
                (of_journal, of_table) => panic!("one is read, the other not: {of_journal:?}, {of_table:?}"),
            }
        }
        Err(error) => super::said(&error),
    }
}

/// The session goes on from there, as far as it belongs to its study.
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

/// Numbers the lines, and gives each its check sum; a study's text gets its own.
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
