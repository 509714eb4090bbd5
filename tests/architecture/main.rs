//! Checks that the sources have none of what ARCHITECTURE.md rules out: forbidden dependencies, circles, undocumented
//! `unsafe`, unnamed randomness and the like. The tests only read the sources and need no GPU.

mod circles;
mod source;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use source::{code, module_of, named_modules, naming, tokens};

/// Folders (or files) below `src/`, each with the modules of this crate that it must not name.
const ABSENT: &[(&str, &[&str])] = &[
    ("study", &["gpu", "render", "method", "scene", "commands"]),
    ("method", &["console", "gpu", "render", "scene", "study", "display", "picture", "metrics", "compare", "commands"]),
    ("scene", &["gpu", "render", "study", "display", "picture", "commands"]),
    ("gpu", &["console", "scene", "render", "study", "display", "picture", "metrics", "commands"]),
    ("render", &["study", "display", "metrics", "compare", "paper", "commands"]),
    ("stress", &["study", "display", "commands"]),
    ("display", &["render", "metrics", "commands"]),
    ("picture", &["gpu", "render", "study", "display", "commands"]),
    ("metrics", &["gpu", "render", "study", "display", "compare", "commands"]),
    ("compare", &["study", "display", "paper", "commands"]),
    ("paper", &["study", "display", "commands"]),
    ("console", &["gpu", "render", "scene", "study", "display", "picture", "metrics", "commands"]),
];

/// The only modules of `study` that `display` may name.
const STUDY_SEEN_BY_DISPLAYS: &[&str] = &["protocol", "observer"];

/// Crates for graphics, windows, devices or pictures.
const GRAPHICS: &[&str] = &[
    "ash",
    "cyclopean",
    "exr",
    "glam",
    "glow",
    "gltf",
    "glutin",
    "gpu-allocator",
    "image",
    "minifb",
    "naga",
    "obvhs",
    "openxr",
    "openxr-sys",
    "pixels",
    "raw-window-handle",
    "sdl2",
    "sdl3",
    "softbuffer",
    "spirq",
    "vulkano",
    "wgpu",
    "wgpu-core",
    "winit",
];

/// The only folders in which `unsafe` may be used.
const UNSAFE_FOLDERS: &[&str] = &["src/gpu/", "src/display/"];

/// Random generators that the system or the thread seeds, so that their numbers cannot be drawn again.
const UNNAMED_RANDOMNESS: &[&str] = &[
    "StdRng",
    "SmallRng",
    "ThreadRng",
    "OsRng",
    "SysRng",
    "thread_rng",
    "from_entropy",
    "from_os_rng",
    "try_from_os_rng",
    "getrandom",
    "rand::rng",
    "rand::random",
    "rand::random_range",
];

/// Functions that open whatever a name leads to, and read it to its end without a limit.
const READING: &[&str] = &[
    "File::open",
    "fs::read",
    "fs::read_to_string",
    "std::fs::read",
    "std::fs::read_to_string",
    "std::fs::File::open",
    "image::open",
    "from_file",
    "read_from_file",
    "read_first_flat_layer_from_file",
];

/// Macros that print text without escaping it, and panic if nobody reads the output.
const PRINTING: &[&str] = &["println", "eprintln", "eprint"];

/// Sources whose path begins like this must name no clock, file, thread, process or environment, because their
/// functions depend on nothing but their arguments.
const PURE: &[&str] = &["src/study/protocol/", "src/study/order", "src/study/plan", "src/study/random"];
const OUTSIDE_WORLD: &[&str] = &[
    "Instant",
    "SystemTime",
    "Utc",
    "Local",
    "chrono",
    "std::time",
    "std::fs",
    "std::net",
    "std::env",
    "std::thread",
    "std::process",
    "std::os",
];

