//! Gives the program hostile input. Every reader must refuse it without a panic, within a time limit and a memory
//! limit, and with one message that names the file. The program must read nothing outside a scene's folder and print
//! nothing that a terminal would execute. Needs no GPU, but a Unix with `sh` and `mkfifo`.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use cyclopean::picture::{self, Part, StereoPicture};
use cyclopean::study::language::Language;
use cyclopean::study::validate;
use serde_json::{Value, json};

use crate::lab::{Lab, rate};

/// The limit of the program's address space and thus of its memory, in KiB. An endless file would soon exceed it.
const MOST_KIB: &str = "6000000";
/// The time limit of one run. It is well above what any refusal takes, even on a busy machine without optimisation.
const LONGEST: Duration = Duration::from_secs(20);
const PROGRAM: &str = env!("CARGO_BIN_EXE_cyclopean");

// ---- The table -------------------------------------------------------------------------------------------------

/// One hostile input: the arguments of the program, and the file that its message must name.
struct Case {
    reader: &'static str,
    what: String,
    file: PathBuf,
    arguments: Vec<String>,
    folder: PathBuf,
}

struct Table {
    folder: PathBuf,
    cases: Vec<Case>,
}

impl Table {
    /// Adds a case whose file exists already. `{}` in `arguments` stands for the file.
    fn at(&mut self, reader: &'static str, what: &str, file: &Path, arguments: &[&str]) {
        let name = file.to_string_lossy();
        self.cases.push(Case {
            reader,
            what: what.to_owned(),
            file: file.to_owned(),
            arguments: arguments.iter().map(|a| a.replace("{}", &name)).collect(),
            folder: self.folder.clone(),
        });
    }

    /// Adds a case whose file holds `bytes`, in a folder of its own.
    fn put(&mut self, reader: &'static str, what: &str, name: &str, bytes: impl AsRef<[u8]>, arguments: &[&str]) {
        let file = self.new_file(name);
        std::fs::write(&file, bytes).expect("written");
        self.at(reader, what, &file, arguments);
    }

    fn new_file(&self, name: &str) -> PathBuf {
        let folder = self.folder.join(self.cases.len().to_string());
        std::fs::create_dir(&folder).expect("a folder");
        folder.join(name)
    }

    /// Adds cases, for any reader, in which there is something other than a regular file, or nothing.
    fn no_files(&mut self, reader: &'static str, name: &str, arguments: &[&str]) {
        type Make = fn(&Path);
        let made: [(&str, Make); 7] = [
            ("no file", |_| {}),
            ("a named pipe", fifo),
            ("a link to a named pipe", |p| {
                fifo(&p.with_file_name("pipe"));
                symlink("pipe", p).expect("linked");
            }),
            ("a link to /dev/zero", |p| symlink("/dev/zero", p).expect("linked")),
            ("a folder", |p| std::fs::create_dir(p).expect("a folder")),
            ("a socket", |p| drop(std::os::unix::net::UnixListener::bind(p).expect("bound"))),
            ("a sparse file of 2 TiB", |p| {
                std::fs::File::create(p).and_then(|f| f.set_len(2 << 40)).expect("made");
            }),
        ];
        for (what, make) in made {
            let file = self.new_file(name);
            make(&file);
            self.at(reader, what, &file, arguments);
        }
    }

    /// Adds cases with text that is wrong for every reader of JSON.
    fn no_json(&mut self, reader: &'static str, name: &str, good: &str, arguments: &[&str]) {
        let cut = |share: usize| good.as_bytes()[..good.len() * share / 8].to_vec();
        for share in 0..8 {
            self.put(reader, &format!("its first {share}/8"), name, cut(share), arguments);
        }
        for (what, text) in [
            ("a byte-order mark alone", "\u{feff}".to_owned()),
            ("100,000 open brackets", "[".repeat(100_000)),
            ("100,000 open objects", r#"{"name":"#.repeat(100_000)),
            ("null", "null".to_owned()),
            ("a list", "[1, 2]".to_owned()),
            ("a word", "\"x\"".to_owned()),
            ("a number that overflows", "1e999".to_owned()),
            ("one line of control sequences", "\u{1b}[2J\u{1b}]0;x\u{7}".to_owned()),
        ] {
            self.put(reader, what, name, text, arguments);
        }
        self.put(
            reader,
            "invalid UTF-8",
            name,
            [b"{\"name\": \"", &[0xff, 0xfe, 0xc3][..], b"\"}"].concat(),
            arguments,
        );
        self.put(reader, "zero bytes", name, vec![0; 4096], arguments);
    }

    /// Runs all cases, prints how many there are, and returns those that went wrong.
    fn run(self) -> Vec<String> {
        let (next, wrong) = (Mutex::new(self.cases.iter()), Mutex::new(Vec::new()));
        let times = Mutex::new(BTreeMap::<&str, (u32, Duration, &str)>::new());
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    loop {
                        let Some(case) = next.lock().expect("no panic").next() else { break };
                        let started = Instant::now();
                        let verdict = judge(case);
                        let took = started.elapsed();
                        let mut times = times.lock().expect("no panic");
                        let of = times.entry(case.reader).or_default();
                        *of = if took > of.1 { (of.0 + 1, took, case.what.as_str()) } else { (of.0 + 1, of.1, of.2) };
                        if let Some(reason) = verdict {
                            wrong.lock().expect("no panic").push(format!("{}: {}: {reason}", case.reader, case.what));
                        }
                    }
                });
            }
        });
        for (reader, (count, longest, which)) in times.into_inner().expect("no panic") {
            println!("{reader:10} {count:3} inputs, the slowest {:.2} s ({which})", longest.as_secs_f64());
        }
        println!("{} hostile inputs refused or reported", self.cases.len());
        wrong.into_inner().expect("no panic")
    }
}

fn fifo(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo").success());
}

