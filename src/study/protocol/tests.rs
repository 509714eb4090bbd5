//! Properties of the machine under any events, at any rate, whether the display steps or skips.

use cyclopean_analysis::journal::record::{
    self as journal, Film, Kind, Outcome, Presentation, Purpose, Record, Shown, Trust,
};
use cyclopean_analysis::journal::{Entry, Verifier};
use proptest::prelude::*;

use super::*;
use crate::display::Display;
use crate::display::headless::Headless;
use crate::study::definition::{CatchTrial, Definition, Questionnaire, Screening};
use crate::study::observer::SimulatedObserver;
use crate::study::plan::Plan;
use crate::study::testing;

/// The refresh rates of the specification: nominal, real.
const RATES: [(f64, f64); 5] = [(72.0, 72.0), (80.0, 80.0), (90.0, 90.0), (120.0, 120.0), (90.0, 89.97)];

/// A study with every stage that there is.
fn everything() -> Definition {
    let mut d = testing::compare(4, 2);
    d.consent = Some(crate::study::definition::ConsentText {
        version: "1".to_owned(),
        purpose: "test".to_owned(),
        retain_until: "2030-01-01".to_owned(),
        text: "?".to_owned(),
    });
    d.questionnaires = vec![Questionnaire::Person, Questionnaire::Ssq];
    d.screening = Some(Screening { disparities_arcsec: vec![600.0, 60.0], required_arcsec: 600.0 });
    d.practice = vec![d.conditions()[0].clone()];
    d.breaks.every_minutes = 1.0;
    let mut same = d.conditions()[1].clone();
    same.other = Some(same.method.clone());
    d.catch_trials = vec![CatchTrial { show: same, passes: vec![2] }];
    d
}

fn machine(d: &Definition, plan: &Plan, nominal_hz: f64) -> Machine {
    Machine::new(Setup::new(d, plan, nominal_hz, Trust::Virtual, 60.0))
}

fn observer(d: &Definition, plan: &Plan, m: &Machine) -> Box<SimulatedObserver> {
    Box::new(SimulatedObserver::new(d, plan, &m.setup().screening, "p01", &[]).unwrap())
}

/// Runs a session to its end; returns every record with its time.
fn drive(mut m: Machine, display: &mut dyn Display) -> Vec<(u64, Record)> {
    let mut out = Vec::new();
    let mut screen = Screen::Blank;
    let (mut unsynced, mut showing) = (false, false);
    let mut perform = |now: u64, actions: Vec<Action>, screen: &mut Screen| {
        for action in actions {
            match action {
                Action::Write(record) => {
                    unsynced |= matches!(record, Record::Answer(_) | Record::Begin(_) | Record::Item(_));
                    showing &= !matches!(record, Record::Presentation(_));
                    out.push((now, record));
                }
                Action::Show(next) => {
                    assert!(!unsynced, "{next:?} appears before the disk has what was said");
                    showing |= matches!(next, Screen::Stimulus { .. });
                    *screen = next;
                }
                Action::Sync => {
                    assert!(!showing, "the disk is waited for while a stimulus stands");
                    unsynced = false;
                }
                Action::Close(_) => {}
            }
        }
    };
    let first = m.start(0);
    perform(0, first, &mut screen);
    display.present(&screen).unwrap();
    while !m.is_over() {
        let timed = display.wait(m.idle_frames()).unwrap();
        let actions = m.handle(timed.now_ns, timed.event);
        perform(timed.now_ns, actions, &mut screen);
        display.present(&screen).unwrap();
    }
    out
}

fn verify(d: &Definition, plan: &Plan, records: &[(u64, Record)]) {
    let mut verifier = Verifier::default();
    let preamble = testing::preamble(d, plan).into_iter().map(|r| (0, r));
    for (seq, (t_ns, record)) in (0..).zip(preamble.chain(records.iter().cloned())) {
        let wall = chrono::DateTime::UNIX_EPOCH;
        verifier.check(&Entry { seq, t_ns, wall, kind: Kind::Simulated, record }).unwrap();
    }
}