/// The modules that a source under `src/` names although it must not, one line each.
fn forbidden_modules(path: &str, text: &str) -> Vec<String> {
    let module = module_of(path);
    let Some(part) = module.first() else { return Vec::new() };
    let absent = ABSENT.iter().find(|(name, _)| name == part).map_or(&[][..], |(_, absent)| *absent);
    let mut found = Vec::new();
    for (line, named) in named_modules(text, &module) {
        let first = named.first().map_or("", String::as_str);
        let second = named.get(1).map_or("*", String::as_str);
        if absent.contains(&first) || (first == "*" && !absent.is_empty()) {
            found.push(format!("{path}:{line}: `{part}` names `{}`", named.join("::")));
        }
        if part == "display" && first == "study" && !STUDY_SEEN_BY_DISPLAYS.contains(&second) {
            found.push(format!("{path}:{line}: `display` names `{}` of the studies", named.join("::")));
        }
    }
    found
}

/// `unsafe` blocks and impls without a comment that says why they are sound, one line each.
fn undocumented_unsafe(path: &str, text: &str) -> Vec<String> {
    let tokens = tokens(text);
    let (lines, bare): (Vec<&str>, String) = (text.lines().collect(), code(text));
    let bare: Vec<&str> = bare.lines().collect();
    let mut found = Vec::new();
    for (i, token) in tokens.iter().enumerate() {
        let needs_reason = matches!(tokens.get(i + 1).map(|t| t.text.as_str()), Some("{" | "impl"));
        if token.text != "unsafe" || !needs_reason {
            continue;
        }
        // Goes up through the lines of the same statement, and then through the comment above it.
        let mut k = token.line - 1;
        while k > 0 && !bare[k - 1].trim().is_empty() && !bare[k - 1].trim_end().ends_with([';', '{', '}', ',']) {
            k -= 1;
        }
        let comment = lines[..k].iter().rev().map(|l| l.trim()).take_while(|l| l.starts_with("//"));
        let reason = comment.filter_map(|l| l.strip_prefix("// SAFETY:")).next();
        if reason.is_none_or(|r| r.trim().is_empty()) {
            found.push(format!("{path}:{}: `unsafe` without a `// SAFETY:` line above its statement", token.line));
        }
    }
    found
}

/// What is wrong with the head of a shader, if anything is. A shader with an entry point (`is_stage`) needs a
/// `#version`.
fn shader_head(path: &str, text: &str, is_stage: bool) -> Option<String> {
    let mut lines = text.lines();
    if is_stage && !lines.next().is_some_and(|l| l.starts_with("#version ")) {
        return Some(format!("{path}: the first line is not `#version`"));
    }
    let comment: Vec<&str> = lines.take_while(|l| l.starts_with("// ")).collect();
    match (comment.is_empty(), is_stage && !comment.iter().any(|l| l.contains("Out:"))) {
        (true, _) => Some(format!("{path}: no comment at its head says what goes in and out, and whose idea it is")),
        (_, true) => Some(format!("{path}: the comment at its head does not say what comes out (`Out:`)")),
        _ => None,
    }
}

/// From a `Cargo.lock`, each package with the packages that it needs.
fn lock_graph(lock: &str) -> BTreeMap<String, BTreeSet<String>> {
    let mut graph = BTreeMap::new();
    for package in lock.split("[[package]]").skip(1) {
        let quoted = |line: &str| line.split('"').nth(1).map(|s| s.split(' ').next().unwrap_or(s).to_owned());
        let name = package.lines().find(|l| l.starts_with("name = ")).and_then(quoted);
        let needs = package.lines().skip_while(|l| !l.starts_with("dependencies")).skip(1);
        let needs = needs.take_while(|l| !l.starts_with(']')).filter_map(quoted);
        // Two versions of a package count as one, which can only find more dependencies than there are.
        graph.entry(name.unwrap_or_default()).or_insert_with(BTreeSet::new).extend(needs);
    }
    graph
}

/// Everything that `package` needs, directly or not.
fn reachable(graph: &BTreeMap<String, BTreeSet<String>>, package: &str) -> BTreeSet<String> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![package.to_owned()]);
    while let Some(next) = open.pop() {
        for need in graph.get(&next).into_iter().flatten() {
            if seen.insert(need.clone()) {
                open.push(need.clone());
            }
        }
    }
    seen
}

// ---- The tree --------------------------------------------------------------------------------------------------

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path} cannot be read: {e}"))
}

