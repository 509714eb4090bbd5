//! Writes sessions as the application writes them, to measure reading and to try the commands.
//!
//! `cargo run --release -p cyclopean-analysis --example journals -- DIR SESSIONS [SCENES] [REPETITIONS] [KIND] [STUDY]`
//!
//! STUDY is `rate` (three methods, a five-point scale) or `compare` (a forced choice for each eye).

use std::collections::BTreeMap;
use std::path::PathBuf;

use chrono::DateTime;
use cyclopean_analysis::chance::Stream;
use cyclopean_analysis::files::write_whole;
use cyclopean_analysis::journal::record::*;
use cyclopean_analysis::journal::{AnalysisPlan, Entry, FORMAT, Kind, Record, encode};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let usage = "journals DIR SESSIONS [SCENES] [REPETITIONS] [real|pilot|simulated] [rate|compare]";
    let [dir, sessions, rest @ ..] = &arguments[..] else { return Err(usage.into()) };
    let number = |i: usize, default: u32| rest.get(i).map_or(Ok(default), |t| t.parse());
    let (scenes, repetitions) = (number(0, 3)?, number(1, 1)?);
    let kind = match rest.get(2).map(String::as_str) {
        None | Some("simulated") => Kind::Simulated,
        Some("real") => Kind::Real,
        Some("pilot") => Kind::Pilot,
        Some(_) => return Err(usage.into()),
    };
    let compare = rest.get(3).is_some_and(|s| s == "compare");
    for session in 0..sessions.parse::<u32>()? {
        let folder = PathBuf::from(dir).join(format!("p{session:05}"));
        std::fs::create_dir_all(&folder)?;
        let lines = lines(session, scenes, repetitions, kind, compare)?;
        write_whole(&folder.join("s01.jsonl"), |out| out.write_all(&lines))?;
    }
    Ok(())
}

/// A session's writer: sequence numbers and a clock that only goes on.
struct Session {
    bytes: Vec<u8>,
    seq: u64,
    t_ns: u64,
    kind: Kind,
}

impl Session {
    fn say(&mut self, record: Record, after_ms: u64) -> Result<(), serde_json::Error> {
        self.t_ns += after_ms * 1_000_000;
        let wall =
            DateTime::from_timestamp_millis(1_790_000_000_000 + (self.t_ns / 1_000_000) as i64).unwrap_or_default();
        let entry = Entry { seq: self.seq, t_ns: self.t_ns, wall, kind: self.kind, record };
        self.seq += 1;
        encode(&entry, &mut self.bytes)
    }
}

