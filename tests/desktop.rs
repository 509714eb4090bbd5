//! Tests whole sessions in a desktop window, answered by simulated keys and mouse clicks, and the commands
//! `display test` and `live`. The oracle is the script that the keys follow. Needs a Vulkan device, Xvfb and
//! xdotool; tests are skipped, with a message, where one of the programs is missing.
#![cfg(feature = "gpu")]

use std::process::Child;
use std::time::{Duration, Instant};

use cyclopean::study::Plan;
use cyclopean::study::prepare::{self, Shard};
use cyclopean::study::protocol::Setup;
use cyclopean_analysis::journal::Entry;
use cyclopean_analysis::journal::record::{Outcome, Purpose, Record, Shown, Trust};

use crate::desk::{self, Desk, EyePainter, entries, until};
use crate::lab::{Lab, stderr};

/// A study of the repository, changed to have short times, few conditions and small pictures.
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
    // A shared machine without a monitor does not keep time to the millisecond, so the rules of validity are loose.
    // Frames are still counted.
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

/// After this time a key that had no effect is pressed again, in case the window did not get it.
const PRESS_AGAIN: Duration = Duration::from_secs(10);

/// A simulated participant who follows a script at the keyboard.
struct Sitting<'a> {
    desk: &'a Desk,
    lab: &'a Lab,
    child: Option<Child>,
    seen: std::collections::BTreeSet<String>,
}

impl<'a> Sitting<'a> {
    fn begin(desk: &'a Desk, lab: &'a Lab, more: &[&str]) -> Sitting<'a> {
        let mut args = vec!["run", "study.json", "--participant", "p1", "--display", "desktop", "--pilot"];
        args.extend(["--window", "1240x680", "--hz", "60"]);
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

    /// Takes a picture of each phase, the first time it is reached.
    fn look(&mut self, what: &str) {
        if self.seen.insert(what.to_owned()) {
            self.desk.still_picture(what);
        }
    }

    /// Presses a key, and again only if it had no effect for a long time. A busy machine may handle a key late, and a
    /// second press would then answer the next question too.
    fn press_until_so(&self, key: &str, what: &str, is_so: impl Fn() -> bool) {
        let mut pressed: Option<Instant> = None;
        until(what, || {
            if pressed.is_none_or(|at| at.elapsed() > PRESS_AGAIN) {
                self.desk.key(key);
                pressed = Some(Instant::now());
            }
            is_so()
        });
    }

    /// Presses a key until a further record for which `is` holds is in the journal.
    fn press_until(&self, key: &str, what: &str, is: impl Fn(&Record) -> bool) {
        let before = self.count(&is);
        self.press_until_so(key, what, || self.count(&is) > before);
    }

    fn phase(&self, phase: &str) -> bool {
        self.count(|r| matches!(r, Record::Phase(p) if p.phase == phase)) > 0
    }

    /// Waits for the page of this phase and turns it.
    fn turn(&mut self, phase: &str) {
        until(phase, || self.phase(phase));
        self.look(phase);
        let lines = self.journal().len();
        self.press_until_so("Return", "the page turns", || self.journal().len() > lines);
    }

    /// Watches one presentation and answers it. Returns the presentation's number and the choice.
    fn rate(&mut self, choices: u32) -> (u32, u32) {
        self.rate_after(choices, 0)
    }

