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
use xr::window::{Window, spots};
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

/// Two methods compared, toggled four times.
fn compare() -> serde_json::Value {
    serde_json::json!({
        "format": 1, "id": "rate", "title": "Compare", "seed": 11, "participants": 4, "task": "compare",
        "instructions": "Look.", "question": "Which was more consistent between your eyes?",
        "labels": ["A", "No difference", "B"], "preference": {"other": 1, "same": 2, "method": 3},
        "protocol": [{"show": "a", "seconds": 0.5}, {"show": "b", "seconds": 1.0}, {"show": "a", "seconds": 1.0},
                     {"show": "b", "seconds": 1.0}, {"show": "a", "seconds": 0.5}],
        "blank": {"seconds": 0.5},
        "conditions": {"cross": {"scene": ["pica", "room"], "method": ["stereo"], "other": ["sssr"]}},
        "stimuli": {"width_px": 16, "height_px": 16}
    })
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
const MARKS: [(u32, u32); 5] = [(240, 180), (60, 60), (420, 60), (60, 300), (330, 240)];

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

/// Tangents of the half field of Monado's remote headset in its window: 85° across a panel of 65 × 70 mm an eye.
const WINDOW_TAN: (f64, f64) = (0.916_33, 0.986_82);
/// Pixels of an eye's half of the window.
const HALF_PX: (f64, f64) = (480.0, 540.0);

/// What the headset says of its eyes is what its window shows.
fn as_the_window(hands: &mut xr::Hands) {
    let (x, y) = (WINDOW_TAN.0.atan() as f32, WINDOW_TAN.1.atan() as f32);
    hands.fov = [-x, x, y, -y];
}

/// Where a direction (tangents to the right and down) is seen in an eye's half of the window.
fn in_window(eye: usize, tan: (f64, f64)) -> (f64, f64) {
    let x = HALF_PX.0 * (0.5 + 0.5 * tan.0 / WINDOW_TAN.0) + eye as f64 * HALF_PX.0;
    (x, HALF_PX.1 * (0.5 + 0.5 * tan.1 / WINDOW_TAN.1))
}

fn assert_spots(name: &str, mut expected: Vec<(f64, f64)>, mut seen: Vec<(f64, f64)>) {
    let order =
        |a: &(f64, f64), b: &(f64, f64)| (a.1 / 4.0).round().total_cmp(&(b.1 / 4.0).round()).then(a.0.total_cmp(&b.0));
    expected.sort_by(order);
    seen.sort_by(order);
    assert_eq!(expected.len(), seen.len(), "{name}: {expected:?} {seen:?}");
    for (e, s) in expected.iter().zip(&seen) {
        assert!((e.0 - s.0).abs() <= 1.0 && (e.1 - s.1).abs() <= 1.0, "{name}: {s:?} is not within a pixel of {e:?}");
    }
}

/// Red and blue spots, of any lightness.
fn red(c: [u8; 3]) -> bool {
    c[0] > 90 && c[1] < 50 && c[2] < 50
}

fn blue(c: [u8; 3]) -> bool {
    c[2] > 90 && c[0] < 50 && c[1] < 50
}

/// A study of one presentation that stands for eight seconds, under a compositor that draws, up to the stimulus.
struct Shown {
    tail: Tail,
    run: Run,
    remote: xr::Remote,
    _service: Service,
    window: Window,
    lab: Lab,
}

fn show(mut study: serde_json::Value, name: &str) -> Shown {
    study["practice"] = serde_json::json!([]);
    study["stimuli"]["width_px"] = MARKS_PX.0.into();
    study["stimuli"]["height_px"] = MARKS_PX.1.into();
    let lab = marked(&study);
    let window = Window::open();
    let service = Service::start(Compositor::Window(window.number));
    let remote = service.remote();
    remote.set(as_the_window);
    let run = Run::start(&service, &lab, &[], &[]);
    let mut tail = Tail::of(&lab.journal("p1", "001"));
    tail.next("the instructions", Duration::from_secs(60), |r| matches!(r, Record::Phase(_)).then_some(()));
    std::thread::sleep(Duration::from_secs(2));
    window.keep(&format!("{name}-instructions"));
    let all = tail.all().len();
    while tail.all().len() == all {
        remote.trigger();
    }
    std::thread::sleep(Duration::from_millis(300));
    window.keep(&format!("{name}-blank"));
    Shown { tail, run, remote, _service: service, window, lab }
}

#[test]
fn each_eye_sees_its_own_picture_where_it_belongs() {
    if !xr::is_there() {
        return;
    }
    let mut study = wide(rate(&["pica"], 1), 60.0);
    study["protocol"] = serde_json::json!([{"show": "stimulus", "seconds": 8.0}]);
    study["blank"]["seconds"] = 2.0.into();
    let mut shown = show(study, "stereo");
    std::thread::sleep(Duration::from_secs(5));
    let seen = shown.window.keep("stereo-stimulus");
    // Sixty degrees across, straight ahead of each eye: no shift by its place in the head.
    let half = 30f64.to_radians().tan();
    let mark = |eye: usize| {
        let tan =
            |(x, y): (u32, u32)| ((f64::from(x) / 240.0 - 1.0) * half, (f64::from(y) / 180.0 - 1.0) * half * 0.75);
        MARKS.iter().map(|m| in_window(eye, tan(*m))).collect::<Vec<_>>()
    };
    assert_spots("left", mark(0), spots(&seen, red));
    assert_spots("right", mark(1), spots(&seen, blue));
    let choice = |_: u32, _: u32| 2;
    let mut participant = Participant::new(&shown.remote, shown.tail, 5, &choice);
    participant.until(|r| matches!(r, Record::Presentation(_)).then_some(()));
    std::thread::sleep(Duration::from_secs(3));
    shown.window.keep("stereo-panel");
    // Whoever looks elsewhere and centres the view has the same picture again.
    shown.remote.set(|h| {
        h.head = [0.0, 0.3f32.sin(), 0.0, 0.3f32.cos(), 0.4, 1.5, 0.2];
    });
    std::thread::sleep(Duration::from_millis(500));
    shown.run.operator("r");
    std::thread::sleep(Duration::from_secs(1));
    shown.window.keep("stereo-panel-centred");
}

#[test]
fn a_mirrored_pair_is_one_flat_picture_for_both_eyes() {
    if !xr::is_there() {
        return;
    }
    let mut study = wide(compare(), 60.0);
    study["layout"] = "mirrored-pair".into();
    study["conditions"] = serde_json::json!({"list": [
        {"scene": "pica", "method": "sssr", "other": "stereo", "reference": "path-traced", "eye": "right"}]});
    study["protocol"] = serde_json::json!([{"show": "a", "seconds": 8.0}, {"show": "b", "seconds": 8.0}]);
    study["blank"]["seconds"] = 2.0.into();
    let shown = show(study, "pair");
    std::thread::sleep(Duration::from_secs(5));
    let seen = shown.window.keep("pair-a");
    assert!(spots(&seen, red).is_empty(), "the left eye's images are not asked for");
    // Four fifths of 85° are 68°: the picture of 2 × 480 by 360 texels, at two metres, for eyes 64 mm apart.
    let half = 34f64.to_radians().tan();
    let mut expected = Vec::new();
    for eye in 0..2 {
        let shift = if eye == 0 { 0.016 } else { -0.016 };
        for (x, y) in MARKS.map(|(x, y)| (f64::from(x), f64::from(y))) {
            for column in [x, 960.0 - x] {
                let tan = ((column / 480.0 - 1.0) * half + shift, (y / 180.0 - 1.0) * half * 360.0 / 960.0);
                expected.push(in_window(eye, tan));
            }
        }
    }
    assert_spots("pair", expected, spots(&seen, blue));
    std::thread::sleep(Duration::from_secs(8));
    shown.window.keep("pair-b");
    drop(shown.lab);
}
