//! Tests what people can do in a session beside answering: pause, skip, decline, quit, withdraw and change a choice. A
//! simulated person acts through the same interface as a real one. The expected records are written out here. Needs no
//! GPU.

use cyclopean::display::headless::Headless;
use cyclopean::study::observer::{Observer, SimulatedObserver};
use cyclopean::study::protocol::{Input, Page, Screen};
use cyclopean::study::session::{Options, Session, SessionEnd};
use cyclopean_analysis::journal::record::{Kind, Outcome, Record};
use cyclopean_analysis::journal::{self, collect};

use crate::lab::{Lab, rate, stderr};

/// An observer who does what `acts` says for a screen, and otherwise answers like the simulated observer.
struct Person<F> {
    calm: SimulatedObserver,
    acts: F,
}

impl<F: FnMut(&Screen) -> Option<Vec<(u64, Input)>>> Observer for Person<F> {
    fn respond(&mut self, screen: &Screen) -> Vec<(u64, Input)> {
        (self.acts)(screen).unwrap_or_else(|| self.calm.respond(screen))
    }
}

fn sit(lab: &Lab, resume: bool, acts: impl FnMut(&Screen) -> Option<Vec<(u64, Input)>> + 'static) -> SessionEnd {
    let study = lab.load();
    let (info, options) = (Headless::information(90.0), Options::new(Kind::Pilot));
    let (store, sessions) = (lab.store(), lab.sessions());
    let session = if resume {
        Session::resume(&study, &store, &sessions, "p01", &info, &options).unwrap()
    } else {
        Session::begin(&study, &store, &sessions, "p01", &info, &options).unwrap()
    };
    let calm = session.simulated_observer(&study).unwrap();
    let mut display = Headless::new(90.0, session.start_ns(), Box::new(Person { calm, acts }));
    session.run(&mut display).unwrap()
}

/// Acts once, on the first screen that fits.
fn once(
    fits: impl Fn(&Screen) -> bool + 'static,
    inputs: Vec<(u64, Input)>,
) -> impl FnMut(&Screen) -> Option<Vec<(u64, Input)>> + 'static {
    let mut inputs = Some(inputs);
    move |screen| if fits(screen) { inputs.take() } else { None }
}

fn records(ended: &SessionEnd) -> Vec<Record> {
    journal::read(&ended.journal).unwrap().map(|e| e.unwrap().record).collect()
}

fn is_stimulus(screen: &Screen, at: u32) -> bool {
    matches!(screen, Screen::Stimulus { presentation, .. } if *presentation == at)
}

fn is_panel(screen: &Screen, at: u32) -> bool {
    matches!(screen, Screen::Panel { presentation, .. } if *presentation == at)
}

#[test]
fn a_pause_during_the_stimulus_shows_it_again_as_a_new_attempt() {
    let lab = Lab::new(&rate(&["pica", "room"], 1));
    let pause = vec![(500_000_000, Input::Pause { by_operator: true })];
    let ended = sit(&lab, false, once(|s| is_stimulus(s, 2), pause));
    let begun: Vec<(u32, u32)> = records(&ended)
        .iter()
        .filter_map(|r| if let Record::Begin(b) = r { Some((b.presentation, b.attempt)) } else { None })
        .collect();
    assert_eq!(begun, [(0, 0), (1, 0), (2, 0), (2, 1), (3, 0), (4, 0)]);
    let votes = collect(&ended.journal).unwrap();
    assert_eq!((votes.outcome, votes.votes.len()), (Some(Outcome::Completed), 4));
    assert_eq!(votes.votes[1].attempt, 1);
}

#[test]
fn what_is_skipped_is_missing_and_nothing_else_is() {
    let lab = Lab::new(&rate(&["pica", "room"], 1));
    let ended = sit(&lab, false, once(|s| is_panel(s, 3), vec![(1, Input::Skip)]));
    let votes = collect(&ended.journal).unwrap();
    assert_eq!(votes.missing, [(3, "skipped".to_owned())]);
    assert_eq!(votes.votes.iter().map(|v| v.presentation).collect::<Vec<_>>(), [1, 2, 4]);
    let Some(Record::End(end)) = records(&ended).pop() else { panic!("no end") };
    assert_eq!((end.answered, end.missing), (3, 1));
}

