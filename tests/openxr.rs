//! Tests whole sessions on a real OpenXR runtime (Monado), with a scripted head and scripted hands. The oracles are the
//! script of the answers, a log of all OpenXR calls, and pictures of the compositor's window. Needs Linux, root's
//! rights and the root folder that `tests/xr/root` builds; tests are skipped, with a message, without them.

use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::Duration;

use cyclopean::study::prepare::{self, Shard};
use cyclopean::study::sha256_hex;
use cyclopean::study::stimulus::{StimulusInfo, StimulusRenderer, StimulusRequest, frame_file};
use cyclopean_analysis::journal::record::{Film, Kind, Outcome, Record, Trust};
use cyclopean_analysis::journal::{SessionVotes, collect};

use crate::lab::{self, Lab, rate};
use crate::xr::journal::Tail;
use crate::xr::participant::Participant;
use crate::xr::window::{Window, spots};
use crate::xr::witness::Witness;
use crate::xr::{self, Compositor, Service, wait_for};

/// The program under test, which runs in the test root. Its output goes to the file `said`.
struct Run {
    child: Child,
    said: PathBuf,
}

impl Run {
    fn start(service: &Service, lab: &Lab, more: &[&str], environment: &[(&str, &str)]) -> Run {
        let mut args = vec!["run", "study.json", "--display", "openxr", "--participant", "p1"];
        args.extend_from_slice(more);
        Run::program(service, lab.dir.path(), &args, environment)
    }

    fn program(service: &Service, folder: &Path, args: &[&str], environment: &[(&str, &str)]) -> Run {
        let mut all = vec![env!("CARGO_BIN_EXE_cyclopean")];
        all.extend_from_slice(args);
        let said = folder.join("said.txt");
        let file = std::fs::File::options().create(true).append(true).open(&said).unwrap();
        let mut command = service.inside(&all);
        command.current_dir(folder).envs(environment.iter().copied());
        command.stdin(Stdio::piped()).stdout(file.try_clone().unwrap()).stderr(file);
        Run { child: command.spawn().expect("the program starts"), said }
    }

    /// Types a line on the operator's keyboard.
    fn operator(&mut self, line: &str) {
        use std::io::Write as _;
        writeln!(self.child.stdin.as_mut().expect("a keyboard"), "{line}").unwrap();
    }

    /// Waits for the program to end, and returns its exit status and everything that it printed.
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
            eprintln!("--- the program printed:\n{}", std::fs::read_to_string(&self.said).unwrap_or_default());
        }
    }
}

/// A study that compares two methods, toggling between them four times in each presentation.
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

/// The same study with a given width of its pictures, in degrees, and with loose rules of validity. A machine that is
/// busy with other work misses frames. They are still counted and compared, but they do not make a presentation
/// invalid.
fn wide(mut study: serde_json::Value, degrees: f64) -> serde_json::Value {
    study["stimuli"]["horizontal_fov_deg"] = degrees.into();
    study["validity"] = serde_json::json!({
        "lost_ms": 60000, "gap_ms": 60000, "toggle_ms": 60000, "duration_percent": 100, "skipped_percent": 100
    });
    study
}

fn journal(lab: &Lab) -> PathBuf {
    lab.journal("p1", "001")
}

