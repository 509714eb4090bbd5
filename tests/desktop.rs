//! Sessions in a window, answered by real keys: an X server without a monitor, a software device, validation on.
#![cfg(feature = "gpu")]

mod desk;
mod lab;

use std::process::Child;
use std::time::{Duration, Instant};

use cyclopean::study::prepare::{self, Shard};
use cyclopean_analysis::journal::Entry;
use cyclopean_analysis::journal::record::{Outcome, Purpose, Record, Shown};
use desk::{Desk, EyePainter, entries, until};
use lab::{Lab, stderr};

/// A study of the repository with short times, few conditions and small pictures.
fn short(name: &str) -> serde_json::Value {
    let path = format!("{}/studies/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let mut study: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for segment in study["protocol"].as_array_mut().unwrap() {
        let seconds = segment["seconds"].as_f64().unwrap();
        segment["seconds"] = (seconds / if seconds > 10.0 { 20.0 } else { 5.0 }).into();
    }
    study["blank"]["seconds"] = 0.5.into();
    study["conditions"]["cross"]["scene"] = serde_json::json!(["pica"]);
    study["practice"] = serde_json::json!([study["practice"][0]]);
    study["stimuli"]["width_px"] = desk::STILL.0.into();
    study["stimuli"]["height_px"] = desk::STILL.1.into();
    // A shared machine without a monitor keeps no time to the millisecond; frames are counted all the same.
    study["validity"] =
        serde_json::json!({"lost_ms": 5000, "gap_ms": 5000, "duration_percent": 100, "toggle_ms": 5000});
    study
}

fn lab(study: &serde_json::Value) -> Lab {
    let lab = Lab { dir: tempfile::tempdir().unwrap() };
    std::fs::write(lab.study(), serde_json::to_string_pretty(study).unwrap()).unwrap();
    let definition = lab.load().definition;
    prepare::prepare(&definition, &lab.store(), &mut EyePainter, Shard::WHOLE, &mut |_, _| Ok(())).unwrap();
    lab
}

/// A participant who follows a script at the keyboard.
struct Sitting<'a> {
    desk: &'a Desk,
    lab: &'a Lab,
    child: Option<Child>,
    seen: std::collections::BTreeSet<String>,
}

impl<'a> Sitting<'a> {
    fn begin(desk: &'a Desk, lab: &'a Lab, more: &[&str]) -> Sitting<'a> {
        let mut args = vec!["run", "study.json", "--participant", "p1", "--display", "desktop", "--pilot"];
        args.extend(["--window", "1280x720", "--hz", "60"]);
        args.extend_from_slice(more);
        let child = desk.on(&mut lab.command(&args));
        desk.window();
        Sitting { desk, lab, child: Some(child), seen: Default::default() }
    }

    fn journal(&self) -> Vec<Entry> {
        entries(&self.lab.journal("p1", "001"))
    }

    fn count(&self, is: impl Fn(&Record) -> bool) -> usize {
        self.journal().iter().filter(|e| is(&e.record)).count()
    }

    /// A picture of each phase, the first time it is met.
    fn look(&mut self, what: &str) {
        if self.seen.insert(what.to_owned()) {
            std::thread::sleep(Duration::from_millis(250));
            self.desk.picture(what);
        }
    }

    /// Presses until something is written.
    fn press_until(&self, key: &str, what: &str, is: impl Fn(&Record) -> bool) {
        let before = self.count(&is);
        let mut last = Instant::now() - Duration::from_secs(1);
        until(what, || {
            if last.elapsed() > Duration::from_millis(400) {
                self.desk.key(key);
                last = Instant::now();
            }
            self.count(&is) > before
        });
    }

    fn phase(&self, phase: &str) -> bool {
        self.count(|r| matches!(r, Record::Phase(p) if p.phase == phase)) > 0
    }

    /// Goes on from a page to whatever comes.
    fn turn(&mut self, phase: &str) {
        until(phase, || self.phase(phase));
        self.look(phase);
        let lines = self.journal().len();
        let mut last = Instant::now() - Duration::from_secs(1);
        until("the page turns", || {
            if last.elapsed() > Duration::from_millis(500) {
                self.desk.key("Return");
                last = Instant::now();
            }
            self.journal().len() > lines
        });
    }

    /// One presentation to its confirmed answer; gives (presentation, choice).
    fn rate(&mut self, choices: u32) -> (u32, u32) {
        let answers = self.count(|r| matches!(r, Record::Answer(_)));
        until("a presentation begins", || self.count(|r| matches!(r, Record::Begin(_))) > answers);
        let entries = self.journal();
        let begun = entries.iter().filter_map(|e| match &e.record {
            Record::Begin(b) => Some(b.presentation),
            _ => None,
        });
        let presentation = begun.last().unwrap();
        self.look("1-blank");
        std::thread::sleep(Duration::from_millis(500));
        self.look("2-stimulus");
        until("the stimulus is over", || self.count(|r| matches!(r, Record::Presentation(_))) > answers);
        std::thread::sleep(Duration::from_millis(600));
        self.look("3-panel");
        let choice = (2 * presentation + 1) % choices;
        self.press_until(&(choice + 1).to_string(), "the choice is taken", |r| matches!(r, Record::Change(_)));
        self.look("4-chosen");
        self.press_until("Return", "the answer is confirmed", |r| matches!(r, Record::Answer(_)));
        (presentation, choice)
    }

    fn end(mut self) -> Vec<Entry> {
        let child = self.child.take().unwrap();
        let output = child.wait_with_output().unwrap();
        let said = stderr(&output);
        println!("{said}");
        assert!(output.status.success(), "{said}");
        assert!(!said.contains("validation") && !said.contains("panicked"), "{said}");
        entries(&self.lab.journal("p1", "001"))
    }
}