fn presentations(records: &[(u64, Record)]) -> Vec<&Presentation> {
    records.iter().filter_map(|(_, r)| if let Record::Presentation(p) = r { Some(p) } else { None }).collect()
}

#[test]
fn skipping_to_the_next_deadline_equals_stepping_every_frame() {
    for d in [everything(), testing::rate(3, 2)] {
        for (nominal, real) in RATES {
            let plan = Plan::draw(&d, 1);
            let run = |steps: bool| {
                let m = machine(&d, &plan, nominal);
                let display = Headless::new(real, 0, observer(&d, &plan, &m)).with_nominal_hz(nominal);
                drive(m, &mut if steps { display.stepping() } else { display })
            };
            let (skipped, stepped) = (run(false), run(true));
            let differs = skipped.iter().zip(&stepped).find(|(a, b)| a != b);
            assert!(differs.is_none(), "{nominal} Hz, really {real}: {differs:?}");
            assert_eq!(skipped.len(), stepped.len());
            verify(&d, &plan, &skipped);
        }
    }
}

#[test]
fn every_phase_has_its_frames_at_every_rate() {
    let d = everything();
    for (nominal, real) in RATES {
        let plan = Plan::draw(&d, 0);
        let m = machine(&d, &plan, nominal);
        let mut display = Headless::new(real, 0, observer(&d, &plan, &m)).with_nominal_hz(nominal);
        let records = drive(m, &mut display);
        let shown = presentations(&records);
        assert_eq!(shown.len(), plan.presentations.len());
        for p in shown {
            let asked: Vec<u64> = d.protocol.iter().map(|s| (s.seconds * nominal).round() as u64).collect();
            assert_eq!(p.segments.iter().map(|s| s.frames_asked).collect::<Vec<_>>(), asked);
            assert_eq!(p.segments.iter().map(|s| s.frames_shown).collect::<Vec<_>>(), asked, "{nominal}/{real}");
            assert_eq!((p.missed, p.unrendered, p.lost_ms), (0, 0, 0.0));
            assert!(p.invalid.is_empty(), "{:?}", p.invalid);
            let seconds: f64 = asked.iter().sum::<u64>() as f64 / real;
            assert!((p.duration_ms / 1e3 - seconds).abs() < 1e-6, "{} {seconds}", p.duration_ms);
        }
        let answers = records.iter().filter(|(_, r)| matches!(r, Record::Answer(a) if a.counts)).count();
        assert_eq!(answers, plan.presentations.len());
        let Some((_, Record::End(end))) = records.last() else { panic!("no end") };
        assert_eq!((end.outcome, end.answered, end.missing), (Outcome::Completed, 8, 0));
    }
}

#[test]
fn the_paper_s_toggles_are_whole_frames_and_halve_the_time() {
    for nominal in [72.0, 80.0, 90.0, 120.0] {
        let mut d = testing::compare(2, 1);
        for (segment, seconds) in d.protocol.iter_mut().zip([2.5, 5.0, 5.0, 5.0, 2.5]) {
            segment.seconds = seconds;
            assert_eq!((seconds * nominal).fract(), 0.0);
        }
        let setup = Setup::new(&d, &Plan::draw(&d, 0), nominal, Trust::Virtual, 60.0);
        let of = |show| setup.segments.iter().filter(|s| s.show == show).map(|s| s.frames).sum::<u64>();
        assert_eq!(of(Shown::A), of(Shown::B));
        assert_eq!(of(Shown::A), (10.0 * nominal) as u64);
    }
}

/// A machine in the middle of its first stimulus, its time, and its period.
fn in_the_first_stimulus(d: &Definition) -> (Machine, u64, u64) {
    let plan = Plan::draw(d, 0);
    let mut m = machine(d, &plan, 100.0);
    let mut now = 0;
    m.start(now);
    m.handle(now, Event::Input(Input::Continue));
    loop {
        now += 10_000_000;
        let actions = m.handle(now, Event::Frame { at_ns: now, rendered: true });
        if actions.iter().any(|a| matches!(a, Action::Show(Screen::Stimulus { .. }))) {
            return (m, now, 10_000_000);
        }
    }
}

