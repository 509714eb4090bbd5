//! Tests the glTF loader with small hand-made files. The core features must be read correctly, and bad input must give
//! an error that names the place. The expected values are computed by hand. Needs no GPU.

use cyclopean::scene::{self, LightSource, Scene};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use serde_json::{Value, json};

/// A glTF document under construction. Its only buffer becomes a data URI or the binary chunk of a GLB.
struct Doc {
    root: Value,
    bytes: Vec<u8>,
}

impl Doc {
    fn new() -> Doc {
        let root = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
            "nodes": [{ "name": "N", "mesh": 0 }], "meshes": [{ "name": "M", "primitives": [] }],
            "accessors": [], "bufferViews": [],
        });
        Doc { root, bytes: Vec::new() }
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let views = self.root["bufferViews"].as_array_mut().expect("array");
        views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len() }));
        views.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, kind: &str) -> usize {
        let view = self.view(bytes);
        let accessors = self.root["accessors"].as_array_mut().expect("array");
        let mut value = json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        if kind == "VEC3" && component == 5126 {
            value["min"] = json!([-1e9, -1e9, -1e9]);
            value["max"] = json!([1e9, 1e9, 1e9]);
        }
        accessors.push(value);
        accessors.len() - 1
    }

    fn floats(&mut self, values: &[f32], width: usize) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, values.len() / width, ["", "SCALAR", "VEC2", "VEC3", "VEC4"][width])
    }

    fn primitive(&mut self, primitive: Value) {
        self.root["meshes"][0]["primitives"].as_array_mut().expect("array").push(primitive);
    }

    fn json(&self) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": format!("data:application/octet-stream;base64,{}", base64(&self.bytes)) }]);
        serde_json::to_vec(&root).expect("json")
    }

    fn glb(&self) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        let mut text = serde_json::to_vec(&root).expect("json");
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut out = b"glTF".to_vec();
        out.extend(2u32.to_le_bytes());
        out.extend(((12 + 8 + text.len() + 8 + self.bytes.len()) as u32).to_le_bytes());
        for (kind, chunk) in [(0x4E4F_534Au32, &text), (0x004E_4942, &self.bytes)] {
            out.extend((chunk.len() as u32).to_le_bytes());
            out.extend(kind.to_le_bytes());
            out.extend(chunk);
        }
        out
    }

    fn load(&self) -> Scene {
        scene::load_bytes("test", &self.json()).unwrap_or_else(|error| panic!("{error}"))
    }

    fn error(&self) -> String {
        scene::load_bytes("test", &self.json()).map(|_| ()).expect_err("must be refused").to_string()
    }
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for chunk in bytes.chunks(3) {
        let bits = chunk.iter().fold(0u32, |n, b| n << 8 | u32::from(*b)) << (8 * (3 - chunk.len()));
        for k in 0..4 {
            out.push(if k <= chunk.len() { DIGITS[(bits >> (18 - 6 * k)) as usize & 63] as char } else { '=' });
        }
    }
    out
}

const SQUARE: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
const UP: [f32; 12] = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];

/// A square with normals and u8 indices.
fn square() -> Doc {
    let mut doc = Doc::new();
    let (p, n) = (doc.floats(&SQUARE, 3), doc.floats(&UP, 3));
    let i = doc.accessor(&[0, 1, 2, 0, 2, 3], 5121, 6, "SCALAR");
    doc.primitive(json!({ "attributes": { "POSITION": p, "NORMAL": n }, "indices": i }));
    doc
}

