//! Tests whole simulated sessions by running the program, from prepared stimuli to the journal and its votes. Needs no
//! GPU.

use std::process::Stdio;

use cyclopean::study::session;
use cyclopean_analysis::journal::record::{Kind, Outcome, Record};
use cyclopean_analysis::journal::{self, collect};

use crate::lab::{Lab, Painter, rate, stderr};

#[test]
fn a_simulated_session_runs_to_the_end_and_its_votes_come_back() {
    let lab = Lab::new(&rate(&["pica", "room", "wine"], 2));
    let output = lab.simulate("s01", &["--json"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let said: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&said["outcome"], &said["kind"]), (&"completed".into(), &"simulated".into()));

    let votes = collect(&lab.journal("s01", "001")).unwrap();
    assert_eq!((votes.kind, votes.outcome), (Kind::Simulated, Some(Outcome::Completed)));
    assert_eq!((votes.votes.len(), votes.missing.len()), (12, 0));
    let mean = |method: &str| {
        let of: Vec<i32> =
            votes.votes.iter().filter(|v| votes.level(v, "method") == Some(method)).map(|v| v.rating).collect();
        assert_eq!(of.len(), 6);
        of.iter().sum::<i32>()
    };
    assert!(mean("path-traced") > mean("sssr"));
    let proof = session::prove_order(&lab.journal("s01", "001")).unwrap();
    assert_eq!((proof.row, proof.presentations), (0, 13));
    let replayed = lab.program(&["study", "replay", "sessions/rate/s01/001.jsonl"]);
    assert!(replayed.status.success(), "{}", stderr(&replayed));
}

#[test]
fn the_journal_says_everything_before_the_first_trial_and_is_for_its_owner_alone() {
    let lab = Lab::new(&rate(&["pica"], 1));
    assert!(lab.simulate("s01", &[]).status.success());
    let path = lab.journal("s01", "001");
    let entries: Vec<_> = journal::read(&path).unwrap().map(Result::unwrap).collect();
    let ready = entries.iter().position(|e| matches!(e.record, Record::Ready(_))).unwrap();
    let before = &entries[..ready];
    let count = |f: fn(&Record) -> bool| before.iter().filter(|e| f(&e.record)).count();
    assert_eq!(count(|r| matches!(r, Record::Header(_))), 1);
    assert_eq!(count(|r| matches!(r, Record::Stimulus(s) if s.files.len() == 2 && s.scene_sha256.is_some())), 3);
    assert_eq!(count(|r| matches!(r, Record::Condition(_))), 3);
    assert_eq!(count(|r| matches!(r, Record::Planned(_))), 3);
    let Record::Header(header) = &entries[0].record else { panic!("no header") };
    assert_eq!(header.study.text, std::fs::read_to_string(lab.study()).unwrap());
    assert!(entries.iter().all(|e| e.kind == Kind::Simulated));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        assert_eq!(std::fs::metadata(path.parent().unwrap()).unwrap().permissions().mode() & 0o777, 0o700);
    }
}

#[test]
fn participants_get_rows_of_their_own_and_kinds_do_not_share_them() {
    let lab = Lab::new(&rate(&["pica", "room"], 1));
    for (i, id) in ["s01", "s02", "s03"].iter().enumerate() {
        assert!(lab.simulate(id, &[]).status.success());
        assert_eq!(collect(&lab.journal(id, "001")).unwrap().header.row, i as u64);
    }
    let twice = lab.simulate("s02", &[]);
    assert_eq!(twice.status.code(), Some(1));
    assert!(stderr(&twice).contains("has completed this study in session 001"), "{}", stderr(&twice));

    // After a withdrawal the row is free, and no file has the participant's id.
    let gone = lab.program(&["study", "withdraw", "study.json", "--participant", "s02"]);
    assert!(gone.status.success(), "{}", stderr(&gone));
    let folder = lab.sessions().join("rate");
    let tree = walk(&folder);
    assert!(tree.iter().all(|(path, text)| !path.contains("s02") && !text.contains("s02")), "{tree:?}");
    assert_eq!(std::fs::read_dir(folder.join(".withdrawn")).unwrap().count(), 1);
    assert!(lab.simulate("s04", &[]).status.success());
    assert_eq!(collect(&lab.journal("s04", "001")).unwrap().header.row, 1);
    let again = lab.program(&["study", "withdraw", "study.json", "--participant", "s02"]);
    assert_eq!(again.status.code(), Some(1));
    assert!(stderr(&again).contains("no data of participant `s02`"));
}

fn walk(folder: &std::path::Path) -> Vec<(String, String)> {
    let mut out = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            out.extend(walk(&path));
        }
        out.push((path.display().to_string(), std::fs::read_to_string(&path).unwrap_or_default()));
    }
    out
}

#[test]
fn nothing_begins_while_a_stimulus_is_missing_or_damaged() {
    let lab = Lab::new(&rate(&["pica"], 1));
    let object = std::fs::read_dir(lab.path("store/objects")).unwrap().next().unwrap().unwrap().path();
    let entry = std::fs::read_dir(object).unwrap().next().unwrap().unwrap().path();
    let png = entry.join("sbs.png");
    let mut bytes = std::fs::read(&png).unwrap();
    bytes[40] ^= 1;
    std::fs::write(&png, bytes).unwrap();
    let output = lab.simulate("s01", &[]);
    assert_eq!(output.status.code(), Some(1));
    let said = stderr(&output);
    assert!(
        said.contains("1 of 3 stimuli") && said.contains("damaged") && said.contains("cyclopean prepare"),
        "{said}"
    );
    assert!(!lab.sessions().exists());

    // `prepare` finds the damaged stimulus and renders only this one again.
    let mut painter = Painter::default();
    let report = lab.prepare(&mut painter);
    assert_eq!((painter.rendered, report.damaged.len(), report.whole.len()), (1, 1, 2));
    assert!(lab.simulate("s01", &[]).status.success());
}

