//! Tests that a session survives crashes: it is stopped at every step on the disk, by a simulated loss of power, by a
//! full disk, and by kills at random moments. The oracle is the same session without a disturbance. Needs no GPU.
//!
//! More kills: `CYCLOPEAN_KILLS=1000 cargo test --no-default-features --test all crashes::killed`.

use std::path::Path;
use std::time::Duration;

use cyclopean::study::disk::Disk;
use cyclopean::study::random::Stream;
use cyclopean::study::session::{Options, SessionError, simulate};
use cyclopean::study::sessions::{Sessions, SessionsError};
use cyclopean::study::writer::{Durability, WriterError};
use cyclopean::study::{recover, validate};
use cyclopean_analysis::journal::record::{Kind, Outcome, Record};
use cyclopean_analysis::journal::{self, JournalError, Verifier, collect};

use crate::lab::{Lab, rate, stderr};

fn options(disk: Disk) -> Options {
    Options { disk, ..Options::new(Kind::Simulated) }
}

/// The presentation and the choice of every answer that counts.
fn answers(path: &Path) -> Vec<(u32, u32)> {
    let mut verifier = Verifier::default();
    let mut out = Vec::new();
    for entry in journal::read(path).unwrap() {
        let entry = entry.unwrap();
        verifier.check(&entry).unwrap();
        if let Record::Answer(a) = entry.record
            && a.counts
        {
            out.push((a.presentation, a.choice));
        }
    }
    out.sort_unstable();
    out
}

/// The answers in the first `bytes` bytes of a journal, which may be damaged after them.
fn accepted(path: &Path, bytes: u64) -> Vec<(u32, u32)> {
    let Ok(all) = std::fs::read(path) else { return Vec::new() };
    let prefix = &all[..usize::try_from(bytes).unwrap().min(all.len())];
    journal::read_from(path, prefix)
        .map_while(Result::ok)
        .filter_map(|e| if let Record::Answer(a) = e.record { Some((a.presentation, a.choice)) } else { None })
        .collect()
}

/// The participant's last journal. A session that is killed before its first trial begins anew under the next number,
/// so that only the last journal counts.
fn last_journal(sessions: &Path, participant: &str) -> Option<std::path::PathBuf> {
    let all = std::fs::read_dir(sessions.join("rate").join(participant)).ok()?.map(|e| e.unwrap().path());
    all.filter(|p| p.extension().is_some_and(|e| e == "jsonl")).max()
}

/// Resumes the session until it is complete, and recovers the journal where the program asks for it.
fn finish(study: &validate::Study, lab: &Lab, sessions: &Path) -> std::path::PathBuf {
    for _ in 0..5 {
        match simulate(study, &lab.store(), sessions, "s01", 90.0, &options(Disk::real())) {
            Ok(ended) => {
                assert_eq!(ended.outcome, Some(Outcome::Completed));
                return ended.journal;
            }
            Err(SessionError::Writer(WriterError::Journal(
                JournalError::Line { path, .. } | JournalError::NoHeader { path },
            ))) => {
                let found = recover::recover(&Disk::real(), &path).unwrap();
                assert!(found.cut_bytes > 0);
                assert_eq!(found.whole_lines_cut, 0);
            }
            // The session was already complete when the failing step stopped it.
            Err(SessionError::Sessions(SessionsError::Completed { .. })) => {
                return last_journal(sessions, "s01").unwrap();
            }
            Err(error) => panic!("{error}"),
        }
    }
    panic!("the session does not become complete");
}