/// Says why the program's answer is not as it should be, or returns `None` if it is.
fn judge(case: &Case) -> Option<String> {
    let limited = format!("ulimit -v {MOST_KIB}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &limited, PROGRAM]).args(&case.arguments).current_dir(&case.folder);
    command.env("XDG_CACHE_HOME", case.folder.join("cache"));
    let Some(done) = within(LONGEST, &mut command) else { return Some(format!("did not end in {LONGEST:?}")) };
    let (out, said) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    let reason = match done.status.code() {
        None => "it was killed",
        Some(0) => "the input was accepted",
        Some(1 | 2) if said.contains("panicked") || said.contains("allocation of") => "it panicked or aborted",
        Some(1 | 2) if said.lines().count() != 1 && !said.contains(" problems\n") => "the message is not one line",
        Some(1 | 2) if !said.starts_with("error: ") => "the message does not begin with `error: `",
        Some(1 | 2) if !said.contains(&*case.file.file_name().unwrap_or_default().to_string_lossy()) => {
            "the message does not name the file"
        }
        Some(1 | 2) if said.chars().chain(out.chars()).any(|c| c.is_control() && c != '\n') => "a control character",
        Some(1 | 2) if said.chars().count() > 4000 => "the message is too long",
        Some(1 | 2) => return None,
        Some(_) => "the exit status is neither 1 nor 2",
    };
    Some(format!("{reason} (code {:?}): {}", done.status.code(), said.chars().take(300).collect::<String>()))
}

/// Runs a command and returns its output, or kills it and returns `None` if it does not end in time.
fn within(longest: Duration, command: &mut Command) -> Option<Output> {
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("started");
    let ended = Instant::now() + longest;
    while child.try_wait().expect("a child").is_none() {
        if Instant::now() > ended {
            let _ = child.kill();
            let _ = child.wait();
            return None;
        }
        std::thread::sleep(Duration::from_millis(3));
    }
    Some(child.wait_with_output().expect("its output"))
}

// ---- Scenes ----------------------------------------------------------------------------------------------------

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for chunk in bytes.chunks(3) {
        let bits = chunk.iter().fold(0u32, |n, b| n << 8 | u32::from(*b)) << (8 * (3 - chunk.len()));
        (0..4).for_each(|k| {
            out.push(if k <= chunk.len() { DIGITS[(bits >> (18 - 6 * k)) as usize & 63] as char } else { '=' });
        });
    }
    out
}

/// A triangle: positions (36 bytes), then indices (6).
fn triangle() -> Vec<u8> {
    let positions: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut bytes: Vec<u8> = positions.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
    bytes
}

/// A valid scene with one triangle.
fn scene() -> Value {
    json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "N", "mesh": 0 }],
        "meshes": [{ "name": "M", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
        "materials": [{ "name": "Wall" }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 36, "byteLength": 6 },
        ],
        "buffers": [{ "byteLength": 42, "uri": format!("data:application/octet-stream;base64,{}", base64(&triangle())) }],
    })
}

/// Sets the value at a place such as `/a/0/b`. Objects and lists that are missing on the way are made.
fn set(root: &mut Value, place: &str, value: Value) {
    let mut at = root;
    for key in place.split('/').skip(1) {
        at = match (key.parse::<usize>(), &mut *at) {
            (Ok(i), Value::Array(list)) => {
                while list.len() <= i {
                    list.push(json!({}));
                }
                &mut list[i]
            }
            (Ok(0), other) if other.is_null() => {
                *other = json!([{}]);
                &mut other[0]
            }
            (_, other) => &mut other[key],
        };
    }
    *at = value;
}

fn changed(mut root: Value, changes: &[(&str, Value)]) -> Value {
    changes.iter().for_each(|(place, value)| set(&mut root, place, value.clone()));
    root
}

fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut out = b"glTF".to_vec();
    out.extend(2u32.to_le_bytes());
    let pad = |b: &[u8], with: u8| [b, &vec![with; b.len().next_multiple_of(4) - b.len()]].concat();
    let (json, binary) = (pad(json, b' '), pad(binary, 0));
    out.extend(((28 + json.len() + binary.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(0x4E4F_534Au32, &json), (0x004E_4942, &binary)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend(chunk);
    }
    out
}

const CHECK: [&str; 3] = ["scene", "check", "{}"];

fn gltf(table: &mut Table) {
    table.no_files("glTF", "x.gltf", &CHECK);
    table.no_json("glTF", "x.gltf", &scene().to_string(), &CHECK);
    let far = json!(1u64 << 40);
    let picture = |uri: &str| {
        vec![
            ("/images/0/uri", json!(uri)),
            ("/textures/0/source", json!(0)),
            ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", json!(0)),
        ]
    };
    let chain: Vec<Value> =
        (1..=200_000).map(|i| if i < 200_000 { json!({ "children": [i] }) } else { json!({}) }).collect();
    let many = |n: usize, node: Value| vec![node; n];
    let all = |n: usize| (0..n).collect::<Vec<usize>>();
    let lens = json!({ "type": "perspective", "name": "c", "perspective": { "yfov": 1.0, "znear": 0.1 } });
    let lamp = json!({ "type": "point" });
    let lit = json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } });
    let huge = "n".repeat(5000);
    let draco = json!({ "bufferView": 0, "attributes": { "POSITION": 0 } });
    let meshopt = json!({ "buffer": 0, "byteLength": 42, "byteStride": 12, "count": 3, "mode": "ATTRIBUTES" });
    let wide = vec![json!({ "attributes": { "POSITION": 0 } }); 100];
    let cases: Vec<(&str, Vec<(&str, Value)>)> = vec![
        ("no asset", vec![("/asset", Value::Null)]),
        ("asset is a list", vec![("/asset", json!([]))]),
        ("version 1.0", vec![("/asset/version", json!("1.0"))]),
        ("version 3.0", vec![("/asset/version", json!("3.0"))]),
        ("version 2", vec![("/asset/version", json!("2"))]),
        ("version 2.x", vec![("/asset/version", json!("2.x"))]),
        ("version as a number", vec![("/asset/version", json!(2.0))]),
        ("minVersion 3.0", vec![("/asset/minVersion", json!("3.0"))]),
        ("minVersion 2.1", vec![("/asset/minVersion", json!("2.1"))]),
        ("minVersion two", vec![("/asset/minVersion", json!("two"))]),
        ("minVersion with a control sequence", vec![("/asset/minVersion", json!("\u{1b}[2J"))]),
        ("an unknown extension that is required", vec![("/extensionsRequired", json!(["EXT_nothing"]))]),
        (
            "200,000 such extensions",
            vec![("/extensionsRequired", json!((0..200_000).map(|i| format!("X{i}")).collect::<Vec<_>>()))],
        ),
        ("scene 5", vec![("/scene", json!(5))]),
        ("scene −1", vec![("/scene", json!(-1))]),
        ("a root that is not there", vec![("/scenes/0/nodes", json!([7]))]),
        ("nodes as an object", vec![("/nodes", json!({ "0": {} }))]),
        ("a node in a circle", vec![("/nodes/0/children", json!([0]))]),
        ("a circle of two", vec![("/nodes", json!([{ "children": [1] }, { "children": [0] }]))]),
        ("two parents", vec![("/nodes", json!([{ "children": [1, 2] }, { "children": [2] }, {}]))]),
        ("a child that is not there", vec![("/nodes/0/children", json!([99]))]),
        ("200,000 nodes deep", vec![("/nodes", json!(chain))]),
        ("a translation that overflows", vec![("/nodes/0/translation", json!([1e39, 0, 0]))]),
        ("a matrix of nine numbers", vec![("/nodes/0/matrix", json!([0, 0, 0, 0, 0, 0, 0, 0, 0]))]),
        ("a name of 5,000 bytes", vec![("/nodes/0/name", json!(huge))]),
        ("a mesh that is not there", vec![("/nodes/0/mesh", json!(9))]),
        ("a camera that is not there", vec![("/nodes/0/camera", json!(9))]),
        ("a skin that is not there", vec![("/nodes/0/skin", json!(9))]),
        ("a joint that is not there", vec![("/nodes/0/skin", json!(0)), ("/skins/0/joints", json!([99]))]),
        (
            "200,000 cameras",
            vec![
                ("/cameras/0", lens),
                ("/nodes", json!(many(200_000, json!({ "camera": 0 })))),
                ("/scenes/0/nodes", json!(all(200_000))),
            ],
        ),
        (
            "200,000 lights",
            vec![
                ("/extensions/KHR_lights_punctual/lights", json!([lamp])),
                ("/nodes", json!(many(200_000, lit))),
                ("/scenes/0/nodes", json!(all(200_000))),
            ],
        ),
        (
            "a light of negative power",
            vec![
                ("/extensions/KHR_lights_punctual/lights", json!([{ "type": "point", "intensity": -1 }])),
                ("/nodes/0/extensions/KHR_lights_punctual/light", json!(0)),
            ],
        ),
        ("a light that is not there", vec![("/nodes/0/extensions/KHR_lights_punctual/light", json!(3))]),
        (
            "3,000 nodes of 100 primitives",
            vec![
                ("/meshes/0/primitives", json!(wide)),
                ("/nodes", json!(many(3000, json!({ "mesh": 0 })))),
                ("/scenes/0/nodes", json!(all(3000))),
            ],
        ),
        ("a POSITION that is not there", vec![("/meshes/0/primitives/0/attributes/POSITION", json!(77))]),
        ("no POSITION", vec![("/meshes/0/primitives/0/attributes", json!({}))]),
        ("indices that are not there", vec![("/meshes/0/primitives/0/indices", json!(77))]),
        ("mode 99", vec![("/meshes/0/primitives/0/mode", json!(99))]),
        ("a material that is not there", vec![("/meshes/0/primitives/0/material", json!(9))]),
        ("a NORMAL of another count", vec![("/meshes/0/primitives/0/attributes/NORMAL", json!(1))]),
        ("5,000 positions", vec![("/accessors/0/count", json!(5000))]),
        ("2⁴⁰ positions", vec![("/accessors/0/count", far.clone())]),
        (
            "2²⁵ positions without a buffer",
            vec![("/accessors/0", json!({ "componentType": 5126, "count": 1 << 25, "type": "VEC3" }))],
        ),
        ("−1 positions", vec![("/accessors/0/count", json!(-1))]),
        ("an unknown type of component", vec![("/accessors/0/componentType", json!(1))]),
        ("an unknown type of element", vec![("/accessors/0/type", json!("VEC9"))]),
        ("an accessor at byte 2⁴⁰", vec![("/accessors/0/byteOffset", far.clone())]),
        ("an accessor at byte 2⁶⁴ − 1", vec![("/accessors/0/byteOffset", json!(u64::MAX))]),
        ("indices as floats", vec![("/accessors/1/componentType", json!(5126)), ("/accessors/1/count", json!(1))]),
        ("a view that is not there", vec![("/accessors/0/bufferView", json!(9))]),
        (
            "a sparse index out of range",
            vec![(
                "/accessors/0/sparse",
                json!({ "count": 1, "indices": { "bufferView": 0, "byteOffset": 12, "componentType": 5125 }, "values": { "bufferView": 0 } }),
            )],
        ),
        (
            "2⁴⁰ sparse values",
            vec![(
                "/accessors/0/sparse",
                json!({ "count": far, "indices": { "bufferView": 0, "componentType": 5125 }, "values": { "bufferView": 0 } }),
            )],
        ),
        ("a buffer that is not there", vec![("/bufferViews/0/buffer", json!(9))]),
        ("a view of 2⁴⁰ bytes", vec![("/bufferViews/0/byteLength", far.clone())]),
        ("a view at byte 2⁴⁰", vec![("/bufferViews/0/byteOffset", far.clone())]),
        ("a view at byte 2⁶⁴ − 1", vec![("/bufferViews/0/byteOffset", json!(u64::MAX))]),
        ("a buffer of 2⁴⁰ bytes", vec![("/buffers/0/byteLength", far)]),
        ("a buffer without a URI", vec![("/buffers/0", json!({ "byteLength": 42 }))]),
        ("a texture that is not there", vec![("/materials/0/normalTexture/index", json!(3))]),
        (
            "an image that is not there",
            vec![("/textures/0/source", json!(99)), ("/materials/0/normalTexture/index", json!(0))],
        ),
        ("an invalid image", picture("data:image/png;base64,AAAA")),
        ("an image without bytes", picture("data:image/png;base64,")),
        ("a KTX2 that ends early", picture("data:image/ktx2;base64,q0tUWCAyMLsNChoK")),
        ("an invalid Draco mesh", vec![("/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression", draco)]),
        ("an invalid meshopt view", vec![("/bufferViews/0/extensions/EXT_meshopt_compression", meshopt)]),
        (
            "instances of different counts",
            vec![(
                "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes",
                json!({ "TRANSLATION": 0, "ROTATION": 1 }),
            )],
        ),
        ("instances without attributes", vec![("/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes", json!({}))]),
    ];
    for (what, changes) in cases {
        table.put("glTF", what, "x.gltf", changed(scene(), &changes).to_string(), &CHECK);
    }
    table.put(
        "glTF",
        "1.2 million objects",
        "x.gltf",
        format!("{{\"nodes\": [{}{{}}]}}", "{},".repeat(1_200_000)),
        &CHECK,
    );
    table.put("glTF", "18 million values", "x.gltf", format!("{{\"nodes\": [{}0]}}", "0,".repeat(18_000_000)), &CHECK);
    table.put("glTF", "a byte-order mark before a scene", "x.gltf", format!("\u{feff}{}", scene()), &CHECK);

    // URIs that lead to something hostile. The message must name the glTF.
    for (what, uri) in [
        ("by two dots", "../outside.bin"),
        ("by encoded dots", "%2e%2e/outside.bin"),
        ("by an encoded slash", "..%2Foutside.bin"),
        ("into a folder and out again", "a/../../outside.bin"),
        ("through a link", "link/outside.bin"),
        ("absolute", "/etc/hostname"),
        ("absolute by a scheme", "file:///etc/hostname"),
        ("from the net", "http://localhost/x.bin"),
        ("with a zero byte", "a%00b"),
        ("invalid UTF-8", "%ff%fe"),
        ("no file", "none.bin"),
        ("a folder", "folder"),
        ("a named pipe", "pipe"),
        ("an endless device", "zero"),
        ("a sparse file of 2 TiB", "hole"),
        ("a control sequence", "\u{1b}[2J"),
        ("data without a comma", "data:x"),
        ("data that is no base64", "data:;base64,!!"),
        ("data that are too short", "data:;base64,AAAA"),
    ] {
        for (kind, changes) in [("buffer", vec![("/buffers/0/uri", json!(uri))]), ("image", picture(uri))] {
            let file = table.new_file("x.gltf");
            let at = |name: &str| file.with_file_name(name);
            std::fs::write(&file, changed(scene(), &changes).to_string()).expect("written");
            std::fs::write(table.folder.join("outside.bin"), triangle()).expect("written");
            std::fs::create_dir(at("folder")).expect("a folder");
            fifo(&at("pipe"));
            symlink("/dev/zero", at("zero")).expect("linked");
            symlink("..", at("link")).expect("linked");
            std::fs::File::create(at("hole")).and_then(|f| f.set_len(2 << 40)).expect("made");
            table.at("URI", &format!("{kind}: {what}"), &file, &CHECK);
        }
    }
    let long = changed(scene(), &[("/buffers/0/uri", json!("a/".repeat(5000)))]);
    table.put("URI", "of 10,000 bytes", "x.gltf", long.to_string(), &CHECK);
}