/// The whole file of one session.
pub fn lines(
    session: u32,
    scenes: u32,
    repetitions: u32,
    kind: Kind,
    compare: bool,
) -> Result<Vec<u8>, serde_json::Error> {
    let mut stream = Stream::new(2026, u64::from(session));
    let bias = 0.4 * stream.normal();
    let mut s = Session { bytes: Vec::new(), seq: 0, t_ns: 0, kind };
    s.say(Record::Header(Box::new(header(session, compare))), 0)?;
    let names = ["pica", "room", "wine"];
    let scene = |i: u32| names.get(i as usize).map_or_else(|| format!("scene{i:03}"), |n| (*n).to_owned());
    let levels: &[(&str, &str)] = if compare {
        &[("eye", "left"), ("eye", "right")]
    } else {
        &[("method", "sssr"), ("method", "stereo"), ("method", "path-traced")]
    };
    let conditions: Vec<BTreeMap<String, String>> = (0..scenes)
        .flat_map(|i| levels.iter().map(move |l| (i, *l)))
        .map(|(i, (factor, level))| {
            let mut f = BTreeMap::from([("scene".to_owned(), scene(i)), (factor.to_owned(), level.to_owned())]);
            if compare {
                f.extend([("method", "stereo"), ("other", "sssr")].map(|(a, b)| (a.to_owned(), b.to_owned())));
            }
            f
        })
        .collect();
    for (id, f) in conditions.iter().enumerate() {
        let stimulus = Stimulus {
            id: id as u32,
            key: format!("{id:064x}"),
            scene: f["scene"].clone(),
            view: "main".into(),
            method: f["method"].clone(),
            files: BTreeMap::from([("sbs.png".to_owned(), format!("{:064x}", id * 7919))]),
            scene_sha256: None,
            shaders_sha256: None,
            renderer: None,
            film: None,
        };
        s.say(Record::Stimulus(stimulus), 1)?;
    }
    for (id, f) in conditions.iter().enumerate() {
        s.say(Record::Condition(Condition { id: id as u32, factors: f.clone() }), 1)?;
    }
    let total = conditions.len() as u32 * repetitions;
    let order = Order {
        ordering: "random".into(),
        procedure: "example-1".into(),
        rows: 0,
        row: u64::from(session),
        presentations: total,
        sha256: "0".repeat(64),
    };
    s.say(Record::Order(order), 1)?;
    let a_is = |p: u32| compare.then_some(if (p + session).is_multiple_of(2) { Side::Method } else { Side::Other });
    for p in 0..total {
        let planned = Planned {
            presentation: p,
            purpose: Purpose::Trial,
            condition: p % conditions.len() as u32,
            repetition: p / conditions.len() as u32,
            block: 0,
            a_is: a_is(p),
            stimuli: vec![p % conditions.len() as u32],
            passes: Vec::new(),
        };
        s.say(Record::Planned(planned), 1)?;
    }
    let ready = Ready { lines: s.seq };
    s.say(Record::Ready(ready), 5)?;
    for p in 0..total {
        let f = &conditions[(p % conditions.len() as u32) as usize];
        s.say(Record::Begin(Begin { presentation: p, attempt: 0 }), 2000)?;
        let first_ns = s.t_ns;
        let segment = Segment {
            show: Shown::Stimulus,
            frames_asked: 1800,
            frames_shown: 1800,
            first_ns,
            last_ns: first_ns + 19_988_888_888,
            film_onsets_ns: Vec::new(),
        };
        let shown = Presentation {
            presentation: p,
            attempt: 0,
            segments: vec![segment],
            missed: u64::from(stream.index(20) == 0),
            unrendered: 0,
            lost_ms: 0.0,
            longest_gap_ms: 11.1 + stream.unit(),
            duration_ms: 20_000.0,
            trust: if kind == Kind::Simulated { Trust::Virtual } else { Trust::Predicted },
            invalid: Vec::new(),
        };
        s.say(Record::Presentation(shown), 20_000)?;
        let after_ns = 1_000_000_000 + u64::from(stream.index(3_000)) * 1_000_000;
        let choice = if compare {
            let ours = stream.weighted(&[0.2, 0.3, 0.5]) as u32;
            // The better side is A or B as the presentation had it.
            if a_is(p) == Some(Side::Method) { 2 - ours } else { ours }
        } else {
            let quality = match f["method"].as_str() {
                "sssr" => 2.2,
                "stereo" => 4.0,
                _ => 4.3,
            };
            (quality + bias + 0.7 * stream.normal()).round().clamp(1.0, 5.0) as u32 - 1
        };
        let answer = Answer { presentation: p, attempt: 0, choice, after_ns, changes: 1, counts: true };
        s.say(Record::Change(Change { presentation: p, attempt: 0, choice, after_ns: after_ns - 400_000_000 }), 1500)?;
        s.say(Record::Answer(answer), 400)?;
    }
    s.say(Record::End(End { outcome: Outcome::Completed, answered: total, missing: 0 }), 100)?;
    Ok(s.bytes)
}

fn header(session: u32, compare: bool) -> Header {
    let option = |value: i32, label: &str| ScaleOption { value, label: label.to_owned() };
    let question = if compare {
        Question::Compare { values: PreferenceValues { other: 1, same: 2, method: 3 } }
    } else {
        Question::Rate {
            options: vec![
                option(1, "very strong inconsistency"),
                option(2, "strong inconsistency"),
                option(3, "moderate inconsistency"),
                option(4, "slight inconsistency"),
                option(5, "no perceivable inconsistency"),
            ],
        }
    };
    let plan = if compare {
        r#"{"against":2}"#
    } else {
        r#"{"contrasts":[{"a":"stereo","b":"sssr"},{"a":"stereo","b":"path-traced","family":"reference"},
        {"a":"sssr","b":"path-traced","family":"reference"},{"a":"stereo","b":"sssr","family":"per scene","per":"scene"}],
        "equivalence":{"a":"stereo","b":"path-traced","margin":0.5}}"#
    };
    let id = if compare { "quality" } else { "consistency" };
    Header {
        format: FORMAT,
        study: Study {
            id: id.into(),
            title: if compare { "Visual quality".into() } else { "Inconsistent cues".into() },
            sha256: "ab".repeat(32),
            text: format!("{{\n  \"id\": \"{id}\"\n}}\n"),
            seed: 1,
        },
        participant: format!("p{session:05}"),
        session: "s01".into(),
        row: u64::from(session),
        question,
        analysis: serde_json::from_str::<AnalysisPlan>(plan).unwrap_or_else(|e| panic!("the plan above is valid: {e}")),
        program: Program { name: "cyclopean".into(), version: "0.1.0".into(), commit: "unknown".into() },
        display: Display {
            kind: "headless".into(),
            system: "none".into(),
            runtime: "virtual clock".into(),
            trust: Trust::Virtual,
            nominal_hz: 90.0,
            measured_hz: None,
            interval_sd_ms: None,
            width_px: 1920,
            height_px: 1080,
            fov_deg: None,
            ipd_m: None,
            rendered_ipd_m: 0.063,
        },
        device: None,
        os: "linux x86_64".into(),
        consent: None,
        frozen_sha256: None,
        poses: None,
    }
}