#[test]
fn stopped_at_every_step_or_without_power_no_accepted_answer_is_lost_or_doubled() {
    let lab = Lab::in_memory(&rate(&["pica", "room"], 1));
    let study = lab.load();
    let whole = simulate(&study, &lab.store(), &lab.path("whole"), "s01", 90.0, &options(Disk::real())).unwrap();
    let undisturbed = answers(&whole.journal);
    assert_eq!(undisturbed.len(), 5);
    let mut chance = Stream::new(7, 0, "crash test");
    let mut visited = 0;
    // After the stop the journal is left as it is (0), or cut at a random place after the last sync (1), as a loss of
    // power may do. The cut journal may also end with garbage without line breaks (2) or with any garbage (3).
    'tails: for tail in 0..4 {
        for step in 0.. {
            let sessions = lab.path(&format!("sessions-{tail}-{step}"));
            let disk = Disk::failing_after(step);
            let result = simulate(&study, &lab.store(), &sessions, "s01", 90.0, &options(disk.clone()));
            if !disk.has_failed() {
                assert!(result.is_ok() && step > 60, "{step}");
                continue 'tails;
            }
            visited += 1;
            assert!(result.is_err());
            let journal = last_journal(&sessions, "s01");
            let mut safe = Vec::new();
            if let Some(path) = &journal {
                let synced = disk.synced_bytes(path).unwrap();
                safe = accepted(path, synced);
                let length = std::fs::metadata(path).unwrap().len();
                let file = std::fs::OpenOptions::new().append(true).open(path).unwrap();
                if tail > 0 {
                    file.set_len(synced + chance.below(length - synced + 1)).unwrap();
                }
                let garbage: Vec<u8> = (0..chance.below(300)).map(|_| chance.below(256) as u8).collect();
                let garbage: Vec<u8> = match tail {
                    2 => garbage.into_iter().filter(|b| *b != b'\n').collect(),
                    3 => garbage,
                    _ => Vec::new(),
                };
                // A journal that was synced as a whole has no damaged end.
                if length > synced {
                    std::io::Write::write_all(&mut &file, &garbage).unwrap();
                }
            }
            let ended = finish(&study, &lab, &sessions);
            let after = answers(&ended);
            assert_eq!(after, undisturbed, "step {step}, tail {tail}");
            assert!(safe.iter().all(|a| after.contains(a)));
            std::fs::remove_dir_all(&sessions).unwrap();
        }
    }
    assert!(visited > 240, "{visited}");
}

#[test]
fn a_journal_cut_at_every_byte_goes_on_and_keeps_every_whole_answer() {
    let lab = Lab::in_memory(&rate(&["pica"], 1));
    let study = lab.load();
    let options = Options { durability: Durability::Relaxed, ..options(Disk::real()) };
    let sessions = lab.sessions();
    let whole = simulate(&study, &lab.store(), &sessions, "s01", 90.0, &options).unwrap();
    let undisturbed = answers(&whole.journal);
    let bytes = std::fs::read(&whole.journal).unwrap();
    let rows = sessions.join("rate/rows.json");
    let reserved = std::fs::read_to_string(&rows).unwrap().replace("completed", "reserved");
    // The journal is cut at every byte after the record `ready`, and at every 97th byte before it.
    let ready = bytes.windows(9).position(|w| w == b"\"ready\":{").unwrap();
    for cut in (0..ready).step_by(97).chain(ready..bytes.len()) {
        std::fs::remove_dir_all(sessions.join("rate/s01")).unwrap();
        std::fs::create_dir(sessions.join("rate/s01")).unwrap();
        std::fs::write(&whole.journal, &bytes[..cut]).unwrap();
        std::fs::write(&rows, &reserved).unwrap();
        let ended = simulate(&study, &lab.store(), &sessions, "s01", 90.0, &options);
        let ended = ended.unwrap_or_else(|e| panic!("cut at {cut}: {e}"));
        assert_eq!(answers(&ended.journal), undisturbed, "cut at {cut}");
        // The torn line is kept in a file beside the journal.
        let torn = bytes[..cut].iter().rev().take_while(|b| **b != b'\n').count();
        let aside = whole.journal.with_file_name("001.jsonl.aside-1");
        assert_eq!(std::fs::metadata(aside).map_or(0, |m| m.len()), torn as u64);
    }
}

