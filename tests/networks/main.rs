//! Tests measures by networks that the user names. One network, which the test writes itself, computes the mean squared
//! difference; the program's own MSE is its oracle. A published network is compared with PyTorch, where PyTorch and the
//! network's package are installed. Most tests need a build with the feature `networks`.

#[cfg(feature = "networks")]
mod onnx;

use std::path::Path;

use cyclopean::picture::{Part, StereoPicture, write_exr};

use crate::program::{cyclopean, stderr};

const SIZE: (u32, u32) = (24, 21);

/// Writes two pictures with different values.
fn pictures(folder: &Path) {
    let (width, height) = SIZE;
    for (name, phase) in [("a.exr", 0.0f32), ("b.exr", 0.4)] {
        let eye = |eye: f32| -> Vec<[f32; 3]> {
            let value = |i: u32, channel: f32| (0.1 * i as f32 + channel + phase * eye).sin().powi(2);
            (0..width * height).map(|i| [0.0, 1.0, 2.0].map(|channel| value(i, channel))).collect()
        };
        let picture = StereoPicture { width, height, eyes: [eye(1.0), eye(2.0)] };
        write_exr(&folder.join(name), &[Part { layer: "", picture: &picture }]).expect("written");
    }
}

#[cfg(not(feature = "networks"))]
#[test]
fn a_build_without_networks_says_how_to_build_one_with_them() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    pictures(folder.path());
    std::fs::write(folder.path().join("n.onnx"), "").expect("written");
    let output = cyclopean(folder.path(), &["compare", "a.exr", "b.exr", "--lpips", "n.onnx"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("--features networks"), "{}", stderr(&output));
}

#[cfg(feature = "networks")]
mod with_networks {
    use std::path::PathBuf;
    use std::process::Command;

    use serde_json::Value;

    use super::onnx::{broken_networks, mean_square, with_smallest_side};
    use super::*;

    fn json(folder: &Path, arguments: &[&str]) -> Value {
        let output = cyclopean(folder, &[&["--json"], arguments].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).expect("JSON")
    }