#[test]
fn lists_strips_fans_and_unindexed() {
    for (mode, listed, triangles) in
        [(4, vec![0u8, 1, 2, 0, 2, 3], 2), (5, vec![0, 1, 3, 2], 2), (6, vec![0, 1, 2, 3], 2)]
    {
        let mut doc = Doc::new();
        let (p, n) = (doc.floats(&SQUARE, 3), doc.floats(&UP, 3));
        let i = doc.accessor(&listed, 5121, listed.len(), "SCALAR");
        doc.primitive(json!({ "attributes": { "POSITION": p, "NORMAL": n }, "indices": i, "mode": mode }));
        let scene = doc.load();
        assert_eq!(scene.triangle_count(), triangles);
        let p = &scene.primitives[0];
        for t in p.indices.chunks(3) {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| p.positions[i as usize]);
            assert!((b - a).cross(c - a).z > 0.0, "mode {mode}: the winding is reversed");
        }
    }
    let mut doc = Doc::new();
    let p = doc.floats(&SQUARE[..9], 3);
    doc.primitive(json!({ "attributes": { "POSITION": p } }));
    let scene = doc.load();
    assert_eq!(scene.triangle_count(), 1);
    assert!(scene.primitives[0].normals.iter().all(|n| *n == Vec3::Z));
    assert!(scene.repairs.iter().any(|r| r.contains("`M`") && r.contains("no normals")), "{:?}", scene.repairs);
}