/// Runs a whole session on the null compositor, answered as `choice` says, and checks what its journal must say in any
/// study.
///
/// A frame that shows a stimulus has this number of `layers`, which no other screen has.
fn whole_session(study: &serde_json::Value, layers: usize, choice: &dyn Fn(u32, u32) -> u32) -> (Lab, SessionVotes) {
    let lab = Lab::new(study);
    let service = Service::start(Compositor::Null);
    let remote = service.remote();
    let witness = Witness::in_folder(service.folder.path());
    let environment = witness.environment();
    let environment: Vec<(&str, &str)> = environment.iter().map(|(name, value)| (*name, value.as_str())).collect();
    let mut run = Run::start(&service, &lab, &[], &environment);
    let mut participant = Participant::new(&remote, Tail::of(&journal(&lab)), choice);
    assert_eq!(participant.take_part(), Outcome::Completed);
    let (code, said) = run.end();
    assert_eq!(code, 0, "{said}");
    assert!(!said.contains("vulkan validation"), "{said}");
    // Only the median is checked. On a machine that is busy with other work the scheduler sometimes takes the processor
    // away for longer than a frame, and the largest times and the frames "missed by us" include that.
    assert!(number_before(&said, " % of the period (median)") < 20.0, "{said}");
    assert_eq!(witness.complaints(), Vec::<String>::new());

    let entries = Tail::of(&journal(&lab)).all();
    let answers: Vec<(u32, u32, u32)> = entries
        .iter()
        .filter_map(|e| match &e.record {
            Record::Answer(a) => Some((a.presentation, a.attempt, a.choice)),
            _ => None,
        })
        .collect();
    assert_eq!(participant.answered, answers);
    for (presentation, attempt, answer) in &answers {
        assert_eq!(*answer, choice(*presentation, *attempt));
    }
    // The journal must agree, frame by frame, with the log of an independent witness.
    let presentations: Vec<_> =
        entries.iter().filter_map(|e| if let Record::Presentation(p) = &e.record { Some(p) } else { None }).collect();
    let runs = witness.runs(layers);
    assert_eq!(runs.len(), presentations.len(), "{runs:?}");
    let mut clocks = Vec::new();
    for (p, (frames, first, last)) in presentations.iter().zip(&runs) {
        assert!(p.invalid.is_empty(), "{p:?}");
        assert_eq!(p.segments.iter().map(|s| s.frames_shown).sum::<u64>(), *frames, "{p:?}");
        let (begun, ended) = (p.segments[0].first_ns as i64, p.segments[p.segments.len() - 1].last_ns as i64);
        assert_eq!(ended - begun, last - first, "{p:?}");
        // The number of frames in a segment may differ from what was asked for by no more than the missed ones.
        for segment in &p.segments {
            assert!(segment.frames_shown.abs_diff(segment.frames_asked) <= p.missed, "{p:?}");
        }
        clocks.push(first - begun);
    }
    assert!(
        clocks.windows(2).all(|w| w[0] == w[1]),
        "the journal and the witness do not use the same clock: {clocks:?}"
    );
    let votes = collect(&journal(&lab)).unwrap();
    assert_eq!((votes.kind, votes.outcome), (Kind::Real, Some(Outcome::Completed)));
    let display = &votes.header.display;
    assert_eq!((display.kind.as_str(), display.trust, display.nominal_hz), ("openxr", Trust::Predicted, 20.0));
    assert!((display.ipd_m.unwrap() - 0.064).abs() < 1e-5, "{display:?}");
    assert!((display.fov_deg.unwrap()[1][0] - 49.85).abs() < 0.01, "{display:?}");
    (lab, votes)
}

#[test]
fn a_rating_study_with_consent_questions_and_head_poses() {
    if !xr::is_there() {
        return;
    }
    let mut study = wide(rate(&["pica"], 1), 60.0);
    study["consent"] =
        serde_json::json!({"version": "1", "purpose": "a test", "retain_until": "2030-01-01", "text": "Do you agree?"});
    study["questionnaires"] = serde_json::json!(["person"]);
    study["head_poses"] = true.into();
    let choice = |presentation: u32, _: u32| (presentation * 2 + 1) % 5;
    // The layers are the ground and one picture for each eye.
    let (lab, votes) = whole_session(&study, 3, &choice);
    assert_eq!(votes.votes.len(), 2);
    let poses = std::fs::read_to_string(journal(&lab).with_extension("poses.jsonl")).unwrap();
    let seen = poses.lines().filter(|l| l.contains("orientation")).count();
    assert!(seen > 200, "{seen} head poses");
}

#[test]
fn a_comparison_in_stereo_toggles_in_whole_frames() {
    if !xr::is_there() {
        return;
    }
    let choice = |presentation: u32, _: u32| presentation % 3;
    // The layers are the ground, one picture for each eye, and the letter.
    let (_lab, votes) = whole_session(&wide(compare(), 60.0), 4, &choice);
    assert_eq!(votes.votes.len(), 2);
}

#[test]
fn a_mirrored_comparison_is_answered_too() {
    if !xr::is_there() {
        return;
    }
    let mut study = wide(compare(), 60.0);
    study["layout"] = "mirrored-pair".into();
    study["conditions"]["cross"]["reference"] = "path-traced".into();
    study["conditions"]["cross"]["eye"] = serde_json::json!(["left", "right"]);
    let choice = |presentation: u32, _: u32| (presentation + 1) % 3;
    // The layers are the ground, the pair, and the letter.
    let (_lab, votes) = whole_session(&study, 3, &choice);
    assert_eq!(votes.votes.len(), 4);
}

