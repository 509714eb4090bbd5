//! Tests the decoders of compressed meshes and pictures, the glTF extensions, and what happens with damaged files. The
//! files are a torus and a picture that other people's encoders have compressed; the oracle is the original.
//! tests/data/README.md describes them. Needs no GPU.

use cyclopean::scene::{self, Alpha, Scene, Treatment};
use glam::{Vec2, Vec3, Vec4};
use proptest::prelude::*;
use serde_json::{Value, json};

const PACKED: [&str; 8] = [
    "torus-draco.glb",
    "torus-draco-sequential.glb",
    "torus-meshopt.glb",
    "torus-meshopt-high.glb",
    "torus-pack-khr.glb",
    "torus-pack-float.glb",
    "torus-quantized.glb",
    "torus-webp.glb",
];
const PICTURES: [&str; 4] = ["checker.webp", "etc1s.ktx2", "uastc.ktx2", "uastc-zstd.ktx2"];

fn data(name: &str) -> Vec<u8> {
    let path = format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn load(name: &str) -> Scene {
    scene::load_bytes(name, &data(name)).unwrap_or_else(|error| panic!("{error}"))
}

/// A corner of a triangle in world space: its position, its normal and its texture coordinates.
type Corner = (Vec3, Vec3, Vec2);

fn triangles(scene: &Scene) -> Vec<[Corner; 3]> {
    let mut out = Vec::new();
    for instance in &scene.instances {
        let p = &scene.primitives[instance.primitive];
        let slot = scene.materials[p.material].base_color_texture.as_ref().expect("a base colour texture");
        for t in p.indices.chunks_exact(3) {
            out.push([t[0], t[1], t[2]].map(|i| {
                let i = i as usize;
                let at = instance.world_from_object.transform_point3(p.positions[i].as_dvec3()).as_vec3();
                let turned = instance.world_from_object.transform_vector3(p.normals[i].as_dvec3());
                (at, turned.as_vec3().normalize(), (slot.transform * p.uv0[i].extend(1.0)).truncate())
            }));
        }
    }
    out
}

/// The largest differences of two triangles in positions, normals and UVs. The triangles may begin at different
/// corners.
fn apart(a: &[Corner; 3], b: &[Corner; 3]) -> [f32; 3] {
    let turned = |k: usize| {
        let mut most = [0.0f32; 3];
        for i in 0..3 {
            let ((p, n, t), (q, m, u)) = (a[i], b[(i + k) % 3]);
            most = [most[0].max(p.distance(q)), most[1].max(n.distance(m)), most[2].max(t.distance(u))];
        }
        most
    };
    [turned(0), turned(1), turned(2)].into_iter().min_by(|a, b| a[0].total_cmp(&b[0])).expect("three")
}

#[test]
fn every_encoding_of_the_torus_is_the_torus() {
    let original = triangles(&load("torus.glb"));
    // The tolerances follow from the encoders' steps. Draco keeps 14 bits of a position in the box, 10 of the normals
    // and 12 of the UVs. Quantised positions have 14 bits, meshopt's normals 8 bits, and gltfpack's floats 15 bits.
    for (name, position, normal, uv) in [
        ("torus-draco.glb", 2e-4, 6e-3, 4e-4),
        ("torus-draco-sequential.glb", 2e-4, 6e-3, 4e-4),
        ("torus-meshopt.glb", 3e-4, 2e-2, 5e-4),
        ("torus-meshopt-high.glb", 3e-4, 2e-2, 5e-4),
        ("torus-pack-khr.glb", 3e-4, 2e-2, 5e-4),
        ("torus-pack-float.glb", 3e-4, 2e-2, 5e-4),
        ("torus-quantized.glb", 3e-4, 6e-3, 5e-4),
        ("torus-webp.glb", 0.0, 0.0, 0.0),
    ] {
        let scene = load(name);
        let found = triangles(&scene);
        assert_eq!(found.len(), original.len(), "{name}");
        for wanted in &original {
            let best = found.iter().map(|t| apart(wanted, t)).min_by(|a, b| (a[0] + a[2]).total_cmp(&(b[0] + b[2])));
            let [p, n, t] = best.expect("a triangle");
            assert!(p <= position && n <= normal && t <= uv, "{name}: {p} {n} {t}");
        }
        assert!(scene.extensions.iter().all(|e| e.treatment == Treatment::Read), "{name}: {:?}", scene.extensions);
        assert!(scene.repairs.is_empty(), "{name}: {:?}", scene.repairs);
        let picture = &scene.textures[0];
        assert_eq!(*picture.rgba8, checker(), "{name}: the picture differs");
    }
}

/// The original picture that the encoders compressed.
fn checker() -> Vec<u8> {
    let texel = |i: usize| {
        let (x, y) = (i % 16, i / 16);
        let [r, g, b] = if (x / 8 + y / 8) % 2 == 0 { [200, 60, 40] } else { [40, 90, 200] };
        [r, g, b, if x < 12 { 255 } else { 128 }]
    };
    (0..256).flat_map(texel).collect()
}

/// A GLB of a triangle with the given material, textures and images.
fn textured(images: &[Vec<u8>], textures: Value, material: Value) -> Vec<u8> {
    let positions: Vec<u8> =
        [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let mut bytes = positions;
    let mut views = vec![json!({ "buffer": 0, "byteLength": 36 })];
    let mut listed = Vec::new();
    for image in images {
        views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": image.len() }));
        listed.push(json!({ "bufferView": views.len() - 1, "mimeType": "image/png" }));
        bytes.extend(image);
    }
    let names = material.get("extensions").and_then(Value::as_object).map(|o| o.keys().cloned().collect::<Vec<_>>());
    glb(
        &json!({
            "asset": { "version": "2.0" }, "extensionsUsed": names.unwrap_or_default(),
            "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
            "meshes": [{ "name": "M", "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
            "materials": [material], "textures": textures, "images": listed,
            "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
            "bufferViews": views, "buffers": [{ "byteLength": bytes.len() }],
        }),
        &bytes,
    )
}

fn glb(root: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(((28 + text.len() + binary.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text.as_slice()), (b"BIN\0", binary)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    out
}

fn with_picture(image: Vec<u8>, extension: &str) -> Vec<u8> {
    let texture = json!([{ "extensions": { extension: { "source": 0 } } }]);
    textured(&[image], texture, json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }))
}

#[track_caller]
fn error(bytes: &[u8]) -> String {
    let text = scene::load_bytes("x.glb", bytes).map(|_| ()).expect_err("must be refused").to_string();
    assert!(!text.contains('\n'), "{text}");
    text
}

#[test]
fn compressed_pictures_are_the_picture() {
    // This WebP file is lossless. UASTC keeps nearly 8 bits of a colour, and ETC1S keeps four colours in each block.
    for (name, extension, most, mean) in [
        ("checker.webp", "EXT_texture_webp", 0, 0.0),
        ("uastc.ktx2", "KHR_texture_basisu", 6, 2.0),
        ("uastc-zstd.ktx2", "KHR_texture_basisu", 6, 2.0),
        ("etc1s.ktx2", "KHR_texture_basisu", 24, 8.0),
    ] {
        let scene =
            scene::load_bytes("x", &with_picture(data(name), extension)).unwrap_or_else(|e| panic!("{name}: {e}"));
        let picture = &scene.textures[0];
        assert_eq!((picture.width, picture.height, picture.srgb), (16, 16, true), "{name}");
        let off: Vec<u8> = picture.rgba8.iter().zip(checker()).map(|(a, b)| a.abs_diff(b)).collect();
        let sum: f64 = off.iter().map(|d| f64::from(*d)).sum();
        let worst = off.iter().max().copied().unwrap_or(0);
        assert!(
            worst <= most && sum / off.len() as f64 <= mean,
            "{name}: {worst} at most, {} on average",
            sum / 1024.0
        );
    }
}

#[test]
fn broken_pictures_are_one_sentence() {
    let refused = |change: &dyn Fn(&mut Vec<u8>), words: &str| {
        let mut image = data("uastc-zstd.ktx2");
        change(&mut image);
        let said = error(&with_picture(image, "KHR_texture_basisu"));
        assert!(said.contains(words) && said.contains("images[0]"), "{said:?} should say {words:?}");
    };
    refused(&|b| b.truncate(60), "ends too early");
    refused(&|b| b.truncate(200), "ends too early");
    refused(&|b| b[20..24].fill(255), "texels; 1 to 16384");
    refused(&|b| b[96..104].fill(127), "level 0 claims");
    refused(&|b| b[36] = 6, "plain two-dimensional");
    refused(&|b| b[44] = 3, "supercompression 3");
    refused(&|b| b[80..88].fill(255), "ends too early");
    refused(&|b| (b[20], b[21], b[24], b[25]) = (0, 60, 0, 60), "15360 × 15360 texels are more than 512 MiB");
    let said = error(&textured(
        &[],
        json!([{ "extensions": { "MSFT_texture_dds": { "source": 0 } } }]),
        json!({ "name": "W", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }),
    ));
    assert!(said.contains("material `W`") && said.contains("MSFT_texture_dds"), "{said}");
}

#[test]
fn broken_geometry_is_one_sentence() {
    // The place of the Draco stream in the file is found by its first bytes.
    let draco = data("torus-draco.glb");
    let at = draco.windows(5).position(|w| w == b"DRACO").expect("a Draco stream");
    for (offset, byte, words) in [(0, 0u8, "not a Draco stream"), (7, 0, "holds no mesh"), (8, 99, "cannot be decoded")]
    {
        let mut bytes = draco.clone();
        bytes[at + offset] = byte;
        let said = error(&bytes);
        assert!(
            said.contains("mesh `Torus` primitive 0: KHR_draco_mesh_compression") && said.contains(words),
            "{said}"
        );
    }
    let edit = |name: &str, change: &dyn Fn(&mut Value)| {
        let bytes = data(name);
        let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
        let mut root: Value = serde_json::from_slice(&bytes[20..20 + length]).expect("JSON");
        change(&mut root);
        error(&glb(&root, &bytes[28 + length..]))
    };
    let meshopt = |key: &'static str, value: Value| {
        edit("torus-meshopt.glb", &move |root: &mut Value| {
            root["bufferViews"][2]["extensions"]["EXT_meshopt_compression"][key] = value.clone();
        })
    };
    for (key, value, words) in [
        ("count", json!(1u64 << 40), "count is 1099511627776"),
        ("count", json!(20), "compressed bytes"),
        ("byteStride", json!(7), "byteStride is 7"),
        ("byteStride", json!(0), "byteStride is 0"),
        ("byteOffset", json!(u64::MAX), "run past"),
        ("buffer", json!(9), "buffers[9] does not exist"),
        ("mode", json!("MAGIC"), "byteStride is 8; indices take 2 or 4"),
        ("filter", json!("MAGIC"), "filter `MAGIC` is unknown"),
        ("byteLength", json!(40), "end too early"),
        ("mode", json!(3), "invalid type"),
    ] {
        let said = meshopt(key, value);
        assert!(said.contains("bufferViews[2]: EXT_meshopt_compression") && said.contains(words), "{said}");
    }
    let said = edit("torus-draco.glb", &|root| {
        root["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["NORMAL"] =
            json!(77);
    });
    assert!(said.contains("attribute 77 is not in the stream"), "{said}");
    let said = edit("torus.glb", &|root| {
        root["extensionsRequired"] = json!(["KHR_magic", "EXT_magic", "KHR_texture_transform"]);
    });
    assert!(said.contains("extensions `KHR_magic`, `EXT_magic`, which"), "{said}");
}

#[test]
fn instances_stand_where_they_are_put_and_hidden_nodes_are_not_there() {
    let numbers: Vec<f32> =
        vec![0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 7.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, -1.0, 1.0, 1.0];
    let mut bytes: Vec<u8> =
        [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend(numbers.iter().flat_map(|v| v.to_le_bytes()));
    let view = |offset: usize| json!({ "buffer": 0, "byteOffset": offset, "byteLength": 36 });
    let accessor = |view: usize| json!({ "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC3" });
    let places =
        |shift: Value| json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": shift, "SCALE": 2 } } });
    let file = |shift: Value| {
        glb(
            &json!({
                "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0, 1] }],
                "extensionsUsed": ["EXT_mesh_gpu_instancing", "KHR_node_visibility"],
                "nodes": [
                    { "mesh": 0, "translation": [0, 0, 1], "extensions": places(shift) },
                    { "children": [2], "extensions": { "KHR_node_visibility": { "visible": false } } },
                    { "mesh": 0 },
                ],
                "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
                "accessors": [accessor(0), accessor(1), accessor(2)],
                "bufferViews": [view(0), view(36), view(72)], "buffers": [{ "byteLength": bytes.len() }],
            }),
            &bytes,
        )
    };
    let scene = scene::load_bytes("x", &file(json!(1))).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(
        (scene.instances.len(), scene.primitives.len()),
        (3, 2),
        "there are not three instances, one of them mirrored"
    );
    let corner = |i: usize| {
        let instance = &scene.instances[i];
        assert!(instance.world_from_object.matrix3.determinant() > 0.0);
        let p = &scene.primitives[instance.primitive];
        let mut all: Vec<Vec3> =
            p.positions.iter().map(|p| instance.world_from_object.transform_point3(p.as_dvec3()).as_vec3()).collect();
        all.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).expect("finite"));
        all
    };
    assert_eq!(corner(0), [Vec3::Z, Vec3::Y + Vec3::Z, Vec3::X + Vec3::Z]);
    assert_eq!(corner(1), [Vec3::new(5.0, 0.0, 1.0), Vec3::new(5.0, 2.0, 1.0), Vec3::new(7.0, 0.0, 1.0)]);
    assert_eq!(corner(2), [Vec3::new(-1.0, 7.0, 1.0), Vec3::new(0.0, 7.0, 1.0), Vec3::new(0.0, 8.0, 1.0)]);
    assert!(error(&file(json!(9))).contains("EXT_mesh_gpu_instancing: accessors[9] does not exist"));
    assert!(error(&file(json!("far"))).contains("TRANSLATION is not the number of an accessor"));
}

fn png(texels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_vec(texels.len() as u32, 1, texels.concat())
        .expect("a row")
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("png");
    bytes.into_inner()
}

fn material(images: &[Vec<u8>], material: Value) -> Scene {
    let textures: Vec<Value> = (0..images.len()).map(|i| json!({ "source": i })).collect();
    scene::load_bytes("x", &textured(images, json!(textures), material)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn unlit_is_emission_and_specular_textures_count_with_their_mean() {
    let scene = material(
        &[png(&[[255, 255, 255, 255]])],
        json!({
            "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 1, 0.75], "baseColorTexture": { "index": 0 } },
            "emissiveFactor": [1, 1, 1], "normalTexture": { "index": 0 }, "extensions": { "KHR_materials_unlit": {} },
        }),
    );
    let m = &scene.materials[0];
    assert_eq!((m.emissive, m.base_color), (Vec3::new(0.5, 0.25, 1.0), Vec4::new(0.0, 0.0, 0.0, 0.75)));
    assert_eq!((m.dielectric_f0, m.metallic, m.roughness), (Vec3::ZERO, 0.0, 1.0));
    assert!(m.emissive_texture.is_some() && m.normal_texture.is_none());
    assert_eq!(scene.extensions[0].treatment, Treatment::Approximated);
    let scene = material(
        &[png(&[[255, 0, 0, 255], [255, 0, 0, 0]])],
        json!({ "extensions": { "KHR_materials_specular": {
            "specularFactor": 0.5, "specularTexture": { "index": 0 }, "specularColorTexture": { "index": 0 },
        } } }),
    );
    assert!((scene.materials[0].dielectric_f0 - Vec3::new(0.01, 0.0, 0.0)).length() < 1e-6, "{:?}", scene.materials[0]);
    assert!(
        scene.textures.is_empty() && scene.repairs.iter().any(|r| r.contains("only the mean")),
        "{:?}",
        scene.repairs
    );
}

#[test]
fn a_coat_shows_where_it_is_the_stronger_highlight() {
    let coat = json!({ "KHR_materials_clearcoat": { "clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.1 } });
    let surface = |metal: f32| json!({ "metallicFactor": metal, "roughnessFactor": 0.7 });
    let scene = material(&[], json!({ "pbrMetallicRoughness": surface(0.0), "extensions": coat }));
    let m = &scene.materials[0];
    assert!(m.roughness == 0.1 && (m.dielectric_f0 - Vec3::splat(0.04)).length() < 1e-6);
    assert!(scene.repairs.iter().any(|r| r.contains("replaces the highlight below it")), "{:?}", scene.repairs);
    let scene = material(&[], json!({ "pbrMetallicRoughness": surface(1.0), "extensions": coat }));
    assert_eq!(scene.materials[0].roughness, 0.7);
    assert!(scene.repairs.iter().any(|r| r.contains("its coat is left out")), "{:?}", scene.repairs);
    // If a texture says that nothing is metal, the coat replaces its roughness everywhere.
    let mut surface = surface(1.0);
    surface["metallicRoughnessTexture"] = json!({ "index": 0 });
    let scene = material(&[png(&[[0, 200, 0, 255]])], json!({ "pbrMetallicRoughness": surface, "extensions": coat }));
    let m = &scene.materials[0];
    let slot = m.metallic_roughness_texture.as_ref().expect("the texture of the metal is kept");
    assert_eq!((m.roughness, &scene.textures[slot.texture].rgba8[..3]), (0.1, &[0u8, 255, 0][..]));
}

#[test]
fn specular_and_glossiness_become_metal_and_roughness() {
    let gloss =
        |value: Value| json!({ "alphaMode": "MASK", "extensions": { "KHR_materials_pbrSpecularGlossiness": value } });
    let scene = material(
        &[],
        gloss(
            json!({ "diffuseFactor": [0.2, 0.4, 0.6, 1], "specularFactor": [0.5, 0.4, 0.3], "glossinessFactor": 0.75 }),
        ),
    );
    let m = &scene.materials[0];
    assert_eq!((m.base_color, m.dielectric_f0), (Vec4::new(0.2, 0.4, 0.6, 1.0), Vec3::new(0.5, 0.4, 0.3)));
    assert_eq!((m.metallic, m.roughness), (0.0, 0.25));
    // The first texel is white metal and half as glossy as the factor. The second is a red dielectric and not glossy at
    // all.
    let scene = material(
        &[png(&[[0, 0, 0, 255], [200, 20, 20, 64]]), png(&[[255, 255, 255, 128], [56, 56, 56, 0]])],
        gloss(json!({ "diffuseTexture": { "index": 0 }, "specularGlossinessTexture": { "index": 1 } })),
    );
    let m = &scene.materials[0];
    assert!(matches!(m.alpha, Alpha::Mask { .. }) && m.base_color == Vec4::ONE && m.metallic == 1.0);
    let texels = |slot: &Option<scene::TextureRef>| &scene.textures[slot.as_ref().expect("a texture").texture];
    let (base, surface) = (texels(&m.base_color_texture), texels(&m.metallic_roughness_texture));
    assert!(base.srgb && !surface.srgb);
    assert_eq!(base.rgba8[..4], [255, 255, 255, 255]);
    assert!(
        base.rgba8[4].abs_diff(200) < 4 && base.rgba8[5].abs_diff(20) < 4 && base.rgba8[7] == 64,
        "{:?}",
        base.rgba8
    );
    assert_eq!(surface.rgba8[1..3], [127, 255]);
    assert!(surface.rgba8[5] == 255 && surface.rgba8[6] < 6, "{:?}", surface.rgba8);
}

#[test]
fn what_is_left_out_is_said_by_name() {
    let bytes = data("torus.glb");
    let length = u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
    let mut root: Value = serde_json::from_slice(&bytes[20..20 + length]).expect("JSON");
    root["extensionsUsed"] =
        json!(["KHR_materials_variants", "KHR_materials_sheen", "KHR_animation_pointer", "X_magic"]);
    root["extensionsRequired"] = json!(["KHR_animation_pointer"]);
    root["extensions"] = json!({ "KHR_materials_variants": { "variants": [{ "name": "red" }, { "name": "blue" }] } });
    root["materials"][0]["extensions"] = json!({ "KHR_materials_sheen": {} });
    let target =
        json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": "/nodes/0/scale" } } });
    root["animations"] = json!([{ "channels": [{ "sampler": 0, "target": target }], "samplers": [] }]);
    root["meshes"][0]["primitives"][0]["attributes"]["MAGIC"] = json!(0);
    let scene = scene::load_bytes("x", &glb(&root, &bytes[28 + length..])).unwrap_or_else(|e| panic!("{e}"));
    for words in
        ["`red`, `blue`", "animations are not played (1)", "KHR_materials_sheen is not used", "names that glTF"]
    {
        assert!(scene.repairs.iter().any(|r| r.contains(words)), "{words}: {:?}", scene.repairs);
    }
    let all: Vec<_> = scene.extensions.iter().map(|e| (e.name.as_str(), e.required, e.treatment)).collect();
    let names = ["KHR_animation_pointer", "KHR_materials_sheen", "KHR_materials_variants", "X_magic"];
    assert_eq!(all, names.map(|n| (n, n == "KHR_animation_pointer", Treatment::Ignored)));
}

#[test]
fn scene_check_says_what_became_of_each_extension() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let unlit = json!({ "name": "Sign", "extensions": { "KHR_materials_unlit": {}, "KHR_materials_sheen": {} } });
    std::fs::write(folder.path().join("sign.glb"), textured(&[], json!([]), unlit)).expect("written");
    let broken = with_picture(data("etc1s.ktx2")[..90].to_vec(), "KHR_texture_basisu");
    std::fs::write(folder.path().join("broken.glb"), broken).expect("written");
    std::fs::write(folder.path().join("torus.glb"), data("torus-draco.glb")).expect("written");
    let check = |file: &str| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_cyclopean"));
        let done = command.args(["scene", "check", file]).current_dir(folder.path()).output().expect("it starts");
        let text = [done.stdout, done.stderr].map(|b| String::from_utf8_lossy(&b).into_owned()).concat();
        (done.status.code(), text)
    };
    let (code, text) = check("torus.glb");
    assert!(code == Some(0) && text.contains("read       KHR_draco_mesh_compression: "), "{text}");
    let (code, text) = check("sign.glb");
    assert!(code == Some(0) && text.contains("approx.    KHR_materials_unlit: "), "{text}");
    assert!(
        text.contains("ignored    KHR_materials_sheen: ") && text.contains("material `Sign`: the extension"),
        "{text}"
    );
    let (code, text) = check("broken.glb");
    assert!(code == Some(1) && text.starts_with("error: broken.glb: material") && text.contains("KTX2"), "{text}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn damaged_files_are_refused_or_read_and_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let damage = |mut bytes: Vec<u8>, first: usize| {
            for (at, byte) in &flips {
                let at = first + at.index(bytes.len() - first);
                bytes[at] = *byte;
            }
            if let Some(cut) = cut {
                bytes.truncate(cut.index(bytes.len()));
            }
            bytes
        };
        for name in PACKED {
            let bytes = data(name);
            // Damage is also limited to the binary chunk, because damaged JSON usually just fails to parse.
            let binary = 28 + u32::from_le_bytes([bytes[12], bytes[13], bytes[14], bytes[15]]) as usize;
            for first in [0, binary] {
                let said = scene::load_bytes(name, &damage(bytes.clone(), first));
                prop_assert!(said.map_or_else(|e| !e.to_string().contains('\n'), |_| true));
            }
        }
        for name in PICTURES {
            let extension = if name.ends_with("ktx2") { "KHR_texture_basisu" } else { "EXT_texture_webp" };
            let said = scene::load_bytes(name, &with_picture(damage(data(name), 0), extension));
            prop_assert!(said.map_or_else(|e| !e.to_string().contains('\n'), |_| true));
        }
    }
}
