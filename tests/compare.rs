//! Tests `cyclopean compare` by running the program: its reports and sheets, the references and results that it keeps,
//! and how it refuses what it cannot compare. Comparing scenes needs a Vulkan device; comparing two pictures does not.

use std::path::Path;
#[cfg(feature = "gpu")]
use std::process::Output;

use cyclopean::picture::{Part, StereoPicture, write_exr};
use serde_json::Value;

use crate::program::{cyclopean, stderr};

fn json(bytes: &[u8]) -> Value {
    serde_json::from_slice(bytes).expect("one JSON object")
}

/// A pattern of this size. The right eye has the left one's pattern, shifted by three pixels.
fn picture(width: u32, height: u32, offset: f32) -> StereoPicture {
    let eye = |shift: u32| -> Vec<[f32; 3]> {
        let at = |i: u32| ((i % width + shift) as f32, (i / width) as f32);
        (0..width * height)
            .map(|i| [0.0, 1.0, 2.0].map(|c| offset + (at(i).0 * 0.3 + at(i).1 * 0.2 + c).sin().abs()))
            .collect()
    };
    StereoPicture { width, height, eyes: [eye(0), eye(3)] }
}

fn write(folder: &Path, name: &str, color: &StereoPicture, reflection: Option<&StereoPicture>) {
    let mut parts = vec![Part { layer: "", picture: color }];
    parts.extend(reflection.map(|picture| Part { layer: "reflection", picture }));
    write_exr(&folder.join(name), &parts).expect("written");
}

#[test]
fn two_pictures_are_compared_without_a_gpu() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (a, b) = (picture(24, 16, 0.0), picture(24, 16, 0.1));
    write(folder.path(), "a.exr", &a, Some(&a));
    write(folder.path(), "b.exr", &b, Some(&b));
    let done = cyclopean(folder.path(), &["compare", "a.exr", "b.exr", "--json"]);
    assert!(done.status.success(), "{}", stderr(&done));
    let report = json(&done.stdout);
    assert_eq!((&report["width"], &report["height"]), (&24.into(), &16.into()));
    for eye in ["left", "right"] {
        for layer in ["composite", "reflection"] {
            let scores = &report[eye][layer];
            let mse = scores["mse"].as_f64().expect("a number");
            assert!((mse - 0.01).abs() < 1e-6, "{eye} {layer}: {mse}");
            for key in ["rse", "relmse", "tonemapped_mse", "ssim", "flip"] {
                assert!(scores[key].as_f64().is_some_and(|v| v > 0.0), "{eye} {layer} {key}: {scores}");
            }
        }
    }
    let same = cyclopean(folder.path(), &["compare", "a.exr", "a.exr", "--json"]);
    let scores = &json(&same.stdout)["left"]["composite"];
    assert_eq!((&scores["mse"], &scores["flip"]), (&0.0.into(), &0.0.into()));
    assert!((scores["ssim"].as_f64().expect("a number") - 1.0).abs() < 1e-12);

    // A picture without a reflection layer, such as another program's, is compared without it.
    write(folder.path(), "plain.exr", &b, None);
    let done = cyclopean(folder.path(), &["compare", "a.exr", "plain.exr"]);
    assert!(done.status.success(), "{}", stderr(&done));
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(said.contains("left composite") && !said.contains("reflection"), "{said}");
}

