//! Tests study files: their schema, how mistakes are refused, the repository's own studies, preparing stimuli,
//! freezing, and moving stimuli. The schema's oracle is the crate `jsonschema`. Needs no GPU.

use std::path::Path;

use cyclopean::study::definition::Definition;
use cyclopean::study::prepare::{self, Shard};
use cyclopean::study::session::{Options, simulate};
use cyclopean::study::show::{RecordedSession, render_again};
use cyclopean::study::stimulus::{Catalogue, StimulusRequest};
use cyclopean::study::store::Store;
use cyclopean::study::writer::Durability;
use cyclopean::study::{Plan, schema, validate};
use cyclopean_analysis::journal::collect;
use cyclopean_analysis::journal::record::{Film, Kind, Presentation, Purpose, Record, Side};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::lab::{Lab, Painter, rate, stderr};

const SHIPPED: [&str; 6] = ["consistency", "quality", "ablation", "recommended", "motion", "example-minimal"];

fn shipped(name: &str) -> validate::Study {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(format!("{name}.json"));
    validate::load(&path).unwrap_or_else(|e| panic!("{e}"))
}

/// A catalogue with every scene, method and path that the repository's studies name.
fn whole_catalogue() -> Catalogue {
    let methods = [
        "sssr",
        "stereo",
        "stereo-temporal",
        "path-traced",
        "unrelated",
        "stereo-no-traversal",
        "stereo-no-fade",
        "stereo-no-reprojection",
    ];
    Catalogue::of(&["pica", "room", "wine", "pink", "temple"], &methods)
        .with_ao(&["mono", "variant2"])
        .with_paths(&["still", "sway", "cut"])
}

#[test]
fn ambient_occlusion_is_asked_for_by_name_and_part_of_every_request() {
    let mut definition = shipped("example-minimal").definition;
    let request = |definition: &Definition| {
        let condition = &definition.conditions()[0];
        serde_json::to_value(StimulusRequest::new(definition, condition, &condition.method)).unwrap()
    };
    let plain = request(&definition);
    assert!(plain.get("ao").is_none());
    definition.stimuli.ao = Some("none".to_owned());
    assert_eq!(validate::resolve(&definition, &whole_catalogue()), []);
    assert_eq!(request(&definition), plain);
    definition.stimuli.ao = Some("variant2".to_owned());
    assert_eq!(validate::resolve(&definition, &whole_catalogue()), []);
    assert_eq!(request(&definition)["ao"], "variant2");
    definition.stimuli.ao = Some("variant3".to_owned());
    let problems = validate::resolve(&definition, &whole_catalogue());
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert!(problems[0].path == "stimuli.ao" && problems[0].what.contains("none, mono, variant2"), "{problems:?}");
}

#[test]
fn the_checked_in_schema_is_the_one_of_the_types() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/schema.json");
    if std::env::var_os("CYCLOPEAN_RENEW").is_some() {
        let text = serde_json::to_string_pretty(&schema::generate()).unwrap();
        std::fs::write(&path, format!("{text}\n")).unwrap();
    }
    let file: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    assert!(file == schema::generate(), "studies/schema.json is outdated; run this test once with CYCLOPEAN_RENEW=1");
}

#[test]
fn the_walk_through_shows_the_file_as_it_is() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("docs/studies.md")).unwrap();
    assert!(text.contains(&shipped("example-minimal").text));
}