fn glbs(table: &mut Table) {
    let mut root = scene();
    root["buffers"] = json!([{ "byteLength": 42 }]);
    let good = glb(root.to_string().as_bytes(), &triangle());
    let json_length = u32::from_le_bytes([good[12], good[13], good[14], good[15]]) as usize;
    let patched = |at: usize, value: u32| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    for cut in [4, 8, 11, 12, 16, 19, 20, 40, 20 + json_length, 24 + json_length, good.len() - 1] {
        table.put("GLB", &format!("its first {cut} bytes"), "x.glb", &good[..cut], &CHECK);
    }
    for (what, bytes) in [
        ("version 1", patched(4, 1)),
        ("version 3", patched(4, 3)),
        ("a length beyond the file", patched(8, u32::MAX)),
        ("a JSON chunk beyond the file", patched(12, u32::MAX)),
        ("an empty JSON chunk", patched(12, 0)),
        ("a JSON chunk cut short", patched(12, 12)),
        ("a first chunk that is not JSON", patched(16, 0x004E_4942)),
        ("a binary chunk beyond the file", patched(20 + json_length, u32::MAX)),
        ("a binary chunk cut short", patched(20 + json_length, 8)),
        ("no binary chunk", patched(24 + json_length, 0)),
        ("invalid JSON", glb(b"not JSON at all ", &triangle())),
    ] {
        table.put("GLB", what, "x.glb", bytes, &CHECK);
    }
    table.no_files("GLB", "x.glb", &CHECK);
}

