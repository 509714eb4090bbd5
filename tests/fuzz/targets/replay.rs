//! The target for sessions. Whatever a display and the people do, and however often the program is killed, the session
//! must write a journal that can be read and that fits its study.
//!
//! The bytes are a study file, a zero byte, and then a row, a rate and events.

use cyclopean::study::plan::Plan;
use cyclopean::study::protocol::{Action, Event, Input, Machine, Setup};
use cyclopean::study::session::prove_order;
use cyclopean::study::show::RecordedSession;
use cyclopean::study::validate::{self, Study};
use cyclopean_analysis::inspect::inspect;
use cyclopean_analysis::journal::record::{Film, Ready, Record, Resume, Trust};
use cyclopean_analysis::journal::{self, Entry, Kind, Verifier, collect};
use serde_json::{Value, json};

/// Sessions with more presentations are left out, because they take long and find nothing more.
const MOST_PRESENTATIONS: usize = 64;
const RATES_HZ: [f64; 6] = [60.0, 72.0, 89.97, 120.0, 1000.0, 1.0];

pub fn run(bytes: &[u8]) {
    journal_of(bytes);
}

/// The journal of the session that these bytes describe, or `None` if their study is not valid or too long.
pub fn journal_of(bytes: &[u8]) -> Option<Vec<u8>> {
    let end = bytes.iter().position(|b| *b == 0)?;
    let text = String::from_utf8(bytes[..end].to_vec()).ok()?;
    let study = validate::parse("study.json".as_ref(), text).ok()?;
    let mut bytes = bytes[end + 1..].iter().copied();
    let row = u64::from_le_bytes(std::array::from_fn(|_| bytes.next().unwrap_or(0)));
    let mut next = || bytes.next();
    let rate_hz = RATES_HZ[usize::from(next().unwrap_or(0)) % RATES_HZ.len()];
    let plan = Plan::draw(&study.definition, row);
    if plan.presentations.len() > MOST_PRESENTATIONS {
        return None;
    }
    let film = next().filter(|n| *n > 127).map(|n| Film { rate_hz: 30.0, frames: u32::from(n - 127) });
    let mut session = Session::begin(&study, &plan, rate_hz, film);
    while let Some(what) = next() {
        session.event(what, next().unwrap_or(0));
        if session.machine.is_over() {
            break;
        }
    }
    Some(session.judge())
}

struct Session<'a> {
    study: &'a Study,
    plan: &'a Plan,
    rate_hz: f64,
    film: Option<Film>,
    machine: Machine,
    now_ns: u64,
    entries: Vec<Entry>,
    verifier: Verifier,
}