    #[test]
    fn a_network_of_the_mean_square_gives_the_mean_square() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        pictures(folder.path());
        std::fs::write(folder.path().join("n.onnx"), mean_square()).expect("written");
        let found = json(folder.path(), &["compare", "a.exr", "b.exr", "--lpips", "n.onnx"]);
        for eye in ["left", "right"] {
            let composite = &found[eye]["composite"];
            let [network, ours] = ["lpips", "tonemapped_mse"].map(|key| composite[key].as_f64().expect("a number"));
            assert!(ours > 1e-3 && (network - ours).abs() < 1e-6 * ours.max(1.0), "{eye}: {network}, not {ours}");
            assert!(
                composite.get("dists").is_none(),
                "there is a number for DISTS, although no network was named for it"
            );
        }
        let without = json(folder.path(), &["compare", "a.exr", "b.exr"]);
        assert!(without["left"]["composite"].get("lpips").is_none());
        let alike = json(folder.path(), &["compare", "a.exr", "a.exr", "--dists", "n.onnx"]);
        assert_eq!(alike["left"]["composite"]["dists"], 0.0);
        let table = cyclopean(folder.path(), &["compare", "a.exr", "b.exr", "--lpips", "n.onnx"]);
        assert!(String::from_utf8_lossy(&table.stdout).contains("LPIPS"));
    }

    #[test]
    fn what_is_no_network_is_refused_with_one_sentence() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        pictures(folder.path());
        let refused = |name: &str, code: i32, says: &str| {
            let output = cyclopean(folder.path(), &["compare", "a.exr", "b.exr", "--lpips", name]);
            let text = stderr(&output);
            assert_eq!(output.status.code(), Some(code), "{name}: {text}");
            assert!(text.contains(says) && text.contains("--lpips") && !text.contains("panicked"), "{name}: {text}");
            assert_eq!(text.trim().lines().count(), 1, "{name}: {text}");
        };
        refused("none.onnx", 1, "cannot read");
        for (name, bytes, says) in broken_networks() {
            std::fs::write(folder.path().join(name), bytes).expect("written");
            refused(name, 1, says);
        }
        std::fs::write(folder.path().join("large.onnx"), with_smallest_side("22")).expect("written");
        refused("large.onnx", 2, "at least 22×22 pixels, and these have 24×21");
        assert!(Command::new("mkfifo").arg(folder.path().join("pipe.onnx")).status().expect("mkfifo").success());
        refused("pipe.onnx", 1, "a named pipe");
        std::fs::write(folder.path().join("fits.onnx"), with_smallest_side("21")).expect("written");
        json(folder.path(), &["compare", "a.exr", "b.exr", "--lpips", "fits.onnx"]);
    }

    /// Whatever byte is damaged, the reader must give a network or an error, and must not panic.
    #[test]
    fn a_damaged_network_never_ends_the_program_by_surprise() {
        let whole = with_smallest_side("21");
        let reference = vec![[0.5; 3]; 21 * 21];
        for at in 0..whole.len() {
            for flip in [0x01, 0x10, 0x80] {
                let mut bytes = whole.clone();
                bytes[at] ^= flip;
                if let Ok(network) = cyclopean::metrics::network::Network::new("lpips", &bytes) {
                    let _ = network.distance((21, 21), &reference, &reference);
                }
            }
            let _ = cyclopean::metrics::network::Network::new("lpips", &whole[..at]);
        }
    }

    #[cfg(feature = "gpu")]
    #[test]
    fn a_comparison_has_columns_of_its_networks_and_keeps_them_apart() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("n.onnx"), mean_square()).expect("written");
        let small = "--size 48x27 --seeds 2 --spp 1 --methods sssr,stereo --reference-spp 8 --no-shadows --keep kept --cache references";
        let arguments: Vec<&str> = ["compare", "room"].into_iter().chain(small.split(' ')).collect();
        let markdown = || std::fs::read_to_string(folder.path().join("out/compare.md")).expect("written");
        let without = json(folder.path(), &arguments);
        assert!(markdown().contains("LPIPS and DISTS are absent") && without.get("networks").is_none());
        let with = json(folder.path(), &[&arguments[..], &["--lpips", "n.onnx"]].concat());
        assert_eq!(
            std::fs::read_dir(folder.path().join("kept")).expect("kept").count(),
            2,
            "not one kept result with the network and one without"
        );
        assert_eq!(with["networks"]["lpips"].as_str().map(str::len), Some(64));
        for row in with["scenes"][0]["results"].as_array().expect("rows") {
            let eye = &row["left"];
            let [network, ours] = ["lpips", "composite_tonemapped_mse"].map(|key| eye[key].as_f64().expect("a number"));
            assert!((network - ours).abs() < 1e-6 && eye["reflection_lpips"].as_f64().is_some(), "{row}");
            assert!(eye.get("dists").is_none(), "{row}");
        }
        let ratios = with["scenes"][0]["equal_sample"].as_array().expect("ratios");
        assert!(ratios.iter().any(|r| r["measure"] == "lpips"), "{ratios:?}");
        let text = markdown();
        assert!(
            text.contains("| LPIPS | LPIPS, reflection |") && text.contains("LPIPS by the network with SHA-256"),
            "{text}"
        );
        // A network that cannot be used fails before anything is rendered.
        std::fs::write(folder.path().join("large.onnx"), with_smallest_side("28")).expect("written");
        let arguments = [&arguments[..], &["--lpips", "large.onnx", "-o", "other"]].concat();
        let output = cyclopean(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(!folder.path().join("other").exists());
    }

    /// Compares with PyTorch's own numbers for the same pictures. The test is skipped, with a message, where PyTorch or
    /// the network's package is not installed, unless `CYCLOPEAN_REQUIRE_PYTORCH` is 1.
    #[test]
    fn a_published_network_gives_what_pytorch_gives() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let scripts = Path::new(env!("CARGO_MANIFEST_DIR"));
        let python = std::env::var("CYCLOPEAN_PYTHON").unwrap_or_else(|_| "python3".to_owned());
        let run = |script: PathBuf, arguments: &[&str]| {
            Command::new(&python).arg(script).args(arguments).current_dir(folder.path()).output()
        };
        let scores = run(scripts.join("tests/networks/scores.py"), &["st-lpips-alex", "n.onnx", "scores.txt"]);
        let required = std::env::var("CYCLOPEAN_REQUIRE_PYTORCH").is_ok_and(|v| v == "1");
        match scores {
            Ok(output) if output.status.success() => {}
            other => {
                let why = other.map_or_else(|e| e.to_string(), |output| stderr(&output));
                assert!(!required, "{why}");
                eprintln!("skipped: {}", why.lines().last().unwrap_or_default());
                return;
            }
        }
        let onnx = std::fs::read(folder.path().join("n.onnx")).expect("exported");
        let network = cyclopean::metrics::network::Network::new("lpips", &onnx).expect("a network");
        let scores = std::fs::read_to_string(folder.path().join("scores.txt")).expect("scores");
        let mut worst = 0.0f64;
        for line in scores.lines() {
            let numbers: Vec<f64> = line.split(' ').map(|n| n.parse().expect("a number")).collect();
            let (width, height) = (numbers[0] as usize, numbers[1] as usize);
            // The same pictures as in scores.py.
            let picture = |phase: f64| -> Vec<[f32; 3]> {
                let value = |i: usize, channel: f64| (0.5 + 0.5 * (0.37 * i as f64 + channel + phase).sin()) as f32;
                (0..width * height).map(|i| [0.0, 1.0, 2.0].map(|channel| value(i, channel))).collect()
            };
            let found = network.distance((width, height), &picture(0.0), &picture(numbers[2]));
            let found = found.expect("pictures that are large enough").expect("a finite number");
            worst = worst.max((found - numbers[3]).abs());
            assert!((found - numbers[3]).abs() < 1e-4, "{width}×{height}: {found}, not {}", numbers[3]);
        }
        println!("{} pairs, PyTorch and this program differ by {worst:.1e} at the most", scores.lines().count());
        assert!(matches!(
            network.prepare((20, 64)),
            Err(cyclopean::metrics::network::NetworkError::TooSmall { least: 21, .. })
        ));
    }
}
