//! Tests the commands `render`, `doctor` and `demo` of the program: what they write, and how they refuse what they
//! cannot do. Needs a Vulkan device. Parts that need `exrheader` or the right to mount are skipped, with a message,
//! without it.
#![cfg(feature = "gpu")]

use std::path::Path;
use std::process::Command;

use crate::program::{self, cyclopean, stderr};

/// The sorted names of the files in a folder, or none if there is no folder.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<_> = entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn render_writes_a_multi_view_exr_a_png_and_a_report() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = ["render", "room", "--method", "sssr", "--size", "96x54", "-o", "r", "--json", "--explain"];
    let done = cyclopean(folder.path(), &arguments);
    assert!(done.status.success(), "{}", stderr(&done));
    let out = folder.path().join("r");
    assert_eq!(names(&out), ["render.json", "room_main_sssr.exr", "room_main_sssr.png"]);
    let file: serde_json::Value =
        serde_json::from_slice(&std::fs::read(out.join("render.json")).expect("read")).expect("JSON");
    let printed: serde_json::Value = serde_json::from_slice(&done.stdout).expect("one object on stdout");
    assert_eq!(file, printed);
    for key in [
        "scene", "method", "width", "height", "seed", "device", "passes", "left_out", "nan", "inf", "clamped", "missed",
    ] {
        assert!(!file[key].is_null(), "render.json lacks `{key}`");
    }
    assert!(file["passes"][0]["ms"].as_f64().expect("a number") > 0.0);
    let why = file["left_out"].as_array().expect("a list").iter().find(|p| p["name"] == "path_trace");
    assert_eq!(why.expect("path_trace is left out")["why"], "the method asks the views");

    // OpenEXR's own tool must find both views.
    match Command::new("exrheader").arg(out.join("room_main_sssr.exr")).output() {
        Err(error) => println!("skipped the check by exrheader, which is not installed: {error}"),
        Ok(header) => {
            let text = String::from_utf8_lossy(&header.stdout).into_owned();
            for word in ["multiView (type stringvector):", "\"left\"", "\"right\"", "right.G, 32-bit"] {
                assert!(text.contains(word), "{word} in {text}");
            }
        }
    }
}

#[test]
fn wrong_usage_gives_one_sentence_and_exit_status_2() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (arguments, said) in [
        (vec!["render", "room", "--method", "magic"], "unknown method `magic`; known: sssr"),
        (vec!["render", "room", "--method", "sssr", "--size", "0x10"], "WIDTHxHEIGHT"),
        (vec!["render", "room", "--method", "sssr", "--size", "1000000x1000000"], "1 to 16383"),
        (vec!["render", "room", "--method", "sssr", "--spp", "0"], "1..=65536"),
        (vec!["render", "room", "--method", "sssr", "--view", "nowhere"], "has no view `nowhere`; it has: main"),
        (vec!["render", "room"], "--method"),
    ] {
        let done = cyclopean(folder.path(), &arguments);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}: {}", stderr(&done));
        assert!(stderr(&done).contains(said), "{arguments:?}: {}", stderr(&done));
        assert!(!stderr(&done).contains("panicked"), "{}", stderr(&done));
        assert!(!names(folder.path()).contains(&"out".to_owned()), "{arguments:?} wrote something");
    }
}

#[test]
fn files_that_cannot_be_read_or_written_give_one_sentence_and_exit_status_1() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("broken.gltf"), b"{ \"asset\": ").expect("written");
    let extension = br#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_magic"],"extensionsUsed":["KHR_magic"]}"#;
    std::fs::write(path("magic.gltf"), extension).expect("written");
    std::fs::write(path("file"), b"").expect("written");
    for (arguments, said) in [
        (vec!["render", "missing.gltf", "--method", "sssr"], "missing.gltf"),
        (vec!["render", "nothing", "--method", "sssr"], "unknown scene `nothing`"),
        (vec!["render", "broken.gltf", "--method", "sssr"], "broken.gltf"),
        (vec!["render", "magic.gltf", "--method", "sssr"], "KHR_magic"),
        (vec!["render", "room", "--method", "sssr", "--size", "16x16", "-o", "file/below"], "file/below"),
        (vec!["render", "room", "--method", "sssr", "--size", "16x16", "--device", "no such device"], "no such device"),
    ] {
        let done = cyclopean(folder.path(), &arguments);
        assert_eq!(done.status.code(), Some(1), "{arguments:?}: {}", stderr(&done));
        let said_it = stderr(&done);
        assert!(said_it.starts_with("error: ") && said_it.contains(said), "{arguments:?}: {said_it}");
        assert!(!said_it.contains("panicked"), "{said_it}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_leaves_nothing_under_a_final_name() {
    // The test mounts a file system of 64 KiB, which needs the right to mount.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let small = folder.path().join("small");
    std::fs::create_dir(&small).expect("made");
    let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]).arg(&small).status();
    if !mounted.is_ok_and(|status| status.success()) {
        println!("skipped: this user may not mount a small file system");
        return;
    }
    let done = cyclopean(folder.path(), &["render", "room", "--method", "sssr", "--size", "320x180", "-o", "small"]);
    let left = names(&small);
    let unmounted = Command::new("umount").arg(&small).status().expect("unmounted");
    assert!(unmounted.success());
    assert_eq!(done.status.code(), Some(1), "{}", stderr(&done));
    assert!(stderr(&done).contains("room_main_sssr.exr"), "{}", stderr(&done));
    assert_eq!(left, Vec::<String>::new(), "part of the output was left");
}

