//! Tests the five built-in scenes: their roughness against Table 1 of the paper, their meshes, manifests and exports,
//! and the commands `scene list`, `scene check` and `scene export`. Needs no GPU.

use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

use cyclopean::scene::manifest::{Geometry, Manifest};
use cyclopean::scene::survey::{Survey, survey};
use cyclopean::scene::{self, Scene, builtin};

/// Table 1 of the paper: each scene with the least, the largest and the mean roughness of its reflective materials.
const TABLE_1: [(&str, f32, f32, f32); 5] = [
    ("pica", 0.069, 0.600, 0.421),
    ("room", 0.0, 0.634, 0.390),
    ("wine", 0.0, 0.597, 0.517),
    ("pink", 0.054, 0.679, 0.488),
    ("temple", 0.036, 0.624, 0.416),
];

/// A built-in scene at low detail, which has the same materials, views and lights but loads faster. Each is loaded
/// once.
fn coarse(name: &str) -> &'static Scene {
    static SCENES: LazyLock<Vec<Scene>> = LazyLock::new(|| {
        let load = |name: &&str| {
            scene::load_with(name, scene::Loading { detail: Some(0.02), ..Default::default() })
                .unwrap_or_else(|e| panic!("{name}: {e}"))
        };
        builtin::NAMES.iter().map(load).collect()
    });
    SCENES.iter().find(|s| s.name == name).expect("a built-in scene")
}

fn detail(name: &str) -> f64 {
    let manifest: Manifest = serde_json::from_str(builtin::manifest(name).expect("a manifest")).expect("valid");
    match manifest.geometry {
        Some(Geometry::Builtin { detail, .. }) => detail,
        _ => panic!("the geometry of {name} is not a built-in one"),
    }
}

/// The signed volume of a primitive, which is positive if its triangles face outwards.
fn volume(p: &scene::Primitive) -> f64 {
    let at = |i: u32| p.positions[i as usize].as_dvec3();
    p.indices.chunks(3).map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6.0).sum()
}

#[test]
fn materials_are_of_table_1s_kind() {
    for (name, low, high, mean) in TABLE_1 {
        let found: Survey = survey(coarse(name));
        let [least, most, average] = found.roughness.expect("reflective materials");
        println!("{name}: {} reflective, {least:.3} to {most:.3}, mean {average:.3}", found.reflective_materials);
        assert!((28..=80).contains(&found.reflective_materials), "{name}: {}", found.reflective_materials);
        assert!((least - low).abs() < 0.04 && (most - high).abs() < 0.04, "{name}: {least} to {most}");
        assert!((average - mean).abs() < 0.08, "{name}: {average}, the paper has {mean}");
        assert!(found.lights >= 3 && found.views[..2] == ["main", "close"], "{name}");
        assert!(
            // Window panes, lamp shades and lanterns let light through.
            found.repairs.is_empty() && found.warnings.iter().all(|w| w.contains("transmit light")),
            "{name}: {:?} {:?}",
            found.repairs,
            found.warnings
        );
        assert_eq!(found.closed_share, 1.0, "{name}");
        assert_eq!(found.moving > 0, ["pink", "temple"].contains(&name), "{name}");
    }
}

#[test]
fn triangle_counts_are_right_at_default_and_full_detail() {
    for name in builtin::NAMES {
        let (usual, _) = builtin::count(name, detail(name)).expect("counted");
        assert!((120_000..260_000).contains(&usual), "{name}: {usual} triangles by default");
        let (full, _) = builtin::count(name, 1.0).expect("counted");
        println!("{name}: {usual} by default, {full} at full detail");
        assert!((250_000..3_400_000).contains(&full), "{name}: {full} triangles at full detail");
    }
}

#[test]
fn solids_face_outwards_and_have_unit_normals_on_their_side() {
    for name in builtin::NAMES {
        let scene = coarse(name);
        for p in &scene.primitives {
            assert!(volume(p) > 0.0, "{name}: `{}` is inside out", p.name);
            // A shading normal that is turned away from its face would light the wrong side.
            let against = p.indices.chunks(3).filter(|t| {
                let [a, b, c] = [t[0], t[1], t[2]].map(|i| p.positions[i as usize]);
                let face = (b - a).cross(c - a).normalize_or_zero();
                t.iter().any(|i| p.normals[*i as usize].dot(face) < -0.1)
            });
            let share = against.count() as f32 / (p.indices.len() / 3) as f32;
            // Bent leaves at the coarsest detail have a few such triangles at their tips.
            assert!(share < 0.06, "{name}: `{}`: {share} of its triangles have normals turned away", p.name);
        }
    }
}

