//! Tests `cyclopean paper` by running the program at a small size. The page must have no gaps. A run that is killed at
//! random moments must continue where it stopped, make nothing twice and end with the page of an undisturbed run, which
//! is the oracle. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, SystemTime};

use serde_json::Value;

use crate::program::{self, stderr};

const SMALL: [&str; 17] = [
    "paper",
    "--quick",
    "--size",
    "48x27",
    "--seeds",
    "2",
    "--reference-spp",
    "4",
    "--scenes",
    "room",
    "--observers",
    "2",
    "--cache",
    "references",
    "-o",
    "p",
    "--json",
];

/// The program as users run it, without Vulkan validation. The tests of comparisons and stimuli check every pass with
/// it.
fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = program::command(folder, arguments);
    command.env_remove("CYCLOPEAN_VALIDATION");
    command
}

fn cyclopean(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("the program starts")
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&bytes(path)).expect("JSON")
}

/// Every finished file below a folder, by its path there, with the time at which it was written.
fn finished(folder: &Path) -> BTreeMap<PathBuf, SystemTime> {
    let mut out = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(&next).into_iter().flatten() {
            let path = entry.expect("an entry").path();
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            // Names of unfinished files begin with a point. Definitions and the list of pieces are written again in
            // every run.
            if name.starts_with('.') || ["finished.json", "studies", "requests"].contains(&name.as_str()) {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else {
                let written = std::fs::metadata(&path).and_then(|m| m.modified()).expect("a time");
                out.insert(path.strip_prefix(folder).expect("below").to_owned(), written);
            }
        }
    }
    out
}

/// The files that rendering leaves (results, sheets, stimuli, sessions and references), each with the time when it was
/// made. A result's time is the one that it contains, because its file is written again after its sheets are drawn. A
/// sheet has its check sum instead of a time, because it is drawn again after a kill between the two files.
fn rendered(folder: &Path) -> BTreeMap<PathBuf, String> {
    let work = folder.join("p/work");
    let when = |(name, time): (PathBuf, SystemTime)| {
        let is_kept_as = |extension: &str| name.starts_with("kept") && name.extension().is_some_and(|e| e == extension);
        if is_kept_as("png") {
            let sheet = cyclopean::study::sha256_hex(&bytes(&work.join(&name)));
            return (name, sheet);
        }
        let is_result = is_kept_as("json");
        let made =
            if is_result { json(&work.join(&name))["content"]["measured"].to_string() } else { format!("{time:?}") };
        (name, made)
    };
    let mut all: BTreeMap<PathBuf, String> = finished(&work).into_iter().map(when).collect();
    let references = finished(&folder.join("references"));
    all.extend(references.into_iter().map(|(name, time)| (Path::new("references").join(name), format!("{time:?}"))));
    all
}

/// The report without tables and columns of times, which differ from run to run.
fn without_times(folder: &Path) -> Value {
    let mut paper = json(&folder.join("p/paper.json"));
    for item in paper["items"].as_array_mut().expect("items") {
        for table in item["tables"].as_array_mut().expect("tables") {
            let caption = table["caption"].as_str().expect("a caption").to_owned();
            let is_timed = caption.starts_with("Milliseconds") || caption.starts_with("Time over");
            let columns: Vec<String> = serde_json::from_value(table["columns"].clone()).expect("columns");
            let timed = |c: &String| {
                ["total, ms", "trace + resolve", "time over mono"].contains(&c.as_str()) || c.contains("same time")
            };
            for row in table["rows"].as_array_mut().expect("rows") {
                for (cell, column) in row.as_array_mut().expect("a row").iter_mut().zip(&columns) {
                    if (is_timed && cell.is_number()) || timed(column) {
                        *cell = Value::Null;
                    }
                }
            }
        }
    }
    // The journals' names and times differ as well.
    paper["studies"] = paper["studies"]["studies"].take();
    paper
}