fn manifests(table: &mut Table) {
    // The manifest has its own environment, because prefiltering the default one takes long.
    std::fs::write(table.folder.join("good.gltf"), scene().to_string()).expect("written");
    let good = json!({
        "name": "m", "geometry": { "file": "../good.gltf" }, "environment": { "constant": [1, 1, 1] },
    });
    let built_in =
        |name: &str, detail: f64| vec![("/geometry", json!({ "builtin": { "name": name, "detail": detail } }))];
    table.no_files("manifest", "x.json", &CHECK);
    table.no_json("manifest", "x.json", &good.to_string(), &CHECK);
    let view = json!({ "name": "v", "position": [0, 1, 3], "target": [0, 1, 0] });
    let with_view = |place: &str, value: Value| vec![("/views", json!([changed(view.clone(), &[(place, value)])]))];
    let map = |file: &str| vec![("/environment", json!({ "map": { "file": file } }))];
    let keys = |times: [f64; 2]| {
        let key = |t: f64| json!({ "time_s": t, "position": [0, 1, 3], "target": [0, 1, 0] });
        vec![("/paths", json!([{ "name": "p", "keys": times.map(key) }]))]
    };
    let cases: Vec<(&str, Vec<(&str, Value)>)> = vec![
        ("an unknown key", vec![("/shell", json!("rm"))]),
        ("no name", vec![("/name", Value::Null)]),
        ("no geometry", vec![("/geometry", Value::Null)]),
        ("an unknown built-in", built_in("nowhere", 1.0)),
        ("detail 10⁹", built_in("room", 1e9)),
        ("detail −1", built_in("room", -1.0)),
        ("detail 0", built_in("room", 0.0)),
        ("exposure 0", vec![("/exposure", json!(0))]),
        ("exposure beyond all", vec![("/exposure", json!(1e40))]),
        ("thickness −1", vec![("/open_mesh_thickness_m", json!(-1))]),
        ("one view twice", vec![("/views", json!([view, view]))]),
        ("5,000 views", vec![("/views", json!(vec![view.clone(); 5000]))]),
        ("field of view 0", with_view("/vertical_fov_deg", json!(0))),
        ("field of view 180", with_view("/vertical_fov_deg", json!(180))),
        ("near plane 0", with_view("/near_m", json!(0))),
        ("eyes beyond all", with_view("/ipd_m", json!("wide"))),
        ("a view of itself", with_view("/target", json!([0, 1, 3]))),
        (
            "a view by a zero quaternion",
            vec![("/views", json!([{ "name": "v", "position": [0, 1, 3], "orientation": [0, 0, 0, 0] }]))],
        ),
        ("a view of two directions", with_view("/orientation", json!([0, 0, 0, 1]))),
        ("a path back in time", keys([1.0, 0.0])),
        ("a path of one moment", keys([1.0, 1.0])),
        ("a path without keys", vec![("/paths", json!([{ "name": "p", "keys": [] }]))]),
        ("a path at rate 0", vec![("/paths", json!([{ "name": "p", "rate_hz": 0, "keys": [] }]))]),
        (
            "2,000 lights",
            vec![(
                "/lights",
                json!(vec![json!({ "kind": "point", "position": [0, 1, 0], "intensity": [1, 1, 1] }); 2000]),
            )],
        ),
        (
            "a light of negative size",
            vec![(
                "/lights",
                json!([{ "kind": "point", "position": [0, 1, 0], "intensity": [1, 1, 1], "radius_m": -1 }]),
            )],
        ),
        ("an environment below zero", vec![("/environment", json!({ "constant": [-1, 0, 0] }))]),
        ("an environment that is not there", map("none.hdr")),
        ("an environment from a pipe", map("pipe.hdr")),
        ("an environment without end", map("zero.exr")),
        ("an environment in a folder's place", map(".")),
        ("an environment that is none", map("none.txt")),
        ("an HDR of 10⁹ × 10⁹", map("wide.hdr")),
        ("an HDR that ends early", map("short.hdr")),
        ("an EXR that ends early", map("short.exr")),
        ("a geometry that is not there", vec![("/geometry", json!({ "file": "none.gltf" }))]),
        ("a geometry from a pipe", vec![("/geometry", json!({ "file": "pipe.hdr" }))]),
        (
            "what moves is not there",
            vec![(
                "/motion",
                json!([{ "node": "x", "path": { "translate": { "offset_m": [0, 1, 0], "period_s": 1 } } }]),
            )],
        ),
    ];
    for (what, changes) in cases {
        let file = table.new_file("x.json");
        let at = |name: &str| file.with_file_name(name);
        let text = changed(good.clone(), &changes).to_string();
        std::fs::write(&file, text).expect("written");
        let sentence_names = what.contains("pipe")
            || what.contains("not there")
            || what.contains("without end")
            || what.contains("folder's");
        if what.contains("environment") || what.contains("HDR") || what.contains("EXR") || what.contains("geometry") {
            fifo(&at("pipe.hdr"));
            symlink("/dev/zero", at("zero.exr")).expect("linked");
            std::fs::write(at("none.txt"), "no picture").expect("written");
            std::fs::write(at("wide.hdr"), "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000000 +X 1000000000\n\0\0")
                .expect("written");
            std::fs::write(at("short.hdr"), "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 64 +X 64\n\x02\x02")
                .expect("written");
            std::fs::write(at("short.exr"), b"\x76\x2f\x31\x01\x02\0\0\0channels\0chlist\0").expect("written");
        }
        // If a file that the manifest names cannot be read, the message must name that file.
        let named = match what {
            "an environment that is not there" => at("none.hdr"),
            "an environment from a pipe" | "a geometry from a pipe" => at("pipe.hdr"),
            "an environment without end" => at("zero.exr"),
            "a geometry that is not there" => at("none.gltf"),
            _ if sentence_names && what.contains("folder's") => file.parent().expect("a folder").to_owned(),
            _ => file.clone(),
        };
        let name = file.to_string_lossy().into_owned();
        table.at("manifest", what, &named, &["scene", "check", &name]);
    }
    table.put("manifest", "17 MiB of spaces", "x.json", vec![b' '; 17 << 20], &CHECK);
}

// ---- Studies and their data ------------------------------------------------------------------------------------

fn studies(table: &mut Table) {
    let check = ["study", "check", "{}"];
    let good = rate(&["pica"], 2);
    table.no_files("study", "x.json", &check);
    table.no_json("study", "x.json", &good.to_string(), &check);
    let names = |n: usize| json!((0..n).map(|i| format!("s{i}")).collect::<Vec<_>>());
    let cases: Vec<(&str, Vec<(&str, Value)>)> = vec![
        ("format 2", vec![("/format", json!(2))]),
        ("format as text", vec![("/format", json!("1"))]),
        ("an id of dots", vec![("/id", json!("../../x"))]),
        ("an id with a control sequence", vec![("/id", json!("\u{1b}[2J"))]),
        ("an unknown key with a control sequence", vec![("/\u{1b}[2J\n", json!(1))]),
        ("no participants", vec![("/participants", json!(0))]),
        ("4·10⁹ participants", vec![("/participants", json!(4_000_000_000u32))]),
        (
            "100,000 participants of 1,000 repetitions",
            vec![("/participants", json!(100_000)), ("/repetitions", json!(1000))],
        ),
        ("−1 repetitions", vec![("/repetitions", json!(-1))]),
        ("10⁹ repetitions", vec![("/repetitions", json!(1_000_000_000))]),
        ("half a repetition", vec![("/repetitions", json!(0.5))]),
        ("a seed beyond 53 bits", vec![("/seed", json!(u64::MAX))]),
        (
            "5,000 scenes by 5,000 methods",
            vec![("/conditions/cross/scene", names(5000)), ("/conditions/cross/method", names(5000))],
        ),
        ("no conditions", vec![("/conditions", json!({}))]),
        ("an unknown scene with a control sequence", vec![("/conditions/cross/scene", json!(["\u{9b}2J"]))]),
        ("an unknown method", vec![("/conditions/cross/method", json!(["magic"]))]),
        ("an unknown task", vec![("/task", json!("guess"))]),
        ("100,000 labels", vec![("/labels", names(100_000))]),
        ("a scale that falls", vec![("/scale", json!([5, 4, 3, 2, 1]))]),
        ("a scale as text", vec![("/scale", json!("1 to 5"))]),
        ("no protocol", vec![("/protocol", json!([]))]),
        ("a segment of 10³⁰⁰ s", vec![("/protocol/0/seconds", json!(1e300))]),
        ("a segment of −1 s", vec![("/protocol/0/seconds", json!(-1))]),
        ("pictures without pixels", vec![("/stimuli/width_px", json!(0))]),
        ("pictures of 10⁹ pixels", vec![("/stimuli/width_px", json!(1_000_000_000))]),
        ("a practice as a number", vec![("/practice", json!(3))]),
        (
            "5,000 practice presentations",
            vec![("/practice", json!(vec![json!({ "scene": "pink", "method": "sssr" }); 5000]))],
        ),
        ("a level of confidence of 2", vec![("/analysis", json!({ "interval": { "level": 2 } }))]),
    ];
    for (what, changes) in cases {
        table.put("study", what, "x.json", changed(good.clone(), &changes).to_string(), &check);
    }
    table.put("study", "17 MiB of spaces", "x.json", vec![b' '; 17 << 20], &check);
}

/// The CRC-32 of zip, for lines whose check sum is right and whose record is wrong.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    })
}