#[test]
fn the_shipped_studies_are_sound_and_have_the_paper_s_conditions() {
    for name in SHIPPED {
        assert_eq!(validate::resolve(&shipped(name).definition, &whole_catalogue()), []);
        assert_eq!(shipped(name).definition.id, name);
    }
    let seconds = |name: &str| shipped(name).definition.protocol.iter().map(|s| s.seconds).sum::<f64>();
    for name in ["consistency", "quality", "ablation", "recommended"] {
        assert_eq!(seconds(name), 20.0, "{name}");
        assert_eq!(shipped(name).definition.analysis.interval.level, 0.9, "{name}");
    }
    assert_eq!(shipped("consistency").definition.conditions().len(), 9);
    assert_eq!(shipped("consistency").definition.participants, 18);
    let contrasts = |name: &str| -> Vec<(String, Option<String>)> {
        let all = shipped(name).definition.analysis.contrasts.into_iter();
        all.map(|c| (format!("{}: {} - {}", c.family, c.a, c.b), c.per)).collect()
    };
    let planned = [
        ("primary: stereo - sssr".to_owned(), None),
        ("against-reference: stereo - path-traced".to_owned(), None),
        ("against-reference: sssr - path-traced".to_owned(), None),
        ("exploratory: stereo - sssr".to_owned(), Some("scene".to_owned())),
    ];
    assert_eq!(contrasts("consistency"), planned);
    assert_eq!(contrasts("recommended"), planned);
    assert_eq!(shipped("quality").definition.conditions().len(), 6);
    assert_eq!(shipped("ablation").definition.conditions().len(), 3);
    assert_eq!(shipped("recommended").definition.conditions().len(), 9);
    assert_eq!(shipped("recommended").definition.participants % 18, 0);
    // In study 3 two successive rows show each module once as A and once as B.
    for pair in 0..9 {
        let sides = |row| -> Vec<(u32, Option<Side>)> {
            let plan = Plan::draw(&shipped("ablation").definition, row);
            let trials = plan.presentations.iter().filter(|p| p.purpose == Purpose::Trial);
            let mut sides: Vec<_> = trials.map(|p| (p.condition, p.a_is)).collect();
            sides.sort_by_key(|(c, _)| *c);
            sides
        };
        for (a, b) in sides(2 * pair).into_iter().zip(sides(2 * pair + 1)) {
            assert_eq!((a.0, a.1.map(Side::opposite)), b);
        }
    }
}

#[test]
fn every_shipped_study_runs_dry_from_preparation_to_votes() {
    for name in SHIPPED {
        let study = shipped(name);
        let lab = Lab::new(&serde_json::from_str(&study.text).unwrap());
        let options = Options { durability: Durability::Relaxed, ..Options::new(Kind::Simulated) };
        let study = lab.load();
        for row in 0..2 {
            let id = format!("s{row}");
            let ended = simulate(&study, &lab.store(), &lab.sessions(), &id, 90.0, &options).unwrap();
            let votes = collect(&ended.journal).unwrap();
            let trials = votes.votes.iter().filter(|v| v.purpose == Purpose::Trial).count();
            let expected = study.definition.conditions().len() * study.definition.repetitions as usize;
            assert_eq!((trials, votes.missing.len()), (expected, 0), "{name}");
            for vote in votes.votes.iter().filter(|v| v.purpose == Purpose::Catch) {
                assert_eq!(vote.passed, Some(vote.rating <= 2));
            }
        }
    }
}

#[test]
fn a_choice_becomes_the_rating_of_the_side_that_was_chosen() {
    // The observer has no noise and no lapses, and always finds the method better.
    let mut study: Value = serde_json::from_str(&shipped("quality").text).unwrap();
    study["simulation"] = json!({"latent": {"stereo": 9, "sssr": 1, "path-traced": 9}});
    let lab = Lab::new(&study);
    assert!(lab.simulate("s01", &[]).status.success());
    let votes = collect(&lab.journal("s01", "001")).unwrap();
    assert!(votes.votes.iter().all(|v| v.rating == 3));
    // A and B were nevertheless chosen equally often.
    let choices: Vec<u32> = cyclopean_analysis::journal::read(&lab.journal("s01", "001"))
        .unwrap()
        .filter_map(|e| if let Record::Answer(a) = e.unwrap().record { Some(a.choice) } else { None })
        .skip(2)
        .collect();
    assert_eq!(choices.iter().filter(|c| **c == 0).count(), 3);
    assert_eq!(choices.iter().filter(|c| **c == 2).count(), 3);
    // Each presentation shows the reference and both images.
    let plan = Plan::draw(&lab.load().definition, 0);
    assert!(plan.presentations.iter().all(|p| p.stimuli.len() == 3));
}

