//! Tests sessions on a disk that really is full: a file system of 64 KiB in memory, with different amounts of space
//! left. The oracle is the same session with enough space. Needs Linux and the right to mount, and is skipped, with a
//! message, without it.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use cyclopean::study::disk::Disk;
use cyclopean::study::sessions::Sessions;
use cyclopean_analysis::journal::record::{Outcome, Record};
use cyclopean_analysis::journal::{self, collect};

use crate::lab::{Lab, rate, stderr};

const PAGE: usize = 4096;

/// A mounted file system. It is unmounted when this is dropped, also if the test fails.
struct Small(PathBuf);

impl Small {
    fn mount(folder: PathBuf) -> Option<Small> {
        std::fs::create_dir(&folder).expect("made");
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]).arg(&folder).output();
        mount.is_ok_and(|output| output.status.success()).then_some(Small(folder))
    }
}

impl Drop for Small {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

/// The choice for each presentation with an answer that counts, up to the first damaged line. Panics if a presentation
/// has two such answers.
fn answers(path: &Path) -> BTreeMap<u32, u32> {
    let mut out = BTreeMap::new();
    for entry in journal::read(path).expect("readable").map_while(Result::ok) {
        if let Record::Answer(a) = entry.record
            && a.counts
        {
            assert_eq!(out.insert(a.presentation, a.choice), None, "a presentation was answered twice");
        }
    }
    out
}

#[test]
fn a_full_disk_stops_a_session_with_a_sentence_and_space_lets_it_go_on() {
    let lab = Lab::new(&rate(&["pica", "room"], 7));
    let Some(small) = Small::mount(lab.path("small")) else {
        println!("skipped: this user may not mount a small file system");
        return;
    };
    assert!(lab.simulate("s01", &["--sessions", "roomy"]).status.success());
    let undisturbed = answers(&lab.path("roomy/rate/s01/001.jsonl"));
    assert_eq!(undisturbed.len(), 29);
    let sessions = small.0.join("sessions");
    let filler = small.0.join("filler");
    let (mut stopped, mut midway) = (0, 0);
    for pages in 0..=16 {
        let _ = std::fs::remove_dir_all(&sessions);
        std::fs::write(&filler, vec![1; pages * PAGE]).expect("fits");
        let output = lab.simulate("s01", &["--sessions", "small/sessions"]);
        if output.status.success() {
            continue;
        }
        stopped += 1;
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("No space left on device") && said.contains("small/sessions/rate"), "{said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
        // Every answer that was accepted must be in the journal, now and after every further try.
        let of_rate = Sessions::new(Disk::real(), &sessions, "rate");
        let place = of_rate.unfinished("s01").ok();
        let before = place.as_ref().map(|p| answers(&p.journal)).unwrap_or_default();
        midway += usize::from(!before.is_empty());
        let more: &[&str] = if place.is_some() { &["--resume", "--yes"] } else { &[] };
        let arguments = [&["--sessions", "small/sessions"], more].concat();
        let still_full = lab.simulate("s01", &arguments);
        assert_eq!(still_full.status.code(), Some(1), "{}", stderr(&still_full));
        assert!(stderr(&still_full).contains("No space left on device"), "{}", stderr(&still_full));
        if let Some(place) = &place {
            let after = answers(&place.journal);
            assert!(before.iter().all(|(p, choice)| after.get(p) == Some(choice)), "{pages} pages were filled");
        }
        std::fs::remove_file(&filler).expect("removed");
        let more: &[&str] = if of_rate.unfinished("s01").is_ok() { &["--resume", "--yes"] } else { &[] };
        let output = lab.simulate("s01", &[&["--sessions", "small/sessions"], more].concat());
        assert!(output.status.success(), "{pages} pages were filled: {}", stderr(&output));
        // A session that was stopped before its first trial has begun anew under the next number.
        let last = ["002", "001"].map(|s| sessions.join(format!("rate/s01/{s}.jsonl")));
        let ended = last.iter().find(|p| p.exists()).expect("a journal");
        let votes = collect(ended).expect("whole");
        assert_eq!((votes.outcome, votes.votes.len()), (Some(Outcome::Completed), 28));
        assert_eq!(answers(ended), undisturbed, "{pages} pages were filled");
    }
    assert!(stopped >= 5 && midway >= 2, "only {stopped} sessions stopped, {midway} of them after an answer");
    println!("{stopped} sessions stopped by a full disk, {midway} of them after an answer");
}