    /// The same after `cut_off` attempts that were begun and never answered.
    fn rate_after(&mut self, choices: u32, cut_off: usize) -> (u32, u32) {
        let answers = self.count(|r| matches!(r, Record::Answer(_)));
        until("a presentation begins", || self.count(|r| matches!(r, Record::Begin(_))) > answers + cut_off);
        let entries = self.journal();
        let begun = entries.iter().rev().find_map(|e| match &e.record {
            Record::Begin(b) => Some(b.presentation),
            _ => None,
        });
        let presentation = begun.unwrap();
        let is_over = || self.count(|r| matches!(r, Record::Presentation(_))) > answers;
        if !self.seen.contains("stimulus") {
            until("the stimulus is being shown or has been shown", || {
                is_over() || desk::shows_stimulus(&self.desk.screen())
            });
            self.desk.picture("stimulus");
            self.seen.insert("stimulus".to_owned());
        }
        until("the stimulus is over", || self.count(|r| matches!(r, Record::Presentation(_))) > answers);
        // The blank before the panel takes no keys.
        until("the panel is shown", || desk::shows_text(&self.desk.screen()));
        self.look("panel");
        let choice = (2 * presentation + 1) % choices;
        self.press_until(&(choice + 1).to_string(), "the choice is taken", |r| matches!(r, Record::Change(_)));
        self.look("chosen");
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

/// Checks what must hold for every journal: the frames were shown as asked, and the answers are those of the script.
fn check(entries: &[Entry], script: &[(u32, u32)]) {
    let mut answers = Vec::new();
    for entry in entries {
        match &entry.record {
            Record::Answer(a) => answers.push((a.presentation, a.choice)),
            Record::Presentation(p) => {
                let frames: Vec<_> = p.segments.iter().map(|s| (s.frames_asked, s.frames_shown)).collect();
                println!("{frames:?}, {} missed, {:.0} ms, gap {:.1} ms", p.missed, p.duration_ms, p.longest_gap_ms);
                for segment in &p.segments {
                    // The number of shown frames may differ from the number asked for by no more than the missed ones.
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

/// The setup of the study's first row, for a display with 60 Hz and 90 arc seconds per pixel.
fn setup(lab: &Lab) -> Setup {
    let definition = lab.load().definition;
    Setup::new(&definition, &Plan::draw(&definition, 0), 60.0, Trust::Predicted, 90.0)
}

/// The journal's entries, and the presentations and choices of the script.
type CompletedSession = (Vec<Entry>, Vec<(u32, u32)>);

fn whole_session(name: &str, choices: u32, more: &[&str]) -> Option<CompletedSession> {
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
        // The segment lasts for the second that was asked for, and on a loaded machine up to 0.3 s longer.
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

#[test]
fn the_recommended_study_with_consent_questionnaires_and_stereograms() {
    let Some(desk) = Desk::new("recommended") else { return };
    let mut study = short("recommended");
    study["screening"]["disparities_arcsec"] = serde_json::json!([400]);
    study["screening"]["required_arcsec"] = 400.into();
    study["repetitions"] = 1.into();
    study["conditions"]["cross"]["method"] = serde_json::json!(["stereo", "sssr"]);
    study["catch_trials"] = serde_json::json!([]);
    study["analysis"]["exclusion"] = serde_json::Value::Null;
    study["analysis"]["contrasts"] = serde_json::json!([]);
    study["analysis"]["equivalence"] = serde_json::Value::Null;
    let lab = lab(&study);
    let setup = setup(&lab);
    let mut sitting = Sitting::begin(&desk, &lab, &["--mode", "crossed"]);
    sitting.turn("consent");
    let is_item = |r: &Record| matches!(r, Record::Item(_));
    let mut chosen = Vec::new();
    for (i, item) in setup.items.iter().enumerate() {
        if item.questionnaire == "ssq-after" {
            break;
        }
        if i == 0 || i == 6 {
            sitting.look(item.name);
        }
        let choice = i % item.options.len();
        sitting.press_until(&(choice + 1).to_string(), item.name, is_item);
        chosen.push(Some(item.options[choice].to_owned()));
    }
    for (i, trial) in setup.screening.iter().enumerate() {
        if i == 0 {
            sitting.look("dots");
        }
        sitting.press_until(&(trial.shown + 1).to_string(), "a stereogram", |r| matches!(r, Record::Screening(_)));
    }
    sitting.turn("instructions");
    let n = presentations(&sitting.journal());
    let mut script = vec![sitting.rate(5)];
    sitting.turn("ready");
    while script.len() < n {
        script.push(sitting.rate(5));
    }
    until("the questionnaire", || sitting.phase("ssq-after"));
    for item in setup.items.iter().filter(|i| i.questionnaire == "ssq-after") {
        // The participant need not answer a question of a questionnaire.
        sitting.press_until("BackSpace", item.name, is_item);
        chosen.push(None);
    }
    sitting.turn("thanks");
    let entries = sitting.end();
    check(&entries, &script);
    assert_eq!(outcome(&entries), Some(Outcome::Completed));
    let said = entries.iter().filter_map(|e| match &e.record {
        Record::Item(item) => Some(item.answer.clone()),
        _ => None,
    });
    assert_eq!(said.collect::<Vec<_>>(), chosen);
    assert!(entries.iter().all(|e| !matches!(&e.record, Record::Screening(s) if s.shown != s.chosen)));
}

#[test]
fn a_moving_stimulus_plays_in_the_window_and_its_last_frame_stands() {
    let Some(desk) = Desk::new("moving") else { return };
    let mut study = short("motion");
    study["conditions"]["cross"]["method"] = serde_json::json!(["stereo"]);
    study["analysis"]["contrasts"] = serde_json::json!([]);
    study["repetitions"] = 1.into();
    study["practice"] = serde_json::json!([]);
    // The film lasts 0.6 seconds, and its last frame is shown for the rest of the six seconds.
    study["protocol"] = serde_json::json!([{"show": "stimulus", "seconds": 6.0}]);
    study["validity"]["skipped_percent"] = 100.into();
    let lab = lab(&study);
    let mut sitting = Sitting::begin(&desk, &lab, &["--mode", "left"]);
    sitting.turn("instructions");
    until("the presentation begins", || sitting.count(|r| matches!(r, Record::Begin(_))) == 1);
    // The white disc moves down from the middle of the left eye's reddish picture to its place in the last frame.
    let last = f64::from((desk::FILM.frames - 1) * desk::SINKS_PX) / f64::from(desk::STILL.1);
    until("the last frame is shown", || {
        let picture = desk.picture("film");
        let rows = |is: &dyn Fn(f64, [u8; 3]) -> bool| -> Vec<f64> {
            let rows = picture.enumerate_pixels().map(|(_, y, p)| (f64::from(y), p.0));
            rows.filter(|(y, color)| is(*y, *color)).map(|(y, _)| y).collect()
        };
        let red = rows(&|_, c| c[0].saturating_sub(c[2]) > 110);
        let top = red.iter().copied().fold(f64::INFINITY, f64::min);
        let bottom = red.iter().copied().fold(0.0, f64::max);
        let height = bottom + 1.0 - top;
        // The rows outside the picture are left out, because the window's own signs are drawn there.
        let white = rows(&|y, c| y > top && y < bottom && c.iter().all(|v| *v > 220));
        if white.len() < 900 || height < 100.0 {
            return false;
        }
        let disc = white.iter().sum::<f64>() / white.len() as f64 + 0.5;
        ((disc - top) / height - 0.5 - last).abs() < 0.01
    });
    sitting.press_until("1", "the choice is taken", |r| matches!(r, Record::Change(_)));
    sitting.press_until("Return", "the answer is confirmed", |r| matches!(r, Record::Answer(_)));
    sitting.turn("thanks");
    let entries = sitting.end();
    let shown: Vec<_> =
        entries.iter().filter_map(|e| if let Record::Presentation(p) = &e.record { Some(p) } else { None }).collect();
    let [p] = shown[..] else { panic!("{shown:?}") };
    let segment = &p.segments[0];
    assert_eq!(segment.film_onsets_ns.len(), desk::FILM.frames as usize);
    assert_eq!(segment.film_onsets_ns[0], Some(segment.first_ns));
    for (frame, onset) in segment.film_onsets_ns.iter().enumerate() {
        let Some(onset) = onset else { continue };
        // No frame may be early, or later than the machine's longest gap explains.
        let due = frame as f64 * 1e9 / desk::FILM.rate_hz;
        let late_ms = ((onset - segment.first_ns) as f64 - due) / 1e6;
        assert!((-1.0..p.longest_gap_ms + 20.0).contains(&late_ms), "frame {frame} is {late_ms} ms late");
    }
}

#[test]
fn a_window_killed_while_a_stimulus_stands_is_taken_up_again() {
    let Some(desk) = Desk::new("killed") else { return };
    let lab = lab(&short("consistency"));
    let mut sitting = Sitting::begin(&desk, &lab, &["--mode", "left"]);
    sitting.turn("instructions");
    let mut script = vec![sitting.rate(5)];
    sitting.turn("ready");
    until("the next presentation begins", || sitting.count(|r| matches!(r, Record::Begin(_))) == 2);
    until("its stimulus is shown", || desk::shows_stimulus(&desk.picture("killed")));
    let mut child = sitting.child.take().unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    let before = sitting.journal().len();
    drop(sitting);

    let mut sitting = Sitting::begin(&desk, &lab, &["--mode", "left", "--resume", "--yes"]);
    until("the session is resumed", || sitting.journal().len() > before);
    sitting.look("welcome-back");
    let n = presentations(&sitting.journal());
    until("the session goes on", || {
        desk.key("Return");
        sitting.count(|r| matches!(r, Record::Begin(_))) == 3
    });
    while script.len() < n {
        script.push(sitting.rate_after(5, 1));
    }
    sitting.turn("thanks");
    let entries = sitting.end();
    check(&entries, &script);
    assert_eq!(outcome(&entries), Some(Outcome::Completed));
    let attempts: Vec<(u32, u32)> = entries
        .iter()
        .filter_map(|e| match &e.record {
            Record::Begin(b) => Some((b.presentation, b.attempt)),
            _ => None,
        })
        .collect();
    assert_eq!(attempts[1].0, attempts[2].0, "the attempt after the kill is of another presentation");
    assert_eq!((attempts[1].1, attempts[2].1), (0, 1));
}

#[test]
fn a_window_can_be_resized_hidden_and_paused_and_the_mouse_answers() {
    let Some(desk) = Desk::new("moved") else { return };
    let lab = lab(&short("ablation"));
    let mut sitting = Sitting::begin(&desk, &lab, &["--mode", "anaglyph"]);
    until("instructions", || sitting.phase("instructions"));
    let window = desk.window();
    desk.window_does("windowsize", &window, &["800", "500"]);
    // The corners right of the smaller window show the empty desktop, and therefore the same colour.
    until("the desktop is seen beside the smaller window", || {
        let small = desk.picture("resized");
        small.get_pixel(1270, 10).0 == small.get_pixel(1270, 700).0
    });
    sitting.press_until("Return", "the page turns", |r| matches!(r, Record::Begin(_)));
    until("the stimulus is over", || sitting.count(|r| matches!(r, Record::Presentation(_))) == 1);
    // Esc pauses the session, which asks for the answer afterwards.
    sitting.press_until("Escape", "a pause", |r| matches!(r, Record::Pause(_)));
    sitting.look("paused");
    sitting.press_until("Return", "the session goes on", |r| matches!(r, Record::Continue(_)));
    // Finds the first button. The buttons are one below the other or side by side, somewhere in the left half.
    let first_button = |panel: &image::RgbImage| {
        let light = |x: u32, y: u32| panel.get_pixel(x, y).0[0] > 150 && panel.get_pixel(x, y).0[1] > 150;
        let inside = |&(x, y): &(u32, u32)| (0..30).all(|i| light(x + i, y) && light(x, y + i));
        (150..500).flat_map(|y| (60..700).map(move |x| (x, y))).find(inside)
    };
    let mut button = None;
    until("a button of the panel is shown", || {
        button = first_button(&desk.picture("panel-small"));
        button.is_some()
    });
    let (x, y) = button.unwrap();
    let mut clicked: Option<Instant> = None;
    until("the mouse chooses", || {
        if clicked.is_none_or(|at| at.elapsed() > PRESS_AGAIN) {
            desk.click(x as i32 + 15, y as i32 + 10);
            clicked = Some(Instant::now());
        }
        sitting.count(|r| matches!(r, Record::Change(_))) == 1
    });
    sitting.press_until("Return", "the answer is confirmed", |r| matches!(r, Record::Answer(_)));
    if desk.has_manager() {
        sitting.turn("ready");
        until("a stimulus begins", || sitting.count(|r| matches!(r, Record::Begin(_))) == 2);
        until("the stimulus is shown", || desk::shows_stimulus(&desk.picture("before-minimised")));
        desk.window_does("windowminimize", &window, &[]);
        // The window stays hidden for two seconds, longer than the second that is checked below.
        std::thread::sleep(Duration::from_secs(2));
        desk.window_does("windowmap", &window, &[]);
        desk.window_does("windowactivate", &window, &[]);
        // Nobody could see the stimulus, so the presentation must be lost or the session must pause.
        let is_judged = |r: &Record| match r {
            Record::Presentation(p) => p.lost_ms > 1000.0,
            Record::Pause(p) => p.reason == "not-seen",
            _ => false,
        };
        until("the presentation that nobody saw is lost or paused", || sitting.count(is_judged) == 1);
    }
    // Ctrl+Q closes the window and leaves the session unfinished, to be resumed later.
    desk.key("ctrl+q");
    let entries = sitting.end();
    assert_eq!(outcome(&entries), None);
}

#[test]
fn without_a_desktop_one_sentence_says_so() {
    let lab = lab(&short("consistency"));
    let args = ["run", "study.json", "--participant", "p1", "--display", "desktop"];
    for (display, words) in [(None, "neither DISPLAY nor WAYLAND_DISPLAY is set"), (Some(":4711"), "DISPLAY=:4711")] {
        let mut command = lab.command(&args);
        command.env_remove("WAYLAND_DISPLAY").env_remove("DISPLAY").envs(display.map(|d| ("DISPLAY", d)));
        let output = command.output().unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert_eq!(said.trim().lines().count(), 1, "{said}");
        assert!(said.contains(words) && said.contains("cyclopean doctor"), "{said}");
        assert!(!lab.sessions().exists(), "a session was begun");
    }
}

#[test]
fn without_the_keyboard_library_one_sentence_says_so() {
    let Some(desk) = Desk::new("library") else { return };
    let lab = lab(&short("consistency"));
    // The loader finds these first, and cannot read them.
    for name in ["libxkbcommon-x11.so.0", "libxkbcommon-x11.so"] {
        std::fs::write(lab.path(name), "no library").unwrap();
    }
    let run =
        |args: &[&str]| desk.on(lab.command(args).env("LD_LIBRARY_PATH", lab.path(""))).wait_with_output().unwrap();
    let output = run(&["run", "study.json", "--participant", "p1", "--display", "desktop"]);
    let said = stderr(&output);
    assert_eq!((output.status.code(), said.trim().lines().count()), (Some(1), 1), "{said}");
    assert!(said.contains("libxkbcommon-x11.so.0") && said.contains("cyclopean doctor"), "{said}");
    assert!(!lab.sessions().exists(), "a session was begun");
    let doctor = run(&["doctor"]);
    let found = String::from_utf8_lossy(&doctor.stdout).into_owned();
    assert!(found.contains("apt-get install libxkbcommon-x11-0"), "{found}");
}

#[test]
fn a_display_test_measures_intervals_and_asks_for_eyes_and_depth() {
    let Some(desk) = Desk::new("test") else { return };
    let lab = Lab { dir: tempfile::tempdir().unwrap() };
    let args = ["display", "test", "--json", "--mode", "sbs", "--window", "1200x640", "--hz", "60", "--seconds", "2"];
    let words = lab.path("said.txt");
    let child = desk.on_saying(&mut lab.command(&args), &words);
    desk.window();
    let is_extreme = |p: &image::Rgb<u8>| p.0 == [0; 3] || p.0 == [255; 3];
    let said = || std::fs::read_to_string(&words).unwrap();
    until("the square for the photodiode or the first question is shown", || {
        desk.picture("measuring").pixels().any(is_extreme) || said().contains("question")
    });
    // A key is accepted only while a question is shown, and each question is asked once.
    let answer = |question: &str, name: &str, key: &str| {
        until(question, || said().contains(question));
        desk.still_picture(name);
        desk.key(key);
    };
    answer("which word does the open eye see?", "eyes", "l");
    for (at, key) in ["3", "2", "4", "4"].into_iter().enumerate() {
        answer(&format!("stereogram {} of 4", at + 1), "depth", key);
    }
    let output = child.wait_with_output().unwrap();
    let said = said();
    assert!(output.status.success() && !said.contains("vulkan validation"), "{said}");
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["eyes_right"], true);
    assert_eq!(found["depth_right"], serde_json::json!([3, 4]));
    // How many frames a busy machine draws in two seconds is its own affair; each interval between them must be counted.
    let counted = found["intervals"]["histogram"].as_array().unwrap().iter().map(|bin| bin[1].as_u64().unwrap());
    let frames = found["intervals"]["frames"].as_u64().unwrap();
    assert!(frames > 2 && counted.sum::<u64>().abs_diff(frames) <= 1, "{found}");
}

#[test]
fn a_scene_is_flown_through_and_its_method_switched() {
    let Some(desk) = Desk::new("live") else { return };
    let lab = Lab { dir: tempfile::tempdir().unwrap() };
    let args = ["live", "pica", "--json", "--mode", "sbs", "--window", "800x400", "--size", "96x48"];
    let child = desk.on(&mut lab.command(&args));
    desk.window();
    until("the scene is drawn", || {
        let screen = desk.picture("stereo");
        let first = screen.get_pixel(400, 200).0;
        let differs = |p: &&image::Rgb<u8>| p.0.iter().zip(first).any(|(a, b)| a.abs_diff(b) > 20);
        screen.pixels().filter(differs).count() > 30_000
    });
    let before = desk.picture("stereo");
    desk.key("2");
    desk.key("Right");
    desk.key("Right");
    let began = Instant::now();
    until("the picture changes", || desk.picture("sssr") != before && began.elapsed() > Duration::from_secs(2));
    desk.key("Escape");
    let output = child.wait_with_output().unwrap();
    let said = stderr(&output);
    assert!(output.status.success() && !said.contains("vulkan validation"), "{said}");
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(found["frames"].as_u64().unwrap() >= 2, "{found}");
}