#[test]
fn wrong_usage_and_wrong_input_get_a_sentence_and_a_code() {
    let lab = Lab::new(&rate(&["pica"], 1));
    let cases: [(&[&str], i32, &str); 8] = [
        (&["run", "study.json", "--participant", "s01"], 2, "--simulate"),
        (&["run", "study.json", "--participant", "a b", "--simulate"], 2, "not 1 to 32 letters"),
        (&["run", "study.json", "--participant", "../x", "--simulate"], 2, "not 1 to 32 letters"),
        (&["run", "study.json", "--participant", "s01", "--simulate", "--hz", "0"], 2, "--hz"),
        (
            &["run", "study.json", "--participant", "s01", "--display", "openxr", "--simulate"],
            2,
            "only with `--display headless`",
        ),
        (&["run", "none.json", "--participant", "s01", "--simulate"], 1, "cannot read study none.json"),
        (&["run", "study.json", "--participant", "s01", "--simulate", "--resume", "--yes"], 1, "no unfinished session"),
        (&["study", "replay", "study.json"], 1, "line 1"),
    ];
    for (args, code, words) in cases {
        let output = lab.program(args);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {said}");
        assert!(said.contains(words) && !said.contains("panicked"), "{args:?}: {said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{args:?}: {said}");
    }
}

#[test]
fn two_programs_cannot_write_one_journal() {
    let lab = Lab::new(&rate(&["pica"], 1));
    assert!(lab.simulate("s01", &[]).status.success());
    let path = lab.journal("s01", "001");
    let held = std::fs::File::open(&path).unwrap();
    held.lock().unwrap();
    let recover = lab.program(&["study", "recover", path.to_str().unwrap()]);
    assert_eq!(recover.status.code(), Some(1));
    assert!(stderr(&recover).contains("in use by another program"), "{}", stderr(&recover));
    let withdraw = lab.program(&["study", "withdraw", "study.json", "--participant", "s01"]);
    assert!(stderr(&withdraw).contains("in use by another program"), "{}", stderr(&withdraw));
    assert!(path.exists());
}

#[test]
fn programs_at_once_get_rows_of_their_own_and_one_participant_sits_once() {
    let lab = Lab::new(&rate(&["pica", "room"], 1));
    let start = |id: &str| {
        let args = ["run", "study.json", "--participant", id, "--simulate"];
        lab.command(&args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    let ids: Vec<String> = (0..6).map(|i| format!("s{i}")).collect();
    let all: Vec<_> = ids.iter().map(|id| start(id)).collect();
    assert!(all.into_iter().all(|mut child| child.wait().unwrap().success()));
    let mut rows: Vec<u64> = ids.iter().map(|id| collect(&lab.journal(id, "001")).unwrap().header.row).collect();
    rows.sort_unstable();
    assert_eq!(rows, [0, 1, 2, 3, 4, 5]);
    let same: Vec<_> = (0..4).map(|_| start("twin")).collect();
    let succeeded = same.into_iter().filter_map(|mut c| c.wait().ok()).filter(|status| status.success()).count();
    assert_eq!(succeeded, 1);
}

#[test]
fn a_lost_list_of_rows_is_made_again_from_the_journals() {
    let lab = Lab::new(&rate(&["pica", "room"], 1));
    assert!(lab.simulate("s01", &[]).status.success());
    assert!(lab.simulate("s02", &[]).status.success());
    let list = lab.sessions().join("rate/rows.json");
    let before = std::fs::read_to_string(&list).unwrap();
    std::fs::remove_file(&list).unwrap();
    assert!(stderr(&lab.simulate("s02", &[])).contains("has completed this study in session 001"));
    assert!(lab.simulate("s03", &[]).status.success());
    assert_eq!(collect(&lab.journal("s03", "001")).unwrap().header.row, 2);
    assert!(
        std::fs::read_to_string(&list).unwrap().starts_with(before.trim_end().trim_end_matches(['}', ']', '\n', ' ']))
    );
    std::fs::write(&list, "{").unwrap();
    let damaged = lab.simulate("s04", &[]);
    assert_eq!(damaged.status.code(), Some(1));
    assert!(stderr(&damaged).contains("rows.json is damaged"), "{}", stderr(&damaged));
}

#[test]
fn simulated_observers_can_judge_what_the_renderer_measured() {
    let mut study = rate(&["pica", "room", "wine"], 3);
    study["simulation"] = serde_json::json!({"from_inconsistency": {"at_zero": 5, "slope": -20}});
    let lab = Lab::new(&study);
    assert!(lab.simulate("s01", &[]).status.success());
    let votes = collect(&lab.journal("s01", "001")).unwrap();
    for vote in &votes.votes {
        // The painter reports an inconsistency of 0.2 for `sssr` and 0 for the other method.
        let expected = if votes.level(vote, "method") == Some("sssr") { 1 } else { 5 };
        assert_eq!(vote.rating, expected);
    }
    study["simulation"] = serde_json::json!({"latent": {"sssr": 3}});
    let lab = Lab::new(&study);
    let output = lab.simulate("s01", &[]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        stderr(&output).contains("simulation.latent: has no value for method `path-traced`"),
        "{}",
        stderr(&output)
    );
    assert!(!lab.sessions().exists());
}