impl Drop for Sitting<'_> {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            self.desk.picture("last");
            eprintln!("the journal ends with:");
            for entry in self.journal().iter().rev().take(15).rev() {
                eprintln!("{:?}", entry.record);
            }
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// What must hold of every journal: frames as asked, answers as scripted.
fn check(entries: &[Entry], script: &[(u32, u32)]) {
    let mut answers = Vec::new();
    for entry in entries {
        match &entry.record {
            Record::Answer(a) => answers.push((a.presentation, a.choice)),
            Record::Presentation(p) => {
                let frames: Vec<_> = p.segments.iter().map(|s| (s.frames_asked, s.frames_shown)).collect();
                println!("{frames:?}, {} missed, {:.0} ms, gap {:.1} ms", p.missed, p.duration_ms, p.longest_gap_ms);
                for segment in &p.segments {
                    // Missed frames are time that passed: shown and missed together make what was asked.
                    let late = segment.frames_asked.abs_diff(segment.frames_shown);
                    assert!(late <= p.missed, "{segment:?}, {} missed", p.missed);
                }
            }
            _ => {}
        }
    }
    assert_eq!(answers, script);
}

fn outcome(entries: &[Entry]) -> Option<Outcome> {
    entries.iter().find_map(|e| match &e.record {
        Record::End(end) => Some(end.outcome),
        _ => None,
    })
}

fn presentations(entries: &[Entry]) -> usize {
    entries.iter().filter(|e| matches!(e.record, Record::Planned(_))).count()
}

fn whole_session(name: &str, choices: u32, more: &[&str]) -> Option<(Vec<Entry>, Vec<(u32, u32)>)> {
    let desk = Desk::new(name)?;
    let lab = lab(&short(name));
    let mut sitting = Sitting::begin(&desk, &lab, more);
    sitting.turn("instructions");
    let n = presentations(&sitting.journal());
    let mut script = vec![sitting.rate(choices)];
    sitting.turn("ready");
    while script.len() < n {
        script.push(sitting.rate(choices));
    }
    sitting.turn("thanks");
    let entries = sitting.end();
    check(&entries, &script);
    assert_eq!(outcome(&entries), Some(Outcome::Completed));
    Some((entries, script))
}

#[test]
fn study_1_in_red_and_cyan() {
    let Some((entries, script)) = whole_session("consistency", 5, &["--mode", "anaglyph"]) else { return };
    assert_eq!(script.len(), 4);
    let Record::Header(header) = &entries[0].record else { panic!("no header") };
    assert_eq!(header.display.kind, "desktop");
    assert!(header.device.is_some());
    let shown = entries.iter().filter_map(|e| match &e.record {
        Record::Presentation(p) => Some(p),
        _ => None,
    });
    for p in shown {
        assert_eq!(p.segments[0].frames_asked, 60);
        // Whole frames of a loaded machine: as long as asked, and at most a few frames more.
        assert!((999.0..1300.0).contains(&p.duration_ms), "{} ms", p.duration_ms);
    }
}

#[test]
fn study_2_with_its_mirrored_pair() {
    let Some((entries, _)) = whole_session("quality", 3, &["--mode", "left"]) else { return };
    let toggles = entries.iter().filter_map(|e| match &e.record {
        Record::Presentation(p) => Some(p.segments.iter().map(|s| s.show).collect::<Vec<_>>()),
        _ => None,
    });
    for shown in toggles {
        assert_eq!(shown, [Shown::A, Shown::B, Shown::A, Shown::B, Shown::A]);
    }
}

#[test]
fn study_3_side_by_side() {
    let Some((entries, _)) = whole_session("ablation", 3, &["--mode", "sbs"]) else { return };
    let trials = entries.iter().filter(|e| matches!(&e.record, Record::Planned(p) if p.purpose == Purpose::Trial));
    assert_eq!(trials.count(), 3);
}