/// Random numbers between 0 and 1 from a seed. A failure prints the seed.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        // Marsaglia's xorshift64.
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[test]
#[cfg(unix)]
fn a_page_that_was_killed_at_random_is_that_of_an_undisturbed_run_and_nothing_is_made_twice() {
    let [alone, killed] = [(); 2].map(|()| tempfile::tempdir().expect("a temporary folder"));
    let done = cyclopean(alone.path(), &SMALL);
    assert!(done.status.success(), "{}", stderr(&done));
    let said: Value = serde_json::from_slice(&done.stdout).expect("one object on stdout");
    let pieces = said["pieces"].as_u64().expect("a count");
    assert!(stderr(&done).contains(&format!("{pieces} of {pieces}: study ablation made")), "{}", stderr(&done));
    assert_page(&alone.path().join("p"));

    // The same command in the finished folder makes nothing and writes the same bytes.
    let (before, page) = (rendered(alone.path()), bytes(&alone.path().join("p/paper.html")));
    let again = cyclopean(alone.path(), &SMALL);
    assert!(again.status.success(), "{}", stderr(&again));
    assert!(bytes(&alone.path().join("p/paper.html")) == page, "running again in the finished folder changed the page");
    assert_eq!(rendered(alone.path()), before);
    assert_eq!(stderr(&again).matches("taken from what is kept").count() as u64, pieces, "{}", stderr(&again));

    // The same sessions, given with --sessions, have the same analysis. Items that are left out say why.
    let sessions = std::fs::read_dir(alone.path().join("p/work/sessions")).expect("sessions").flatten();
    let sessions: Vec<String> = sessions.map(|e| e.path().display().to_string()).collect();
    let mut given = vec!["paper", "--scenes", "room", "--parts", "sessions", "--quick", "-o", "given", "--sessions"];
    given.extend(sessions.iter().map(String::as_str));
    let given = cyclopean(alone.path(), &given);
    assert!(given.status.success(), "{}", stderr(&given));
    let [made, given] = ["p", "given"].map(|folder| json(&alone.path().join(folder).join("paper.json")));
    assert_eq!(item(&made, "signed-rank")["tables"], item(&given, "signed-rank")["tables"]);
    assert_eq!(item(&given, "table2")["tables"][0]["rows"][5][3]["none"], "left out by --parts");
    assert_eq!((&given["stamp"], &given["failed"]), (&Value::from("simulated"), &serde_json::json!([])));

    let seed = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).expect("a time").as_nanos() as u64 | 1;
    let mut dice = Dice(seed);
    for kill in 0..3 {
        let before = rendered(killed.path());
        let mut child = command(killed.path(), &SMALL);
        let mut child = child.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts");
        // The program is killed at a random moment after this many new pieces.
        let after = (dice.roll() * 4.0) as usize;
        let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines();
        let mut made = 0;
        while made < after
            && let Some(line) = lines.next()
        {
            made += usize::from(line.expect("text").contains(" made in "));
        }
        std::thread::sleep(Duration::from_secs_f64(1.5 * dice.roll()));
        child.kill().expect("killed or ended");
        child.wait().expect("ended");
        let now = rendered(killed.path());
        for (name, time) in before {
            assert_eq!(now.get(&name), Some(&time), "seed {seed}, kill {kill}: {} was made again", name.display());
        }
    }
    let before = rendered(killed.path());
    let last = cyclopean(killed.path(), &SMALL);
    assert!(last.status.success(), "seed {seed}: {}", stderr(&last));
    let now = rendered(killed.path());
    for (name, time) in before {
        assert_eq!(now.get(&name), Some(&time), "seed {seed}: {} was made again", name.display());
    }
    assert!(
        without_times(killed.path()) == without_times(alone.path()),
        "seed {seed}: the page differs from that of the undisturbed run"
    );
    for sheet in ["table2", "figure10", "figure11", "figure12", "figure13", "figure14"] {
        let [a, b] = [&killed, &alone].map(|f| bytes(&f.path().join(format!("p/{sheet}/room_steps.png"))));
        assert!(a == b, "seed {seed}: the sheet of {sheet} differs from that of the undisturbed run");
    }
    let leftover = std::fs::read_dir(killed.path().join("p/work/kept")).expect("kept").flatten();
    assert!(
        leftover.map(|e| e.file_name()).all(|n| !n.to_string_lossy().starts_with('.')),
        "seed {seed}: an unfinished file is left"
    );
}

fn item<'a>(paper: &'a Value, id: &str) -> &'a Value {
    paper["items"].as_array().expect("items").iter().find(|item| item["id"] == id).expect("the item")
}