fn finish(m: &mut Machine, mut now: u64, period: u64, mut event: impl FnMut(u64) -> Event) -> Presentation {
    for i in 0.. {
        now += period;
        for action in
            m.handle(now, event(i)).into_iter().chain(m.handle(now, Event::Frame { at_ns: now, rendered: true }))
        {
            if let Action::Write(Record::Presentation(p)) = action {
                return p;
            }
        }
    }
    unreachable!()
}

#[test]
fn what_disturbs_a_presentation_makes_it_invalid() {
    let d = testing::rate(2, 1);
    let quiet = |_| Event::Input(Input::Confirm);
    let (mut m, now, period) = in_the_first_stimulus(&d);
    assert!(finish(&mut m, now, period, quiet).invalid.is_empty());
    // 30 frames of 10 ms without focus.
    let (mut m, now, period) = in_the_first_stimulus(&d);
    let p = finish(&mut m, now, period, |i| Event::Focus(!(20..50).contains(&i)));
    assert_eq!((p.lost_ms, p.invalid.len()), (300.0, 1), "{p:?}");
    // 25 frames are exactly the limit, which still counts.
    let (mut m, now, period) = in_the_first_stimulus(&d);
    assert!(finish(&mut m, now, period, |i| Event::Visible(!(20..45).contains(&i))).invalid.is_empty());
    let (mut m, now, period) = in_the_first_stimulus(&d);
    assert_eq!(finish(&mut m, now, period, |_| Event::RefreshRate(72.0)).invalid, ["the refresh rate changed"]);
    // A gap of 110 ms in a presentation of two seconds: only the gap is wrong, the duration is as planned.
    let (mut m, now, period) = in_the_first_stimulus(&d);
    m.handle(now + 11 * period, Event::Frame { at_ns: now + 11 * period, rendered: true });
    let p = finish(&mut m, now + 11 * period, period, quiet);
    assert_eq!((p.missed, p.longest_gap_ms, p.duration_ms), (10, 110.0, 2000.0));
    assert_eq!(p.invalid, ["no frame for 110 ms"]);
    assert_eq!((p.segments[0].frames_asked, p.segments[0].frames_shown), (200, 190));
}

#[test]
fn what_the_operator_repeats_comes_again_as_a_new_attempt_and_notes_are_kept() {
    let d = testing::compare(4, 2);
    let plan = Plan::draw(&d, 0);
    let mut m = machine(&d, &plan, 90.0);
    let mut now = 0;
    m.start(now);
    m.handle(now, Event::Input(Input::Continue));
    for _ in 0..600 {
        now += 11_111_111;
        m.handle(now, Event::Frame { at_ns: now, rendered: true });
    }
    let actions = m.handle(now, Event::Input(Input::Repeat));
    let wrote = |record: &Record| actions.iter().any(|a| matches!(a, Action::Write(r) if r == record));
    let (presentation, reason) = (0, "repeat".to_owned());
    assert!(wrote(&Record::Interrupted(journal::Interrupted { presentation, attempt: 0, reason })), "{actions:?}");
    assert!(wrote(&Record::Begin(journal::Begin { presentation, attempt: 1 })), "{actions:?}");
    let actions = m.handle(now, Event::Input(Input::Note("coughed".to_owned())));
    let note = Record::Note(journal::Note { text: "coughed".to_owned() });
    assert_eq!(actions, [Action::Write(note), Action::Sync]);
}