fn line(record: &str) -> String {
    let body = format!(r#"{{"seq":0,"t_ns":0,"wall":"2026-01-31T23:59:59.999Z","kind":"real","record":{record}"#);
    format!("{body},\"crc\":\"{:08x}\"}}\n", crc32(body.as_bytes()))
}

fn journals(table: &mut Table) {
    let (replay, recover) = (["study", "replay", "{}"], ["study", "recover", "{}"]);
    table.no_files("journal", "x.jsonl", &replay);
    for (what, bytes) in [
        ("an empty file", Vec::new()),
        ("a byte-order mark", "\u{feff}\n".into()),
        ("text", "hello\n".into()),
        ("no line feed", "{\"seq\":0".into()),
        ("a line feed alone", "\n".into()),
        ("a record without a check sum", "{\"seq\":0,\"record\":{}}\n".into()),
        ("a wrong check sum", line("{}").replace("\"t_ns\":0", "\"t_ns\":1").into()),
        ("an unknown record", line("{\"rm\":{}}").into()),
        ("a record 100,000 deep", line(&"[".repeat(100_000)).into()),
        ("an unknown record with a control sequence", line("{\"\\u001b[2J\":1}").into()),
        ("a pause first", line("{\"pause\":{\"reason\":\"operator\"}}").into()),
        ("invalid UTF-8", vec![0xff; 100]),
        ("a line of 65 MiB", vec![b'x'; 65 << 20]),
    ] {
        table.put("journal", what, "x.jsonl", bytes, &replay);
    }
    for (what, target) in [("an endless file to recover", "/dev/zero"), ("a folder to recover", ".")] {
        let file = table.new_file("x.jsonl");
        symlink(target, &file).expect("linked");
        table.at("journal", what, &file, &recover);
    }
    let file = table.new_file("x.jsonl");
    fifo(&file);
    table.at("journal", "a pipe to recover", &file, &recover);
    table.put("journal", "text to recover", "x.jsonl", "hello\nthere\n", &recover);
}

/// Adds cases in which a study with prepared stimuli is damaged. Each `harm` gets the study's folder and returns the
/// file that the message must name.
fn sessions(table: &mut Table, labs: &mut Vec<Lab>) {
    type Harm = fn(&Path) -> PathBuf;
    fn find(folder: &Path, name: &str) -> PathBuf {
        let mut folders = vec![folder.to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
                match entry.path() {
                    path if path.is_dir() => folders.push(path),
                    path if path.to_string_lossy().ends_with(name) => return path,
                    _ => {}
                }
            }
        }
        panic!("no {name}")
    }
    fn instead(folder: &Path, name: &str, make: fn(&Path)) -> PathBuf {
        let path = find(&folder.join("store"), name);
        std::fs::remove_file(&path).expect("removed");
        make(&path);
        path
    }
    fn beside(folder: &Path, name: &str, make: fn(&Path)) -> PathBuf {
        let path = folder.join("sessions/rate").join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        make(&path);
        // For these two files the message names the folder of sessions.
        if name == ".lock" || name == "rows.json" { folder.join("sessions/rate") } else { path }
    }
    let cases: Vec<(&'static str, &str, Harm)> = vec![
        ("stimulus", "a picture from a pipe", |f| instead(f, "sbs.png", fifo)),
        ("stimulus", "a picture without end", |f| instead(f, "sbs.png", |p| symlink("/dev/zero", p).expect("linked"))),
        ("stimulus", "an empty picture", |f| instead(f, "sbs.png", |p| std::fs::write(p, "").expect("written"))),
        ("stimulus", "a picture that is gone", |f| instead(f, "sbs.png", |_| {})),
        ("stimulus", "an EXR from a pipe", |f| instead(f, "stereo.exr", fifo)),
        ("stimulus", "an EXR in a folder's place", |f| {
            instead(f, "stereo.exr", |p| std::fs::create_dir(p).expect("made"))
        }),
        ("stimulus", "a side-car from a pipe", |f| instead(f, "stimulus.json", fifo)),
        ("stimulus", "a side-car without end", |f| {
            instead(f, "stimulus.json", |p| symlink("/dev/zero", p).expect("linked"))
        }),
        ("stimulus", "a side-car with a control sequence", |f| {
            instead(f, "stimulus.json", |p| std::fs::write(p, "{\"\u{1b}[2J\": 1}").expect("written"))
        }),
        ("stimulus", "a side-car that is gone", |f| instead(f, "stimulus.json", |_| {})),
        ("rows", "from a pipe", |f| beside(f, "rows.json", fifo)),
        ("rows", "without end", |f| beside(f, "rows.json", |p| symlink("/dev/zero", p).expect("linked"))),
        ("rows", "that are invalid", |f| beside(f, "rows.json", |p| std::fs::write(p, "[]").expect("written"))),
        ("rows", "a lock from a pipe", |f| beside(f, ".lock", fifo)),
    ];
    for (reader, what, harm) in cases {
        let lab = Lab::in_memory(&rate(&["pica"], 1));
        let named = harm(lab.dir.path());
        let folder = lab.dir.path().to_owned();
        let arguments = ["run", "study.json", "--participant", "p1", "--simulate"].map(str::to_owned).to_vec();
        table.cases.push(Case { reader, what: what.to_owned(), file: named, arguments, folder });
        labs.push(lab);
    }
}