#[test]
fn a_service_killed_in_a_trial_leaves_a_session_that_goes_on() {
    if !xr::is_there() {
        return;
    }
    let lab = Lab::new(&wide(rate(&["pica"], 1), 60.0));
    let mut service = Service::start(Compositor::Null);
    let choice = |_: u32, _: u32| 2;
    {
        let remote = service.remote();
        let mut run = Run::start(&service, &lab, &[], &[]);
        let mut participant = Participant::new(&remote, Tail::of(&journal(&lab)), &choice);
        participant.until(|r| matches!(r, Record::Begin(b) if b.presentation == 1).then_some(()));
        service.kill();
        let (code, said) = run.end();
        assert_eq!(code, 1, "{said}");
        let last = said.lines().rfind(|l| l.starts_with("error: ")).unwrap_or_else(|| panic!("{said}"));
        assert!(last.contains("the OpenXR runtime is gone") && last.contains("--resume"), "{said}");
    }
    service.restart();
    let remote = service.remote();
    let before = Tail::of(&journal(&lab)).all().len();
    assert!(before > 10);
    let mut run = Run::start(&service, &lab, &["--resume", "--yes"], &[]);
    let mut tail = Tail::of(&journal(&lab));
    tail.next("resumed", Duration::from_secs(60), |r| matches!(r, Record::Resume(_)).then_some(()));
    let mut participant = Participant::new(&remote, tail, &choice);
    assert_eq!(participant.take_part(), Outcome::Completed);
    assert_eq!(run.end().0, 0);
    let votes = collect(&journal(&lab)).unwrap();
    assert_eq!((votes.votes.len(), votes.missing.len()), (2, 0));
    let begun: Vec<(u32, u32)> = Tail::of(&journal(&lab))
        .all()
        .iter()
        .filter_map(|e| if let Record::Begin(b) = &e.record { Some((b.presentation, b.attempt)) } else { None })
        .collect();
    assert_eq!(begun, [(0, 0), (1, 0), (1, 1), (2, 0)]);
}