#[test]
fn what_cannot_be_compared_is_said() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(folder.path(), "a.exr", &picture(24, 16, 0.0), None);
    write(folder.path(), "small.exr", &picture(12, 16, 0.0), None);
    std::fs::write(folder.path().join("broken.exr"), b"no picture").expect("written");
    for (arguments, code, said) in [
        (vec!["compare", "a.exr"], 2, "two pictures are compared"),
        (vec!["compare", "a.exr", "room"], 2, "two pictures are compared"),
        (vec!["compare", "a.exr", "a.exr", "a.exr"], 2, "two pictures are compared"),
        (vec!["compare", "a.exr", "small.exr"], 2, "a.exr has 24×16 pixels an eye and small.exr has 12×16"),
        (
            vec!["compare", "a.exr", "a.exr", "--pixels-per-degree", "0"],
            2,
            "--pixels-per-degree 0 is not within 1 to 1000",
        ),
        (vec!["compare", "a.exr", "a.exr", "--exposure", "nan"], 2, "--exposure NaN is not above 0"),
        (vec!["compare", "a.exr", "broken.exr"], 1, "broken.exr"),
        (vec!["compare", "a.exr", "missing.exr"], 1, "missing.exr"),
        (vec!["compare"], 2, "SCENE"),
    ] {
        let done = cyclopean(folder.path(), &arguments);
        assert_eq!(done.status.code(), Some(code), "{arguments:?}: {}", stderr(&done));
        assert!(stderr(&done).contains(said), "{arguments:?}: {}", stderr(&done));
        assert!(done.stdout.is_empty(), "{arguments:?}");
    }
}

#[cfg(not(feature = "gpu"))]
#[test]
fn a_build_that_renders_nothing_says_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let done = cyclopean(folder.path(), &["compare", "room"]);
    assert_eq!(done.status.code(), Some(1));
    assert!(stderr(&done).contains("renders nothing"), "{}", stderr(&done));
}

#[cfg(feature = "gpu")]
mod scenes {
    use std::collections::BTreeMap;
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;

    use super::*;
    use crate::program;

    const SMALL: [&str; 8] = ["--size", "64x36", "--seeds", "3", "--reference-spp", "16", "--cache", "kept"];

    fn compare(folder: &Path, scenes: &[&str], more: &[&str]) -> Output {
        let arguments = [&["compare"], scenes, &SMALL, more].concat();
        cyclopean(folder, &arguments)
    }

    fn number(value: &Value) -> f64 {
        value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
    }