#[test]
fn an_invalid_trial_comes_again_at_the_end_of_its_block_and_then_is_missing() {
    let mut d = testing::rate(3, 2);
    d.practice.clear();
    let plan = Plan::draw(&d, 0);
    let mut m = machine(&d, &plan, 90.0);
    let display = Headless::new(90.0, 0, observer(&d, &plan, &m));
    // The refresh rate changes whenever presentation 1 is shown.
    struct Disturbed(Headless, Option<Event>);
    impl Display for Disturbed {
        fn info(&self) -> &crate::display::DisplayInfo {
            self.0.info()
        }
        fn load(&mut self, s: &[crate::display::StimulusFiles]) -> Result<(), crate::display::DisplayError> {
            self.0.load(s)
        }
        fn wait(&mut self, idle: u64) -> Result<crate::display::TimedEvent, crate::display::DisplayError> {
            match self.1.take() {
                Some(event) => Ok(crate::display::TimedEvent { now_ns: self.0.now_ns(), event }),
                None => self.0.wait(idle),
            }
        }
        fn present(&mut self, screen: &Screen) -> Result<(), crate::display::DisplayError> {
            let bad = matches!(screen, Screen::Stimulus { presentation: 1, .. });
            self.1 = bad.then_some(Event::RefreshRate(72.0)).filter(|_| self.0.is_new(screen));
            self.0.present(screen)
        }
    }
    assert_eq!(m.idle_frames(), u64::MAX);
    let records = drive(std::mem::replace(&mut m, machine(&d, &plan, 90.0)), &mut Disturbed(display, None));
    verify(&d, &plan, &records);
    let begun: Vec<(u32, u32)> = records
        .iter()
        .filter_map(|(_, r)| if let Record::Begin(b) = r { Some((b.presentation, b.attempt)) } else { None })
        .collect();
    assert_eq!(begun, [(0, 0), (1, 0), (2, 0), (1, 1), (1, 2), (3, 0), (4, 0), (5, 0)]);
    let Some((_, Record::End(end))) = records.last() else { panic!("no end") };
    assert_eq!((end.answered, end.missing), (5, 1));
    assert!(
        records.iter().any(|(_, r)| matches!(r, Record::Missing(m) if m.presentation == 1 && m.reason == "invalid"))
    );
}

#[test]
fn a_headset_taken_off_pauses_the_session_until_somebody_says_to_go_on() {
    let d = testing::rate(2, 1);
    let (mut m, mut now, period) = in_the_first_stimulus(&d);
    let mut step = |m: &mut Machine, n: u64| -> Vec<Action> {
        let frames = (0..n).flat_map(|_| {
            now += period;
            m.handle(now, Event::Frame { at_ns: now, rendered: true })
        });
        frames.collect()
    };
    step(&mut m, 10);
    let taken_off = in_the_first_stimulus(&d).1 + 10 * period;
    assert!(m.handle(taken_off, Event::Visible(false)).is_empty());
    let said = step(&mut m, 150);
    let paused = said.iter().filter(|a| matches!(a, Action::Write(Record::Pause(p)) if p.reason == "not-seen")).count();
    assert_eq!(paused, 1);
    assert!(said.iter().any(|a| matches!(a, Action::Write(Record::Interrupted(_)))));
    assert!(matches!(said.last(), Some(Action::Show(Screen::Page(Page::Paused)))));
    // The headset is put on again: the page waits, and the stimulus comes again as a new attempt.
    assert!(m.handle(taken_off + 2_000_000_000, Event::Visible(true)).is_empty());
    let back = m.handle(taken_off + 2_000_000_000, Event::Input(Input::Continue));
    assert!(back.iter().any(|a| matches!(a, Action::Write(Record::Begin(b)) if b.attempt == 1)), "{back:?}");
    assert!(step(&mut m, 300).iter().any(|a| matches!(a, Action::Show(Screen::Stimulus { attempt: 1, .. }))));
}

#[test]
fn silence_is_reminded_then_paused_and_never_answered() {
    let d = testing::rate(2, 1);
    let (mut m, mut now, period) = in_the_first_stimulus(&d);
    let mut said = Vec::new();
    for _ in 0..20_000 {
        now += period;
        said.extend(m.handle(now, Event::Frame { at_ns: now, rendered: true }).into_iter().map(|a| (now, a)));
    }
    let at = |f: &dyn Fn(&Action) -> bool| said.iter().find(|(_, a)| f(a)).map(|(t, _)| *t).unwrap();
    let opened = at(&|a| matches!(a, Action::Show(Screen::Panel { reminder: false, .. })));
    assert_eq!(at(&|a| matches!(a, Action::Show(Screen::Panel { reminder: true, .. }))) - opened, 30_000_000_000);
    assert_eq!(at(&|a| matches!(a, Action::Write(Record::Pause(_)))) - opened, 120_000_000_000);
    assert!(!said.iter().any(|(_, a)| matches!(a, Action::Write(Record::Answer(_)))));
    // The stimulus was seen as a whole, so the same panel waits after the pause.
    let back = m.handle(now, Event::Input(Input::Continue));
    assert!(back.iter().any(|a| matches!(a, Action::Show(Screen::Panel { attempt: 0, .. }))));
}