#[test]
fn who_quits_can_go_on_and_who_gives_up_cannot() {
    let lab = Lab::new(&rate(&["pica", "room"], 1));
    let ended = sit(&lab, false, once(|s| is_stimulus(s, 3), vec![(1, Input::Quit)]));
    assert_eq!(ended.outcome, None);
    let fresh = lab.simulate("p01", &[]);
    assert!(stderr(&fresh).contains("has an unfinished session 001"), "{}", stderr(&fresh));
    let silent = lab.simulate("p01", &["--resume"]);
    assert_eq!(silent.status.code(), Some(2), "{}", stderr(&silent));
    let ended = sit(&lab, true, |_| None);
    assert_eq!(ended.outcome, Some(Outcome::Completed));
    assert_eq!(collect(&ended.journal).unwrap().votes.len(), 4);

    let lab = Lab::new(&rate(&["pica", "room"], 1));
    sit(&lab, false, once(|s| is_stimulus(s, 3), vec![(1, Input::Quit)]));
    let abandoned = lab.program(&["study", "abandon", "study.json", "--participant", "p01"]);
    assert!(abandoned.status.success(), "{}", stderr(&abandoned));
    let again = sit(&lab, false, |_| None);
    assert_eq!((again.session.as_str(), again.row), ("002", 0));
}

#[test]
fn nothing_is_kept_of_a_participant_who_withdraws() {
    let lab = Lab::new(&rate(&["pica", "room"], 1));
    let ended = sit(&lab, false, once(|s| is_panel(s, 2), vec![(1, Input::Withdraw)]));
    assert_eq!(ended.outcome, Some(Outcome::Withdrawn));
    assert_eq!(ended.deleted, std::slice::from_ref(&ended.journal));
    assert!(!ended.journal.parent().unwrap().exists());
    let rows = std::fs::read_to_string(lab.sessions().join("rate/rows.json")).unwrap();
    assert!(!rows.contains("p01"), "{rows}");
}

#[test]
fn without_consent_or_stereo_vision_nothing_is_shown_and_the_row_is_free() {
    let mut study = rate(&["pica"], 1);
    study["consent"] = serde_json::json!({
        "version": "1", "purpose": "a test", "retain_until": "2030-01-01", "text": "Do you agree?"
    });
    study["screening"] = serde_json::json!({"disparities_arcsec": [600, 300], "required_arcsec": 300});
    let lab = Lab::new(&study);
    let decline = once(|s| *s == Screen::Page(Page::Consent), vec![(1, Input::Decline)]);
    let ended = sit(&lab, false, decline);
    assert_eq!(ended.outcome, Some(Outcome::Declined));
    assert!(!records(&ended).iter().any(|r| matches!(r, Record::Begin(_))));
    // Somebody who always chooses the same square is right in about a quarter of the trials, and never in seven of ten.
    let blind = |s: &Screen| if let Screen::Dots(_) = s { Some(vec![(1, Input::Choose(0))]) } else { None };
    let ended = sit(&lab, false, blind);
    assert_eq!((ended.outcome, ended.row), (Some(Outcome::Screened), 0));
    assert_eq!(records(&ended).iter().filter(|r| matches!(r, Record::Screening(_))).count(), 20);
    assert!(!records(&ended).iter().any(|r| matches!(r, Record::Begin(_))));
    let ended = sit(&lab, false, |_| None);
    assert_eq!((ended.outcome, ended.row), (Some(Outcome::Completed), 0));
}

#[test]
fn a_choice_can_be_changed_until_it_is_confirmed_and_each_change_is_kept() {
    let lab = Lab::new(&rate(&["pica"], 1));
    let mut step = 0;
    let undecided = move |s: &Screen| {
        let Screen::Panel { presentation: 1, .. } = s else { return None };
        step += 1;
        Some(vec![(
            1_000_000_000,
            [Input::Choose(4), Input::Choose(0), Input::Choose(2), Input::Confirm][step - 1].clone(),
        )])
    };
    let ended = sit(&lab, false, undecided);
    let of = |r: &Record| match r {
        Record::Change(c) if c.presentation == 1 => Some((c.choice, c.after_ns / 1_000_000_000)),
        _ => None,
    };
    let changes: Vec<(u32, u64)> = records(&ended).iter().filter_map(of).collect();
    assert_eq!(changes, [(4, 1), (0, 2), (2, 3)]);
    let vote = &collect(&ended.journal).unwrap().votes[0];
    assert_eq!((vote.presentation, vote.rating, vote.after_ns / 1_000_000_000), (1, 3, 4));
}