/// The files below a folder with one of these extensions, sorted. Each has its path from the root, with `/`, and its
/// text.
fn sources(folder: &str, extensions: &[&str]) -> Vec<(String, String)> {
    fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
        let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{} cannot be read: {e}", folder.display()));
        for path in entries.flatten().map(|e| e.path()) {
            if path.is_dir() { walk(&path, out) } else { out.push(path) }
        }
    }
    let mut files = Vec::new();
    walk(&root().join(folder), &mut files);
    files.retain(|f| f.extension().and_then(|e| e.to_str()).is_some_and(|e| extensions.contains(&e)));
    files.sort();
    assert!(!files.is_empty(), "{folder} holds no source, so the check would prove nothing");
    let name = |f: &Path| -> String {
        let inside = f.strip_prefix(root()).expect("below the root");
        inside.components().map(|c| c.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
    };
    files.iter().map(|f| (name(f), std::fs::read_to_string(f).expect("UTF-8"))).collect()
}

fn rust() -> Vec<(String, String)> {
    let mut all = sources("src", &["rs"]);
    all.extend(sources("analysis/src", &["rs"]));
    all
}

#[track_caller]
fn none(found: Vec<String>) {
    assert!(found.is_empty(), "these violate ARCHITECTURE.md:\n  {}", found.join("\n  "));
}

#[test]
fn modules_name_only_what_stands_before_them() {
    let sources = sources("src", &["rs"]);
    for part in ["study", "method", "scene", "gpu", "render", "display", "metrics", "compare", "paper"] {
        assert!(sources.iter().any(|(path, _)| path.starts_with(&format!("src/{part}/"))), "src/{part} is gone");
    }
    none(sources.iter().flat_map(|(path, text)| forbidden_modules(path, text)).collect());
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    for folder in ["src", "analysis/src"] {
        none(circles::circles(&sources(folder, &["rs"])));
    }
}

#[test]
fn only_gpu_render_and_display_name_vulkan() {
    let allowed = ["src/gpu/", "src/render/", "src/display/"];
    let named = |(path, text): &(String, String)| -> Vec<String> {
        let found = naming(text, &["ash::", "gpu_allocator::"]);
        found.iter().map(|(line, word)| format!("{path}:{line}: names `{word}`")).collect()
    };
    let elsewhere = rust().into_iter().filter(|(path, _)| !allowed.iter().any(|a| path.starts_with(a)));
    none(elsewhere.flat_map(|source| named(&source)).collect());
}

#[test]
fn the_analysis_needs_no_graphics() {
    let graph = lock_graph(&read("Cargo.lock"));
    let needs = reachable(&graph, "cyclopean-analysis");
    assert!(needs.contains("serde_json"), "Cargo.lock was not understood: {needs:?}");
    none(GRAPHICS.iter().filter(|g| needs.contains(**g)).map(|g| format!("cyclopean-analysis needs {g}")).collect());
    // The manifest is searched too, because the lock file lacks optional packages that no build of this workspace
    // selects.
    let manifest = read("analysis/Cargo.toml");
    let keys = manifest.lines().filter_map(|l| l.split(['=', '.']).next()).map(|k| k.trim().trim_matches('"'));
    none(keys.filter(|k| GRAPHICS.contains(k)).map(|k| format!("analysis/Cargo.toml names {k}")).collect());
}

#[test]
fn unsafe_stands_in_two_folders_and_says_why() {
    let mut found = Vec::new();
    let mut blocks = 0;
    for (path, text) in rust() {
        let allowed = UNSAFE_FOLDERS.iter().any(|f| path.starts_with(f));
        for token in tokens(&text).iter().filter(|t| t.text == "unsafe") {
            blocks += 1;
            if !allowed {
                found.push(format!("{path}:{}: `unsafe`", token.line));
            }
        }
        found.extend(undocumented_unsafe(&path, &text));
    }
    assert!(blocks > 0, "the check found no `unsafe` at all, although src/gpu calls Vulkan");
    none(found);
}

#[test]
fn no_source_draws_random_numbers_without_a_seed() {
    let named = |(path, text): (String, String)| -> Vec<String> {
        let found = naming(&text, UNNAMED_RANDOMNESS);
        found
            .into_iter()
            .map(|(line, word)| format!("{path}:{line}: `{word}` makes numbers that cannot be drawn again"))
            .collect()
    };
    none(rust().into_iter().flat_map(named).collect());
}