fn any_event() -> impl Strategy<Value = (u64, Event)> {
    let input = prop_oneof![
        8 => (0u32..7).prop_map(Input::Choose),
        8 => Just(Input::Confirm),
        6 => Just(Input::Continue),
        1 => Just(Input::Decline),
        2 => any::<bool>().prop_map(|by_operator| Input::Pause { by_operator }),
        2 => Just(Input::Skip),
        2 => Just(Input::Repeat),
        1 => Just(Input::Note("a note".to_owned())),
    ];
    let event = prop_oneof![
        6 => input.prop_map(Event::Input),
        8 => any::<bool>().prop_map(|rendered| Event::Frame { at_ns: 0, rendered }),
        8 => (1u64..800).prop_map(|count| Event::Frames { count, first_ns: 0, last_ns: 0 }),
        1 => any::<bool>().prop_map(Event::Focus),
        1 => any::<bool>().prop_map(Event::Visible),
        1 => (60.0f64..130.0).prop_map(Event::RefreshRate),
    ];
    (prop_oneof![Just(11_111_111u64), 1u64..400_000_000], event)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_events_leave_a_journal_without_contradiction_and_an_end(
        events in prop::collection::vec(any_event(), 0..400),
        last in prop::option::of(prop_oneof![Just(Input::Withdraw), Just(Input::Abandon)]),
    ) {
        let d = everything();
        let plan = Plan::draw(&d, 2);
        let mut m = machine(&d, &plan, 90.0);
        let (mut now, mut records) = (0u64, Vec::new());
        let mut keep = |now: u64, actions: Vec<Action>| {
            records.extend(actions.into_iter().filter_map(|a| if let Action::Write(r) = a { Some((now, r)) } else { None }));
        };
        keep(0, m.start(0));
        for (gap, event) in events {
            now += gap;
            let event = match event {
                Event::Frame { rendered, .. } => Event::Frame { at_ns: now, rendered },
                Event::Frames { count, .. } => {
                    let first_ns = now;
                    now += (count - 1) * 11_111_111;
                    Event::Frames { count, first_ns, last_ns: now }
                }
                other => other,
            };
            keep(now, m.handle(now, event));
        }
        // Then somebody leaves, or a patient participant answers everything.
        if let Some(input) = last {
            keep(now, m.handle(now, Event::Input(input)));
        }
        for event in [Event::Focus(true), Event::Visible(true)] {
            keep(now, m.handle(now, event));
        }
        let mut rounds = 0;
        while !m.is_over() {
            for input in [Input::Continue, Input::Choose(0), Input::Confirm] {
                keep(now, m.handle(now, Event::Input(input)));
            }
            now += 11_111_111;
            keep(now, m.handle(now, Event::Frame { at_ns: now, rendered: true }));
            rounds += 1;
            prop_assert!(rounds < 200_000, "no end");
        }
        verify(&d, &plan, &records);
        let ends = records.iter().filter(|(_, r)| matches!(r, Record::End(_))).count();
        prop_assert_eq!(ends, 1);
        prop_assert!(matches!(records.last(), Some((_, Record::End(_)))));
    }

    #[test]
    fn inputs_do_not_move_a_frame(clicks in prop::collection::vec((0u64..3, 0u32..9), 0..300)) {
        let d = testing::compare(2, 1);
        let run = |clicks: &[(u64, u32)]| {
            let (mut m, mut now, period) = in_the_first_stimulus(&d);
            for i in 0.. {
                let (times, choice) = clicks.get(i).copied().unwrap_or((0, 0));
                for _ in 0..times {
                    assert!(m.handle(now + 1, Event::Input(Input::Choose(choice))).is_empty());
                    assert!(m.handle(now + 2, Event::Input(Input::Confirm)).is_empty());
                }
                now += period;
                for action in m.handle(now, Event::Frame { at_ns: now, rendered: true }) {
                    if let Action::Write(Record::Presentation(p)) = action {
                        return p;
                    }
                }
            }
            unreachable!()
        };
        prop_assert_eq!(run(&clicks), run(&[]));
    }

    #[test]
    fn a_journal_cut_at_any_record_resumes_to_the_same_answers(cut in any::<prop::sample::Index>(), row in 0u64..8) {
        let d = everything();
        let plan = Plan::draw(&d, row);
        let answers = |records: &[(u64, Record)]| -> Vec<(u32, u32)> {
            let mut all: Vec<(u32, u32)> = records.iter().filter_map(|(_, r)| match r {
                Record::Answer(a) if a.counts => Some((a.presentation, a.choice)),
                _ => None,
            }).collect();
            all.sort_unstable();
            all
        };
        let fresh = machine(&d, &plan, 90.0);
        let whole = drive(fresh.clone(), &mut Headless::new(90.0, 0, observer(&d, &plan, &fresh)));
        let cut = cut.index(whole.len() - 1);
        let mut resumed = machine(&d, &plan, 90.0);
        for (_, record) in &whole[..cut] {
            resumed.replay(record).unwrap();
        }
        let start = whole[..cut].last().map_or(0, |(t, _)| *t) + 1;
        let mut records = whole[..cut].to_vec();
        let first = resumed.resume(start);
        records.extend(first.into_iter().filter_map(|a| if let Action::Write(r) = a { Some((start, r)) } else { None }));
        let mut display = Headless::new(90.0, start, observer(&d, &plan, &resumed));
        display.present(&Screen::Page(Page::WelcomeBack)).unwrap();
        while !resumed.is_over() {
            let timed = display.wait(resumed.idle_frames()).unwrap();
            for action in resumed.handle(timed.now_ns, timed.event) {
                match action {
                    Action::Write(r) => records.push((timed.now_ns, r)),
                    Action::Show(screen) => display.present(&screen).unwrap(),
                    _ => {}
                }
            }
        }
        verify(&d, &plan, &records);
        prop_assert_eq!(answers(&records), answers(&whole));
        prop_assert_eq!(plan.presentations.iter().filter(|p| p.purpose == Purpose::Trial).count(), 8);
    }
}

