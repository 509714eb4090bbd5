//! Tests the whole chain through both programs: `cyclopean run --simulate` makes journals, and `mos` analyses them. The
//! oracle is the library, which reads the votes from the same journals. Needs no GPU. The tests are skipped where the
//! program `mos` is missing and cannot be built.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

use cyclopean_analysis::journal::collect;
use cyclopean_analysis::journal::record::{Kind, Purpose};
use serde_json::Value;

use crate::lab::{Lab, mos, stderr};

const PEOPLE: [&str; 6] = ["s01", "s02", "s03", "s04", "s05", "s06"];

fn run(mos: &Path, lab: &Lab, arguments: &[&str]) -> Output {
    let output = Command::new(mos).args(arguments).current_dir(lab.dir.path()).output().expect("mos starts");
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    output
}

fn object(mos: &Path, lab: &Lab, arguments: &[&str]) -> Value {
    serde_json::from_slice(&run(mos, lab, arguments).stdout).expect("one JSON object")
}

/// Loads one of the repository's studies and simulates a session of every participant with the program.
fn sit(name: &str) -> Lab {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies").join(format!("{name}.json"));
    let lab = Lab::new(&serde_json::from_str(&std::fs::read_to_string(path).expect("a study")).expect("JSON"));
    for id in PEOPLE {
        let output = lab.simulate(id, &["--no-sync"]);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    lab
}

/// The one rating of each condition (by its factors) and participant, as the library reads it.
type Votes = BTreeMap<(BTreeMap<String, String>, String), i32>;

fn votes(lab: &Lab) -> Votes {
    let mut out = BTreeMap::new();
    for id in PEOPLE {
        let session = collect(&lab.journal(id, "001")).expect("whole");
        assert_eq!(session.kind, Kind::Simulated);
        for vote in session.votes.iter().filter(|v| v.purpose == Purpose::Trial) {
            let factors = session.factors(vote).expect("a condition").clone();
            assert_eq!(out.insert((factors, id.to_owned()), vote.rating), None);
        }
    }
    out
}

fn check_accepts(mos: &Path, lab: &Lab) {
    let said = object(mos, lab, &["check", "sessions", "--json"]);
    assert_eq!((&said["ok"], &said["damaged"]), (&true.into(), &0.into()));
    assert_eq!(said["kinds"]["simulated"], PEOPLE.len());
    assert_eq!(said["sources"].as_array().map(Vec::len), Some(PEOPLE.len()));
}

fn table_agrees(mos: &Path, lab: &Lab, votes: &Votes) {
    let said = object(mos, lab, &["table", "sessions", "--json"]);
    assert!(said["stamp"].as_str().is_some_and(|s| s.contains("simulated")), "{}", said["stamp"]);
    assert_eq!(said["level"], 0.9);
    let rows = said["rows"].as_array().expect("rows");
    assert_eq!(rows.len() * PEOPLE.len(), votes.len());
    for row in rows {
        // A factor with a single level has no column in the table.
        let is_of = |f: &BTreeMap<String, String>| {
            f.iter().all(|(name, level)| row.get(name).is_none_or(|l| l == level.as_str()))
        };
        let of: Vec<i32> = votes.iter().filter(|((f, _), _)| is_of(f)).map(|(_, rating)| *rating).collect();
        assert_eq!((of.len(), &row["n"]), (PEOPLE.len(), &PEOPLE.len().into()), "{row}");
        let mean = f64::from(of.iter().sum::<i32>()) / of.len() as f64;
        assert!((row["mean"].as_f64().expect("a number") - mean).abs() < 1e-12, "{row}");
        for (rating, count) in row["counts"].as_object().expect("counts") {
            let found = of.iter().filter(|r| r.to_string() == *rating).count();
            assert_eq!(count, found, "{row}");
        }
    }
}

fn export_agrees(mos: &Path, lab: &Lab, votes: &Votes) {
    let said = object(mos, lab, &["export", "sessions", "-o", "out", "--json"]);
    assert_eq!(said["rows"], votes.len());
    let text = std::fs::read_to_string(lab.path("out/responses.csv")).expect("a table");
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().expect("a header");
    let at = |name: &str| head.iter().position(|h| *h == name).unwrap_or_else(|| panic!("{name} in {head:?}"));
    let mut exported = Votes::new();
    for line in lines {
        let factors = votes.keys().next().expect("a vote").0.keys();
        let factors = factors.map(|f| (f.clone(), line[at(f)].to_owned())).collect();
        let rating = line[at("rating")].parse().expect("a rating");
        assert_eq!(exported.insert((factors, line[at("participant")].to_owned()), rating), None);
    }
    assert_eq!(&exported, votes);
    assert!(!head.iter().any(|h| h.contains("wall") || h.contains("host")), "{head:?}");
    for name in ["dictionary.csv", "analysis.R", "psych-ds/dataset_description.json"] {
        assert!(lab.path("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn ratings_go_from_sessions_to_tables_tests_and_exports_unchanged() {
    let Some(mos) = mos() else { return };
    let lab = sit("consistency");
    let votes = votes(&lab);
    assert_eq!(votes.len(), 9 * PEOPLE.len());
    check_accepts(&mos, &lab);
    table_agrees(&mos, &lab, &votes);
    export_agrees(&mos, &lab, &votes);

    // `mos test` does the tests that the study file plans, on each participant's sum of votes.
    let said = object(&mos, &lab, &["test", "sessions", "--json"]);
    let contrasts = said["contrasts"].as_array().expect("contrasts");
    let names: Vec<String> = contrasts
        .iter()
        .map(|c| format!("{} {} {} {}", c["family"], c["a"], c["b"], c["at"]).replace('"', ""))
        .collect();
    let planned = [
        "primary stereo sssr null",
        "against-reference stereo path-traced null",
        "against-reference sssr path-traced null",
        "exploratory stereo sssr pica",
        "exploratory stereo sssr room",
        "exploratory stereo sssr wine",
    ];
    assert_eq!(names, planned);
    for (contrast, family_size) in contrasts.iter().zip([1, 2, 2, 3, 3, 3]) {
        assert_eq!((&contrast["correction"], &contrast["family_size"]), (&"holm".into(), &family_size.into()));
        let is_here = |f: &BTreeMap<String, String>| contrast["at"].as_str().is_none_or(|at| f["scene"] == at);
        let sum = |level: &Value, who: &str| -> i32 {
            let of = |f: &BTreeMap<String, String>, p: &str| p == who && f["method"] == *level && is_here(f);
            votes.iter().filter(|((f, p), _)| of(f, p)).map(|(_, rating)| rating).sum()
        };
        let differences = PEOPLE.map(|who| sum(&contrast["a"], who) - sum(&contrast["b"], who));
        let zeros = differences.iter().filter(|d| **d == 0).count();
        assert_eq!((&contrast["n"], &contrast["n_zero"]), (&PEOPLE.len().into(), &zeros.into()), "{contrast}");
        let p = contrast["p_adjusted"].as_f64().expect("a number");
        assert!((0.0..=1.0).contains(&p), "{contrast}");
        let cells = if contrast["at"].is_null() { 3.0 } else { 1.0 };
        let mean = f64::from(differences.iter().sum::<i32>()) / PEOPLE.len() as f64 / cells;
        let found = contrast["difference"]["mean"].as_f64().expect("a number");
        assert!((found - mean).abs() < 1e-12, "{contrast}: {mean}");
    }
}

#[test]
fn choices_of_a_and_b_become_the_same_ratings_in_every_tool() {
    let Some(mos) = mos() else { return };
    let lab = sit("quality");
    let votes = votes(&lab);
    assert_eq!(votes.len(), 6 * PEOPLE.len());
    check_accepts(&mos, &lab);
    table_agrees(&mos, &lab, &votes);
    export_agrees(&mos, &lab, &votes);
    let said = object(&mos, &lab, &["test", "sessions", "--json"]);
    let contrasts = said["contrasts"].as_array().expect("contrasts");
    assert_eq!(contrasts.len(), 1, "{said}");
    assert_eq!(contrasts[0]["n"], PEOPLE.len());
    // A table of real sessions is refused, because there are only simulated ones.
    let refused = Command::new(&mos).args(["table", "sessions", "--kind", "real"]).current_dir(lab.dir.path()).output();
    assert_eq!(refused.expect("mos starts").status.code(), Some(1));
}