#[test]
fn doctor_names_the_device() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let done = cyclopean(folder.path(), &["doctor", "--json"]);
    assert!(done.status.success(), "{}", stderr(&done));
    let found: serde_json::Value = serde_json::from_slice(&done.stdout).expect("one object");
    assert!(
        found["findings"].as_array().expect("a list").iter().any(|f| f["what"] == "device in use" && f["ok"] == true)
    );
    // A machine without a graphics card can render, and `doctor` says that it renders in software. With `--hardware`,
    // which asks for a card, `doctor` fails there.
    let software = found["software"].as_bool().expect("known where a device is");
    assert_eq!(software, found["device"]["kind"] == "cpu");
    let asked = cyclopean(folder.path(), &["doctor", "--hardware"]);
    assert_eq!(asked.status.code(), Some(i32::from(software)), "{}", stderr(&asked));
    assert_eq!(stderr(&asked).contains("error: graphics card: none in use: the processor renders"), software);
}

#[test]
#[cfg(target_os = "linux")]
fn doctor_fails_with_the_remedy_where_nothing_renders() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let without = |arguments: &[&str]| {
        let mut command = program::command(folder.path(), arguments);
        let none = folder.path().join("no-driver.json");
        command.env("VK_DRIVER_FILES", &none).env("VK_ICD_FILENAMES", &none).env_remove("CYCLOPEAN_VALIDATION");
        command.output().expect("the program starts")
    };
    let done = without(&["doctor", "--json"]);
    assert_eq!(done.status.code(), Some(1), "{}", stderr(&done));
    let found: serde_json::Value = serde_json::from_slice(&done.stdout).expect("one object");
    assert!(found["device"].is_null() && found["software"].is_null(), "{found}");
    let findings = found["findings"].as_array().expect("a list");
    for what in ["Vulkan devices", "device in use"] {
        let finding = findings.iter().find(|f| f["what"] == what).expect("a finding");
        assert!(finding["ok"] == false && finding["mend"].as_str().expect("a remedy").contains("mesa-vulkan-drivers"));
    }
    let said = stderr(&done);
    assert!(said.contains("mesa-vulkan-drivers") && !said.contains("panicked"), "{said}");
    let done = without(&["doctor"]);
    assert!(String::from_utf8_lossy(&done.stdout).contains("MISSING  Vulkan devices"), "{}", stderr(&done));
}

#[test]
fn the_demo_ends_with_a_table_and_a_page() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let done = cyclopean(folder.path(), &["demo", "--out", "d", "--observers", "3", "--size", "48x27"]);
    assert!(done.status.success(), "{}", stderr(&done));
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    for word in ["SIMULATED", "pica", "room", "wine", "sssr", "stereo", "path-traced", "n=3", "90 %", "report.html"] {
        assert!(said.contains(word), "{word} in {said}");
    }
    let page = std::fs::read_to_string(folder.path().join("d/report.html")).expect("a page");
    assert!(page.contains("data:image/png;base64,") && page.to_lowercase().contains("simulated"));
    // A folder that holds other sessions is left alone.
    std::fs::create_dir_all(folder.path().join("mine/sessions")).expect("made");
    let refused = cyclopean(folder.path(), &["demo", "--out", "mine"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains("no demo made"), "{}", stderr(&refused));
}
