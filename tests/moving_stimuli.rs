//! Tests moving stimuli from `prepare` to the session and `study show`. The oracle is `render --path`, which must give
//! the same pictures frame by frame. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use serde_json::{Value, json};

use crate::program::{cyclopean, stderr};

const FRAMES: usize = 5;
/// The distance between the eyes of the scene's view.
const IPD_M: f64 = 0.063;

fn study() -> Value {
    json!({
        "format": 1, "id": "moving", "title": "Moving", "seed": 3, "participants": 2, "task": "rate",
        "instructions": "Look.", "question": "How much?", "labels": ["much", "little"], "scale": [1, 2],
        // Five frames at 60 frames per second.
        "protocol": [{"show": "stimulus", "seconds": FRAMES as f64 / 60.0}],
        "blank": {"seconds": 0.1},
        "stimuli": {"width_px": 48, "height_px": 32, "seed": 4, "shadows": false, "ipd_m": IPD_M},
        "conditions": {"cross": {"scene": ["pica"], "path": ["sway"], "method": ["sssr", "stereo-temporal"]}},
        "simulation": {"latent": {"sssr": 1, "stereo-temporal": 2}}
    })
}

#[test]
fn a_moving_stimulus_is_the_path_as_it_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.json"), study().to_string()).unwrap();
    let succeeds = |arguments: &[&str]| {
        let output = cyclopean(folder.path(), arguments);
        assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    };
    succeeds(&["prepare", "study.json"]);
    let objects = folder.path().join("store/objects");
    let stimuli: Vec<(std::path::PathBuf, Value)> = walk(&objects, "stimulus.json")
        .into_iter()
        .map(|path| {
            let side_car = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
            (path.parent().unwrap().to_owned(), side_car)
        })
        .collect();
    assert_eq!(stimuli.len(), 2);
    let picture = |path: &std::path::Path| image::open(path).unwrap().into_rgb8();
    for (stimulus, side_car) in &stimuli {
        assert_eq!(side_car["info"]["film"], json!({"rate_hz": 60.0, "frames": FRAMES}));
        let method = side_car["request"]["method"].as_str().unwrap();
        let out = folder.path().join(method);
        let frames = FRAMES.to_string();
        succeeds(&[
            "render",
            "pica",
            "-m",
            method,
            "--path",
            "sway",
            "--frames",
            &frames,
            "--size",
            "48x32",
            "--seed",
            "4",
            "--fallback",
            "black",
            "--no-shadows",
            "-o",
            out.to_str().unwrap(),
        ]);
        for frame in 0..FRAMES {
            let name = if frame == 0 { "sbs.png".to_owned() } else { format!("sbs_{frame:05}.png") };
            let shown = picture(&stimulus.join(name));
            let rendered = picture(&out.join(format!("pica_sway_{method}_{frame:04}.png")));
            assert_eq!(shown.dimensions(), (96, 32));
            // With the same seed and device the pictures are equal, unless the method has a history. A film begins as
            // after standing still, and `render` begins without a history.
            let differing = shown.pixels().zip(rendered.pixels()).filter(|(a, b)| a != b).count();
            match method {
                "sssr" => assert_eq!(differing, 0, "frame {frame}"),
                _ => assert!(frame > 0 || differing > 0, "the film begins without a history"),
            }
        }
    }
    // Complete stimuli are not rendered again, and a session shows every frame.
    let again = cyclopean(folder.path(), &["prepare", "study.json"]);
    assert!(String::from_utf8_lossy(&again.stdout).contains("2 whole, 0 rendered"), "{again:?}");
    succeeds(&["run", "study.json", "--participant", "p1", "--simulate", "--hz", "60"]);
    let journal = walk(&folder.path().join("sessions"), "jsonl").remove(0);
    let text = std::fs::read_to_string(journal).unwrap();
    let lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let onsets: Vec<usize> = lines
        .filter_map(|line| {
            let segments = line.pointer("/presentation/segments").or(line.pointer("/record/presentation/segments"));
            segments.map(|s| s[0]["film_onsets_ns"].as_array().unwrap().iter().filter(|o| o.is_u64()).count())
        })
        .collect();
    assert_eq!(onsets, [FRAMES; 2]);

    // `study show` renders a trial again, byte for byte and with every frame, and writes a page about the session.
    let journal = walk(&folder.path().join("sessions"), "001.jsonl").remove(0);
    let journal = journal.to_str().unwrap();
    let again = cyclopean(folder.path(), &["study", "show", journal, "--trial", "1"]);
    let said = String::from_utf8_lossy(&again.stdout).into_owned();
    assert!(
        again.status.success() && said.contains("1 of 1 stimuli came out byte for byte"),
        "{said}{}",
        stderr(&again)
    );
    assert_eq!(walk(&folder.path().join("shown/stimulus"), ".png").len(), FRAMES);
    let page = std::fs::read_to_string(folder.path().join("shown/session.html")).unwrap();
    assert!(page.contains("data:image/png;base64,") && page.contains("pica by sssr"), "{}", page.len());
    let all = cyclopean(folder.path(), &["study", "show", journal, "--check", "-o", "all"]);
    assert!(String::from_utf8_lossy(&all.stdout).contains("2 of 2 stimuli came out byte for byte"), "{}", stderr(&all));
    let beyond = cyclopean(folder.path(), &["study", "show", journal, "--trial", "2", "-o", "beyond"]);
    assert_eq!(beyond.status.code(), Some(1));
    assert!(stderr(&beyond).contains("numbered from 0 to 1"), "{}", stderr(&beyond));
}

/// Every file below a folder whose name ends with `end`.
fn walk(folder: &std::path::Path, end: &str) -> Vec<std::path::PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => found.extend(walk(&path, end)),
            false if path.to_string_lossy().ends_with(end) => found.push(path),
            false => {}
        }
    }
    found.sort();
    found
}