/// Uses of `words` in the programs' sources, without their tests. `exempt` is the file or folder that may use them.
fn past_the_one_way(words: &[&str], exempt: &str) -> Vec<String> {
    let own = [sources("src", &["rs"]), sources("analysis/src", &["rs"])].concat();
    assert!(own.iter().any(|(path, _)| path.starts_with(exempt)), "{exempt} is gone");
    let named = |(path, text): (String, String)| -> Vec<String> {
        let text = text.split("\n#[cfg(test)]").next().unwrap_or_default();
        naming(text, words).iter().map(|(line, word)| format!("{path}:{line}: `{word}`; see {exempt}")).collect()
    };
    own.into_iter().filter(|(path, _)| !path.starts_with(exempt)).flat_map(named).collect()
}

#[test]
fn files_are_read_and_words_are_printed_in_one_way() {
    none(past_the_one_way(READING, "analysis/src/files/"));
    none(past_the_one_way(PRINTING, "analysis/src/terminal.rs"));
}

#[test]
fn the_state_machine_and_the_orders_know_no_clock_and_no_file() {
    let sources = sources("src/study", &["rs"]);
    for prefix in PURE {
        assert!(sources.iter().any(|(path, _)| path.starts_with(prefix)), "{prefix} is gone");
    }
    let pure = |path: &str| PURE.iter().any(|p| path.starts_with(p)) && !path.ends_with("/tests.rs");
    let named = |(path, text): &(String, String)| -> Vec<String> {
        let found = naming(text, OUTSIDE_WORLD);
        found.iter().map(|(line, word)| format!("{path}:{line}: names `{word}`")).collect()
    };
    none(sources.iter().filter(|(path, _)| pure(path)).flat_map(named).collect());
}

#[test]
fn every_shader_says_what_it_is_and_is_used() {
    let users = ["src/render", "src/display"];
    let renderer: BTreeSet<String> =
        users.iter().flat_map(|u| sources(u, &["rs"])).flat_map(|(_, text)| tokens(&text)).map(|t| t.text).collect();
    let shaders = sources("shaders", &["comp", "vert", "frag", "glsl"]);
    let mut found = Vec::new();
    for (path, text) in &shaders {
        let file = path.trim_start_matches("shaders/").trim_start_matches("display/");
        let is_stage = !path.ends_with(".glsl");
        found.extend(shader_head(path, text, is_stage));
        let used = if is_stage {
            renderer.contains(&file.replace('.', "_").to_uppercase())
        } else {
            let name = file.rsplit('/').next().unwrap_or(file);
            let includes = |t: &str| {
                let mut files = t.lines().filter(|l| l.starts_with("#include")).filter_map(|l| l.split('"').nth(1));
                files.any(|f| f.rsplit('/').next() == Some(name))
            };
            shaders.iter().any(|(other, t)| other != path && includes(t))
        };
        if !used {
            found.push(format!("{path}: nothing uses it"));
        }
    }
    none(found);
}

#[test]
fn there_is_no_blending() {
    let mut found = Vec::new();
    for (path, text) in sources("src/gpu", &["rs"]) {
        let words = tokens(&text).into_iter().filter(|t| t.text == "blend_enable");
        found.extend(words.map(|t| format!("{path}:{}: blending", t.line)));
    }
    none(found);
}

// ---- The checker itself ----------------------------------------------------------------------------------------

#[test]
fn a_forbidden_module_is_found() {
    let say = |path: &str, text: &str| forbidden_modules(path, text);
    assert_eq!(say("src/study/a.rs", "\nuse crate::gpu::Gpu;"), ["src/study/a.rs:2: `study` names `gpu::Gpu`"]);
    assert_eq!(say("src/render/a.rs", "fn f() { crate::commands::main(); }").len(), 1);
    assert_eq!(say("src/render/a.rs", "use crate::study;").len(), 1);
    assert_eq!(say("src/scene/load/a.rs", "use crate::*;").len(), 1);
    assert_eq!(say("src/picture.rs", "use crate::gpu;").len(), 1);
    assert_eq!(say("src/display/desktop/a.rs", "use crate::study::{protocol::Event, store::Store};").len(), 1);
    assert_eq!(say("src/display/a.rs", "use crate::study;").len(), 1);
    assert!(say("src/render/a.rs", "use crate::{gpu, scene::Scene}; use super::study;").is_empty());
    assert!(say("src/commands/a.rs", "use crate::{gpu, study, render};").is_empty());
}

