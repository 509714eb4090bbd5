//! Whole sessions on a real OpenXR runtime, with a scripted head and scripted hands.

mod lab;
mod xr;

use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::Duration;

use cyclopean_analysis::journal::collect;
use cyclopean_analysis::journal::record::{Kind, Outcome, Record, Trust};
use lab::{Lab, rate};
use xr::journal::Tail;
use xr::participant::Participant;
use xr::{Compositor, Service, wait_for};

/// `cyclopean run … --display openxr` in the root.
struct Run {
    child: Child,
    said: PathBuf,
}

impl Run {
    fn start(service: &Service, lab: &Lab, more: &[&str], environment: &[(&str, &str)]) -> Run {
        let mut args = vec![env!("CARGO_BIN_EXE_cyclopean"), "run", "study.json", "--display", "openxr"];
        args.extend_from_slice(&["--participant", "p1"]);
        args.extend_from_slice(more);
        let said = lab.path("said.txt");
        let file = std::fs::File::options().create(true).append(true).open(&said).unwrap();
        let mut command = service.inside(&args);
        command.current_dir(lab.dir.path()).envs(environment.iter().copied());
        command.stdin(Stdio::piped()).stdout(file.try_clone().unwrap()).stderr(file);
        Run { child: command.spawn().expect("the program starts"), said }
    }

    /// Types a line on the operator's keyboard.
    fn operator(&mut self, line: &str) {
        use std::io::Write as _;
        writeln!(self.child.stdin.as_mut().expect("a keyboard"), "{line}").unwrap();
    }

    /// Exit code and everything it said.
    fn end(&mut self) -> (i32, String) {
        let code = wait_for("the program's end", Duration::from_secs(60), || self.child.try_wait().unwrap());
        (code.code().unwrap_or(-1), std::fs::read_to_string(&self.said).unwrap())
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            eprintln!("--- the program said:\n{}", std::fs::read_to_string(&self.said).unwrap_or_default());
        }
    }
}

/// The same study with pictures that say how wide they are.
fn wide(mut study: serde_json::Value, degrees: f64) -> serde_json::Value {
    study["stimuli"]["horizontal_fov_deg"] = degrees.into();
    study
}

fn journal(lab: &Lab) -> PathBuf {
    lab.journal("p1", "001")
}

#[test]
fn a_rating_study_answered_with_the_stick() {
    if !xr::is_there() {
        return;
    }
    let mut study = wide(rate(&["pica"], 1), 60.0);
    study["consent"] =
        serde_json::json!({"version": "1", "purpose": "a test", "retain_until": "2030-01-01", "text": "Do you agree?"});
    let lab = Lab::new(&study);
    let service = Service::start(Compositor::Null);
    let remote = service.remote();
    let mut run = Run::start(&service, &lab, &[], &[]);
    let choice = |presentation: u32, _: u32| (presentation * 2 + 1) % 5;
    let mut participant = Participant::new(&remote, Tail::of(&journal(&lab)), 5, &choice);
    assert_eq!(participant.take_part(), Outcome::Completed);
    let (code, said) = run.end();
    assert_eq!(code, 0, "{said}");
    eprintln!("{said}");
    let votes = collect(&journal(&lab)).unwrap();
    assert_eq!((votes.kind, votes.votes.len()), (Kind::Real, 2));
    assert_eq!(votes.header.display.trust, Trust::Predicted);
    eprintln!("{:?}", votes.header.display);
    for entry in Tail::of(&journal(&lab)).all() {
        eprintln!("{:?}", entry.record);
    }
    let _ = (Path::new(""), |r: &Record| matches!(r, Record::End(_)));
}