/// A study of one moving stimulus that is shown for two seconds, with its plan and machine.
fn film(film: Film, nominal_hz: f64) -> (Definition, Plan, Machine) {
    let mut d = testing::rate(1, 1);
    d.practice.clear();
    let plan = Plan::draw(&d, 0);
    let m = machine(&d, &plan, nominal_hz).with_films(vec![Some(film); plan.stimuli.len()]);
    (d, plan, m)
}

#[test]
fn every_frame_of_a_film_begins_when_its_rate_says() {
    for (nominal, real, rate) in [(90.0, 90.0, 90.0), (90.0, 90.0, 30.0), (90.0, 89.97, 60.0), (120.0, 120.0, 24.0)] {
        let frames = (rate * 1.5) as u32;
        let (d, plan, m) = film(Film { rate_hz: rate, frames }, nominal);
        let display = Headless::new(real, 0, observer(&d, &plan, &m)).with_nominal_hz(nominal);
        let records = drive(m.clone(), &mut display.stepping());
        verify(&d, &plan, &records);
        let skipping = Headless::new(real, 0, observer(&d, &plan, &m)).with_nominal_hz(nominal);
        assert_eq!(drive(m, &mut { skipping }), records, "{nominal} Hz, a film of {rate}");
        let p = presentations(&records)[0];
        assert!(p.invalid.is_empty(), "{:?}", p.invalid);
        let segment = &p.segments[0];
        assert_eq!((segment.frames_asked, segment.frames_shown), ((2.0 * nominal) as u64, (2.0 * nominal) as u64));
        assert_eq!(segment.film_onsets_ns.len(), frames as usize);
        for (frame, onset) in segment.film_onsets_ns.iter().enumerate() {
            // The first display frame at or after its time. On a display that is a little slow, all of them are shown
            // later.
            let due = (frame as f64 * nominal / rate - 1e-6).ceil() / real * 1e9;
            let at = (onset.expect("each was displayed") - segment.first_ns) as f64;
            assert!((at - due).abs() < 2.0, "{nominal} Hz, frame {frame} of a film of {rate}: {at} instead of {due}");
        }
    }
}

