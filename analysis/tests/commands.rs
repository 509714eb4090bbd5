//! Tests the program `mos`: each test runs it in a fresh folder and checks its output, its files and its exit status.
//! Expected values are computed by hand from small tables. Needs nothing but the program itself.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use cyclopean_analysis::journal::Kind;
use serde_json::Value;
use tempfile::TempDir;

#[path = "../examples/journals.rs"]
#[allow(dead_code, reason = "the example's own main is not run here")]
mod journals;

fn mos(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mos")).current_dir(folder).args(arguments).output().unwrap()
}

fn ok(folder: &Path, arguments: &[&str]) -> String {
    let out = mos(folder, arguments);
    assert!(out.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8(out.stdout).unwrap()
}

fn object(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&ok(folder, arguments)).unwrap()
}

/// Exit status and message of a command that must fail.
fn refused(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let out = mos(folder, arguments);
    (out.status.code().unwrap(), String::from_utf8(out.stderr).unwrap())
}

fn write(folder: &Path, name: &str, text: &str) {
    fs::write(folder.join(name), text).unwrap();
}

fn journal(folder: &Path, name: &str, session: u32, kind: Kind, compare: bool) -> PathBuf {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, journals::lines(session, 3, 1, kind, compare).unwrap()).unwrap();
    path
}

/// A table of ten participants' ratings of two scenes with three methods. The ratings follow a fixed rule.
fn ratings() -> String {
    let mut out = "participant,scene,method,rating\n".to_owned();
    for p in 0..10u32 {
        for (s, scene) in ["pica", "room"].iter().enumerate() {
            for (m, method) in ["sssr", "stereo", "path-traced"].iter().enumerate() {
                let rating = 1 + (p * 7 + s as u32 * 3 + m as u32 * 11) % 3 + m.min(1) as u32;
                out += &format!("p{p},{scene},{method},{rating}\n");
            }
        }
    }
    out
}

