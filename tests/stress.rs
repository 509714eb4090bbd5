//! Tests `cyclopean stress` by running the program: every case must pass, and with an impossible bound a case must
//! fail. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::program::stderr;

/// Cases that fail for a known reason. Whoever corrects one removes it from this list.
const KNOWN: &[&str] = &[];

fn stress(folder: &Path, arguments: &[&str]) -> (Output, Value) {
    let done = Command::new(env!("CARGO_BIN_EXE_cyclopean"))
        .args(["stress", "--json", "-o", "out"])
        .args(arguments)
        .current_dir(folder)
        .env("CYCLOPEAN_VALIDATION", "1")
        .output()
        .expect("the program starts");
    let report = serde_json::from_slice(&done.stdout).unwrap_or(Value::Null);
    (done, report)
}

#[test]
fn every_case_stays_within_its_bound() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (done, report) = stress(folder.path(), &[]);
    let failed: Vec<&str> = report["failed"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    assert_eq!(failed, KNOWN, "{}\n{:#}", stderr(&done), report["cases"]);
    assert_eq!(done.status.code(), Some(i32::from(!failed.is_empty())), "{}", stderr(&done));
    let cases = report["cases"].as_array().expect("a list");
    assert!(cases.len() >= 40, "{} cases", cases.len());
    for case in cases {
        for key in ["name", "hazard", "checks", "unit", "at"] {
            assert!(case[key].as_str().is_some_and(|s| !s.is_empty()), "{key}: {case}");
        }
        assert!(
            case["worst"].is_number()
                && (case["bound"]["at_most"].is_number() || case["bound"]["at_least"].is_number())
        );
    }
    let sweeps = report["sweeps"].as_array().expect("a list");
    assert!(sweeps.iter().all(|s| s["rows"].as_array().is_some_and(|r| r.len() >= 6)), "{sweeps:?}");
    let file = std::fs::read(folder.path().join("out/stress.json")).expect("stress.json");
    assert_eq!(serde_json::from_slice::<Value>(&file).expect("JSON"), report);
}

#[test]
fn a_bound_that_cannot_be_kept_fails_with_pictures() {
    for (bound, name) in [("mirror-ball=-1", "mirror-ball"), ("fp16-overflow-counted=1e9", "fp16-overflow-counted")] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (done, report) = stress(folder.path(), &["--only", name, "--bound", bound]);
        assert_eq!(done.status.code(), Some(1), "{}", stderr(&done));
        assert_eq!(report["failed"], serde_json::json!([name]));
        assert!(stderr(&done).contains(name), "{}", stderr(&done));
        let pictures =
            std::fs::read_dir(folder.path().join("out").join(name)).expect("a folder with pictures of the failed case");
        let names: Vec<String> = pictures.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        assert!(names.iter().any(|n| n.ends_with(".exr")) && names.iter().any(|n| n.ends_with(".png")), "{names:?}");
        assert_eq!(report["pictures"].as_array().map(Vec::len), Some(names.len()));
    }
}

#[test]
fn a_sweep_fails_too() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (done, report) = stress(folder.path(), &["--only", "place", "--bound", "place=1e-9"]);
    assert_eq!(done.status.code(), Some(1), "{}", stderr(&done));
    // The case `singular-placement` also has `place` in its name, and must pass.
    assert_eq!(report["failed"], serde_json::json!(["place"]));
}

#[test]
fn wrong_names_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for arguments in [&["--only", "no-such-case"][..], &["--bound", "no-such-case=1"], &["--bound", "mirror"]] {
        let (done, _) = stress(folder.path(), arguments);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}: {}", stderr(&done));
    }
    assert!(!folder.path().join("out").exists(), "a folder was made although the request was refused");
}