#[test]
fn the_same_bytes_every_time_and_an_export_is_the_same_scene() {
    let (a, b) = (builtin::generate("pica", 0.02).expect("made"), builtin::generate("pica", 0.02).expect("made"));
    assert!(a.gltf == b.gltf && a.files == b.files);
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("pica");
    let done = Command::new(env!("CARGO_BIN_EXE_cyclopean"))
        .args(["scene", "export", "pica", "--detail", "0.02", "--json", "-o"])
        .arg(&out)
        .output()
        .expect("started");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let said: serde_json::Value = serde_json::from_slice(&done.stdout).expect("one JSON object");
    assert!(said["files"].as_array().is_some_and(|f| f.len() > 5), "{said}");
    let exported = scene::load(&out.join("pica.gltf").to_string_lossy()).unwrap_or_else(|error| panic!("{error}"));
    let own = coarse("pica");
    assert_eq!(exported.content_sha256, own.content_sha256);
    assert_eq!(exported.primitives.len(), own.primitives.len());
    assert!(
        exported
            .primitives
            .iter()
            .zip(&own.primitives)
            .all(|(a, b)| a.positions == b.positions && a.indices == b.indices)
    );
    assert_eq!(exported.views, own.views);
    // The manifest beside it can be loaded as well, and gives the same scene.
    let through =
        scene::load(&out.join("pica.cyclopean.json").to_string_lossy()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(through.content_sha256, own.content_sha256);
}

#[test]
fn moving_things_move_and_stills_know_where_they_were() {
    let mut scene = coarse("pink").clone();
    let moved = |s: &Scene| s.instances.iter().filter(|i| i.world_from_object != i.previous_world_from_object).count();
    assert!(moved(&scene) > 0, "at t = 0 no instance has another previous place");
    let before = scene.instances.clone();
    scene.set_time(1.0, 1.0 / 90.0);
    let elsewhere =
        scene.instances.iter().zip(&before).filter(|(a, b)| a.world_from_object != b.world_from_object).count();
    assert_eq!(elsewhere, moved(&scene));
}

#[test]
fn manifests_refuse_what_they_do_not_know_and_name_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("x.json");
    let error = |text: &str| {
        std::fs::write(&path, text).expect("written");
        scene::load(&path.to_string_lossy()).map(|_| ()).expect_err("refused").to_string()
    };
    let with = |more: &str| format!(r#"{{"name":"x","geometry":{{"builtin":{{"name":"pica","detail":0.02}}}}{more}}}"#);
    for (text, word) in [
        (with(r#","colour":1"#), "colour"),
        (r#"{"name":"x"}"#.to_owned(), "geometry"),
        (r#"{"name":"x","geometry":{"builtin":{"name":"attic","detail":1}}}"#.to_owned(), "attic"),
        (r#"{"name":"x","geometry":{"file":"none.gltf"}}"#.to_owned(), "none.gltf"),
        (with(r#","views":[{"name":"v","position":[0,0,0]}]"#), "view `v`"),
        (with(r#","views":[{"name":"v","position":[0,0,0],"target":[0,0,0]}]"#), "same point"),
        (with(r#","motion":[{"node":"ghost","path":{"spin":{"period_s":1}}}]"#), "ghost"),
        (with(r#","exposure":0"#), "exposure"),
        (with(r#","environment":{"map":{"file":"sky.hdr"}}"#), "sky.hdr"),
        (with(r#","lights":[{"kind":"point","position":[0,0,0],"intensity":[-1,0,0]}]"#), "lights[0]"),
    ] {
        let error = error(&text);
        assert!(error.contains(word), "{error:?} should say {word:?}");
    }
}

#[test]
fn files_in_the_scenes_folder_are_the_built_in_ones() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for name in builtin::NAMES {
        let text = std::fs::read_to_string(folder.join(format!("{name}.json"))).expect("a manifest");
        assert_eq!(Some(text.as_str()), builtin::manifest(name));
    }
    let list =
        Command::new(env!("CARGO_BIN_EXE_cyclopean")).args(["scene", "list", "--json"]).output().expect("started");
    let list: serde_json::Value = serde_json::from_slice(&list.stdout).expect("one JSON object");
    assert_eq!(list["scenes"].as_array().map(Vec::len), Some(5));
}

#[test]
fn wrong_requests_exit_with_their_code_and_one_sentence() {
    let run = |args: &[&str]| Command::new(env!("CARGO_BIN_EXE_cyclopean")).args(args).output().expect("started");
    for (args, code, word) in [
        (vec!["scene", "check", "attic"], 1, "attic"),
        (vec!["scene", "check", "no/such.gltf"], 1, "no/such.gltf"),
        (vec!["scene", "export", "attic"], 2, "attic"),
        (vec!["scene", "check", "room", "--detail", "1000"], 2, "1000"),
    ] {
        let done = run(&args);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(code), "{args:?}: {said}");
        assert!(said.contains(word) && said.lines().count() == 1, "{args:?}: {said}");
    }
}

#[test]
fn the_schema_in_the_scenes_folder_is_the_types_own_and_the_manifests_follow_it() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/schema.json");
    let schema = serde_json::to_value(schemars::schema_for!(Manifest)).expect("a schema");
    let text = format!("{}\n", serde_json::to_string_pretty(&schema).expect("text"));
    if std::env::var_os("CYCLOPEAN_RENEW").is_some() {
        std::fs::write(&path, &text).expect("written");
    }
    let stored = std::fs::read_to_string(&path).expect("scenes/schema.json");
    assert_eq!(stored, text, "scenes/schema.json is outdated; run this test once with CYCLOPEAN_RENEW=1");
    let validator = jsonschema::validator_for(&schema).expect("a valid schema");
    for name in builtin::NAMES {
        let manifest = serde_json::from_str(builtin::manifest(name).expect("a manifest")).expect("JSON");
        assert!(validator.is_valid(&manifest), "{name}: {:?}", validator.validate(&manifest).err());
    }
}
