//! Tests the operator's window beside a display in real time: it must mirror the session, and its keys must work. Needs
//! a Vulkan device, Xvfb and xdotool; the test is skipped, with a message, where one of the programs is missing.
#![cfg(feature = "gpu")]

use std::process::{Command, Stdio};
use std::time::Duration;

use cyclopean::display::headless::Headless;
use cyclopean::display::operator::WithOperatorWindow;
use cyclopean::display::{Display, DisplayError, DisplayInfo, StimulusFiles, TimedEvent};
use cyclopean::study::content::content;
use cyclopean::study::observer::Observer;
use cyclopean::study::prepare::{self, Shard};
use cyclopean::study::protocol::{Event, Input, Page, Screen};
use cyclopean::study::session::{Options, Session};
use cyclopean_analysis::journal::record::{Kind, Record};

use crate::desk::{self, Desk, EyePainter, entries, until};
use crate::lab::{Lab, rate};

/// A headless display whose frames take real time.
struct Slow(Headless);

impl Display for Slow {
    fn info(&self) -> &DisplayInfo {
        self.0.info()
    }

    fn load(&mut self, stimuli: &[StimulusFiles]) -> Result<(), DisplayError> {
        self.0.load(stimuli)
    }

    fn wait(&mut self, _: u64) -> Result<TimedEvent, DisplayError> {
        let timed = self.0.wait(1)?;
        if matches!(timed.event, Event::Frame { .. }) {
            std::thread::sleep(Duration::from_millis(33));
        }
        Ok(timed)
    }

    fn present(&mut self, screen: &Screen) -> Result<(), DisplayError> {
        self.0.present(screen)
    }
}

/// An observer who turns pages but never rates.
struct Patient;

impl Observer for Patient {
    fn respond(&mut self, screen: &Screen) -> Vec<(u64, Input)> {
        match screen {
            Screen::Page(Page::Paused) => Vec::new(),
            Screen::Page(_) => vec![(100_000_000, Input::Continue)],
            _ => Vec::new(),
        }
    }
}

fn study() -> serde_json::Value {
    let mut study = rate(&["pica"], 1);
    study["protocol"][0]["seconds"] = 6.0.into();
    study
}

/// The session of the test below, which runs it as a program of its own with the desk's DISPLAY.
#[test]
#[ignore = "part of the test below"]
fn the_session() {
    let Ok(folder) = std::env::var("OPERATOR_TEST_FOLDER") else { return };
    let folder = std::path::Path::new(&folder);
    let study = cyclopean::study::validate::load(&folder.join("study.json")).unwrap();
    let store = cyclopean::study::store::Store::new(folder.join("store"));
    let info = Headless::information(30.0);
    let options = Options::new(Kind::Pilot);
    let session = Session::begin(&study, &store, &folder.join("sessions"), "p1", &info, &options).unwrap();
    let words = content(&study, session.plan(), session.setup(), Kind::Pilot).unwrap();
    let headless = Headless::new(30.0, session.start_ns(), Box::new(Patient)).stepping();
    let mut display = WithOperatorWindow::new(Slow(headless), &words);
    let ended = session.run(&mut display).unwrap();
    assert_eq!(ended.outcome, None);
}

#[test]
fn the_operator_sees_the_session_pauses_repeats_skips_and_notes() {
    let Some(desk) = Desk::new("operator") else { return };
    let lab = Lab { dir: tempfile::tempdir().unwrap() };
    std::fs::write(lab.study(), serde_json::to_string(&study()).unwrap()).unwrap();
    prepare::prepare(&lab.load().definition, &lab.store(), &mut EyePainter, Shard::WHOLE, &mut |_, _| Ok(())).unwrap();
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "operator::the_session", "--ignored", "--nocapture"]);
    command.env("OPERATOR_TEST_FOLDER", lab.dir.path()).stdin(Stdio::null());
    let child = desk.on(&mut command);
    let window = desk.window();
    let journal = lab.journal("p1", "001");
    let count = |is: &dyn Fn(&Record) -> bool| entries(&journal).iter().filter(|e| is(&e.record)).count();
    until("a presentation begins", || count(&|r| matches!(r, Record::Begin(_))) == 1);
    until("its stimulus is mirrored", || desk::shows_stimulus(&desk.picture("stimulus")));

    desk.window_does("windowfocus", &window, &[]);
    for key in ["n", "c", "o", "u", "g", "h", "e", "d", "space", "p"] {
        desk.key(key);
    }
    desk.picture("note");
    desk.key("Return");
    until("the note is kept", || count(&|r| matches!(r, Record::Note(n) if n.text == "coughed p")) == 1);
    desk.key("r");
    until("it is repeated", || count(&|r| matches!(r, Record::Interrupted(i) if i.reason == "repeat")) == 1);
    desk.key("p");
    until("the session is paused", || count(&|r| matches!(r, Record::Pause(p) if p.reason == "operator")) == 1);
    desk.picture("paused");
    desk.key("c");
    until("the session goes on", || count(&|r| matches!(r, Record::Continue(_))) == 1);
    desk.key("s");
    until("the presentation is skipped", || count(&|r| matches!(r, Record::Skip(_))) == 1);
    desk.key("q");
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(!said.contains("vulkan validation"), "{said}");
    let pauses = count(&|r| matches!(r, Record::Pause(_)));
    assert_eq!(pauses, 1, "a key that was typed into the note was taken as a command");
}