fn pictures(table: &mut Table) {
    let eye = |e: f32| (0..12).map(|i| [i as f32, e, 0.5]).collect();
    let good = StereoPicture { width: 4, height: 3, eyes: [eye(0.0), eye(1.0)] };
    let path = table.folder.join("good.exr");
    picture::write_exr(&path, &[Part { layer: "", picture: &good }]).expect("written");
    let bytes = std::fs::read(&path).expect("read");
    let name = path.to_string_lossy().into_owned();
    let compare = ["compare", name.as_str(), "{}"];
    table.no_files("EXR", "x.exr", &compare);
    for eighth in 0..8 {
        let cut = &bytes[..bytes.len() * eighth / 8];
        table.put("EXR", &format!("its first {eighth}/8"), "x.exr", cut, &compare);
    }
    let find = |word: &[u8]| bytes.windows(word.len()).position(|w| w == word).expect("there") + word.len();
    let patched = |at: usize, value: i32| {
        let mut bytes = bytes.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    let window = find(b"dataWindow\0box2i\0") + 4;
    for (what, bytes) in [
        ("another magic number", patched(0, 7)),
        ("version 9", patched(4, 9)),
        ("2³¹ columns", patched(window + 8, i32::MAX - 1)),
        ("30,000 columns, more than there are", patched(window + 8, 30_000)),
        ("a million rows, more than there are", patched(window + 12, 1_000_000)),
        ("a negative number of columns", patched(window + 8, -5)),
        ("an unknown compression", {
            let mut bytes = bytes.clone();
            bytes[find(b"compression\0compression\0") + 4] = 99;
            bytes
        }),
        ("a PNG", b"\x89PNG\r\n\x1a\n".to_vec()),
        ("text", b"no picture".to_vec()),
    ] {
        table.put("EXR", what, "x.exr", bytes, &compare);
    }
    let other = StereoPicture { width: 3, height: 4, ..good };
    let file = table.new_file("x.exr");
    picture::write_exr(&file, &[Part { layer: "", picture: &other }]).expect("written");
    table.at("EXR", "another size", &file, &compare);
}

#[cfg(feature = "gpu")]
fn poses(table: &mut Table) {
    let scene_file = table.folder.join("poses.json");
    std::fs::write(table.folder.join("poses.gltf"), scene().to_string()).expect("written");
    let manifest = json!({
        "name": "m", "geometry": { "file": "poses.gltf" }, "environment": { "constant": [1, 1, 1] },
    });
    std::fs::write(&scene_file, manifest.to_string()).expect("written");
    let name = scene_file.to_string_lossy().into_owned();
    let render = ["render", &name, "--method", "sssr", "--path", "{}"];
    table.no_files("poses", "x.poses.jsonl", &render);
    let pose = |t: u64, position: &str, turned: &str| {
        format!("{{\"pose\":{{\"t_ns\":{t},\"position\":{position},\"orientation\":{turned}}}}}\n")
    };
    let upright = "[0,0,0,1]";
    for (what, text) in [
        ("an empty file", String::new()),
        ("text", "hello\n".to_owned()),
        ("one pose", pose(0, "[0,0,0]", upright)),
        ("numbers that overflow", pose(0, "[1e999,0,0]", upright) + &pose(1, "[0,0,0]", upright)),
        ("numbers beyond f32", pose(0, "[1e39,0,0]", upright) + &pose(1, "[0,0,0]", upright)),
        ("words instead of numbers", pose(0, "[\"a\",0,0]", upright)),
        ("no direction", pose(0, "[0,0,0]", "[0,0,0,0]") + &pose(9, "[0,0,0]", "[0,0,0,0]")),
        ("a line of 5,000 bytes", " ".repeat(5000) + &pose(0, "[0,0,0]", upright)),
        ("a line of 64 MiB", " ".repeat(64 << 20)),
        ("4,000 open brackets", "[".repeat(4000)),
        ("a control sequence", "{\"\u{1b}[2J\": 1}\n".to_owned()),
        ("a byte-order mark", format!("\u{feff}{}", pose(0, "[0,0,0]", upright))),
    ] {
        table.put("poses", what, "x.poses.jsonl", text, &render);
    }
}

#[test]
fn hostile_files_are_refused_by_one_sentence_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let started = Instant::now();
    let mut table = Table { folder: folder.path().canonicalize().expect("a folder"), cases: Vec::new() };
    let mut labs = Vec::new();
    gltf(&mut table);
    glbs(&mut table);
    manifests(&mut table);
    studies(&mut table);
    journals(&mut table);
    sessions(&mut table, &mut labs);
    pictures(&mut table);
    #[cfg(feature = "gpu")]
    poses(&mut table);
    let count = table.cases.len();
    let wrong = table.run();
    println!("{:.1} s in all", started.elapsed().as_secs_f64());
    assert!(count >= 150, "{count}");
    assert!(wrong.is_empty(), "{} of {count}:\n{}", wrong.len(), wrong.join("\n"));
}

/// Language files are read only for displays that show text, so this test calls the library instead of the program.
#[test]
fn hostile_languages_are_refused_by_one_sentence_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut table = Table { folder: folder.path().to_owned(), cases: Vec::new() };
    table.no_files("language", "words.json", &[]);
    table.no_json("language", "words.json", include_str!("../languages/en.json"), &[]);
    table.put("language", "17 MiB of spaces", "words.json", vec![b' '; 17 << 20], &[]);
    let text = changed(rate(&["pica"], 1), &[("/language", json!("words.json"))]).to_string();
    for case in &table.cases {
        let file = case.file.with_file_name("study.json");
        let study = validate::parse(&file, text.clone()).expect("a study");
        let (send, receive) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            let _ = send.send(Language::of(&study).map(|l| l.name).map_err(|e| e.to_string()));
        });
        let read = receive.recv_timeout(LONGEST).unwrap_or_else(|_| panic!("{}: did not end in time", case.what));
        let error = read.expect_err(&case.what);
        assert!(error.contains("words.json") && error.lines().count() == 1, "{}: {error}", case.what);
    }
    println!("{} hostile languages refused", table.cases.len());
}

// ---- Outside, names, pipes -------------------------------------------------------------------------------------

