//! Tests head poses: they are kept only if the study asks for them, lie in a file of their own, and are deleted with
//! the participant's data. Needs no GPU.

use std::path::{Path, PathBuf};

use cyclopean::display::headless::Headless;
use cyclopean::display::{Display, DisplayError, DisplayInfo, HeadPose, StimulusFiles, TimedEvent};
use cyclopean::study::disk::Disk;
use cyclopean::study::observer::{Observer, SimulatedObserver};
use cyclopean::study::poses::{PoseLine, path_beside};
use cyclopean::study::protocol::{Event, Input, Page, Screen};
use cyclopean::study::session::{Options, Session, SessionEnd, SessionError};
use cyclopean::study::sessions::Sessions;
use cyclopean_analysis::data::{Source, expand};
use cyclopean_analysis::journal::record::{Kind, Outcome, Record};
use cyclopean_analysis::journal::{self, collect};
use serde_json::{Value, json};

use crate::lab::{Lab, rate};

/// A display that tracks the head. It gives a pose for each event, while a headset gives one for each frame.
struct Headset {
    inner: Headless,
    info: DisplayInfo,
    poses: Vec<HeadPose>,
}

fn information() -> DisplayInfo {
    DisplayInfo { kind: "test".to_owned(), tracks_head: true, ..Headless::information(90.0) }
}

impl Display for Headset {
    fn info(&self) -> &DisplayInfo {
        &self.info
    }

    fn load(&mut self, stimuli: &[StimulusFiles]) -> Result<(), DisplayError> {
        self.inner.load(stimuli)
    }

    fn wait(&mut self, idle_frames: u64) -> Result<TimedEvent, DisplayError> {
        let timed = self.inner.wait(idle_frames)?;
        if let Event::Frame { at_ns, .. } | Event::Frames { last_ns: at_ns, .. } = timed.event {
            let lost = HeadPose { t_ns: at_ns, position: [f32::NAN; 3], orientation: [0.0; 4] };
            let pose = HeadPose { t_ns: at_ns, position: [0.25, 1.5, -0.125], orientation: [0.0, 0.0, 0.0, 1.0] };
            self.poses.extend([lost, pose]);
        }
        Ok(timed)
    }

    fn present(&mut self, screen: &Screen) -> Result<(), DisplayError> {
        self.inner.present(screen)
    }

    fn take_poses(&mut self) -> Vec<HeadPose> {
        std::mem::take(&mut self.poses)
    }
}

/// An observer who gives `input` on the screen `at`, and otherwise answers like the simulated observer.
struct Acts {
    calm: SimulatedObserver,
    at: Option<Screen>,
    input: Input,
}

impl Observer for Acts {
    fn respond(&mut self, screen: &Screen) -> Vec<(u64, Input)> {
        match &self.at {
            Some(at) if at == screen => vec![(1_000_000_000, self.input.clone())],
            _ => self.calm.respond(screen),
        }
    }
}

fn sit(lab: &Lab, disk: Disk, at: Option<Screen>, input: Input) -> Result<SessionEnd, SessionError> {
    let study = lab.load();
    let (info, options) = (information(), Options { disk, ..Options::new(Kind::Pilot) });
    let (store, sessions) = (lab.store(), lab.sessions());
    let session = match Sessions::new(Disk::real(), &sessions, "rate").unfinished("p01") {
        Ok(_) => Session::resume(&study, &store, &sessions, "p01", &info, &options)?,
        Err(_) => Session::begin(&study, &store, &sessions, "p01", &info, &options)?,
    };
    let calm = session.simulated_observer(&study)?;
    let inner = Headless::new(90.0, session.start_ns(), Box::new(Acts { calm, at, input }));
    session.run(&mut Headset { inner, info, poses: Vec::new() })
}

fn study(head_poses: bool) -> Value {
    let mut study = rate(&["pica"], 1);
    if head_poses {
        study["head_poses"] = json!(true);
    }
    study["consent"] = json!({"version": "1", "purpose": "a test", "retain_until": "2030-01-01", "text": "Agreed?"});
    study
}

fn lines(path: &Path) -> Vec<PoseLine> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn times(path: &Path) -> Vec<u64> {
    lines(path).iter().filter_map(|l| if let PoseLine::Pose(p) = l { Some(p.t_ns) } else { None }).collect()
}

fn beside(lab: &Lab) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(lab.sessions().join("rate/p01")).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    files
}

fn panel(presentation: u32) -> Screen {
    Screen::Panel { presentation, attempt: 0, chosen: None, reminder: false }
}

#[test]
fn nothing_is_kept_unless_the_study_says_so_and_the_display_knows() {
    let lab = Lab::new(&study(false));
    let ended = sit(&lab, Disk::real(), None, Input::Quit).unwrap();
    assert_eq!(beside(&lab), std::slice::from_ref(&ended.journal));
    assert_eq!(collect(&ended.journal).unwrap().header.poses, None);
    // This study asks for poses, but its display does not track the head.
    let lab = Lab::new(&study(true));
    assert!(lab.simulate("p01", &[]).status.success());
    assert_eq!(beside(&lab), [lab.journal("p01", "001")]);
    assert_eq!(collect(&lab.journal("p01", "001")).unwrap().header.poses, None);
}