    #[test]
    fn a_scene_gives_json_tables_and_a_plot() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let more =
            ["--spp", "1,2", "--fallback", "both", "--methods", "sssr,stereo,path-traced@2", "--json", "-o", "o"];
        // The second scene fails, but the first one's results must be written.
        let done = compare(folder.path(), &["room", "nowhere"], &more);
        assert_eq!(done.status.code(), Some(1), "{}", stderr(&done));
        assert!(stderr(&done).contains("1 of 2 scenes failed: nowhere: unknown scene"), "{}", stderr(&done));
        let out = folder.path().join("o");
        let read = |name: &str| std::fs::read(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        let report = json(&read("compare.json"));
        assert_eq!(report, json(&done.stdout));
        assert_eq!((&report["width"], &report["height"]), (&64.into(), &36.into()));
        assert!(report["device"]["name"].is_string());
        assert_eq!(report["failed"][0]["scene"], "nowhere");
        let scene = &report["scenes"][0];
        assert_eq!(scene["scene"], "room");
        let fallback = scene["results"].as_array().expect("rows").iter().filter(|r| r["fallback"] == "black").count();
        assert_eq!(fallback, 5, "sssr and stereo with 1 and 2 rays a pixel, path-traced with 2");
        for row in scene["results"].as_array().expect("rows") {
            let name = format!("{}@{}", row["method"], row["spp"]);
            assert_eq!(row["seeds"], 3, "{name}");
            let ms = |group: &str| number(&row["ms"][group]);
            assert!(ms("total") > 0.0 && ms("total") >= ms("trace_resolve"), "{name}: {}", row["ms"]);
            assert!(ms("trace") > 0.0, "{name}");
            for eye in ["left", "right"] {
                let errors = ["rse", "relmse", "mse", "tonemapped_mse", "composite_tonemapped_mse", "variance"];
                for key in errors.into_iter().chain(["ssim", "flip", "reflection_ssim", "reflection_flip"]) {
                    assert!(number(&row[eye][key]) > 0.0, "{name} {eye} {key}: {}", row[eye]);
                }
                let [low, high] = [0, 1].map(|i| number(&row[eye]["intervals"]["mse"][i]));
                assert!(low < number(&row[eye]["mse"]) && number(&row[eye]["mse"]) < high, "{name} {eye}");
                // bias² + variance is the mean squared error.
                let parts = number(&row[eye]["bias2"]) + number(&row[eye]["variance"]);
                assert!((parts / number(&row[eye]["mse"]) - 1.0).abs() < 1e-4, "{name} {eye}: {parts}");
            }
            assert!((0.0..=1.0).contains(&number(&row["systematic_inconsistency"])), "{name}");
            assert!(number(&row["noise_variance"]) >= 0.0, "{name}");
            let within = |value: &Value, interval: &Value| {
                let [low, high] = [0, 1].map(|i| number(&interval[i]));
                let (value, rounding) = (number(value), 1e-9 * number(value).abs());
                assert!(low <= value + rounding && value - rounding <= high, "{name}: {value} in {interval}");
            };
            within(&row["systematic_inconsistency"], &row["systematic_inconsistency_interval"]);
            within(&row["noise_variance"], &row["noise_variance_interval"]);
            let unbiased = &row["systematic_unbiased"];
            within(&unbiased["squared"], &unbiased["interval"]);
            let root = number(&unbiased["squared"]).max(0.0).sqrt();
            assert!((number(&unbiased["rms"]) - root).abs() < 1e-12, "{name}: {unbiased}");
            // With three seeds each group of the jackknife is one seed.
            assert_eq!(row["jackknife"]["seeds"], serde_json::json!([1, 1, 1]), "{name}");
            for key in ["systematic_unbiased", "systematic_inconsistency", "noise_variance"] {
                assert_eq!(row["jackknife"][key].as_array().map(Vec::len), Some(3), "{name} {key}");
            }
            let fireflies = ["left", "right"].map(|eye| number(&row[eye]["fireflies"]));
            assert_eq!(number(&row["fireflies_total"]) > 0.0, fireflies[0] + fireflies[1] > 0.0, "{name}");
            let measures = &row["rounds"]["measures"];
            for key in ["tonemapped_mse", "composite_tonemapped_mse", "fireflies"] {
                assert_eq!(measures[key].as_array().map(Vec::len), Some(3), "{name} {key}");
            }
            let over = |percent: &str| number(&row["noise_over"][percent]);
            assert!(over("2") >= over("5") && over("5") >= over("10") && over("10") >= over("20"), "{name}");
        }
        assert!(number(&scene["pairs"]["used"]) > 20.0, "{}", scene["pairs"]);
        assert!((0.0..1.0).contains(&number(&scene["pairs"]["floor"])));
        let ratio = |list: &str, key: &str, value: &str| {
            let all = scene[list].as_array().expect("a list").iter();
            all.filter(|r| r["method"] == "stereo" && r[key] == value).count()
        };
        assert!(ratio("equal_sample", "measure", "mse") >= 2);
        assert!(ratio("overhead", "group", "total") >= 2);
        assert!(ratio("equal_time", "fallback", "black") == 2);
        // A measure without a ratio must be listed in `left_out` instead.
        for measure in ["relmse", "tonemapped_mse", "systematic_unbiased", "noise_variance", "bias2"] {
            let named = ratio("equal_sample", "measure", measure) + ratio("left_out", "measure", measure);
            assert_eq!(named, ratio("equal_sample", "measure", "mse"), "{measure}");
        }
        for r in scene["equal_time"].as_array().expect("a list") {
            for key in ["relmse", "tonemapped_mse"] {
                let quotient = number(&r[key]) / number(&r[format!("baseline_{key}")]);
                assert!((number(&r[format!("{key}_ratio")]) / quotient - 1.0).abs() < 1e-9, "{key}: {r}");
            }
        }
        let noise = |r: &&Value| r["measure"] == "noise_variance" && !r["interval"].is_null();
        assert!(scene["equal_sample"].as_array().expect("a list").iter().any(|r| noise(&r)));
        let summary = report["summary"].as_array().expect("a list");
        for measure in ["equal_time_relmse", "equal_time_tonemapped_mse", "tonemapped_mse", "ms_total"] {
            assert!(summary.iter().any(|s| s["measure"] == measure && s["scenes"] == 1), "{measure}");
        }
        for s in summary {
            let left_out = s["left_out"].as_array().expect("a list");
            assert_eq!(number(&s["scenes"]) + left_out.len() as f64, 1.0, "{s}");
            assert!(left_out.iter().all(|l| l["scene"] == "room" && l["why"].is_string()), "{s}");
            assert_eq!(s["geomean"].is_null(), s["scenes"] == 0, "{s}");
        }
        let plots: Vec<String> = std::fs::read_dir(&out)
            .expect("the folder")
            .flatten()
            .map(|e| e.file_name().to_string_lossy().into_owned())
            .filter(|n| n.ends_with(".svg"))
            .collect();
        assert!(!plots.is_empty());
        for plot in plots {
            let svg = String::from_utf8(read(&plot)).expect("UTF-8");
            assert!(svg.starts_with("<svg") && svg.contains(">stereo</text>") && !svg.contains("NaN"), "{plot}");
        }
        let tables = String::from_utf8(read("compare.md")).expect("UTF-8");
        for column in ["tone-mapped MSE", "fireflies a megapixel", "lasting contrast², unbiased", "relMSE ratio"] {
            assert!(tables.contains(column), "{column}: {tables}");
        }
        assert!(tables.contains("Equal time") && tables.contains("**nowhere failed:**"), "{tables}");
        // `mos report --metrics` must be able to read the file.
        let metrics = cyclopean_analysis::report::metrics_from_compare(&out.join("compare.json")).expect("understood");
        assert!(metrics.iter().any(|m| m.scene == "room" && m.method == "stereo"));
    }

