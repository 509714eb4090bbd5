//! Tests `render` and `compare` along a path of the head by running the program: the files and figures that they write,
//! and how they refuse an invalid path. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use crate::program::{cyclopean, stderr};

/// The scene `pica` at low detail, with a path of its own that jumps once.
const MANIFEST: &str = r#"{
  "name": "little",
  "geometry": { "builtin": { "name": "pica", "detail": 0.01 } },
  "views": [{ "name": "main", "position": [0.0, 1.2, 3.0], "target": [0.0, 0.6, 0.0] }],
  "paths": [
    { "name": "aside", "rate_hz": 30, "keys": [
      { "time_s": 0.0, "position": [0.0, 1.2, 3.0], "target": [0.0, 0.6, 0.0] },
      { "time_s": 0.1, "position": [0.2, 1.2, 3.0], "target": [0.0, 0.6, 0.0] },
      { "time_s": 0.2, "position": [0.0, 1.4, 2.5], "target": [0.2, 0.6, 0.0], "cut": true },
      { "time_s": 0.3, "position": [0.1, 1.4, 2.5], "target": [0.2, 0.6, 0.0] }
    ] }
  ]
}"#;

fn poses(count: u32) -> String {
    let mut text = r#"{"head_poses":{"format":1,"study":"s","session":"x"}}"#.to_owned() + "\n";
    for i in 0..count {
        let x = 0.01 * f64::from(i);
        let t = 11_111_111 * i;
        text += &format!(r#"{{"pose":{{"t_ns":{t},"position":[{x},1.6,0.0],"orientation":[0.0,0.0,0.0,1.0]}}}}"#);
        text += "\n";
    }
    text
}

#[test]
fn a_path_is_rendered_frame_by_frame_and_compared() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("little.json"), MANIFEST).expect("written");
    std::fs::write(folder.path().join("a.poses.jsonl"), poses(4)).expect("written");
    let common = ["--size", "48x32", "--no-shadows", "--json"];
    for (path, frames, cuts) in [("aside", 10, vec![6]), ("a.poses.jsonl", 4, vec![])] {
        let mut arguments = vec!["render", "little.json", "-m", "stereo-temporal", "--path", path, "-o", path];
        arguments[7] = "seq";
        arguments.extend(common);
        let done = cyclopean(folder.path(), &arguments);
        assert!(done.status.success(), "{}", stderr(&done));
        let file: serde_json::Value = serde_json::from_slice(&done.stdout).expect("one object on stdout");
        let written = file["frames"].as_array().expect("a list");
        assert_eq!(written.len(), frames, "{path}");
        let cut = |f: &serde_json::Value| f["cut"] == true;
        assert_eq!((0..frames).filter(|i| cut(&written[*i])).collect::<Vec<_>>(), cuts, "{path}");
        for frame in written {
            for key in ["exr", "png"] {
                let name = frame[key].as_str().expect("a name");
                assert!(folder.path().join(name).exists(), "{name}");
            }
        }
        assert_eq!((&file["nan"], &file["inf"]), (&0.into(), &0.into()));
    }
    let mut arguments = vec!["compare", "little.json", "--path", "aside", "--methods", "stereo,stereo-temporal"];
    arguments.extend(["--spp", "1,2", "--reference-spp", "16", "-o", "cmp"]);
    arguments.extend(common);
    let done = cyclopean(folder.path(), &arguments);
    assert!(done.status.success(), "{}", stderr(&done));
    let file: serde_json::Value = serde_json::from_slice(&done.stdout).expect("one object on stdout");
    let scene = &file["scenes"][0];
    assert_eq!(scene["cuts"], serde_json::json!([6]));
    let row = |method: &str| {
        let rows = scene["results"].as_array().expect("a list");
        rows.iter().find(|r| r["method"] == method && r["spp"] == 1).expect("a row").clone()
    };
    let (alone, over_time) = (row("stereo"), row("stereo-temporal"));
    for measure in ["mse", "variance", "flicker", "noise_flicker", "noise"] {
        assert!(alone["means"][measure].is_number(), "{measure}: {alone}");
        assert_eq!(alone["by_frame"][measure].as_array().expect("a list").len(), 9, "{measure}");
    }
    let noise = |r: &serde_json::Value| r["means"]["noise_flicker"].as_f64().expect("a number");
    assert!(noise(&over_time) < noise(&alone), "{over_time} and {alone}");
    assert!(over_time["lag_frames"].is_number() && over_time["equal_time"]["ratio"].is_number());
    for name in ["sequence.json", "sequence.md", "little_sequence.svg"] {
        assert!(folder.path().join("cmp").join(name).exists(), "{name}");
    }
}

#[test]
fn what_is_no_path_is_said_in_a_sentence() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let refused = |arguments: &[&str], code: i32, words: &str| {
        let done = cyclopean(folder.path(), arguments);
        let said = stderr(&done);
        assert_eq!(done.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(words) && !said.contains("panicked"), "{arguments:?}: {said}");
    };
    let render = |path| ["render", "pica", "-m", "sssr", "--size", "32x24", "--path", path];
    refused(&render("nowhere"), 2, "has no path `nowhere`; it has: still, sway, cut");
    std::fs::write(folder.path().join("one.poses.jsonl"), poses(1)).expect("written");
    refused(&render("one.poses.jsonl"), 1, "it has 1 poses; a path needs at least two");
    std::fs::write(folder.path().join("bad.poses.jsonl"), "no json\n").expect("written");
    refused(&render("bad.poses.jsonl"), 1, "line 1");
    refused(&render("missing.poses.jsonl"), 1, "missing.poses.jsonl");
    let mut many = render("still").to_vec();
    many.extend(["--frames", "5000"]);
    refused(&many, 2, "--frames 5000 is more than path `still` has: 121 at 60 a second");
    for (name, keys, words) in [
        ("few", r#"[{ "time_s": 0, "position": [0,1,3], "target": [0,0,0] }]"#, "it has 1 poses"),
        (
            "order",
            r#"[{ "time_s": 1, "position": [0,1,3], "target": [0,0,0] }, { "time_s": 0, "position": [0,1,3], "target": [0,0,0] }]"#,
            "pose 2 is not later",
        ),
        (
            "nowhere",
            r#"[{ "time_s": 0, "position": [0,1,3] }, { "time_s": 1, "position": [0,1,3], "target": [0,0,0] }]"#,
            "key 1: give `target` or `orientation`",
        ),
    ] {
        let text = format!(
            r#"{{ "name": "x", "geometry": {{ "builtin": {{ "name": "pica", "detail": 0.01 }} }}, "paths": [{{ "name": "{name}", "keys": {keys} }}] }}"#
        );
        std::fs::write(folder.path().join("x.json"), text).expect("written");
        refused(&["scene", "check", "x.json"], 1, &format!("path `{name}`"));
        refused(&["scene", "check", "x.json"], 1, words);
    }
}