#[test]
fn a_flipped_bit_stops_the_reading_with_its_line_and_nothing_is_cut() {
    let lab = Lab::new(&rate(&["pica"], 1));
    assert!(lab.simulate("s01", &[]).status.success());
    let path = lab.journal("s01", "001");
    let bytes = std::fs::read(&path).unwrap();
    let mut chance = Stream::new(7, 0, "bit test");
    for _ in 0..400 {
        let mut damaged = bytes.clone();
        let at = chance.below(bytes.len() as u64) as usize;
        damaged[at] ^= 1 << chance.below(8);
        std::fs::write(&path, &damaged).unwrap();
        let line = bytes[..at].iter().filter(|b| **b == b'\n').count() as u64 + 1;
        let error = collect(&path).unwrap_err().to_string();
        let names_it = error.contains(&format!("line {line} ")) || error.contains(&format!("line {} ", line + 1));
        assert!(names_it && error.contains("001.jsonl"), "bit of line {line}: {error}");
        assert_eq!(std::fs::read(&path).unwrap(), damaged);
    }
    // `recover` keeps everything before the damage in the journal and moves the rest to a file beside it.
    let mut damaged = bytes.clone();
    let at = bytes.len() / 2;
    damaged[at] ^= 1;
    std::fs::write(&path, &damaged).unwrap();
    let output = lab.program(&["study", "recover", path.to_str().unwrap(), "--json"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let said: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let kept = std::fs::read(&path).unwrap();
    let aside = std::fs::read(path.with_file_name("001.jsonl.aside-1")).unwrap();
    assert_eq!([kept.clone(), aside.clone()].concat(), damaged);
    assert_eq!(said["cut_bytes"], aside.len());
    assert!(said["whole_lines_cut"].as_u64().unwrap() > 0);
    assert_eq!(
        journal::read(&path).unwrap().filter(Result::is_ok).count() as u64,
        said["whole_lines"].as_u64().unwrap()
    );
}

/// Runs the program with a limit on the size of files. The write that exceeds it is done in part and fails, as on a
/// full disk.
#[cfg(unix)]
fn with_little_space(lab: &Lab, blocks: u32, args: &[&str]) -> std::process::Output {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let mut command = std::process::Command::new("sh");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_cyclopean")]).args(args).current_dir(lab.dir.path());
    command.output().unwrap()
}

#[cfg(unix)]
#[test]
fn where_space_runs_out_the_session_stops_with_a_sentence_and_goes_on_when_there_is_some() {
    let lab = Lab::new(&rate(&["pica"], 3));
    let mut stopped = 0;
    for blocks in 1.. {
        let id = format!("s{blocks}");
        let args = ["run", "study.json", "--participant", &id, "--simulate"];
        let output = with_little_space(&lab, blocks, &args);
        if output.status.success() {
            break;
        }
        stopped += 1;
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("cannot write") && said.contains("too large") || said.contains("rows.json"), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        let mut args = args.to_vec();
        let sessions = Sessions::new(Disk::real(), &lab.sessions(), "rate");
        if sessions.unfinished(&id).is_ok() {
            args.extend(["--resume", "--yes"]);
        }
        let output = lab.program(&args);
        assert!(output.status.success(), "{}", stderr(&output));
        let journal = collect(&last_journal(&lab.sessions(), &id).unwrap()).unwrap();
        assert_eq!((journal.outcome, journal.votes.len()), (Some(Outcome::Completed), 6));
    }
    assert!(stopped > 20, "{stopped}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_takes_nothing_is_refused_before_anybody_sits_down() {
    let lab = Lab::new(&rate(&["pica"], 1));
    let output = lab.simulate("s01", &["--sessions", "/proc/sessions"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("cannot use the sessions folder at /proc/sessions/rate"), "{}", stderr(&output));
}

#[test]
fn a_clock_that_was_set_back_is_said_and_loses_nothing() {
    let lab = Lab::new(&rate(&["pica"], 1));
    let path = lab.journal("s01", "001");
    for step in 0.. {
        let _ = std::fs::remove_dir_all(lab.sessions());
        let disk = Disk::failing_after(step);
        simulate(&lab.load(), &lab.store(), &lab.sessions(), "s01", 90.0, &options(disk)).unwrap_err();
        if accepted(&path, u64::MAX).len() == 2 {
            break;
        }
    }
    // The records so far are given times one day in the future.
    let mut bytes = Vec::new();
    for entry in journal::read(&path).unwrap().map_while(Result::ok) {
        let wall = entry.wall + chrono::Duration::days(1);
        journal::encode(&journal::Entry { wall, ..entry }, &mut bytes).unwrap();
    }
    std::fs::write(&path, bytes).unwrap();
    let output = lab.simulate("s01", &["--resume", "--yes"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("the clock of this machine was set back"), "{}", stderr(&output));
    let votes = collect(&path).unwrap();
    assert_eq!((votes.outcome, votes.votes.len()), (Some(Outcome::Completed), 2));
    let gaps: Vec<i64> = journal::read(&path)
        .unwrap()
        .filter_map(|e| if let Record::Resume(r) = e.unwrap().record { Some(r.gap_ms) } else { None })
        .collect();
    assert!(gaps.len() == 1 && gaps[0] < -86_000_000, "{gaps:?}");
    assert_eq!(answers(&path).len(), 3);
}

#[cfg(unix)]
#[test]
fn killed_at_random_moments_the_session_ends_as_if_nothing_had_happened() {
    let kills: u32 = std::env::var("CYCLOPEAN_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(50);
    let lab = Lab::new(&rate(&["pica", "room", "wine"], 40));
    let study = lab.load();
    let sessions = Sessions::new(Disk::real(), &lab.sessions(), "rate");
    let started = std::time::Instant::now();
    assert!(lab.simulate("warm-up", &[]).status.success());
    let longest_us = started.elapsed().as_micros() as u64;
    let mut chance = Stream::new(7, 0, "kill test");
    let (mut killed, mut ended) = (0, 0);
    while killed < kills {
        let id = format!("k{ended}");
        let mut args = vec!["run", "study.json", "--participant", &id, "--simulate"];
        if sessions.unfinished(&id).is_ok() {
            args.extend(["--resume", "--yes"]);
        }
        let mut child = lab
            .command(&args)
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_micros(chance.below(longest_us / 2)));
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
            killed += 1;
        }
        let output = child.wait_with_output().unwrap();
        // The program was killed or the session is complete. It may have become complete just before an earlier kill.
        // In no other case may the program fail.
        let was_over = stderr(&output).contains("has completed this study");
        assert!(was_over || output.status.code() != Some(1), "{}", stderr(&output));
        if was_over || output.status.success() {
            ended += 1;
        } else if let Ok(place) = sessions.unfinished(&id) {
            assert!(accepted(&place.journal, u64::MAX).iter().all(|(p, _)| *p < 241));
        }
    }
    // The same participants have the same rows in sessions without kills.
    let relaxed = Options { durability: Durability::Relaxed, ..options(Disk::real()) };
    let quiet = |id: &str| simulate(&study, &lab.store(), &lab.path("quiet"), id, 90.0, &relaxed).unwrap();
    quiet("warm-up");
    for i in 0..=ended {
        let id = format!("k{i}");
        if sessions.unfinished(&id).is_ok() {
            let output = lab.simulate(&id, &["--resume", "--yes"]);
            assert!(output.status.success(), "{}", stderr(&output));
        }
        let Some(journal) = last_journal(&lab.sessions(), &id) else { continue };
        let (votes, quiet) = (collect(&journal).unwrap(), quiet(&id));
        assert_eq!((votes.outcome, votes.header.row), (Some(Outcome::Completed), quiet.row));
        assert_eq!(answers(&journal), answers(&quiet.journal));
        assert_eq!(votes.votes.len(), 240);
    }
}