/// Checks that every item of the page is there, that no cell is empty, and that the sessions have their stamp.
fn assert_page(folder: &Path) {
    let paper = json(&folder.join("paper.json"));
    let ids: Vec<&str> =
        paper["items"].as_array().expect("items").iter().map(|i| i["id"].as_str().expect("id")).collect();
    let wanted = [
        "table1",
        "figure9",
        "table2",
        "figure10",
        "table3",
        "error-against-time",
        "figure11",
        "figure12",
        "figure13",
        "figure14",
        "modules",
        "figure19",
        "signed-rank",
        "figure18a",
        "figure18b",
        "ao-figure8",
        "ao-tables1-2",
        "ao-table3",
        "ao-figure11",
    ];
    assert_eq!(ids, wanted);
    let page = String::from_utf8(bytes(&folder.join("paper.html"))).expect("UTF-8");
    assert!(!page.contains("<td></td>") && !page.contains("<td class=\"n\"></td>"), "an empty cell");
    assert!(page.contains("Figure 19: mean opinion scores of consistency (SIMULATED data)"));
    assert!(page.contains("SIMULATED data. Mean opinion scores with 90 % intervals"));
    for item in paper["items"].as_array().expect("items") {
        for table in item["tables"].as_array().expect("tables") {
            let columns = table["columns"].as_array().expect("columns").len();
            let rows = table["rows"].as_array().expect("rows");
            assert!(!rows.is_empty(), "{}: {} has no row", item["id"], table["caption"]);
            for cell in rows.iter().flat_map(|row| {
                let row = row.as_array().expect("a row");
                assert_eq!(row.len(), columns, "{}", table["caption"]);
                row
            }) {
                let says = cell.is_number()
                    || cell.as_str().or(cell["none"].as_str()).is_some_and(|text| !text.trim().is_empty());
                assert!(says, "{}: {cell}", table["caption"]);
                assert!(cell["none"].as_str().is_none_or(|why| !why.starts_with("failed")), "{cell}");
            }
        }
    }
    // The paper's printed numbers must be in the tables, beside the measured ones.
    let line = |id: &str, table: usize, row: usize| item(&paper, id)["tables"][table]["rows"][row].clone();
    let wine = serde_json::json!(["Wine", "printed", 8.52, 3.61, 5.24, 0.85, 1.22, 4.46, 6.46, 1.44]);
    assert_eq!(line("table3", 0, 4), wine);
    let signed_rank = line("signed-rank", 0, 0);
    assert_eq!((&signed_rank[3], &signed_rank[4]), (&Value::from(-2.870), &Value::from(0.004)));
    assert!(line("table2", 0, 5)[3].is_number(), "room is not measured: {}", line("table2", 0, 5));
}

#[test]
fn a_plan_is_said_and_nothing_is_made() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = ["paper", "--dry-run", "--scenes", "room", "--cache", "references", "-o", "p", "--json"];
    let done = cyclopean(folder.path(), &arguments);
    assert!(done.status.success(), "{}", stderr(&done));
    let plan: Value = serde_json::from_slice(&done.stdout).expect("one object");
    let pieces = plan["pieces"].as_array().expect("pieces");
    let names: Vec<&str> = pieces.iter().map(|p| p["piece"].as_str().expect("a name")).collect();
    assert_eq!(names.len(), 8 + 1 + 3, "{names:?}");
    assert!(pieces.iter().all(|p| p["seconds"].as_f64().is_some_and(|s| s > 0.0) && p["kept"] == false), "{plan}");
    // No piece is kept yet, so that the time left is the sum of all pieces' times.
    let total: f64 = pieces.iter().filter_map(|p| p["seconds"].as_f64()).sum();
    assert!((plan["seconds_left"].as_f64().expect("seconds") - total).abs() < 1e-6 * total, "{plan}");
    assert!(stderr(&done).contains("from a short probe in room"), "{}", stderr(&done));
    assert_eq!(
        finished(folder.path()).keys().filter(|f| !f.starts_with("cache")).collect::<Vec<_>>(),
        [Path::new("p/work/probe.json")]
    );
}

#[test]
fn impossible_requests_are_refused_before_anything_is_rendered() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (arguments, code, said) in [
        (vec!["paper", "--scenes", "room,room"], 2, "--scenes names room twice"),
        (vec!["paper", "--parts", "everything"], 2, "invalid value 'everything'"),
        (vec!["paper", "--sessions", "nowhere"], 1, "nowhere"),
        (vec!["paper", "--sessions", "a", "--observers", "3"], 2, "cannot be used with"),
        (vec!["paper", "--seeds", "1"], 2, "1 is not in 2..=100000"),
    ] {
        let done = cyclopean(folder.path(), &arguments);
        assert_eq!(done.status.code(), Some(code), "{arguments:?}: {}", stderr(&done));
        assert!(stderr(&done).contains(said), "{arguments:?}: {}", stderr(&done));
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0, "wrong usage wrote something");
}
