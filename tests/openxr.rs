//! Whole sessions on a real OpenXR runtime, with a scripted head and scripted hands.

mod lab;
mod xr;

use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::Duration;

use cyclopean::study::prepare::{self, Shard};
use cyclopean::study::sha256_hex;
use cyclopean::study::stimulus::{StimulusInfo, StimulusRenderer, StimulusRequest};
use cyclopean_analysis::journal::collect;
use cyclopean_analysis::journal::record::{Kind, Outcome, Record, Trust};
use lab::{Lab, rate};
use xr::journal::Tail;
use xr::participant::Participant;
use xr::window::Window;
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
    let votes = collect(&journal(&lab)).unwrap();
    assert_eq!((votes.kind, votes.votes.len()), (Kind::Real, 2));
    let answers: Vec<(u32, u32, u32)> = Tail::of(&journal(&lab))
        .all()
        .iter()
        .filter_map(|e| match &e.record {
            Record::Answer(a) => Some((a.presentation, a.attempt, a.choice)),
            _ => None,
        })
        .collect();
    assert_eq!(answers, [(0, 0, 1), (1, 0, 3), (2, 0, 0)]);
    assert_eq!(participant.answered, answers);
    let display = &votes.header.display;
    assert_eq!((display.kind.as_str(), display.trust, display.nominal_hz), ("openxr", Trust::Predicted, 20.0));
    assert!((display.ipd_m.unwrap() - 0.064).abs() < 1e-5, "{display:?}");
    assert!((display.fov_deg.unwrap()[1][0] - 49.85).abs() < 0.01, "{display:?}");
}

/// Stimuli of known marks: a grey ground, and squares of eight texels in a colour that tells the eye.
struct Marks;

const MARKS_PX: (u32, u32) = (480, 360);
/// Centres of the squares, texels.
const MARKS: [(u32, u32); 5] = [(240, 180), (60, 60), (420, 60), (60, 300), (420, 300)];

impl StimulusRenderer for Marks {
    fn identity(&self, request: &StimulusRequest) -> anyhow::Result<String> {
        Ok(sha256_hex(serde_json::to_string(request)?.as_bytes()))
    }

    fn render(&mut self, request: &StimulusRequest, into: &Path) -> anyhow::Result<StimulusInfo> {
        let (width, height) = MARKS_PX;
        // Left red, right blue; the other method has them darker.
        let light = if request.method == "sssr" { 250 } else { 150 };
        let picture = image::RgbImage::from_fn(2 * width, height, |x, y| {
            let (right, x) = (x >= width, x % width);
            let is_mark = MARKS.iter().any(|(mx, my)| x.abs_diff(*mx) < 4 && y.abs_diff(*my) < 4);
            match (is_mark, right) {
                (true, false) => image::Rgb([light, 0, 0]),
                (true, true) => image::Rgb([0, 0, light]),
                _ => image::Rgb([70, 70, 70]),
            }
        });
        picture.save(into.join("sbs.png"))?;
        exr::prelude::write_rgb_file(into.join("stereo.exr"), 4, 4, |_, _| (0.0_f32, 0.0_f32, 0.0_f32))?;
        let horizontal_fov_deg = request.horizontal_fov_deg;
        Ok(StimulusInfo { renderer: "marks".to_owned(), samples: 1, horizontal_fov_deg, ..StimulusInfo::default() })
    }
}

/// A laboratory with marked stimuli.
fn marked(study: &serde_json::Value) -> Lab {
    let lab = Lab::new(study);
    std::fs::remove_dir_all(lab.path("store")).unwrap();
    let study = lab.load();
    prepare::prepare(&study.definition, &lab.store(), &mut Marks, Shard::WHOLE, &mut |_, _| Ok(())).unwrap();
    lab
}

#[test]
fn each_eye_sees_its_own_picture_where_it_belongs() {
    if !xr::is_there() {
        return;
    }
    let mut study = wide(rate(&["pica"], 1), 60.0);
    study["practice"] = serde_json::json!([]);
    study["protocol"] = serde_json::json!([{"show": "stimulus", "seconds": 8.0}]);
    study["stimuli"]["width_px"] = MARKS_PX.0.into();
    study["stimuli"]["height_px"] = MARKS_PX.1.into();
    let lab = marked(&study);
    let window = Window::open();
    let service = Service::start(Compositor::Window(window.number));
    let remote = service.remote();
    let _run = Run::start(&service, &lab, &[], &[]);
    let mut tail = Tail::of(&journal(&lab));
    let choice = |_: u32, _: u32| 2;
    tail.next("the instructions", Duration::from_secs(60), |r| matches!(r, Record::Phase(_)).then_some(()));
    std::thread::sleep(Duration::from_secs(2));
    window.keep("instructions");
    let mut participant = Participant::new(&remote, tail, 5, &choice);
    participant.press_until_written(None);
    window.keep("blank");
    std::thread::sleep(Duration::from_secs(4));
    window.keep("marks");
    participant.until(|r| matches!(r, Record::Presentation(_)).then_some(()));
    std::thread::sleep(Duration::from_secs(2));
    window.keep("panel");
}