#[test]
fn a_known_effect_comes_back() {
    let lab = Lab::new(&serde_json::from_str(&shipped("consistency").text).unwrap());
    let options = Options { durability: Durability::Relaxed, ..Options::new(Kind::Simulated) };
    let mut sums = std::collections::BTreeMap::<String, (f64, f64)>::new();
    for i in 0..60 {
        let id = format!("s{i}");
        let ended = simulate(&lab.load(), &lab.store(), &lab.sessions(), &id, 90.0, &options).unwrap();
        let votes = collect(&ended.journal).unwrap();
        for vote in &votes.votes {
            let sum = sums.entry(votes.level(vote, "method").unwrap().to_owned()).or_default();
            *sum = (sum.0 + f64::from(vote.rating), sum.1 + 1.0);
        }
    }
    let mean = |method: &str| sums[method].0 / sums[method].1;
    // The latent values are 2.4, 4.2 and 4.5, and votes are clipped at 5. Each mean is over 180 votes and has a
    // standard error of about 0.08.
    assert!((mean("sssr") - 2.4).abs() < 0.35, "{}", mean("sssr"));
    assert!((mean("stereo") - 4.1).abs() < 0.35, "{}", mean("stereo"));
    assert!((mean("path-traced") - 4.35).abs() < 0.35, "{}", mean("path-traced"));
}

#[test]
fn every_problem_is_named_at_once_with_path_value_and_what_is_allowed() {
    let mut study = rate(&["pica"], 1);
    study["colour"] = json!("red");
    study["blank"]["seconds"] = json!(-1);
    study["task"] = json!("guess");
    study["protocol"][0]["show"] = json!("picture");
    study["conditions"]["cross"]["scene"] = json!("pica");
    study.as_object_mut().unwrap().remove("question");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("broken.json");
    std::fs::write(&path, study.to_string()).unwrap();
    let said = validate::load(&path).unwrap_err().to_string();
    for words in [
        "broken.json: 6 problems",
        "colour: unknown key; allowed here: `analysis`, `blank`",
        "blank.seconds: -1 is not within 0 to 60",
        "task: \"guess\" is not one of `rate`, `compare`",
        "protocol[0].show: \"picture\" is not one of `stimulus`, `a`, `b`, `blank`",
        "conditions.cross.scene: \"pica\" is not of type array",
        "question: is missing",
    ] {
        assert!(said.contains(words), "{words}\n{said}");
    }
}

#[test]
fn what_the_schema_cannot_say_is_refused_too() {
    let cases: [(&str, Value, &str); 12] = [
        ("/id", json!("Bad Id"), "id: `Bad Id` is not"),
        ("/scale", json!([1, 2, 3]), "scale: 3 ratings for 5 labels"),
        ("/scale", json!([1, 3, 2, 4, 5]), "does not rise"),
        ("/protocol", json!([{"show": "a", "seconds": 2}]), "protocol[0].show: `a` cannot be shown here"),
        ("/protocol", json!([]), "protocol: never shows `stimulus`"),
        ("/conditions/cross/scene", json!(["pica", "pica"]), "is there twice"),
        ("/conditions/cross/scene", json!([]), "no condition"),
        ("/conditions", json!({}), "needs either `cross` or `list`"),
        ("/order", json!({"kind": "blocked"}), "order.block_by: is missing"),
        ("/order", json!({"kind": "fixed", "block_by": "scene"}), "belongs to `blocked`"),
        ("/analysis", json!({"contrasts": [{"a": "stereo", "b": "sssr"}]}), "`stereo` is no level of `method`"),
        (
            "/catch_trials",
            json!([{"show": {"scene": "pica", "method": "sssr"}, "passes": [9]}]),
            "[9]: needs one or more",
        ),
    ];
    for (pointer, value, words) in cases {
        let mut study = rate(&["pica"], 1);
        for key in ["order", "analysis", "catch_trials"] {
            study.as_object_mut().unwrap().entry(key).or_insert(json!({"kind": "random"}));
            if pointer != format!("/{key}") {
                study.as_object_mut().unwrap().remove(key);
            }
        }
        *study.pointer_mut(pointer).unwrap() = value;
        let error = validate::parse(Path::new("study.json"), study.to_string()).unwrap_err().to_string();
        assert!(error.contains(words), "{pointer}: {error}");
    }
}