/// Shows display frames at 90 Hz until the stimulus is over, but not those whose number (from the stimulus's first) is
/// in `missed`. Returns what was shown in each, and the record.
fn show_film(missed: std::ops::Range<u64>, rate_hz: f64) -> (Vec<(u64, u32)>, Presentation) {
    let (_, _, mut m) = film(Film { rate_hz, frames: 1000 }, 90.0);
    let (mut now, period) = (0, 11_111_111);
    m.start(0);
    let (mut shown, mut first, mut screen) = (Vec::new(), None, Screen::Blank);
    m.handle(0, Event::Input(Input::Continue));
    loop {
        now += period;
        let number = first.map(|first: u64| (now - first) / period);
        if number.is_some_and(|n| missed.contains(&n)) {
            continue;
        }
        for action in m.handle(now, Event::Frame { at_ns: now, rendered: true }) {
            match action {
                Action::Write(Record::Presentation(p)) => return (shown, p),
                Action::Show(next) => screen = next,
                _ => {}
            }
        }
        if let Screen::Stimulus { frame, .. } = screen {
            let first = *first.get_or_insert(now);
            shown.push(((now - first) / period, frame));
        }
    }
}

#[test]
fn a_film_goes_on_in_time_when_the_display_misses_frames() {
    let (shown, p) = show_film(50..54, 90.0);
    // The frame that is shown follows from the time alone.
    assert!(shown.iter().all(|(number, frame)| u64::from(*frame) == *number), "{shown:?}");
    let onsets = &p.segments[0].film_onsets_ns;
    let never: Vec<usize> = (0..onsets.len()).filter(|i| onsets[*i].is_none()).collect();
    assert_eq!((onsets.len(), never), (180, vec![50, 51, 52, 53]));
    // 4 of 180 are 2.2 %, more than the two percent that a study accepts by default.
    assert_eq!(p.invalid, ["4 of 180 frames of the moving stimulus were never displayed"]);
    let (_, p) = show_film(50..53, 90.0);
    assert!(p.invalid.is_empty(), "{:?}", p.invalid);
    // A film of half the rate loses two of its ninety frames.
    let (_, p) = show_film(50..54, 45.0);
    let onsets = &p.segments[0].film_onsets_ns;
    assert_eq!((onsets.len(), onsets.iter().filter(|o| o.is_none()).count()), (90, 2));
}

#[test]
fn the_last_frame_of_a_film_stands_and_each_segment_begins_it_anew() {
    let mut d = testing::compare(2, 1);
    d.practice.clear();
    let plan = Plan::draw(&d, 0);
    let films = vec![Some(Film { rate_hz: 30.0, frames: 45 }); plan.stimuli.len()];
    let m = machine(&d, &plan, 90.0).with_films(films);
    let display = Headless::new(90.0, 0, observer(&d, &plan, &m));
    let records = drive(m, &mut { display });
    for p in presentations(&records) {
        assert!(p.invalid.is_empty(), "{:?}", p.invalid);
        for segment in &p.segments {
            // 1.25 seconds have 38 frames, 2.5 seconds all 45.
            let held = if segment.frames_asked < 200 { 38 } else { 45 };
            assert_eq!(segment.film_onsets_ns.len(), held);
            assert_eq!(segment.film_onsets_ns[0], Some(segment.first_ns));
        }
    }
}