#[test]
fn index_widths_and_glb_agree() {
    let reference = square().load();
    for (component, bytes) in [
        (5123u32, [0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<u8>>()),
        (5125, [0u32, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect()),
    ] {
        let mut doc = Doc::new();
        let (p, n) = (doc.floats(&SQUARE, 3), doc.floats(&UP, 3));
        let i = doc.accessor(&bytes, component, 6, "SCALAR");
        doc.primitive(json!({ "attributes": { "POSITION": p, "NORMAL": n }, "indices": i }));
        assert_eq!(doc.load().primitives[0].indices, reference.primitives[0].indices);
    }
    let glb = scene::load_bytes("test", &square().glb()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(glb.primitives[0].positions, reference.primitives[0].positions);
}

#[test]
fn sparse_normalised_colours_and_morphs() {
    let mut doc = square();
    // All positions are 0 except two sparse ones. A morph target with weight ½ lifts vertex 0 by 2.
    let (at, to) = (doc.view(&[1, 2]), doc.view(&[1.0f32, 0.0, 0.0, 1.0, 1.0, 0.0].map(f32::to_le_bytes).concat()));
    let accessors = doc.root["accessors"].as_array_mut().expect("array");
    accessors.push(json!({
        "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0],
        "sparse": { "count": 2, "indices": { "bufferView": at, "componentType": 5121 }, "values": { "bufferView": to } },
    }));
    let sparse = accessors.len() - 1;
    let lift = doc.floats(&[0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 3);
    let color = doc.accessor(&[255, 0, 128, 0, 0, 255, 0, 0, 0, 0, 0, 0], 5121, 3, "VEC4");
    doc.root["accessors"][color]["normalized"] = json!(true);
    doc.root["meshes"][0]["primitives"] = json!([{
        "attributes": { "POSITION": sparse, "COLOR_0": color }, "targets": [{ "POSITION": lift }],
    }]);
    doc.root["nodes"][0]["weights"] = json!([0.5]);
    let scene = doc.load();
    let p = &scene.primitives[0];
    assert_eq!(p.positions, [Vec3::new(0.0, 0.0, 2.0), Vec3::X, Vec3::new(1.0, 1.0, 0.0)]);
    assert!((p.colors[0].z - 128.0 / 255.0).abs() < 1e-6 && p.colors[0].x == 1.0);
}

#[test]
fn mirrored_nodes_keep_their_winding_and_depth_is_f64() {
    let mut doc = square();
    doc.root["nodes"] = json!([
        { "name": "far", "translation": [1e7, 0, 0], "children": [1] },
        { "name": "N", "mesh": 0, "translation": [0.125, 0, 0], "scale": [-1, 1, 1] },
    ]);
    let scene = doc.load();
    let i = &scene.instances[0];
    assert!(i.world_from_object.matrix3.determinant() > 0.0);
    let p = &scene.primitives[i.primitive];
    let at = |k: u32| i.world_from_object.transform_point3(p.positions[k as usize].as_dvec3());
    let (a, b, c) = (at(p.indices[0]), at(p.indices[1]), at(p.indices[2]));
    assert!((b - a).cross(c - a).z > 0.0);
    assert!((a - DVec3::new(1e7 + 0.125, 0.0, 0.0)).length() < 1e-6);
}

#[test]
fn skins_pose_their_vertices() {
    let mut doc = square();
    let joints = doc.accessor(&[0u8; 16], 5121, 4, "VEC4");
    let weights = doc.floats(&[1.0, 0.0, 0.0, 0.0].repeat(4), 4);
    doc.root["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
    doc.root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    doc.root["skins"] = json!([{ "joints": [1] }]);
    doc.root["nodes"] = json!([{ "mesh": 0, "skin": 0, "translation": [9, 9, 9] }, { "translation": [5, 0, 0], "rotation": [0, 0, 1, 0] }]);
    doc.root["scenes"][0]["nodes"] = json!([0, 1]);
    let scene = doc.load();
    let i = &scene.instances[0];
    let p = i.world_from_object.transform_point3(scene.primitives[0].positions[1].as_dvec3());
    assert!((p - DVec3::new(4.0, 0.0, 0.0)).length() < 1e-6, "the vertex is not turned half about the joint: {p}");
}

#[test]
fn lights_cameras_and_materials() {
    let mut doc = square();
    doc.root["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    doc.root["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "intensity": 4.0, "color": [1, 0.5, 0], "spot": { "outerConeAngle": 0.5 } },
    ] } });
    doc.root["cameras"] =
        json!([{ "type": "perspective", "name": "eye", "perspective": { "yfov": 1.0, "znear": 0.1 } }]);
    doc.root["nodes"] = json!([
        { "mesh": 0, "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "camera": 0, "translation": [0, 0, 3] },
    ]);
    doc.root["scenes"][0]["nodes"] = json!([0, 1]);
    doc.root["materials"] = json!([{
        "name": "G", "emissiveFactor": [0.5, 0.5, 0.5], "alphaMode": "MASK", "alphaCutoff": 0.3,
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 6.0 }, "KHR_materials_ior": { "ior": 2.0 },
            "KHR_materials_transmission": { "transmissionFactor": 0.7 }, "KHR_materials_specular": { "specularFactor": 0.5 },
            "KHR_materials_clearcoat": { "clearcoatFactor": 1.0 },
        },
    }]);
    doc.root["meshes"][0]["primitives"][0]["material"] = json!(0);
    let scene = doc.load();
    assert!(
        matches!(scene.lights[0].source, LightSource::Spot { intensity, outer_rad, .. } if intensity == Vec3::new(4.0, 2.0, 0.0) && outer_rad == 0.5)
    );
    assert_eq!(scene.lights.len(), 1, "a scene with a light got a sun as well");
    let view = &scene.views[0];
    assert!(view.name == "eye" && view.ipd_m == 0.063 && view.position == DVec3::new(0.0, 0.0, 3.0));
    let m = &scene.materials[0];
    assert!((m.dielectric_f0.x - 0.5 / 9.0).abs() < 1e-6 && m.emissive == Vec3::splat(3.0) && m.transmission == 0.7);
    assert!(matches!(m.alpha, scene::Alpha::Mask { cutoff } if cutoff == 0.3));
    assert!(scene.repairs.iter().any(|r| r.contains("KHR_materials_clearcoat")), "{:?}", scene.repairs);
}