#[test]
fn a_method_or_scene_that_this_build_has_not_is_named_with_its_place() {
    let lab = Lab::new(&rate(&["pica"], 1));
    let mut study = rate(&["pica", "attic"], 1);
    study["conditions"]["cross"]["method"] = json!(["sssr", "magic@16"]);
    std::fs::write(lab.study(), study.to_string()).unwrap();
    for args in [["study", "check", "study.json"], ["prepare", "study.json", "--dry-run"]] {
        let output = lab.program(&args);
        assert_eq!(output.status.code(), Some(1));
        let said = stderr(&output);
        assert!(said.contains("conditions.cross.scene[1]: scene `attic` is not available in this build"), "{said}");
        assert!(
            said.contains("conditions.cross.method[1]: method `magic@16` is not available in this build"),
            "{said}"
        );
    }
}

#[test]
fn check_prints_conditions_order_length_and_what_is_missing() {
    let lab = Lab::new(&rate(&["pica", "room"], 1));
    let output = lab.program(&["study", "check", "study.json", "--json"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let said: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(said["conditions"].as_array().unwrap().len(), 5);
    assert_eq!(said["order"].as_array().unwrap().len(), 5);
    // Each of the five presentations has 2 s of stimulus, two blanks of 0.5 s and an answer of 1 s.
    assert!((said["minutes"].as_f64().unwrap() - 5.0 * 4.0 / 60.0).abs() < 1e-9);
    assert_eq!(said["to_render"], json!([]));
    let elsewhere = lab.program(&["study", "check", "study.json", "--json", "--store", "none"]);
    let said: Value = serde_json::from_slice(&elsewhere.stdout).unwrap();
    assert_eq!(said["to_render"].as_array().unwrap().len(), 5);
}

fn tree(folder: &Path) -> std::collections::BTreeMap<String, Vec<u8>> {
    fn walk(root: &Path, folder: &Path, out: &mut std::collections::BTreeMap<String, Vec<u8>>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(root, &path, out);
            } else if path.file_name().unwrap() != "timing.json" {
                let name = path.strip_prefix(root).unwrap().display().to_string();
                out.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    let mut out = std::collections::BTreeMap::new();
    walk(folder, folder, &mut out);
    out
}

#[test]
fn shards_together_equal_one_run_byte_for_byte() {
    let lab = Lab::new(&rate(&["pica", "room", "wine"], 1));
    let definition = lab.load().definition;
    let parts = Store::new(lab.path("parts"));
    for index in (0..3).rev() {
        let shard = Shard { index, count: 3 };
        prepare::prepare(&definition, &parts, &mut Painter::default(), shard, &mut |_, _| Ok(())).unwrap();
    }
    let (whole, parts) = (tree(&lab.path("store")), tree(&lab.path("parts")));
    assert_eq!(whole.len(), 7 * 4);
    assert!(whole == parts);
    for bad in ["3/3", "1", "0/0", "a/b", "-1/2"] {
        assert!(bad.parse::<Shard>().is_err(), "{bad}");
    }
}

#[test]
fn preparation_goes_on_where_it_failed_and_follows_a_changed_renderer() {
    let lab = Lab::new(&rate(&["pica", "room"], 1));
    let definition = lab.load().definition;
    let store = Store::new(lab.path("fresh"));
    let run = |painter: &mut Painter| {
        prepare::prepare(&definition, &store, painter, Shard::WHOLE, &mut |_, _| Ok(())).map_err(|e| format!("{e:#}"))
    };
    let error = run(&mut Painter { fails_at: Some(3), ..Painter::default() }).unwrap_err();
    assert!(error.contains("the device is gone") && error.contains(" by "), "{error}");
    // No unfinished file may have a final name.
    assert_eq!(tree(&lab.path("fresh")).len(), 3 * 4);
    let mut painter = Painter::default();
    let report = run(&mut painter).unwrap();
    assert_eq!((painter.rendered, report.whole.len(), report.missing.len()), (2, 3, 2));
    // With another renderer every key changes, and the old entries stay.
    let survey = prepare::survey(&definition, &store, &Painter { version: 2, ..Painter::default() }, Shard::WHOLE);
    assert_eq!(survey.unwrap().missing.len(), 5);
    let mut newer = Painter { version: 2, ..Painter::default() };
    run(&mut newer).unwrap();
    assert_eq!(newer.rendered, 5);
    let found = store.find(&Plan::all_stimuli(&definition)[0]).unwrap();
    assert_eq!(found.side_car.info.renderer, "painter 2");
}

#[test]
fn a_frozen_study_refuses_whatever_differs() {
    let mut study = rate(&["pica"], 1);
    study["analysis"] = json!({"contrasts": [{"a": "path-traced", "b": "sssr"}]});
    let lab = Lab::new(&study);
    let freeze = |folder: &str| lab.program(&["study", "freeze", "study.json", "-o", folder]);
    assert!(freeze("frozen").status.success());
    let again = freeze("frozen");
    assert!(stderr(&again).contains("a frozen study is never overwritten"), "{}", stderr(&again));
    let ok = lab.simulate("s01", &["--frozen", "frozen"]);
    assert!(ok.status.success(), "{}", stderr(&ok));
    assert!(collect(&lab.journal("s01", "001")).unwrap().header.frozen_sha256.is_some());
    // The frozen orders are those of all planned participants, and sessions get the same ones.
    let orders: Value = serde_json::from_slice(&std::fs::read(lab.path("frozen/orders.json")).unwrap()).unwrap();
    assert_eq!(orders.as_array().unwrap().len(), 4);
    let power: Value = serde_json::from_slice(&std::fs::read(lab.path("frozen/power.json")).unwrap()).unwrap();
    assert_eq!((&power["participants"], power["tests"].as_array().map(Vec::len)), (&json!(4), Some(1)));
    let journal = collect(&lab.journal("s01", "001")).unwrap();
    assert_eq!(orders[0]["order"]["row"], journal.header.row);

    let refused = |words: &str| {
        let output = lab.simulate("s02", &["--frozen", "frozen"]);
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
    };
    let keep = std::fs::read(lab.study()).unwrap();
    std::fs::write(lab.study(), [keep.as_slice(), b"\n"].concat()).unwrap();
    refused("is not the frozen study");
    std::fs::write(lab.study(), &keep).unwrap();
    lab.prepare(&mut Painter { version: 2, ..Painter::default() });
    refused("in the store is another");
    std::fs::write(lab.path("frozen/orders.json"), "[]").unwrap();
    refused("orders.json was changed after it was frozen");
    assert!(!lab.journal("s02", "001").exists());
}

/// One of the repository's studies with up to three random changes.
fn mutated() -> impl Strategy<Value = Value> {
    let values = prop_oneof![
        Just(json!(null)),
        Just(json!("word")),
        Just(json!(-3)),
        Just(json!(1.5)),
        Just(json!(1_000_000_000u64)),
        Just(json!([])),
        Just(json!({})),
        Just(json!(true)),
        Just(json!(["stereo", 4])),
    ];
    (prop::sample::select(SHIPPED.to_vec()), prop::collection::vec((any::<prop::sample::Index>(), 0..3, values), 0..4))
        .prop_map(|(name, changes)| {
            let mut study: Value = serde_json::from_str(&shipped(name).text).unwrap();
            for (at, how, value) in changes {
                let mut pointers = Vec::new();
                collect_pointers(&study, String::new(), &mut pointers);
                let pointer = at.get(&pointers).clone();
                match (how, study.pointer_mut(&pointer)) {
                    (0, Some(place)) => *place = value,
                    (1, Some(Value::Object(map))) => drop(map.insert("surprise".to_owned(), value)),
                    (2, Some(Value::Object(map))) => drop(map.keys().next().cloned().map(|key| map.remove(&key))),
                    _ => {}
                }
            }
            study
        })
}

fn collect_pointers(value: &Value, at: String, out: &mut Vec<String>) {
    match value {
        Value::Object(map) => map.iter().for_each(|(k, v)| collect_pointers(v, format!("{at}/{k}"), out)),
        Value::Array(list) => list.iter().enumerate().for_each(|(i, v)| collect_pointers(v, format!("{at}/{i}"), out)),
        _ => {}
    }
    out.push(at);
}

proptest! {
    #[test]
    fn our_walk_along_the_schema_agrees_with_a_validator(study in mutated()) {
        let schema = schema::generate();
        let validator = jsonschema::validator_for(&schema).unwrap();
        let ours = schema::check(&study);
        prop_assert_eq!(ours.is_empty(), validator.is_valid(&study), "{:?}", ours);
        // A study that passes must be read, or refused without a panic.
        let _ = validate::parse(Path::new("study.json"), study.to_string());
    }

    #[test]
    fn any_text_is_refused_without_a_panic(text in ".{0,200}") {
        prop_assert!(validate::parse(Path::new("study.json"), text).is_err());
    }
}

/// A study with moving stimuli: two methods along the path `sway`, shown for half a second.
fn moving() -> Value {
    let mut study = rate(&["pica"], 1);
    study["protocol"] = json!([{"show": "stimulus", "seconds": 0.5}]);
    study["conditions"] = json!({"cross": {"scene": ["pica"], "path": ["sway"], "method": ["sssr", "stereo"]}});
    study["practice"] = json!([]);
    study["simulation"]["latent"] = json!({"sssr": 2.5, "stereo": 4.0});
    study
}

fn presentations_of(lab: &Lab, participant: &str) -> Vec<Presentation> {
    let shown = |record| if let Record::Presentation(p) = record { Some(p) } else { None };
    records(lab, participant).into_iter().filter_map(shown).collect()
}

fn records(lab: &Lab, participant: &str) -> Vec<Record> {
    let entries = cyclopean_analysis::journal::read(&lab.journal(participant, "001")).unwrap();
    entries.map(|entry| entry.unwrap().record).collect()
}

#[test]
fn moving_stimuli_are_prepared_shown_in_time_and_journaled() {
    let lab = Lab::new(&moving());
    let run = |participant: &str, more: &[&str]| {
        lab.command(&[&["run", "study.json", "--participant", participant, "--simulate"], more].concat())
            .output()
            .unwrap()
    };
    assert!(run("p1", &["--hz", "90"]).status.success());
    for p in presentations_of(&lab, "p1") {
        assert!(p.invalid.is_empty(), "{:?}", p.invalid);
        let [segment] = &p.segments[..] else { panic!("{:?}", p.segments) };
        // With 30 frames per second on a display with 90 Hz, each frame is shown for three of the display's frames.
        let onsets: Vec<u64> = segment.film_onsets_ns.iter().map(|o| o.unwrap() - segment.first_ns).collect();
        assert_eq!(onsets.len(), 15);
        for (frame, onset) in onsets.iter().enumerate() {
            assert!((*onset as f64 - frame as f64 * 1e9 / 30.0).abs() < 2.0, "frame {frame}: {onset}");
        }
    }
    let records = records(&lab, "p1");
    let mut films = records.iter().filter_map(|r| if let Record::Stimulus(s) = r { Some(s) } else { None });
    assert!(films.all(|s| s.film == Some(Film { rate_hz: 30.0, frames: 15 }) && s.files.len() == 2 + 14));
    assert!(records.iter().any(|r| matches!(r, Record::Condition(c) if c.factors["path"] == "sway")));

    // A display that is slower than the film is refused, because it would leave frames out.
    let slow = run("p2", &["--hz", "24"]);
    assert_eq!(slow.status.code(), Some(1));
    let said = stderr(&slow);
    assert!(said.contains("along sway") && said.contains("30 frames a second") && said.contains("24"), "{said}");
    // A display whose rate is no multiple of the film's shows all frames for uneven times, and the program warns of
    // that.
    let uneven = run("p3", &["--hz", "50"]);
    assert!(uneven.status.success() && stderr(&uneven).contains("stand longer"), "{}", stderr(&uneven));
    assert!(presentations_of(&lab, "p3").iter().all(|p| p.segments[0].film_onsets_ns.iter().all(Option::is_some)));
}

#[test]
fn every_frame_of_a_moving_stimulus_is_checked() {
    let lab = Lab::new(&moving());
    let definition = lab.load().definition;
    let request = &Plan::all_stimuli(&definition)[1];
    let stored = lab.store().find(request).unwrap();
    let frames = stored.frame_paths();
    assert_eq!(frames.len(), 15);
    let whole = std::fs::read(&frames[7]).unwrap();
    let mut damaged = whole.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    for bytes in [Some(&damaged), None] {
        match bytes {
            Some(bytes) => std::fs::write(&frames[7], bytes).unwrap(),
            None => std::fs::remove_file(&frames[7]).unwrap(),
        }
        let run = lab.command(&["run", "study.json", "--participant", "p1", "--simulate"]).output().unwrap();
        assert_eq!(run.status.code(), Some(1));
        assert!(stderr(&run).contains("sbs_00007.png"), "{}", stderr(&run));
        let mut painter = Painter::default();
        let report = prepare::prepare(&definition, &lab.store(), &mut painter, Shard::WHOLE, &mut |_, _| Ok(()));
        assert_eq!(report.unwrap().damaged, [request.label()]);
        assert_eq!(std::fs::read(&frames[7]).unwrap(), whole);
    }
}

#[test]
fn a_path_that_no_scene_has_is_named_with_those_there_are() {
    let mut study = moving();
    study["conditions"]["cross"]["path"] = json!(["sway", "round-trip"]);
    let definition: Definition = serde_json::from_value(study).unwrap();
    let problems = validate::resolve(&definition, &whole_catalogue());
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert_eq!(problems[0].path, "conditions.cross.path[1]");
    assert!(problems[0].what.contains("`round-trip`; available: still, sway, cut"), "{problems:?}");
    // The requests of still stimuli are the same as before there were paths.
    let still = shipped("example-minimal").definition;
    let condition = &still.conditions()[0];
    let request = serde_json::to_value(StimulusRequest::new(&still, condition, &condition.method)).unwrap();
    assert!(request.get("path").is_none() && request.get("seconds").is_none());
}

#[test]
fn a_journal_alone_gives_its_stimuli_again_or_says_what_differs() {
    let lab = Lab::new(&rate(&["pica"], 1));
    let run = lab.command(&["run", "study.json", "--participant", "p1", "--simulate"]).output().unwrap();
    assert!(run.status.success(), "{}", stderr(&run));
    let journal = lab.journal("p1", "001");
    let seen = RecordedSession::read(&journal).unwrap();
    let shown = seen.of(&journal, 1).unwrap();
    assert_eq!(shown.len(), 1);
    let stimulus = &seen.stimuli[shown[0].1 as usize];
    let folder = tempfile::tempdir().unwrap();
    let same = render_again(&mut Painter::default(), stimulus, &folder.path().join("same")).unwrap();
    assert!(same.same_key && same.differing.is_empty(), "{same:?}");
    let mut other = Painter { version: 1, ..Painter::default() };
    let other = render_again(&mut other, stimulus, &folder.path().join("other")).unwrap();
    assert!(!other.same_key && other.differing.contains(&"sbs.png".to_owned()), "{other:?}");
    assert!(seen.of(&journal, 99).unwrap_err().to_string().contains("no presentation 99"));
    // A session whose order cannot be proven is not shown.
    let text = std::fs::read_to_string(&journal).unwrap();
    let cut: String = text.lines().take(3).map(|line| format!("{line}\n")).collect();
    let torn = folder.path().join("torn.jsonl");
    std::fs::write(&torn, cut).unwrap();
    assert!(RecordedSession::read(&torn).unwrap_err().to_string().contains("before its order is complete"));
}