fn cyclopean(folder: &Path, arguments: &[&str]) -> Output {
    within(LONGEST, Command::new(PROGRAM).args(arguments).current_dir(folder)).expect("it ends")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_scene_reads_nothing_outside_its_folder_unless_asked() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir_all(at("scene/sub")).expect("folders");
    std::fs::write(at("outside.bin"), triangle()).expect("written");
    std::fs::write(at("scene/inside.bin"), triangle()).expect("written");
    symlink("..", at("scene/up")).expect("linked");
    symlink("../outside.bin", at("scene/file")).expect("linked");
    symlink("inside.bin", at("scene/within")).expect("linked");
    let check = |uri: &str, more: &[&str]| {
        let text = changed(scene(), &[("/buffers/0/uri", json!(uri))]).to_string();
        std::fs::write(at("scene/x.gltf"), text).expect("written");
        cyclopean(folder.path(), &[&["scene", "check", "scene/x.gltf"], more].concat())
    };
    for uri in
        ["../outside.bin", "%2e%2e/outside.bin", "..%2foutside.bin", "sub/../../outside.bin", "up/outside.bin", "file"]
    {
        let refused = check(uri, &[]);
        let text = said(&refused);
        assert_eq!(refused.status.code(), Some(1), "{uri}: {text}");
        assert!(text.contains("x.gltf") && text.contains(uri) && text.contains("--allow-outside"), "{uri}: {text}");
        assert_eq!(text.lines().count(), 1, "{text}");
        let taken = check(uri, &["--allow-outside"]);
        assert!(taken.status.success(), "{uri}: {}", said(&taken));
    }
    for uri in ["inside.bin", "./inside.bin", "sub/../inside.bin", "within"] {
        let taken = check(uri, &[]);
        assert!(taken.status.success(), "{uri}: {}", said(&taken));
    }
    // The scene is also checked from within its folder, where its path has no folder.
    assert!(cyclopean(&at("scene"), &["scene", "check", "x.gltf"]).status.success());

    // A side-car is found with its glTF, so that it may not name files outside the folder. A manifest that the command
    // line names may name any file.
    std::fs::write(at("light.hdr"), b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x80")
        .expect("written");
    let manifest = json!({ "name": "m", "environment": { "map": { "file": "../light.hdr" } } });
    std::fs::write(at("scene/x.cyclopean.json"), manifest.to_string()).expect("written");
    let refused = cyclopean(folder.path(), &["scene", "check", "scene/x.gltf"]);
    assert!(said(&refused).contains("light.hdr") && said(&refused).contains("--allow-outside"), "{}", said(&refused));
    assert!(cyclopean(folder.path(), &["scene", "check", "scene/x.gltf", "--allow-outside"]).status.success());
    std::fs::remove_file(at("scene/x.cyclopean.json")).expect("removed");
    let named = changed(manifest, &[("/geometry", json!({ "file": "../x.gltf" }))]);
    std::fs::write(
        at("scene/sub/m.json"),
        changed(named, &[("/environment/map/file", json!("../../light.hdr"))]).to_string(),
    )
    .expect("written");
    let taken = cyclopean(folder.path(), &["scene", "check", "scene/sub/m.json"]);
    assert!(taken.status.success(), "{}", said(&taken));
}

#[test]
fn versions_that_need_more_than_2_0_are_refused_and_others_load() {
    let folder = tempfile::tempdir().expect("a folder");
    for (version, least, loads) in [
        ("2.0", None, true),
        ("2.0", Some("2.0"), true),
        ("2.1", Some("2.0"), true),
        ("2.0", Some("1.0"), true),
        ("2.1", Some("2.1"), false),
        ("2.0", Some("3.0"), false),
        ("2.0", Some("3"), false),
    ] {
        let mut root = changed(scene(), &[("/asset/version", json!(version))]);
        least.iter().for_each(|least| set(&mut root, "/asset/minVersion", json!(least)));
        std::fs::write(folder.path().join("x.gltf"), root.to_string()).expect("written");
        let done = cyclopean(folder.path(), &["scene", "check", "x.gltf"]);
        assert_eq!(done.status.success(), loads, "{version} {least:?}: {}", said(&done));
        assert!(loads || said(&done).contains("asset.minVersion"), "{}", said(&done));
    }
}

#[test]
fn names_from_files_are_escaped_on_the_terminal() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = "\u{1b}[2J\u{9b}31m\u{202e}\r\nrepaired   all";
    let root = changed(scene(), &[("/meshes/0/name", json!(name)), ("/materials/0/name", json!(name))]);
    let root = changed(root, &[("/materials/0/extensions/KHR_materials_transmission/transmissionFactor", json!(0.5))]);
    let file = folder.path().join("\u{1b}[31m.gltf");
    std::fs::write(&file, root.to_string()).expect("written");
    let file = file.to_string_lossy().into_owned();
    for arguments in [
        vec!["scene", "check", &file],
        vec!["scene", "check", &file, "--json"],
        vec!["scene", "check", "\u{1b}[31m"],
        vec!["scene", "check", "none\u{1b}[31m.gltf"],
        vec!["study", "check", "none\u{1b}[31m.json"],
        vec!["study", "\u{1b}[31m"],
        vec!["compare", "\u{1b}[31m.exr", "\u{1b}[31m.exr"],
    ] {
        let done = cyclopean(folder.path(), &arguments);
        for text in [String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr)] {
            let hidden = text.chars().find(|c| (c.is_control() && *c != '\n') || *c == '\u{202e}');
            assert_eq!(hidden, None, "{arguments:?}: {text:?}");
            assert!(!text.lines().any(|l| l.starts_with("repaired   all")), "{text}");
        }
        if arguments.contains(&"--json") {
            let found: Value = serde_json::from_slice(&done.stdout).expect("JSON");
            assert!(
                found["repairs"].to_string().contains("\\u001b[2J"),
                "the JSON does not have the name itself: {found}"
            );
        }
    }
}

#[test]
fn a_reader_that_goes_ends_the_program_quietly() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("x.gltf"), scene().to_string()).expect("written");
    for arguments in [
        &["scene", "list"][..],
        &["study", "schema"],
        &["scene", "check", "x.gltf"],
        &["scene", "check", "x.gltf", "--json"],
        &["completions", "bash"],
        &["--help"],
    ] {
        let mut command = Command::new(PROGRAM);
        command.args(arguments).current_dir(folder.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("started");
        drop(child.stdout.take());
        let done = child.wait_with_output().expect("ended");
        assert_eq!(done.status.code(), Some(0), "{arguments:?}: {}", said(&done));
        assert!(!said(&done).contains("error") && !said(&done).contains("panic"), "{arguments:?}: {}", said(&done));
    }
    for arguments in [&["scene", "check", "none.gltf"][..], &["scene", "check"]] {
        let mut command = Command::new(PROGRAM);
        command.args(arguments).current_dir(folder.path()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("started");
        drop(child.stderr.take());
        let code = child.wait().expect("ended").code();
        assert!(matches!(code, Some(1 | 2)), "{arguments:?}: {code:?}");
    }
    // Output to a full disk must be reported as a failure.
    if let Ok(full) = std::fs::File::options().write(true).open("/dev/full") {
        let mut command = Command::new(PROGRAM);
        command.args(["scene", "list"]).stdout(full).stderr(Stdio::piped());
        let done = command.spawn().and_then(std::process::Child::wait_with_output).expect("ended");
        assert_eq!(done.status.code(), Some(1));
        assert!(said(&done).contains("standard output"), "{}", said(&done));
    }
}

#[test]
fn completions_and_manual_pages_name_every_command() {
    let folder = tempfile::tempdir().expect("a folder");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let done = cyclopean(folder.path(), &["completions", shell]);
        let text = String::from_utf8_lossy(&done.stdout).into_owned();
        assert!(done.status.success() && text.contains("recover") && text.contains("allow-outside"), "{shell}");
    }
    let done = cyclopean(folder.path(), &["man", "-o", "pages"]);
    assert!(done.status.success(), "{}", said(&done));
    let page = std::fs::read_to_string(folder.path().join("pages/cyclopean-scene-check.1")).expect("a page");
    assert!(page.contains("allow\\-outside"), "{page}");
}