#[test]
fn a_normal_map_without_tangents_gets_mikktspace() {
    let mut doc = square();
    let uv = doc.floats(&[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0], 2);
    doc.root["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uv);
    doc.root["meshes"][0]["primitives"][0]["material"] = json!(0);
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(2, 2, image::Rgba([128, 128, 255, 255]))
        .write_to(&mut png, image::ImageFormat::Png)
        .expect("png");
    let view = doc.view(png.get_ref());
    doc.root["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
    doc.root["textures"] = json!([{ "source": 0 }]);
    let slot = json!({ "index": 0, "extensions": { "KHR_texture_transform": { "offset": [0.25, 0.0], "scale": [2.0, 3.0] } } });
    doc.root["materials"] = json!([{ "normalTexture": slot, "pbrMetallicRoughness": { "baseColorTexture": slot } }]);
    let scene = doc.load();
    let p = &scene.primitives[0];
    // u increases along +X, and the image's upward direction is +Y = w · cross(+Z, +X).
    assert!(p.tangents.iter().all(|t| (t.truncate() - Vec3::X).length() < 1e-5 && t.w == 1.0), "{:?}", p.tangents);
    assert_eq!(scene.textures.len(), 2, "the image is not there once as data and once as colour");
    assert!(scene.textures.iter().any(|t| t.srgb) && scene.textures.iter().any(|t| !t.srgb));
    for slot in [&scene.materials[0].normal_texture, &scene.materials[0].base_color_texture] {
        let m = slot.as_ref().expect("a texture").transform;
        assert_eq!(m * Vec3::new(1.0, 1.0, 1.0), Vec3::new(2.25, 3.0, 1.0));
    }
}

#[test]
fn what_is_wrong_is_named() {
    let refused = |change: &dyn Fn(&mut Doc), words: &[&str]| {
        let mut doc = square();
        change(&mut doc);
        let error = doc.error();
        assert!(words.iter().all(|w| error.contains(w)), "{error:?} should say {words:?}");
        assert!(!error.contains('\n'), "{error:?}");
    };
    refused(&|d| d.root["extensionsRequired"] = json!(["EXT_texture_avif"]), &["EXT_texture_avif"]);
    refused(&|d| d.root["asset"]["version"] = json!("1.0"), &["asset.version"]);
    refused(&|d| d.root["accessors"][0]["count"] = json!(5000), &["mesh `M`", "accessors[0]", "5000"]);
    refused(&|d| d.root["accessors"][2]["byteOffset"] = json!(3), &["mesh `M`", "accessors[2]"]);
    refused(&|d| d.root["bufferViews"][0]["byteLength"] = json!(1u64 << 40), &["bufferViews[0]"]);
    refused(&|d| d.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(77), &["POSITION"]);
    refused(&|d| d.root["nodes"][0]["children"] = json!([0]), &["node `N`", "cycle"]);
    refused(&|d| d.bytes[48 + 48] = 9, &["mesh `M`", "index 9", "4 vertices"]);
    refused(&|d| d.bytes[0..4].copy_from_slice(&f32::NAN.to_le_bytes()), &["mesh `M`", "vertex 0", "not finite"]);
    refused(
        &|d| d.root["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 3 } } }]),
        &["materials[0]"],
    );
    refused(
        &|d| {
            d.root["images"] = json!([{ "uri": "no/such.png" }]);
            d.root["textures"] = json!([{ "source": 0 }]);
            d.root["materials"] =
                json!([{ "name": "Wall", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
        },
        &["material `Wall`", "no/such.png"],
    );
    let error = scene::load_bytes("broken.gltf", b"{ not json").map(|_| ()).expect_err("refused").to_string();
    assert!(error.starts_with("broken.gltf: not glTF JSON"), "{error}");
}

#[test]
fn empty_degenerate_and_zero_normal_scenes_load() {
    let mut doc = square();
    doc.bytes[48..96].fill(0);
    let scene = doc.load();
    assert!(scene.primitives[0].normals.iter().all(|n| *n == Vec3::Z));
    assert!(scene.repairs.iter().any(|r| r.contains("mesh `M`: 4 zero or non-finite normals")), "{:?}", scene.repairs);
    let mut doc = square();
    doc.bytes[0..48].fill(0);
    let scene = doc.load();
    assert_eq!(scene.triangle_count(), 0);
    assert!(!scene.views.is_empty());
    assert!(scene.repairs.iter().any(|r| r.contains("no triangle is left")), "{:?}", scene.repairs);
    let empty = scene::load_bytes("empty", br#"{"asset":{"version":"2.0"}}"#).unwrap_or_else(|error| panic!("{error}"));
    assert!(empty.instances.is_empty() && empty.views[0].position.is_finite());
}

/// A GLB with most features, to be mutated.
fn rich() -> Vec<u8> {
    let mut doc = square();
    let joints = doc.accessor(&[0u8; 16], 5121, 4, "VEC4");
    let weights = doc.floats(&[1.0, 0.0, 0.0, 0.0].repeat(4), 4);
    let lift = doc.floats(&SQUARE, 3);
    let (at, to) = (doc.view(&[1]), doc.view(&[0; 12]));
    doc.root["accessors"][lift]["sparse"] =
        json!({ "count": 1, "indices": { "bufferView": at, "componentType": 5121 }, "values": { "bufferView": to } });
    let a = &mut doc.root["meshes"][0]["primitives"][0];
    a["attributes"]["JOINTS_0"] = json!(joints);
    a["attributes"]["WEIGHTS_0"] = json!(weights);
    a["targets"] = json!([{ "POSITION": lift }]);
    doc.root["meshes"][0]["weights"] = json!([0.25]);
    doc.root["skins"] = json!([{ "joints": [0] }]);
    doc.root["nodes"][0]["skin"] = json!(0);
    doc.root["materials"] = json!([{ "name": "m", "extensions": { "KHR_materials_ior": { "ior": 1.4 } } }]);
    doc.glb()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_bytes_never_panic(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), cut in any::<Option<prop::sample::Index>>()) {
        let mut bytes = rich();
        for (at, to) in changes {
            let i = at.index(bytes.len());
            bytes[i] = to;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let _ = scene::load_bytes("mutated", &bytes);
    }
}

#[test]
fn a_light_that_cannot_be_is_refused_by_one_sentence() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("lights.json");
    for (light, said) in [
        (r#"{"kind": "point", "position": [0, 1, 0], "intensity": [1, 1, 1], "radius_m": -1}"#, "radius_m is -1"),
        (r#"{"kind": "point", "position": [0, 1, 0], "intensity": [1, 1, 1], "radius_m": 1e9}"#, "0 to 1000"),
        (r#"{"kind": "point", "position": [0, 1, 0], "intensity": [1, 1, 1], "range_m": 1e39}"#, "range_m is inf"),
        (r#"{"kind": "directional", "direction": [0, -1, 0], "irradiance": [1, 1, 1], "angle_deg": 91}"#, "0 to 90"),
    ] {
        let text = format!(
            r#"{{"name": "x", "geometry": {{"builtin": {{"name": "room", "detail": 0.01}}}}, "lights": [{light}]}}"#
        );
        std::fs::write(&path, text).expect("written");
        let error = scene::load(&path.to_string_lossy()).expect_err("refused").to_string();
        assert!(error.contains("lights[0]") && error.contains(said), "{error}");
        let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_cyclopean"));
        let done = program.args(["scene", "check"]).arg(&path).output().expect("it starts");
        assert_eq!(done.status.code(), Some(2), "{}", String::from_utf8_lossy(&done.stderr));
    }
    let text = r#"{"name": "x", "geometry": {"builtin": {"name": "room", "detail": 0.01}},
                   "file_lights": [{"name": "Sun", "angle_deg": 1}]}"#;
    std::fs::write(&path, text).expect("written");
    let error = scene::load(&path.to_string_lossy()).expect_err("refused").to_string();
    assert!(error.contains("Sun") && error.contains("no light of that name"), "{error}");
}