#[test]
fn a_headset_taken_off_pauses_and_the_trial_comes_again() {
    if !xr::is_there() {
        return;
    }
    let mut study = wide(rate(&["pica"], 1), 60.0);
    study["protocol"] = serde_json::json!([{"show": "stimulus", "seconds": 6.0}]);
    study["practice"] = serde_json::json!([]);
    let lab = Lab::new(&study);
    let other = Lab::new(&study);
    let service = Service::start(Compositor::Null);
    let remote = service.remote();
    let mut run = Run::start(&service, &lab, &[], &[]);
    let choice = |_: u32, _: u32| 2;
    let mut participant = Participant::new(&remote, Tail::of(&journal(&lab)), &choice);
    participant.until(|r| matches!(r, Record::Begin(_)).then_some(()));
    // The runtime shows another program instead, as it may show its own menu.
    let mut second = Run::start(&service, &other, &[], &[]);
    let show = |client: &str| {
        let output = service.inside(&["monado-ctl", "-p", client]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    let mut tail = Tail::of(&journal(&other));
    tail.next("the second session", Duration::from_secs(60), |r| matches!(r, Record::Phase(_)).then_some(()));
    let listed = String::from_utf8_lossy(&service.inside(&["monado-ctl"]).output().unwrap().stdout).into_owned();
    eprintln!("{listed}");
    show("2");
    let reason = participant.tail.next("a pause", Duration::from_secs(20), |r| match r {
        Record::Pause(pause) => Some(pause.reason.clone()),
        _ => None,
    });
    assert_eq!(reason, "not-seen");
    second.operator("q");
    assert_eq!(second.end().0, 0);
    show("1");
    participant.press_until_written(None);
    assert_eq!(participant.take_part(), Outcome::Completed);
    assert_eq!(run.end().0, 0);
    let votes = collect(&journal(&lab)).unwrap();
    assert_eq!((votes.votes.len(), votes.missing.len()), (2, 0));
    let interrupted =
        Tail::of(&journal(&lab)).all().iter().filter(|e| matches!(e.record, Record::Interrupted(_))).count();
    assert_eq!(interrupted, 1);
}

#[test]
fn what_is_missing_is_named_in_one_sentence() {
    let lab = Lab::new(&wide(rate(&["pica"], 1), 60.0));
    let args = ["run", "study.json", "--participant", "p1", "--display", "openxr"];
    let one_sentence = |output: std::process::Output, words: &[&str]| {
        let said = lab::stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
        assert!(words.iter().all(|w| said.contains(w)), "{said}");
        assert!(!lab.sessions().exists());
    };
    // This machine has a loader that knows no runtime, or no loader at all.
    let mut here = lab.command(&args);
    here.env("XR_RUNTIME_JSON", "/nowhere/runtime.json").stdin(Stdio::null());
    one_sentence(here.output().unwrap(), &["cyclopean doctor"]);
    if !xr::is_there() {
        return;
    }
    let mut service = Service::start(Compositor::Null);
    service.kill();
    let mut args = args.to_vec();
    args.insert(0, env!("CARGO_BIN_EXE_cyclopean"));
    let mut command = service.inside(&args);
    command.current_dir(lab.dir.path()).stdin(Stdio::null());
    one_sentence(command.output().unwrap(), &["no OpenXR runtime answers", "cyclopean doctor"]);
    // A picture that is wider than the view is refused.
    service.restart();
    let remote = service.remote();
    remote.set(|hands| hands.fov = [-0.4, 0.4, 0.4, -0.4]);
    remote.sent(25);
    let mut command = service.inside(&args);
    command.current_dir(lab.dir.path()).stdin(Stdio::null());
    let output = command.output().unwrap();
    let said = lab::stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("spans 60°") && said.contains("horizontal_fov_deg"), "{said}");
}

/// The number before these words in the line about frames that the program prints at its end.
fn number_before(said: &str, words: &str) -> f64 {
    let line = said.lines().find(|l| l.starts_with("frames: ")).unwrap_or_else(|| panic!("no line on frames: {said}"));
    let (before, _) = line.split_once(words).unwrap_or_else(|| panic!("{words}: {line}"));
    before.rsplit(' ').next().and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{words}: {line}"))
}

/// Takes nearly nine minutes, at the null compositor's 20 frames per second: `cargo test --test all openxr:: -- --ignored`.
#[test]
#[ignore = "takes nine minutes"]
fn ten_thousand_frames_without_a_miss_of_ours() {
    if !xr::is_there() {
        return;
    }
    let mut study = wide(rate(&["pica"], 1), 60.0);
    study["protocol"] = serde_json::json!([{"show": "stimulus", "seconds": 251.0}]);
    study["practice"] = serde_json::json!([]);
    let lab = Lab::new(&study);
    let service = Service::start(Compositor::Null);
    let remote = service.remote();
    let mut run = Run::start(&service, &lab, &[], &[("CYCLOPEAN_VALIDATION", "0")]);
    let choice = |_: u32, _: u32| 2;
    let mut participant = Participant::new(&remote, Tail::of(&journal(&lab)), &choice);
    participant.patience = Duration::from_secs(300);
    assert_eq!(participant.take_part(), Outcome::Completed);
    let (code, said) = run.end();
    assert_eq!(code, 0, "{said}");
    eprintln!("{}", said.lines().find(|l| l.starts_with("frames: ")).unwrap_or_default());
    assert!(number_before(&said, " given to the runtime") >= 10_000.0, "{said}");
    // Only the median is checked, as in `whole_session`.
    assert!(number_before(&said, " % of the period (median)") < 20.0, "{said}");
}

/// Renders stimuli with known marks: squares of eight texels on a grey ground, in a colour that tells the eyes apart.
struct Marks;

const MARKS_PX: (u32, u32) = (480, 360);
/// The centres of the squares, in texels.
const MARKS: [(u32, u32); 5] = [(240, 180), (60, 60), (420, 60), (60, 300), (330, 240)];

/// The frames of a stimulus along a path. The marks move down with each frame.
const FILM: Film = Film { rate_hz: 2.0, frames: 7 };

fn marks(frame: u32) -> [(u32, u32); 5] {
    MARKS.map(|(x, y)| (x, y + 8 * frame))
}

impl StimulusRenderer for Marks {
    fn identity(&self, request: &StimulusRequest) -> anyhow::Result<String> {
        Ok(sha256_hex(serde_json::to_string(request)?.as_bytes()))
    }

    fn render(&mut self, request: &StimulusRequest, into: &Path) -> anyhow::Result<StimulusInfo> {
        let (width, height) = MARKS_PX;
        // The marks are red in the left eye and blue in the right one. They are brighter for `sssr` than for other
        // methods.
        let light = if request.method == "sssr" { 250 } else { 150 };
        let film = request.path.as_ref().map(|_| FILM);
        for frame in 0..film.map_or(1, |film| film.frames) {
            let picture = image::RgbImage::from_fn(2 * width, height, |x, y| {
                let (right, x) = (x >= width, x % width);
                let is_mark = marks(frame).iter().any(|(mx, my)| x.abs_diff(*mx) < 4 && y.abs_diff(*my) < 4);
                match (is_mark, right) {
                    (true, false) => image::Rgb([light, 0, 0]),
                    (true, true) => image::Rgb([0, 0, light]),
                    _ => image::Rgb([70, 70, 70]),
                }
            });
            picture.save(into.join(frame_file(frame)))?;
        }
        exr::prelude::write_rgb_file(into.join("stereo.exr"), 4, 4, |_, _| (0.0_f32, 0.0_f32, 0.0_f32))?;
        let horizontal_fov_deg = request.horizontal_fov_deg;
        let renderer = "marks".to_owned();
        Ok(StimulusInfo { renderer, samples: 1, horizontal_fov_deg, film, ..StimulusInfo::default() })
    }
}

/// A laboratory whose stimuli are those of [`Marks`].
fn marked(study: &serde_json::Value) -> Lab {
    let lab = Lab::new(study);
    std::fs::remove_dir_all(lab.path("store")).unwrap();
    let study = lab.load();
    prepare::prepare(&study.definition, &lab.store(), &mut Marks, Shard::WHOLE, &mut |_, _| Ok(())).unwrap();
    lab
}

/// The tangents of half the field of view of Monado's remote headset in its window: 85° across, with a panel of 65 × 70
/// mm for each eye.
const WINDOW_TAN: (f64, f64) = (0.916_33, 0.986_82);
/// The size in pixels of one eye's half of the window.
const HALF_PX: (f64, f64) = (480.0, 540.0);

/// Lets the headset report the field of view that its window shows.
fn as_the_window(hands: &mut xr::Hands) {
    let (x, y) = (WINDOW_TAN.0.atan() as f32, WINDOW_TAN.1.atan() as f32);
    hands.fov = [-x, x, y, -y];
}

/// The place in the window, in an eye's half, where a direction is seen. The direction is given by its tangents to the
/// right and down.
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

/// Whether a colour is that of a red spot, of any lightness; likewise `blue`.
fn red(c: [u8; 3]) -> bool {
    c[0] > 90 && c[1] < 50 && c[2] < 50
}

fn blue(c: [u8; 3]) -> bool {
    c[2] > 90 && c[0] < 50 && c[1] < 50
}

/// A session that is about to show its stimulus, with a compositor that draws into a window.
struct Shown {
    tail: Tail,
    run: Run,
    remote: xr::Remote,
    _service: Service,
    window: Window,
    lab: Lab,
}

fn eight_seconds() -> serde_json::Value {
    let mut study = wide(rate(&["pica"], 1), 60.0);
    study["protocol"] = serde_json::json!([{"show": "stimulus", "seconds": 8.0}]);
    study["blank"]["seconds"] = 2.0.into();
    study
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
    // The page has a dark button on a grey ground. Before the first frame everything is black.
    let dark_pixels = |p: &image::RgbImage| {
        let half = HALF_PX.0 as u32;
        let views = image::imageops::crop_imm(p, 0, 0, 2 * half, HALF_PX.1 as u32).to_image();
        views.pixels().filter(|p| p.0.iter().all(|c| *c < 60)).count()
    };
    let page = |p: &image::RgbImage| (600..20_000).contains(&dark_pixels(p));
    window.until(&format!("{name}-instructions"), "the button of the instructions", page);
    let all = tail.all().len();
    while tail.all().len() == all {
        remote.trigger();
    }
    window.until(&format!("{name}-blank"), "the blank", |p| dark_pixels(p) < 600);
    Shown { tail, run, remote, _service: service, window, lab }
}

#[test]
fn each_eye_sees_its_own_picture_where_it_belongs() {
    if !xr::is_there() {
        return;
    }
    let study = eight_seconds();
    let mut shown = show(study, "stereo");
    let seen = shown.window.until("stereo-stimulus", "marks before both eyes", |now| {
        !spots(now, red).is_empty() && !spots(now, blue).is_empty()
    });
    assert_spots("left", marks_in_window(0, 0), spots(&seen, red));
    assert_spots("right", marks_in_window(1, 0), spots(&seen, blue));
    let choice = |_: u32, _: u32| 2;
    let mut participant = Participant::new(&shown.remote, shown.tail, &choice);
    participant.until(|r| matches!(r, Record::Presentation(_)).then_some(()));
    // The panel is complete once its buttons, which are lighter than the ground, are shown and two pictures in a row
    // are the same.
    let last = std::cell::RefCell::new(seen);
    let buttons = |p: &image::RgbImage| p.pixels().filter(|p| p.0.iter().all(|c| *c > 150)).count() > 1000;
    let panel = shown.window.until("stereo-panel", "a rating panel that no longer changes", |now| {
        let before = last.replace(now.clone());
        buttons(now) && xr::window::same_view(&before, now)
    });
    // After the head has turned and moved, centring the view must give the same picture again.
    shown.remote.set(|h| {
        h.head = [0.0, 0.3f32.sin(), 0.0, 0.3f32.cos(), 0.4, 1.5, 0.2];
    });
    shown.window.until("stereo-panel-elsewhere", "the view from elsewhere", |now| !xr::window::same_view(&panel, now));
    shown.run.operator("r");
    shown.window.until("stereo-panel-centred", "a centred view that is the same view as before", |now| {
        xr::window::same_view(&panel, now)
    });
}

/// The places in the window where an eye sees the marks of a frame. The frame spans 60° straight ahead of each eye,
/// without a shift by the eye's place in the head.
fn marks_in_window(eye: usize, frame: u32) -> Vec<(f64, f64)> {
    let half = 30f64.to_radians().tan();
    let tan = |(x, y): (u32, u32)| ((f64::from(x) / 240.0 - 1.0) * half, (f64::from(y) / 180.0 - 1.0) * half * 0.75);
    marks(frame).iter().map(|mark| in_window(eye, tan(*mark))).collect()
}

#[test]
fn a_moving_stimulus_plays_before_each_eye_and_its_last_frame_stands() {
    if !xr::is_there() {
        return;
    }
    let mut study = eight_seconds();
    study["conditions"] = serde_json::json!({"list": [{"scene": "pica", "path": "sway", "method": "sssr"}]});
    let shown = show(study, "film");
    let stands = |name: &str, frame: u32| {
        let is_there = |eye: usize, seen: Vec<(f64, f64)>| {
            let expected = marks_in_window(eye, frame);
            let near = |(x, y): &(f64, f64)| seen.iter().any(|s| (s.0 - x).abs() <= 1.0 && (s.1 - y).abs() <= 1.0);
            seen.len() == expected.len() && expected.iter().all(near)
        };
        shown.window.until(name, &format!("frame {frame} before both eyes"), |now| {
            is_there(0, spots(now, red)) && is_there(1, spots(now, blue))
        });
    };
    stands("film-middle", 3);
    stands("film-last", FILM.frames - 1);
    let choice = |_: u32, _: u32| 2;
    let mut participant = Participant::new(&shown.remote, shown.tail, &choice);
    let p = participant.until(|r| if let Record::Presentation(p) = r { Some(p.clone()) } else { None });
    let segment = &p.segments[0];
    assert_eq!(segment.film_onsets_ns.len(), FILM.frames as usize, "{p:?}");
    for (frame, onset) in segment.film_onsets_ns.iter().enumerate() {
        let Some(onset) = onset else { continue };
        let late_ms = (onset - segment.first_ns) as f64 / 1e6 - frame as f64 * 1e3 / FILM.rate_hz;
        assert!((-1.0..p.longest_gap_ms + 5.0).contains(&late_ms), "frame {frame} is {late_ms} ms late: {p:?}");
    }
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
    let light = |now: &image::RgbImage| now.pixels().filter(|p| blue(p.0)).map(|p| p.0[2]).max();
    let seen = shown.window.until("pair-a", "the marks of one method", |now| light(now).is_some());
    let first = light(&seen).expect("marks");
    assert!(spots(&seen, red).is_empty(), "the left eye's image is shown, but the right one's is asked for");
    // The picture of 2 × 480 by 360 texels spans four fifths of 85°, which is 68°, at two metres from eyes 64 mm apart.
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
    // The marks of the two methods differ in their lightness.
    shown.window.until("pair-b", "the marks of the other method", |now| {
        light(now).is_some_and(|second| second.abs_diff(first) > 50)
    });
    drop(shown.lab);
}

/// The two halves of the compositor's window, one for each eye.
fn halves(picture: &image::RgbImage) -> [image::RgbImage; 2] {
    let half = |eye: u32| image::imageops::crop_imm(picture, eye * 480, 0, 480, 540).to_image();
    [half(0), half(1)]
}

#[test]
fn a_scene_is_looked_at_live_and_left_with_the_b_button() {
    if !xr::is_there() {
        return;
    }
    let window = Window::open();
    let service = Service::start(Compositor::Window(window.number));
    let remote = service.remote();
    remote.set(as_the_window);
    let folder = tempfile::tempdir().unwrap();
    let args = ["live", "pica", "--display", "openxr", "--size", "160x180"];
    let mut run = Run::program(&service, folder.path(), &args, &[]);
    // Both halves of the window must show something with different colours.
    let is_drawn = |half: &image::RgbImage| {
        let first = half.get_pixel(240, 270).0;
        half.pixels().filter(|p| p.0.iter().zip(first).any(|(a, b)| a.abs_diff(b) > 20)).count() > 10_000
    };
    let ahead = wait_for("the scene", Duration::from_secs(120), || {
        let picture = window.picture();
        halves(&picture).iter().all(is_drawn).then_some(picture)
    });
    ahead.save(xr::window::kept("live-ahead")).unwrap();
    let [left, right] = halves(&ahead);
    assert!(left != right, "both eyes have the same view");
    remote.set(|h| h.head = [0.0, 0.12f32.sin(), 0.0, 0.12f32.cos(), 0.0, 1.6, 0.0]);
    window.until("live-turned-left", "a picture that follows the head", |turned| {
        ahead.pixels().zip(turned.pixels()).filter(|(a, b)| a != b).count() > 50_000
    });
    remote.set(|h| h.hands[1].b = true);
    let (code, said) = run.end();
    assert_eq!(code, 0, "{said}");
    assert!(said.contains(" frames, ") && !said.contains("vulkan validation"), "{said}");
}

#[test]
fn the_display_test_counts_intervals_and_asks_both_eyes() {
    if !xr::is_there() {
        return;
    }
    let service = Service::start(Compositor::Null);
    let remote = service.remote();
    let folder = tempfile::tempdir().unwrap();
    let args = ["display", "test", "--display", "openxr", "--seconds", "2"];
    let mut run = Run::program(&service, folder.path(), &args, &[]);
    let said = run.said.clone();
    let asked = |question: &str| {
        wait_for(question, Duration::from_secs(60), || {
            std::fs::read_to_string(&said).ok().filter(|said| said.contains(question))
        });
    };
    asked("which word does the open eye see?");
    remote.stick(-1);
    for (at, square) in [3, 2, 4, 1].into_iter().enumerate() {
        asked(&format!("stereogram {} of 4", at + 1));
        run.operator(&square.to_string());
    }
    let (code, said) = run.end();
    assert_eq!(code, 0, "{said}");
    for words in
        ["Hz of 20.00", "each eye sees its own picture", "stereograms: 4 of 4 right", "the runtime's prediction"]
    {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn doctor_names_runtime_and_headset() {
    if !xr::is_there() {
        return;
    }
    let service = Service::start(Compositor::Null);
    let output = service.inside(&[env!("CARGO_BIN_EXE_cyclopean"), "doctor"]).stdin(Stdio::null()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = said.lines().find(|l| l.contains("headset (OpenXR)")).unwrap_or_else(|| panic!("{said}"));
    assert!(line.starts_with("ok") && line.contains("Remote HMD") && line.contains("Monado"), "{line}");
}