    /// The pixels of the left eye's whole view in one row of a sheet.
    fn left_view(sheet: &image::RgbImage, row: u32) -> Vec<u8> {
        // From `src/compare/sheet/layout.rs`: the sheet's head is 152 pixels high and each row 462. In a row the
        // pictures are 192 pixels high, below 46 pixels of text.
        let view = image::imageops::crop_imm(sheet, 40, 152 + row * 462 + 46, 341, 192);
        view.to_image().into_raw()
    }

    #[test]
    fn a_sheet_has_a_row_a_method_and_the_same_bytes_every_time() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let run = |out: &str, methods: &str| {
            let more = ["--spp", "1", "--sheets", "--methods", methods, "-o", out];
            let done = compare(folder.path(), &["room"], &more);
            assert!(done.status.success(), "{}", stderr(&done));
            std::fs::read(folder.path().join(out).join("room_steps.png")).expect("a sheet")
        };
        let png = run("a", "sssr,stereo-no-fade,stereo");
        assert!(png == run("b", "sssr,stereo-no-fade,stereo"), "the same request gave another sheet");
        let sheet = image::load_from_memory(&png).expect("a PNG").to_rgb8();
        // The sheet has a row for the reference and for each method. Each row has the whole view and three enlarged
        // parts.
        assert_eq!(sheet.dimensions(), (2 * 40 + 688 + 3 * (34 + 390), 152 + 4 * 462 + 40 - 26));
        let views: Vec<Vec<u8>> = (0..4).map(|row| left_view(&sheet, row)).collect();
        for a in 0..4 {
            assert!((0..a).all(|b| views[a] != views[b]), "row {a} has the same picture as another row");
        }
        // With a single method the sheet has two rows: the reference and the method.
        let alone = image::load_from_memory(&run("c", "sssr")).expect("a PNG").to_rgb8();
        assert_eq!(alone.dimensions(), (sheet.width(), 152 + 2 * 462 + 40 - 26));
    }

    #[test]
    fn a_reference_is_kept_verified_and_made_again_when_damaged() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let run = |out: &str| {
            let done = compare(folder.path(), &["room"], &["--spp", "1", "--methods", "sssr", "-o", out, "--json"]);
            assert!(done.status.success(), "{}", stderr(&done));
            let report = json(&done.stdout);
            (stderr(&done), report["scenes"][0].clone())
        };
        let (said, first) = run("a");
        assert!(said.contains("reference:"), "{said}");
        let kept = folder.path().join("kept").join(first["reference"]["key"].as_str().expect("a key"));
        let (said, second) = run("b");
        assert!(!said.contains("reference:"), "the reference was made twice: {said}");
        assert_eq!(first["pairs"], second["pairs"]);
        let errors = |scene: &Value| scene["results"][0]["left"].clone();
        assert_eq!(errors(&first), errors(&second), "the same seeds gave other errors");

        let exr = kept.join("reference.exr");
        let mut bytes = std::fs::read(&exr).expect("read");
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        std::fs::write(&exr, bytes).expect("written");
        let (said, third) = run("c");
        assert!(said.contains("reference.exr does not match its digest; it is made again"), "{said}");
        assert_eq!(errors(&first), errors(&third));
    }

    /// Every file of a folder, by its name.
    fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
        let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
        let name = |path: &Path| path.file_name().expect("a name").to_string_lossy().into_owned();
        entries.map(|path| (name(&path), std::fs::read(&path).expect("read"))).collect()
    }

    #[test]
    fn kept_results_are_taken_to_the_byte_and_made_again_when_damaged() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let run = |out: &str, more: &[&str]| {
            let kept = ["--spp", "1", "--keep", "results", "-o", out];
            let done = compare(folder.path(), &["room"], &[&kept[..], more].concat());
            assert!(done.status.success(), "{}", stderr(&done));
            stderr(&done)
        };
        // Whenever the scene is rendered, at least one line of progress is printed.
        let measured = |said: &str| said.contains("room: 1/");
        let results = folder.path().join("results");
        assert!(measured(&run("a", &["--sheets"])));
        let first = files(&folder.path().join("a"));
        assert!(first.keys().any(|name| name.ends_with(".svg")) && first.keys().any(|name| name.ends_with(".png")));
        let kept = files(&results);
        assert_eq!(kept.len(), 2, "not just results and a sheet are kept: {:?}", kept.keys());

        let said = run("b", &["--sheets"]);
        assert_eq!(said.matches("room: kept from results/").count(), 1, "{said}");
        assert!(!said.contains("1/"), "something was rendered: {said}");
        assert!(files(&folder.path().join("b")) == first, "the report of kept results differs from the first one");
        assert!(files(&results) == kept, "the kept results were written again");

        // A damaged sheet is drawn again without measuring the scene again.
        let (sheet, png) = kept.iter().find(|(name, _)| name.ends_with("_black.png")).expect("a sheet");
        std::fs::write(results.join(sheet), &png[..png.len() - 9]).expect("written");
        let said = run("c", &["--sheets"]);
        assert!(said.contains("_black.png: it does not match its digest; the sheets are drawn again"), "{said}");
        assert!(!measured(&said) && files(&folder.path().join("c")) == first, "{said}");
        assert!(files(&results) == kept);

        // A changed number in the kept results is noticed.
        let (name, json) = kept.iter().find(|(name, _)| name.ends_with(".json")).expect("results");
        let text = String::from_utf8(json.clone()).expect("UTF-8").replacen(
            "\"fireflies_total\": ",
            "\"fireflies_total\": 9",
            1,
        );
        std::fs::write(results.join(name), text).expect("written");
        let said = run("d", &[]);
        assert!(said.contains(&format!("{name}: it does not match its digest; the scene is measured again")), "{said}");
        assert!(measured(&said));
        assert!(run("e", &[]).contains("room: kept from"));
        assert_eq!(files(&folder.path().join("d"))["compare.json"], files(&folder.path().join("e"))["compare.json"]);

        // A request that gives other numbers does not use the kept results.
        for more in [&["--pixels-per-degree", "60"], &["--edge-fade", "0.2"], &["--methods", "stereo,sssr"]] {
            assert!(measured(&run("f", more)), "{more:?}");
        }
    }

    #[test]
    fn a_comparison_that_was_killed_goes_on_at_the_scene_it_was_in() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let more = ["--spp", "1", "--keep", "results", "-o", "o"];
        let arguments = [&["compare", "room", "pica"], &SMALL[..], &more].concat();
        let mut child = program::command(folder.path(), &arguments).stderr(Stdio::piped()).spawn().expect("it starts");
        let lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
        let seen: Vec<String> = lines.map(|l| l.expect("text")).take_while(|l| !l.starts_with("pica: 1/")).collect();
        child.kill().expect("killed");
        assert!(!child.wait().expect("ended").success() && seen.iter().any(|l| l.starts_with("room: 1/")), "{seen:?}");
        let before = files(&folder.path().join("results"));
        assert_eq!(before.len(), 1, "{:?}", before.keys());

        let done = compare(folder.path(), &["room", "pica"], &more);
        let said = stderr(&done);
        assert!(done.status.success() && said.contains("room: kept from") && !said.contains("room: 1/"), "{said}");
        assert!(said.contains("pica: 1/"), "{said}");
        let report = json(&std::fs::read(folder.path().join("o/compare.json")).expect("read"));
        let (_, kept) = before.iter().next().expect("a file");
        assert_eq!(
            report["scenes"][0],
            json(kept)["content"]["scene"],
            "the kept scene has other results than those of the first run"
        );
        assert_eq!(report["scenes"][1]["scene"], "pica");
    }

    #[test]
    fn a_reference_grows_to_the_same_bits_and_stops_where_it_is_good_enough() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let small = ["compare", "room", "--size", "48x27", "--seeds", "2", "--methods", "sssr", "--spp", "1", "--json"];
        let run = |cache: &str, more: &[&str]| {
            let done = cyclopean(folder.path(), &[&small[..], &["--cache", cache], more].concat());
            assert!(done.status.success(), "{}", stderr(&done));
            let reference = json(&done.stdout)["scenes"][0]["reference"].clone();
            let key = reference["key"].as_str().expect("a key").to_owned();
            (reference["spp"].as_u64().expect("a count"), key, stderr(&done))
        };
        let bytes = |cache: &str, key: &str| {
            let read = |name| std::fs::read(folder.path().join(cache).join(key).join(name)).expect("read");
            ["reference.exr", "again.exr"].map(read)
        };
        run("grown", &["--reference-spp", "8"]);
        let (_, key, _) = run("grown", &["--reference-spp", "40"]);
        assert_eq!(run("fresh", &["--reference-spp", "40"]).1, key);
        assert!(
            bytes("grown", &key) == bytes("fresh", &key),
            "a reference that grew differs from one that was made at once"
        );
        // With --until the reference has the same number of paths with kept paths as without, whether fewer paths than
        // the kept ones suffice or more are needed.
        for until in ["30%", "18%"] {
            let (spp, key, _) = run("grown", &["--until", until]);
            let (again, same, said) = run("grown", &["--until", until]);
            assert_eq!((again, &same), (spp, &key));
            assert!(!said.contains("reference:"), "the reference was made twice: {said}");
            assert_eq!(run("fresh", &["--until", until]).1, key);
            assert!(bytes("grown", &key) == bytes("fresh", &key), "until {until}, {spp} paths");
            assert!((16..1000).contains(&spp), "until {until}: {spp} paths");
            println!("until {until}: {spp} paths");
        }
        // The paths of a seed are kept in one file, however many they are.
        let kept = std::fs::read_dir(folder.path().join("grown").join("paths")).expect("a folder").count();
        assert!(kept <= 2, "{kept} files");
    }

    #[test]
    fn wrong_usage_gives_exit_status_2() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (arguments, said) in [
            (vec!["compare", "room", "--methods", "magic"], "unknown method `magic`"),
            (vec!["compare", "room", "--seeds", "1"], "2..=100000"),
            (vec!["compare", "room", "--spp", "0"], "1..=65536"),
            (vec!["compare", "room", "--edge-fade", "0.7"], "outside 0 to 0.5"),
            (vec!["compare", "room", "--exposure", "2"], "a scene says its own"),
            (vec!["compare", "room", "--until", "0.01"], "no percentage above 0"),
            (vec!["compare", "room", "--shard", "0/2", "--keep", "k", "--effect", "ao"], "not for --effect ao"),
            (vec!["compare", "room", "--keep", "k", "--path", "sway"], "cannot be used with"),
        ] {
            let done = cyclopean(folder.path(), &arguments);
            assert_eq!(done.status.code(), Some(2), "{arguments:?}: {}", stderr(&done));
            assert!(stderr(&done).contains(said), "{arguments:?}: {}", stderr(&done));
        }
    }
}