#[test]
fn unsafe_without_a_reason_is_found() {
    let found = |text: &str| undocumented_unsafe("a.rs", text).len();
    assert_eq!(found("// SAFETY: it lives.\nlet a = unsafe { f() };"), 0);
    assert_eq!(found("// SAFETY: it lives\n// and is ours.\nlet a =\n    unsafe { f() }.b();"), 0);
    assert_eq!(found("// SAFETY: no threads.\nunsafe impl Send for A {}"), 0);
    assert_eq!(found("unsafe extern \"system\" fn f() {}"), 0);
    assert_eq!(found("let a = unsafe { f() };"), 1);
    assert_eq!(found("// SAFETY:\nlet a = unsafe { f() };"), 1);
    assert_eq!(found("// it is safe\nlet a = unsafe { f() };"), 1);
    assert_eq!(found("// SAFETY: of another one.\ng();\nlet a = unsafe { f() };"), 1);
    assert_eq!(found("// SAFETY: of the function.\nfn g() {\n    unsafe { f() }\n}"), 1);
    assert_eq!(found("// SAFETY: far away.\n\nlet a = unsafe { f() };"), 1);
    assert_eq!(found("let s = \"unsafe { f() }\"; // unsafe { g() }"), 0);
}

#[test]
fn words_and_paths_are_found() {
    let found = |text: &str, word: &str| naming(text, &[word]).len();
    assert_eq!(found("use rand::rngs::StdRng;", "StdRng"), 1);
    assert_eq!(found("let x = rand::rng();", "rand::rng"), 1);
    assert_eq!(found("use rand::{Rng, rng};", "rand::rng"), 1);
    assert_eq!(found("use std::{fmt, time::Instant};", "std::time"), 1);
    assert_eq!(found("use std::time::{Duration, Instant};", "std::time"), 1);
    assert_eq!(found("use rand::{Rng, SeedableRng}; let y = stream.rng();", "rand::rng"), 0);
    assert_eq!(found("// StdRng\nlet s = \"StdRng\"; let MyStdRng = 1;", "StdRng"), 0);
    assert_eq!(found("use other::std::time;", "std::time"), 0);
    assert_eq!(found("fn f(x: ash::Device) {}", "ash::"), 1);
    assert_eq!(found("use ash as a; let ash = 1;", "ash::"), 1);
    assert_eq!(found("let ash = wood.ash; oak::ash::f()", "ash::"), 0);
}

#[test]
fn a_shader_without_a_head_is_found() {
    let wrong = |text: &str, is_stage: bool| shader_head("a", text, is_stage).is_some();
    assert!(!wrong("#version 460\n// In: a. Out: b.\nvoid main() {}", true));
    assert!(!wrong("// Constants.\n#ifndef A", false));
    assert!(wrong("#version 460\n\n// In: a. Out: b.", true));
    assert!(wrong("#version 460\n// It does something.\n", true));
    assert!(wrong("// In: a. Out: b.\n#version 460", true));
    assert!(wrong("#ifndef A\n// Constants.", false));
}

#[test]
fn what_a_package_needs_is_followed() {
    let lock = "[[package]]\nname = \"a\"\ndependencies = [\n \"b 1.0.0\",\n]\n\n[[package]]\nname = \"b\"\nversion = \"1\"\n\
                dependencies = [\n \"ash\",\n]\n\n[[package]]\nname = \"c\"\ndependencies = [\n \"a\",\n]\n";
    let graph = lock_graph(lock);
    assert_eq!(reachable(&graph, "a").into_iter().collect::<Vec<_>>(), ["ash", "b"]);
    assert!(reachable(&graph, "ash").is_empty());
}