impl<'a> Session<'a> {
    fn begin(study: &'a Study, plan: &'a Plan, rate_hz: f64, film: Option<Film>) -> Session<'a> {
        let machine = machine(study, plan, rate_hz, film);
        let (entries, verifier) = (Vec::new(), Verifier::default());
        let mut session = Session { study, plan, rate_hz, film, machine, now_ns: 0, entries, verifier };
        let mut preamble: Vec<Value> = vec![json!({ "header": header(study, plan, rate_hz) })];
        preamble.extend(plan.stimuli.iter().enumerate().map(|(id, request)| {
            let (scene, method) = (&request.scene, &request.method);
            json!({ "stimulus": {
                "id": id, "key": "k", "scene": scene, "view": "default", "method": method, "files": {}, "film": film,
            } })
        }));
        preamble.extend(plan.conditions.iter().map(|c| json!({ "condition": c })));
        preamble.push(json!({ "order": plan.order }));
        preamble.extend(plan.presentations.iter().map(|p| json!({ "planned": p })));
        for record in preamble {
            session.write(serde_json::from_value(record).expect("a record"));
        }
        session.write(Record::Ready(Ready { lines: session.entries.len() as u64 }));
        let first = session.machine.start(0);
        session.perform(first);
        session
    }

    fn write(&mut self, record: Record) {
        let (seq, wall) = (self.entries.len() as u64, Default::default());
        let entry = Entry { seq, t_ns: self.now_ns, wall, kind: Kind::Simulated, record };
        if let Err(error) = self.verifier.check(&entry) {
            panic!("a session wrote an entry that contradicts its journal: {error}: {entry:?}");
        }
        self.entries.push(entry);
    }

    /// Performs the actions. Returns whether the program goes on after them.
    fn perform(&mut self, actions: Vec<Action>) -> bool {
        let mut goes_on = true;
        for action in actions {
            match action {
                Action::Write(record) => self.write(record),
                Action::Close(_) => goes_on = false,
                Action::Sync | Action::Show(_) => {}
            }
        }
        goes_on
    }

    fn event(&mut self, what: u8, more: u8) {
        let period_ns = (1e9 / self.rate_hz) as u64;
        let input = |input: Input| Some(Event::Input(input));
        let event = match what % 18 {
            0 => self.frames(1, period_ns, true),
            1 => self.frames(1, period_ns, false),
            2 => self.frames(u64::from(more).min(self.machine.idle_frames()), period_ns, true),
            // All frames until something changes by itself, however many, such as to the end of a segment.
            3 => self.frames(self.machine.idle_frames().min(1 << 20), period_ns, true),
            // One frame that is up to a minute late.
            4 => self.frames(1, period_ns + u64::from(more) * 250_000_000, true),
            5 => Some(Event::Focus(more % 2 == 1)),
            6 => Some(Event::Visible(more % 2 == 1)),
            7 => Some(Event::RefreshRate(f64::from(more))),
            8 | 9 => input(Input::Choose(u32::from(more))),
            10 => input(Input::Confirm),
            11 => input(Input::Continue),
            12 => input(Input::Decline),
            13 => input(Input::Pause { by_operator: more % 2 == 1 }),
            14 => input(Input::Skip),
            15 => input(Input::Repeat),
            16 => input(Input::Note("seen".to_owned())),
            _ => match more % 8 {
                0 => input(Input::Withdraw),
                1 => input(Input::Abandon),
                2..=4 => input(Input::Quit),
                _ => None,
            },
        };
        let goes_on = match event {
            Some(event) => {
                let actions = self.machine.handle(self.now_ns, event);
                self.perform(actions)
            }
            // The program is killed.
            None => false,
        };
        if !goes_on && !self.ended() {
            self.resume();
        }
    }

    fn frames(&mut self, count: u64, after_ns: u64, rendered: bool) -> Option<Event> {
        let first_ns = self.now_ns + after_ns;
        if count <= 1 {
            self.now_ns = first_ns;
            return Some(Event::Frame { at_ns: first_ns, rendered });
        }
        let last_ns = first_ns + (count as f64 * 1e9 / self.rate_hz) as u64;
        self.now_ns = last_ns;
        Some(Event::Frames { count, first_ns, last_ns })
    }

    fn ended(&self) -> bool {
        matches!(self.entries.last().map(|e| &e.record), Some(Record::End(_)))
    }

    /// Resumes the session as the program does, by replaying the journal in a new state machine.
    fn resume(&mut self) {
        self.machine = machine(self.study, self.plan, self.rate_hz, self.film);
        let ready = self.entries.iter().position(|e| matches!(e.record, Record::Ready(_))).expect("a ready record");
        for entry in &self.entries[ready + 1..] {
            self.machine.replay(&entry.record).expect("a session's own journal can be replayed");
        }
        self.now_ns += 1;
        let program = cyclopean::study::session::program();
        self.write(Record::Resume(Resume { gap_ms: 0, cut_bytes: 0, program }));
        let first = self.machine.resume(self.now_ns);
        self.perform(first);
    }

    /// Checks that the journal can be read, has a proven order, can be shown, and gives as many votes as it should.
    fn judge(self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for entry in &self.entries {
            journal::encode(entry, &mut bytes).expect("numbers");
        }
        let path = super::file("session.jsonl", &bytes);
        let read: Vec<Entry> = journal::read(&path).expect("a file").collect::<Result<_, _>>().expect("a journal");
        assert_eq!(read, self.entries, "the journal changed when it was written and read again");
        let proof = prove_order(&path).expect("the order follows from the study and the row");
        assert_eq!(proof.sha256, self.plan.order.sha256);
        let seen = RecordedSession::read(&path).expect("a session that can be shown");
        assert_eq!(seen.presentations.len(), count(&read, |r| matches!(r, Record::Presentation(_))));
        let votes = collect(&path).expect("votes");
        let practice = |p: u32| self.plan.presentations[p as usize].purpose == journal::record::Purpose::Practice;
        let counts = |r: &Record| matches!(r, Record::Answer(a) if a.counts && !practice(a.presentation));
        assert_eq!(votes.votes.len(), count(&read, counts), "not every answer that counts is a vote");
        assert_eq!(inspect(&path).error, None);
        bytes
    }
}

fn count(entries: &[Entry], is: impl Fn(&Record) -> bool) -> usize {
    entries.iter().filter(|e| is(&e.record)).count()
}

fn machine(study: &Study, plan: &Plan, rate_hz: f64, film: Option<Film>) -> Machine {
    let setup = Setup::new(&study.definition, plan, rate_hz, Trust::Virtual, 60.0);
    Machine::new(setup).with_films(vec![film; plan.stimuli.len()])
}

fn header(study: &Study, plan: &Plan, rate_hz: f64) -> Value {
    let d = &study.definition;
    json!({
        "format": 1,
        "study": { "id": d.id, "title": d.title, "sha256": study.sha256, "text": study.text, "seed": d.seed },
        "participant": "p01", "session": "s01", "row": plan.order.row,
        "question": d.journal_question(), "analysis": d.analysis,
        "program": { "name": "cyclopean", "version": "0", "commit": "unknown" },
        "display": {
            "kind": "headless", "system": "", "runtime": "", "trust": "virtual", "nominal_hz": rate_hz,
            "width_px": 16, "height_px": 16, "rendered_ipd_m": 0.063,
        },
        "os": "none",
    })
}