#[test]
fn poses_have_a_file_of_their_own_that_the_journal_names_and_the_analysis_passes_over() {
    let lab = Lab::new(&study(true));
    let ended = sit(&lab, Disk::real(), None, Input::Quit).unwrap();
    let poses = path_beside(&ended.journal);
    assert_eq!(beside(&lab), [ended.journal.clone(), poses.clone()]);
    assert_eq!(collect(&ended.journal).unwrap().header.poses.as_deref(), Some("001.poses.jsonl"));
    let text = std::fs::read_to_string(&ended.journal).unwrap();
    assert!(!text.contains("\"pose\"") && !text.contains("orientation"));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        assert_eq!(std::fs::metadata(&poses).unwrap().permissions().mode() & 0o777, 0o600);
    }
    let all = lines(&poses);
    assert_eq!(all[0], PoseLine::HeadPoses { format: 1, study: "rate".to_owned(), session: "001".to_owned() });
    let expected = HeadPose { t_ns: 0, position: [0.25, 1.5, -0.125], orientation: [0.0, 0.0, 0.0, 1.0] };
    for line in &all[1..] {
        let PoseLine::Pose(pose) = line else { panic!("{line:?}") };
        assert_eq!(HeadPose { t_ns: 0, ..*pose }, expected);
    }
    let times = times(&poses);
    assert!(times.len() > 10 && times.is_sorted(), "{}", times.len());
    // There must be no pose from before the consent.
    let phase = |name: &str| {
        let is = |r: &Record| matches!(r, Record::Phase(p) if p.phase == name);
        journal::read(&ended.journal).unwrap().map(Result::unwrap).find(|e| is(&e.record)).unwrap().t_ns
    };
    assert!(times[0] >= phase("instructions") && phase("instructions") > phase("consent"));
    assert_eq!(expand(&[lab.sessions()]).unwrap(), [Source::Journals(vec![ended.journal])]);
    // A lost list of rows is made again from the journals, and not from the poses.
    std::fs::remove_file(lab.sessions().join("rate/rows.json")).unwrap();
    let again = sit(&lab, Disk::real(), None, Input::Quit).unwrap_err().to_string();
    assert!(again.contains("has completed this study in session 001"), "{again}");
}

#[test]
fn no_poses_are_kept_of_people_who_decline_or_withdraw() {
    let lab = Lab::new(&study(true));
    let consent = Some(Screen::Page(Page::Consent));
    let ended = sit(&lab, Disk::real(), consent, Input::Decline).unwrap();
    assert_eq!((ended.outcome, lines(&path_beside(&ended.journal)).len()), (Some(Outcome::Declined), 1));
    let ended = sit(&lab, Disk::real(), Some(panel(1)), Input::Withdraw).unwrap();
    assert_eq!((ended.outcome, ended.session.as_str()), (Some(Outcome::Withdrawn), "002"));
    let names: Vec<_> = ended.deleted.iter().map(|p| p.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names, ["001.jsonl", "001.poses.jsonl", "002.jsonl", "002.poses.jsonl"]);
    assert!(!lab.sessions().join("rate/p01").exists());

    sit(&lab, Disk::real(), None, Input::Quit).unwrap();
    let output = lab.program(&["study", "withdraw", "study.json", "--participant", "p01"]);
    assert!(String::from_utf8_lossy(&output.stdout).contains("001.poses.jsonl"), "{output:?}");
    assert!(!lab.sessions().join("rate/p01").exists());
}

#[test]
fn a_resumed_session_goes_on_in_the_same_file() {
    let lab = Lab::new(&study(true));
    let ended = sit(&lab, Disk::real(), Some(panel(1)), Input::Quit).unwrap();
    let poses = path_beside(&ended.journal);
    let before = times(&poses).len();
    // A kill may leave a torn last line.
    let mut torn = std::fs::read(&poses).unwrap();
    torn.extend_from_slice(b"{\"pose\":{\"t_n");
    std::fs::write(&poses, torn).unwrap();
    let ended = sit(&lab, Disk::real(), None, Input::Quit).unwrap();
    assert_eq!(ended.outcome, Some(Outcome::Completed));
    let resumed = lines(&poses).iter().filter(|l| matches!(l, PoseLine::Resume { .. })).count();
    assert_eq!(resumed, 1);
    assert!(times(&poses).len() > before && times(&poses).is_sorted());
}

#[test]
fn stopped_at_any_step_a_session_with_poses_goes_on_and_no_answer_is_lost() {
    let lab = Lab::in_memory(&study(true));
    let mut stops = 0;
    for step in 0.. {
        let _ = std::fs::remove_dir_all(lab.sessions());
        let disk = Disk::failing_after(step);
        let first = sit(&lab, disk.clone(), None, Input::Quit);
        if !disk.has_failed() {
            assert!(first.is_ok());
            break;
        }
        stops += 1;
        let said = first.unwrap_err().to_string();
        let ended = match sit(&lab, Disk::real(), None, Input::Quit) {
            Ok(ended) => ended,
            // The session was already complete when the failing step stopped it.
            Err(error) if error.to_string().contains("has completed this study") => continue,
            Err(error) => panic!("step {step} ({said}): {error}"),
        };
        let votes = collect(&ended.journal).unwrap();
        assert_eq!((votes.outcome, votes.votes.len()), (Some(Outcome::Completed), 2), "step {step}: {said}");
        assert!(!times(&path_beside(&ended.journal)).is_empty(), "step {step}: {said}");
    }
    assert!(stops > 60, "{stops}");
}
