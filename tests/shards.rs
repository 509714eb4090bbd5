//! Tests work in parts (`--shard`) by running the program, with one folder for all parts. Parts run at the same time,
//! run twice, are killed, or have nothing to do. The oracle is the result of a single run. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::path::Path;
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

use crate::program::{self, cyclopean, stderr, tree, unfinished};

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), stderr(output))
}

const SMALL: [&str; 12] = [
    "--size",
    "48x27",
    "--seeds",
    "2",
    "--spp",
    "1",
    "--methods",
    "sssr",
    "--reference-spp",
    "8",
    "--cache",
    "references",
];

#[test]
fn parts_of_a_comparison_come_together_whatever_runs_twice() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = |more: &[&'static str]| [&["compare", "room", "pica"], &SMALL[..], more].concat();
    // Part 0 runs twice at the same time. One of the three parts has no scene.
    let parts = ["0/3", "0/3", "1/3", "2/3"].map(|part| {
        let mut command = program::command(folder.path(), &arguments(&["--keep", "results", "--shard", part]));
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts")
    });
    let parts = parts.map(|child| child.wait_with_output().expect("ended"));
    for (part, done) in parts.iter().enumerate() {
        assert!(done.status.success(), "part {part}: {}", said(done));
    }
    assert!(said(&parts[0]).contains("room: done") && said(&parts[2]).contains("pica: done"), "{}", said(&parts[2]));
    assert!(said(&parts[3]).contains("part 2/3 has nothing to do: there are 2 scenes"), "{}", said(&parts[3]));
    assert!(!folder.path().join("out").exists(), "a part wrote a report");
    let kept = tree(&folder.path().join("results"));
    assert_eq!(kept.len(), 2, "{:?}", kept.keys());

    // The run that merges the parts renders nothing.
    let merged = cyclopean(folder.path(), &arguments(&["--keep", "results"]));
    assert!(merged.status.success(), "{}", said(&merged));
    for name in ["room", "pica"] {
        assert!(stderr(&merged).contains(&format!("{name}: kept from results")), "{}", stderr(&merged));
    }
    assert!(!stderr(&merged).contains("1/"), "{}", stderr(&merged));
    let report: serde_json::Value =
        serde_json::from_slice(&bytes(&folder.path().join("out/compare.json"))).expect("JSON");
    let scenes: Vec<_> = report["scenes"].as_array().expect("scenes").iter().map(|s| s["scene"].as_str()).collect();
    assert_eq!(scenes, [Some("room"), Some("pica")]);
    assert!(tree(&folder.path().join("results")) == kept);

    // The references are the same as those of a single run. With --references-only that run makes nothing else.
    let alone = [&["compare", "room", "pica", "--references-only"], &SMALL[..10], &["--cache", "alone"]].concat();
    let made = cyclopean(folder.path(), &alone);
    assert!(made.status.success() && stderr(&made).contains("reference: "), "{}", said(&made));
    assert!(!stderr(&made).contains("room: 1/"), "{}", stderr(&made));
    let [shared, alone] = ["references", "alone"].map(|name| tree(&folder.path().join(name)));
    assert_eq!(shared.keys().collect::<Vec<_>>(), alone.keys().collect::<Vec<_>>());
    assert!(shared == alone, "the references of the parts differ from those of a single run");
}

#[test]
fn a_part_says_where_its_results_shall_go() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (more, wrong) in [
        (&["--shard", "0/2"][..], "--shard needs --keep DIR"),
        (&["--shard", "2/2", "--keep", "k"], "`2/2` is not `i/n` with i from 0 to n − 1"),
        (&["--shard", "0/2", "--keep", "k", "--effect", "ao"], "are for comparisons of reflections"),
        (&["--references-only", "--path", "sway"], "cannot be used with"),
    ] {
        let done = cyclopean(folder.path(), &[&["compare", "room"], more].concat());
        assert_eq!(done.status.code(), Some(2), "{more:?}: {}", stderr(&done));
        assert!(stderr(&done).contains(wrong), "{more:?}: {}", stderr(&done));
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0, "wrong usage wrote something");
}

const STUDY: &str = r#"{
  "format": 1, "id": "parts", "title": "Parts", "seed": 7, "participants": 4, "task": "rate",
  "instructions": "Look.", "question": "How natural?", "labels": ["not", "rather", "very"], "scale": [1, 2, 3],
  "protocol": [{ "show": "stimulus", "seconds": 2 }],
  "stimuli": { "width_px": 96, "height_px": 54, "samples": { "path-traced": 64 } },
  "conditions": { "cross": { "scene": ["room"], "method": ["path-traced", "sssr"] } },
  "repetitions": 1, "simulation": { "latent": { "sssr": 1, "path-traced": 2 }, "noise_sd": 0.8 }
}"#;

#[test]
#[cfg(unix)]
fn a_preparation_that_was_killed_leaves_nothing_behind_once_the_whole_is_done() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("study.json"), STUDY).expect("written");
    let prepare = |store: &'static str| vec!["prepare", "study.json", "--store", store];
    let alone = cyclopean(folder.path(), &prepare("alone"));
    assert!(alone.status.success(), "{}", said(&alone));

    let store = folder.path().join("store");
    let mut killed = program::command(folder.path(), &[prepare("store"), vec!["--shard", "0/2"]].concat());
    let mut killed = killed.stderr(Stdio::null()).spawn().expect("it starts");
    let start = Instant::now();
    while unfinished(&store).is_empty() {
        assert!(start.elapsed() < Duration::from_secs(60), "no stimulus was begun within a minute");
        assert!(killed.try_wait().expect("a child").is_none(), "the program ended before it was seen at work");
        std::thread::yield_now();
    }
    killed.kill().expect("killed");
    killed.wait().expect("ended");
    assert_eq!(unfinished(&store).len(), 1, "the kill did not leave one unfinished stimulus");

    // No part removes the unfinished file, not even the one that makes the same stimulus.
    for part in ["1/2", "0/2"] {
        let done = cyclopean(folder.path(), &[prepare("store"), vec!["--shard", part]].concat());
        assert!(done.status.success(), "{part}: {}", said(&done));
        assert_eq!(unfinished(&store).len(), 1, "{part}");
    }
    let idle = cyclopean(folder.path(), &[prepare("store"), vec!["--shard", "7/8"]].concat());
    assert!(said(&idle).contains("part 7/8 has nothing to do: the study has 2 stimuli"), "{}", said(&idle));
    let merged = cyclopean(folder.path(), &prepare("store"));
    assert!(said(&merged).contains("2 whole, 0 rendered"), "{}", said(&merged));
    assert!(tree(&store) == tree(&folder.path().join("alone")), "the store differs from that of a single run");
}
