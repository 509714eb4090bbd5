//! Runs `examples/analysis.py` and `examples/analysis.R` on an export and compares their tables with those of `mos`.
//! Needs Python with pandas and SciPy, or R. A test is skipped, with a message, where the interpreter or a library is
//! missing.

use std::path::{Path, PathBuf};
use std::process::Command;

use cyclopean_analysis::journal::Kind;
use serde_json::Value;

#[path = "../examples/journals.rs"]
#[allow(dead_code, reason = "the example's own main is not run here")]
mod journals;

/// Relative tolerance, because the programs add the same numbers in another order.
const TOLERANCE: f64 = 1e-12;

fn mos(folder: &Path, arguments: &[&str]) -> Vec<u8> {
    let out = Command::new(env!("CARGO_BIN_EXE_mos")).current_dir(folder).args(arguments).output().unwrap();
    assert!(out.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&out.stderr));
    out.stdout
}

fn object(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_slice(&mos(folder, arguments)).unwrap()
}

/// Writes 14 sessions with three scenes, three methods and two repetitions. One of them is cut off after three
/// quarters.
fn sessions(folder: &Path) {
    for session in 0..14 {
        let bytes = journals::lines(session, 3, 2, Kind::Simulated, false).unwrap();
        let kept = if session == 5 { bytes.len() * 3 / 4 } else { bytes.len() };
        let whole = bytes[..kept].iter().rposition(|b| *b == b'\n').unwrap() + 1;
        let path = folder.join(format!("sessions/p{session:02}/001.jsonl"));
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, &bytes[..whole]).unwrap();
    }
}

/// Returns the first program that can run `probe`. If there is none, prints why the test is skipped.
fn interpreter(names: &[&'static str], flag: &str, probe: &str, needs: &str) -> Option<&'static str> {
    let runs = |name: &&&str| Command::new(name).args([flag, probe]).output().is_ok_and(|out| out.status.success());
    let found = names.iter().find(runs).copied();
    if found.is_none() {
        println!("skipped: {needs} is not installed");
    }
    found
}

/// Runs a script of `examples/` on an export. Returns the folder, and the rows and the headers of the two tables that
/// it wrote.
fn rows(interpreter: &str, script: &str) -> (tempfile::TempDir, [Vec<csv::StringRecord>; 2], [csv::StringRecord; 2]) {
    let folder = tempfile::tempdir().unwrap();
    sessions(folder.path());
    mos(folder.path(), &["export", "sessions", "-o", "export"]);
    let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../examples").join(script);
    let mut run = Command::new(interpreter);
    let out = run.arg(script).args(["export", "stereo", "sssr"]).current_dir(folder.path()).output().unwrap();
    let (said, failed) = (String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr));
    assert!(out.status.success(), "{failed}");
    assert!(said.contains("*** SIMULATED data ***"), "{said}");
    let [mos, test] = ["mos.csv", "test.csv"].map(|name| {
        let mut reader = csv::Reader::from_path(folder.path().join("export").join(name)).unwrap();
        (reader.headers().unwrap().clone(), reader.records().map(Result::unwrap).collect::<Vec<_>>())
    });
    (folder, [mos.1, test.1], [mos.0, test.0])
}

#[track_caller]
fn close(found: &str, expected: &Value, what: &str) {
    let (found, expected): (f64, f64) = (found.parse().unwrap(), expected.as_f64().unwrap());
    assert!((found - expected).abs() <= TOLERANCE * expected.abs().max(1.0), "{what}: {found}, mos has {expected}");
}

/// Compares a script's tables with those of `mos`. `of_test` pairs the columns of the script's `test.csv` with the keys
/// of `mos test`.
fn agrees(interpreter: &str, script: &str, of_test: &[(&str, &str)]) {
    let (folder, [cells, tests], [mos_head, test_head]) = rows(interpreter, script);
    let at = |head: &csv::StringRecord, name: &str| head.iter().position(|h| h == name).unwrap();
    let table = object(folder.path(), &["table", "sessions", "--json"]);
    let table = table["rows"].as_array().unwrap();
    assert_eq!((table.len(), cells.len()), (9, 9));
    for row in table {
        let is_it = |cell: &&csv::StringRecord| {
            ["scene", "method"].iter().all(|factor| row[*factor] == cell[at(&mos_head, factor)])
        };
        let cell = cells.iter().find(is_it).unwrap();
        for key in ["n", "mean", "sd", "lo", "hi"] {
            close(&cell[at(&mos_head, key)], &row[key], &format!("{key} of {row}"));
        }
    }
    let said = object(folder.path(), &["test", "sessions", "--contrast", "method=stereo,sssr", "--json"]);
    let contrast = &said["contrasts"][0];
    assert_eq!(contrast["n"], 13, "the session that was cut off must be left out: {contrast}");
    for (column, key) in of_test {
        close(&tests[0][at(&test_head, column)], &contrast[*key], key);
    }
    close(&tests[0][at(&test_head, "mean_difference")], &contrast["difference"]["mean"], "mean difference");
}

#[test]
fn pandas_and_scipy_find_what_mos_finds() {
    let names = ["python3", "/usr/bin/python3", "python"];
    let Some(python) = interpreter(&names, "-c", "import pandas, scipy.stats", "Python with pandas and SciPy") else {
        return;
    };
    let of_test = [
        ("n", "n"),
        ("zeros", "n_zero"),
        ("r_plus", "r_plus"),
        ("r_minus", "r_minus"),
        ("z", "z"),
        ("p_exact", "p_exact"),
        ("p_asymptotic", "p_asymptotic"),
    ];
    agrees(python, "analysis.py", &of_test);
}

#[test]
fn r_finds_what_mos_finds() {
    let Some(r) = interpreter(&["Rscript"], "-e", "wilcox.test", "R") else { return };
    let of_test = [
        ("n", "n"),
        ("zeros", "n_zero"),
        ("r_plus", "r_plus"),
        ("r_minus", "r_minus"),
        ("p_asymptotic", "p_asymptotic"),
    ];
    agrees(r, "analysis.R", &of_test);
}