#[test]
fn wilcoxon_reads_standard_input_and_files() {
    let dir = TempDir::new().unwrap();
    write(dir.path(), "xy.csv", "x,y\n3,1\n2,2\n5,1\n4,3\n1,2\n");
    let o = object(dir.path(), &["wilcoxon", "xy.csv", "--json"]);
    // d = 2, 0, 4, 1, −1: R₊ = 3 + 4 + 1.5, R₋ = 1.5
    assert_eq!((&o["n"], &o["n_zero"], &o["n_used"]), (&5.into(), &1.into(), &4.into()));
    assert_eq!((&o["r_plus"], &o["r_minus"], &o["statistic"]), (&8.5.into(), &1.5.into(), &1.5.into()));
    // Three of the sixteen sign patterns have R₋ ≤ 1.5: either no difference is negative, or only one of the two with
    // rank 1.5 is.
    assert_eq!(o["p_exact"], 2.0 * 3.0 / 16.0);
    for key in ["z", "p_asymptotic", "p_mid", "rank_biserial", "hodges_lehmann", "convention"] {
        assert!(!o[key].is_null(), "{key}");
    }
    let mut child = Command::new(env!("CARGO_BIN_EXE_mos"))
        .args(["wilcoxon", "-", "--json", "--alternative", "greater", "--zeros", "pratt", "--correction"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(b"2\n0\n4\n1\n-1\n").unwrap();
    let piped: Value = serde_json::from_slice(&child.wait_with_output().unwrap().stdout).unwrap();
    assert_eq!(piped["r_plus"], 4.0 + 5.0 + 2.5);
    write(dir.path(), "equal.txt", "0\n0\n0\n");
    let o = object(dir.path(), &["wilcoxon", "equal.txt", "--json"]);
    assert!(o["z"].is_null() && o["p_exact"] == 1.0 && o["p_asymptotic"] == 1.0);
    assert!(ok(dir.path(), &["wilcoxon", "equal.txt"]).contains("no differences"));
}

#[test]
fn table_and_test_have_the_promised_shape() {
    let dir = TempDir::new().unwrap();
    write(dir.path(), "a.csv", &ratings());
    let t = object(dir.path(), &["table", "a.csv", "--json", "--by", "scene,method"]);
    assert_eq!((&t["level"], &t["ci"]), (&0.9.into(), &"t".into()));
    let rows = t["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 6);
    for r in rows {
        assert!(r["scene"].is_string() && r["method"].is_string() && r["n"] == 10, "{r}");
        assert!(r["lo"].as_f64() < r["mean"].as_f64() && r["mean"].as_f64() < r["hi"].as_f64());
        assert_eq!(r["counts"].as_object().unwrap().values().map(|v| v.as_u64().unwrap()).sum::<u64>(), 10);
    }
    let one = object(dir.path(), &["test", "a.csv", "--json", "--contrast", "method=stereo,sssr"]);
    let c = &one["contrasts"][0];
    assert_eq!((&c["a"], &c["b"], &c["n"]), (&"stereo".into(), &"sssr".into(), &10.into()));
    assert!(c["p_adjusted"].as_f64() >= c["p_exact"].as_f64() && c["r_plus"].is_number());
    for ci in ["t", "normal", "bootstrap", "bca", "clopper-pearson", "jeffreys"] {
        assert_eq!(object(dir.path(), &["table", "a.csv", "--json", "--ci", ci, "--level", "0.95"])["ci"], ci);
    }
    let again = |seed| ok(dir.path(), &["table", "a.csv", "--json", "--ci", "bca", "--seed", seed]);
    assert_eq!(again("7"), again("7"));
    assert!(ok(dir.path(), &["friedman", "a.csv"]).contains("Kendall's W"));
    assert_eq!(
        object(dir.path(), &["screen", "a.csv", "--json"])["studies"][0]["participants"].as_array().unwrap().len(),
        10
    );
}

#[test]
fn the_sum_of_a_participant_is_tested_and_not_the_pool() {
    let dir = TempDir::new().unwrap();
    write(dir.path(), "a.csv", &ratings());
    let o = object(dir.path(), &["test", "a.csv", "--json", "--contrast", "method=stereo,sssr", "--pooled"]);
    let c = &o["contrasts"][0];
    assert_eq!((&c["n"], &c["pooled"]["n"]), (&10.into(), &20.into()));
    assert!(c["pooled"]["label"].as_str().unwrap().contains("as the paper may have done"));
}

#[test]
fn wrong_input_is_one_clear_sentence() {
    let dir = TempDir::new().unwrap();
    let d = dir.path();
    write(d, "a.csv", &ratings());
    write(d, "bad.csv", "participant,scene,method,rating\np1,pica,sssr,3\np2,pica,sssr,inf\n");
    write(d, "short.csv", "participant,rating\np1\n");
    write(d, "columns.csv", "person,score\np1,3\n");
    write(d, "twice.csv", "participant,scene,method,repetition,rating\np1,pica,sssr,0,3\np1,pica,sssr,0,4\n");
    write(d, "empty.csv", "participant,rating\n");
    for (arguments, code, words) in [
        (
            &["table", "bad.csv"][..],
            1,
            "bad.csv, line 3: the rating `inf` is not a finite number; participant p2, scene pica",
        ),
        (&["table", "short.csv"], 1, "short.csv, line 2: 1 fields where the header has 2"),
        (&["table", "columns.csv"], 1, "no column `participant`"),
        (&["table", "twice.csv"], 1, "participant p1 answered scene pica, method sssr (repetition 0) twice"),
        (&["table", "empty.csv"], 1, "no answers in empty.csv"),
        (&["table", "nothing.csv"], 1, "cannot read nothing.csv"),
        (&["table", "."], 1, "no journal (.jsonl) in the folder"),
        (&["table", "a.csv", "--by", "colour"], 2, "unknown factor `colour`; known: scene, method"),
        (&["table", "a.csv", "--level", "0"], 2, "between 0 and 1"),
        (&["table", "a.csv", "--ci", "magic"], 2, "possible values"),
        (
            &["test", "a.csv", "--contrast", "method=stereo,none"],
            2,
            "no answers for method `none`; known: sssr, stereo, path-traced",
        ),
        (&["test", "a.csv", "--contrast", "stereo"], 2, "is not FACTOR=A,B"),
        (&["test", "a.csv", "--equivalence", "-1"], 2, ""),
        (&["wilcoxon", "nothing.txt"], 1, "cannot read nothing.txt"),
        (&["power", "--studies", "1"], 2, "studies are 10"),
        (&["export", "a.csv"], 2, "this is tidy data already"),
    ] {
        let (got, message) = refused(d, arguments);
        assert_eq!(got, code, "{arguments:?}: {message}");
        assert!(message.contains(words), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{message}");
    }
}

#[test]
fn a_missing_cell_is_named_and_the_rule_printed() {
    let dir = TempDir::new().unwrap();
    let text: String =
        ratings().lines().filter(|l| !l.starts_with("p3,room,stereo")).map(|l| format!("{l}\n")).collect();
    write(dir.path(), "a.csv", &text);
    let o = object(dir.path(), &["test", "a.csv", "--json", "--contrast", "method=stereo,sssr"]);
    assert_eq!((&o["contrasts"][0]["n"], &o["contrasts"][0]["incomplete"][0][0]), (&9.into(), &"p3".into()));
    let text = ok(dir.path(), &["test", "a.csv", "--contrast", "method=stereo,sssr"]);
    assert!(
        text.contains("without every cell of both levels are left out of this test: p3 (0 of 1 votes for scene room")
    );
    let table = ok(dir.path(), &["table", "a.csv"]);
    assert!(table.contains("participant p3 lacks votes for scene room, method stereo; rows use the votes there are"));
}

#[test]
fn flagged_cells_say_so() {
    let dir = TempDir::new().unwrap();
    let rows: String = (0..10).map(|p| format!("p{p},5\n")).collect();
    write(dir.path(), "fives.csv", &format!("participant,rating\n{rows}"));
    let r = &object(dir.path(), &["table", "fives.csv", "--json"])["rows"][0];
    assert!((r["lo"].as_f64().unwrap() - 3.9645).abs() < 1e-4 && r["hi"] == 5.0 && r["unanimous"] == true, "{r}");
    write(dir.path(), "one.csv", "participant,rating\np1,4\n");
    let r = &object(dir.path(), &["table", "one.csv", "--json"])["rows"][0];
    assert!(r["lo"].is_null() && r["sd"].is_null() && r["notes"][0] == "one vote: no interval", "{r}");
    let polarised = [1, 1, 1, 1, 2, 4, 5, 5, 5, 5];
    let rows: String = polarised.iter().enumerate().map(|(p, v)| format!("p{p},{v}\n")).collect();
    write(dir.path(), "poles.csv", &format!("participant,rating\n{rows}"));
    assert!(ok(dir.path(), &["table", "poles.csv", "--ci", "clopper-pearson"]).contains("the interval is too narrow"));
}

#[test]
fn kinds_are_never_mixed_unasked() {
    let dir = TempDir::new().unwrap();
    let d = dir.path();
    for i in 0..4 {
        let kind = if i < 2 { Kind::Real } else { Kind::Simulated };
        journal(d, &format!("s/p{i}/a.jsonl"), i, kind, false);
    }
    for command in ["table", "test", "screen", "report", "friedman"] {
        let (code, message) = refused(d, &[command, "s"]);
        assert!(code == 1 && message.contains("--allow-kind") && message.contains("simulated"), "{command}: {message}");
    }
    let t = object(d, &["table", "s", "--json", "--allow-kind", "simulated"]);
    assert_eq!((&t["stamp"], &t["rows"][0]["n"]), (&"real + simulated".into(), &4.into()));
    assert_eq!(object(d, &["table", "--allow-kind", "s", "--json"])["rows"][0]["n"], 4);
    let real = object(d, &["table", "s", "--json", "--kind", "real"]);
    assert!(real["stamp"].is_null() && real["rows"][0]["n"] == 2);
    assert!(ok(d, &["table", "s", "--kind", "simulated"]).starts_with("*** SIMULATED data ***"));
    assert!(ok(d, &["check", "s"]).contains("mixed kinds of session: 2 real, 2 simulated"));
}

#[test]
fn a_damaged_journal_is_named_with_its_line() {
    let dir = TempDir::new().unwrap();
    let d = dir.path();
    journal(d, "s/p0/a.jsonl", 0, Kind::Real, false);
    let path = journal(d, "s/p1/a.jsonl", 1, Kind::Real, false);
    let mut bytes = fs::read(&path).unwrap();
    let line: usize = 30;
    let start = bytes.iter().enumerate().filter(|b| *b.1 == b'\n').nth(line - 2).unwrap().0 + 40;
    bytes[start] ^= 1;
    fs::write(&path, bytes).unwrap();
    let (code, message) = refused(d, &["table", "s"]);
    assert!(code == 1 && message.contains("a.jsonl: line 30") && message.contains("Restore"), "{message}");
    let out = mos(d, &["check", "s", "--json"]);
    assert_eq!(out.status.code(), Some(1));
    let o: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert!(o["ok"] == false && o["damaged"] == 1 && o["sources"][0]["error"].is_null(), "{o}");
    let whole = fs::read(d.join("s/p0/a.jsonl")).unwrap();
    fs::write(d.join("s/p0/a.jsonl"), &whole[..whole.len() - 20]).unwrap();
    let (_, message) = refused(d, &["table", "s/p0/a.jsonl"]);
    assert!(message.contains("torn"), "{message}");
}

#[test]
fn journals_and_their_export_give_the_same_table() {
    let dir = TempDir::new().unwrap();
    let d = dir.path();
    for i in 0..6 {
        journal(d, &format!("s/rate/p{i}.jsonl"), i, Kind::Simulated, false);
        journal(d, &format!("s/pair/p{i}.jsonl"), i, Kind::Simulated, true);
    }
    let o = object(d, &["export", "s", "-o", "out", "--json"]);
    assert_eq!(o["rows"], 6 * (9 + 6));
    let (a, b) = (object(d, &["table", "s", "--json"]), object(d, &["table", "out/responses.csv", "--json"]));
    let means = |t: &Value| t["rows"].as_array().unwrap().iter().map(|r| r["mean"].clone()).collect::<Vec<_>>();
    assert_eq!(means(&a), means(&b));
    let csv = fs::read_to_string(d.join("out/responses.csv")).unwrap();
    assert!(!csv.contains("2026-") && !csv.contains("linux"), "the export holds a wall time or a host");
    let script = fs::read_to_string(d.join("out/analysis.R")).unwrap();
    assert!(script.contains("clmm(rating ~ method * scene + (1 + method | participant)"));
    let pref = object(d, &["preference", "s", "--study", "quality", "--json"]);
    assert_eq!(pref["preferences"][0]["conditions"].as_array().unwrap().len(), 6);
    // For comparisons `mos table` says which method was preferred, with the same numbers as `mos preference`.
    assert_eq!(a["preferences"], pref["preferences"]);
    assert!(b.get("preferences").is_none(), "the exported file does not say which ratings are choices");
    let said = String::from_utf8(mos(d, &["table", "s"]).stdout).unwrap();
    let (_, winners) = said.split_once("who was preferred in quality\n").expect("the table of preferences");
    for condition in pref["preferences"][0]["conditions"].as_array().unwrap() {
        let factor = |name: &str| {
            let factors = condition["factors"].as_array().unwrap();
            factors.iter().find(|f| f[0] == name).unwrap()[1].as_str().unwrap().to_owned()
        };
        let votes = |name: &str| condition["votes"][name].as_u64().unwrap();
        let (wins, losses) = (votes("wins"), votes("losses"));
        let name = format!("{} {}", factor("scene"), factor("eye"));
        let line = winners.lines().find(|l| l.starts_with(&name)).unwrap();
        let by = format!("{} of {}", wins.max(losses), wins + losses);
        assert!(line.contains(&by), "{line}: {by}");
        let preferred = match wins.cmp(&losses) {
            std::cmp::Ordering::Greater => factor("method"),
            std::cmp::Ordering::Less => factor("other"),
            std::cmp::Ordering::Equal => "neither".to_owned(),
        };
        assert_eq!(line.split_whitespace().nth(2), Some(preferred.as_str()), "{line}");
    }
    let globbed = object(d, &["table", "s/rate/p?.jsonl", "--json"]);
    assert_eq!(globbed["rows"].as_array().unwrap().len(), 9);
}

/// Checks the main rules of the Psych-DS validator, so that the test does not need the validator itself.
#[test]
fn the_psych_ds_folder_keeps_that_projects_rules() {
    let dir = TempDir::new().unwrap();
    let d = dir.path();
    for i in 0..3 {
        journal(d, &format!("s/p{i}.jsonl"), i, Kind::Simulated, false);
    }
    ok(d, &["export", "s", "-o", "out"]);
    let root = d.join("out/psych-ds");
    let meta: Value =
        serde_json::from_str(&fs::read_to_string(root.join("dataset_description.json")).unwrap()).unwrap();
    assert!(meta["@context"].as_str().unwrap().contains("schema.org") && meta["@type"] == "Dataset");
    assert!(!meta["name"].as_str().unwrap().is_empty() && !meta["description"].as_str().unwrap().is_empty());
    let measured: Vec<&str> =
        meta["variableMeasured"].as_array().unwrap().iter().map(|v| v["name"].as_str().unwrap()).collect();
    const KEYWORDS: [&str; 9] =
        ["study", "site", "subject", "session", "task", "condition", "trial", "stimulus", "description"];
    let mut files = 0;
    for entry in fs::read_dir(root.join("data")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        let stem = name.strip_suffix("_data.csv").unwrap();
        for part in stem.split('_') {
            let (key, value) = part.split_once('-').unwrap();
            assert!(
                KEYWORDS.contains(&key) && !value.is_empty() && value.chars().all(|c| c.is_ascii_alphanumeric()),
                "{name}"
            );
        }
        let text = fs::read_to_string(&path).unwrap();
        let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        assert!(header.iter().all(|h| measured.contains(h)), "{header:?}");
        assert!(text.lines().all(|l| l.split(',').count() == header.len()));
        files += 1;
    }
    assert_eq!(files, 3);
}

#[test]
fn the_report_is_one_page_without_the_network() {
    let dir = TempDir::new().unwrap();
    let d = dir.path();
    for i in 0..6 {
        journal(d, &format!("s/rate/p{i}.jsonl"), i, Kind::Simulated, false);
        journal(d, &format!("s/pair/p{i}.jsonl"), i, Kind::Simulated, true);
    }
    ok(d, &["report", "s", "-o", "page.html"]);
    let page = fs::read_to_string(d.join("page.html")).unwrap();
    for words in [
        "SIMULATED",
        "Inconsistent cues",
        "Visual quality",
        "Timing quality",
        "Provenance",
        "Holm",
        "<svg",
        "prefers-color-scheme",
    ] {
        assert!(page.contains(words), "{words}");
    }
    // The only address is the SVG namespace, which no browser fetches.
    let addresses: Vec<&str> = page.match_indices("http").map(|(i, _)| &page[i..(i + 26).min(page.len())]).collect();
    assert!(addresses.iter().all(|a| a.starts_with("http://www.w3.org/2000/svg")), "{addresses:?}");
    assert!(!page.contains("<script") && !page.contains("<link"));
    for (format, words) in
        [("md", "| scene | method |"), ("latex", "\\begin{tabular}"), ("csv", "study,"), ("json", "\"studies\"")]
    {
        assert!(ok(d, &["report", "s", "--format", format]).contains(words), "{format}");
    }
}

#[test]
fn power_and_exact_shapes() {
    let dir = TempDir::new().unwrap();
    let o = object(dir.path(), &["power", "--n", "10", "--studies", "200", "--json", "--equivalence", "0.5"]);
    let p = &o["points"][0];
    assert!(p["power"]["rate"].as_f64() > p["size"]["rate"].as_f64() && p["size"]["se"].is_number(), "{p}");
    let o =
        object(dir.path(), &["power", "--n", "6", "--votes-a", "0.2,0.3,0.5", "--votes-b", "0.2,0.3,0.5", "--json"]);
    assert!(o["points"][0]["rejection"]["exact"].as_f64().unwrap() <= 0.05);
}
