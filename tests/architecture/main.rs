//! What ARCHITECTURE.md says is absent is absent: checked by reading the sources. Needs no GPU.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A folder (or file) below `src/` and the modules of this crate that it must not name.
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

/// Of the studies a display may name only these.
const STUDY_SEEN_BY_DISPLAYS: &[&str] = &["protocol", "observer"];

/// Crates that bring graphics, windows, devices or pictures.
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

/// Where `unsafe` may stand.
const UNSAFE_FOLDERS: &[&str] = &["src/gpu/", "src/display/"];

/// Generators seeded by the system or by the thread.
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

/// Opens whatever a name leads to and reads it to its end, if it has one.
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

/// Prints as it stands, and panics where nobody reads.
const PRINTING: &[&str] = &["println", "eprintln", "eprint"];

/// Functions of their arguments: sources whose path begins so name no clock, file, thread, process or environment.
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

// ---- Reading Rust and GLSL -------------------------------------------------------------------------------------

/// The text with comments, strings and character literals blanked; lines and columns stay.
fn code(text: &str) -> String {
    let c: Vec<char> = text.chars().collect();
    let at = |i: usize| c.get(i).copied().unwrap_or('\0');
    let is_word = |x: char| x.is_alphanumeric() || x == '_';
    let mut out = String::with_capacity(text.len());
    let blank = |x: char| if x == '\n' { '\n' } else { ' ' };
    let mut i = 0;
    while i < c.len() {
        let from = i;
        if at(i) == '/' && at(i + 1) == '/' {
            while i < c.len() && at(i) != '\n' {
                i += 1;
            }
        } else if at(i) == '/' && at(i + 1) == '*' {
            let mut depth = 0;
            while i < c.len() {
                match (at(i), at(i + 1)) {
                    ('/', '*') => (depth, i) = (depth + 1, i + 2),
                    ('*', '/') => (depth, i) = (depth - 1, i + 2),
                    _ => i += 1,
                }
                if depth == 0 {
                    break;
                }
            }
        } else if let Some(end) = raw_string_end(&c, i).filter(|_| i == 0 || !is_word(at(i - 1))) {
            i = end;
        } else if at(i) == '"' {
            i += 1;
            while i < c.len() && at(i) != '"' {
                i += if at(i) == '\\' { 2 } else { 1 };
            }
            i += 1;
        } else if at(i) == '\'' && at(i + 1) == '\\' {
            i += 3;
            while i < c.len() && at(i) != '\'' {
                i += 1;
            }
            i += 1;
        } else if at(i) == '\'' && at(i + 2) == '\'' {
            i += 3;
        } else {
            out.push(at(i));
            i += 1;
            continue;
        }
        i = i.min(c.len());
        out.extend(c[from..i].iter().map(|x| blank(*x)));
    }
    out
}

/// The index after a raw string that begins at `i` (`r"…"`, `r#"…"#`, `br"…"`, `cr"…"`).
fn raw_string_end(c: &[char], i: usize) -> Option<usize> {
    let mut k = i;
    if matches!(c.get(k), Some('b' | 'c')) {
        k += 1;
    }
    if c.get(k) != Some(&'r') {
        return None;
    }
    k += 1;
    let hashes = c[k..].iter().take_while(|x| **x == '#').count();
    k += hashes;
    if c.get(k) != Some(&'"') {
        return None;
    }
    k += 1;
    while k < c.len() {
        if c[k] == '"' && c[k + 1..].iter().take(hashes).filter(|x| **x == '#').count() == hashes {
            return Some(k + 1 + hashes);
        }
        k += 1;
    }
    Some(k)
}

/// A word, `::`, or one other character, with its line (from 1).
#[derive(Debug, Clone, PartialEq)]
struct Token {
    text: String,
    line: usize,
}

fn tokens(text: &str) -> Vec<Token> {
    let mut out = Vec::new();
    for (line, content) in code(text).lines().enumerate() {
        let c: Vec<char> = content.chars().collect();
        let mut i = 0;
        while i < c.len() {
            let from = i;
            if c[i].is_alphanumeric() || c[i] == '_' {
                while i < c.len() && (c[i].is_alphanumeric() || c[i] == '_') {
                    i += 1;
                }
            } else if c[i] == ':' && c.get(i + 1) == Some(&':') {
                i += 2;
            } else {
                i += 1;
                if c[from].is_whitespace() {
                    continue;
                }
            }
            out.push(Token { text: c[from..i].iter().collect(), line: line + 1 });
        }
    }
    out
}

/// Lines that name one of `words`: an identifier, a path such as `std::time` (written out or as a group), or with
/// `ash::` anything of that crate.
fn naming(text: &str, words: &[&str]) -> Vec<(usize, String)> {
    let tokens = tokens(text);
    let mut found = Vec::new();
    for (i, token) in tokens.iter().enumerate() {
        let starts_path = i == 0 || tokens[i - 1].text != "::";
        for word in words {
            let hit = match word.split_once("::") {
                None => token.text == *word,
                Some((first, "")) => {
                    let used = i > 0 && tokens[i - 1].text == "use";
                    let path = tokens.get(i + 1).is_some_and(|t| t.text == "::");
                    starts_path && token.text == first && (used || path)
                }
                Some((first, _)) => {
                    starts_path && token.text == first && {
                        let mut paths = Vec::new();
                        paths_from(&tokens, i, &mut Vec::new(), &mut paths);
                        paths.iter().any(|(_, p)| {
                            let p = p.join("::");
                            p == *word || p.starts_with(&format!("{word}::"))
                        })
                    }
                }
            };
            if hit {
                found.push((token.line, (*word).to_owned()));
            }
        }
    }
    found
}

/// Every path that begins at token `i`, groups multiplied out; gives the index after it.
fn paths_from(tokens: &[Token], i: usize, prefix: &mut Vec<String>, out: &mut Vec<(usize, Vec<String>)>) -> usize {
    let text = |k: usize| tokens.get(k).map_or("", |t| t.text.as_str());
    let depth = prefix.len();
    let line = tokens[i].line;
    let mut k = i;
    loop {
        prefix.push(text(k).to_owned());
        k += 1;
        if text(k) != "::" {
            break;
        }
        if text(k + 1) == "{" {
            k += 2;
            while k < tokens.len() && text(k) != "}" {
                if text(k) == "," {
                    k += 1;
                    continue;
                }
                k = paths_from(tokens, k, prefix, out);
                // `as name`
                while k < tokens.len() && text(k) != "," && text(k) != "}" {
                    k += 1;
                }
            }
            prefix.truncate(depth);
            return k + 1;
        }
        if !text(k + 1).starts_with(|x: char| x.is_alphabetic() || x == '_' || x == '*') {
            break;
        }
        k += 1;
    }
    out.push((line, prefix.clone()));
    prefix.truncate(depth);
    k
}

/// Paths within this crate that a source names, from the crate's root: `crate::…`, and `self::…` and `super::…`
/// resolved from `module` (the file's own path of modules) and from the modules written inside the file.
fn named_modules(text: &str, module: &[String]) -> Vec<(usize, Vec<String>)> {
    let tokens = tokens(text);
    let (mut found, mut inner, mut depth) = (Vec::new(), Vec::<(String, usize)>::new(), 0usize);
    for (i, token) in tokens.iter().enumerate() {
        let before = |n: usize| i.checked_sub(n).map_or("", |k| tokens[k].text.as_str());
        match token.text.as_str() {
            "{" => {
                depth += 1;
                if before(2) == "mod" {
                    inner.push((before(1).to_owned(), depth));
                }
            }
            "}" => {
                inner.retain(|(_, d)| *d != depth);
                depth = depth.saturating_sub(1);
            }
            "crate" | "super" | "self" if before(1) != "::" => {
                let next = |n: usize| tokens.get(i + n).map_or("", |t| t.text.as_str());
                // `use crate as other` would hide whatever follows.
                if token.text == "crate" && next(1) == "as" {
                    found.push((token.line, vec!["*".to_owned()]));
                }
                if next(1) != "::" {
                    continue;
                }
                let mut paths = Vec::new();
                paths_from(&tokens, i, &mut Vec::new(), &mut paths);
                for (line, path) in paths {
                    let mut here: Vec<String> =
                        module.iter().cloned().chain(inner.iter().map(|(name, _)| name.clone())).collect();
                    for word in path {
                        match word.as_str() {
                            "crate" => here.clear(),
                            "super" => drop(here.pop()),
                            "self" => {}
                            _ => here.push(word),
                        }
                    }
                    found.push((line, here));
                }
            }
            _ => {}
        }
    }
    found
}

/// `src/study/session/mod.rs` → study, session.
fn module_of(path: &str) -> Vec<String> {
    let inside = path.strip_prefix("src/").unwrap_or(path);
    let mut parts: Vec<String> = inside.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if matches!(parts.last().map(String::as_str), Some("mod" | "lib" | "main")) {
        parts.pop();
    }
    parts
}

/// What a source under `src/` names although it must not.
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

/// `unsafe` blocks and impls without the comment that says why they are sound.
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
        // Up through the lines of the same statement, then through the comment above it.
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

/// What is wrong with the head of a shader; `is_stage`: it has an entry point, and so a `#version`.
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

/// Package → the packages it needs, from a `Cargo.lock`.
fn lock_graph(lock: &str) -> BTreeMap<String, BTreeSet<String>> {
    let mut graph = BTreeMap::new();
    for package in lock.split("[[package]]").skip(1) {
        let quoted = |line: &str| line.split('"').nth(1).map(|s| s.split(' ').next().unwrap_or(s).to_owned());
        let name = package.lines().find(|l| l.starts_with("name = ")).and_then(quoted);
        let needs = package.lines().skip_while(|l| !l.starts_with("dependencies")).skip(1);
        let needs = needs.take_while(|l| !l.starts_with(']')).filter_map(quoted);
        // Two versions of one package are one node: that can only find more.
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

/// Files below a folder with one of these extensions: path from the root with `/`, and text; sorted.
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
    assert!(!files.is_empty(), "{folder} holds no source: the check would prove nothing");
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
    assert!(found.is_empty(), "ARCHITECTURE.md says otherwise:\n  {}", found.join("\n  "));
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
fn vulkan_is_named_by_gpu_and_render_alone() {
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
    // The lock file leaves out what no build of this workspace selects.
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
    assert!(blocks > 0, "src/gpu calls Vulkan without `unsafe`? The check sees nothing");
    none(found);
}

#[test]
fn randomness_has_a_name() {
    let named = |(path, text): (String, String)| -> Vec<String> {
        let found = naming(&text, UNNAMED_RANDOMNESS);
        found.into_iter().map(|(line, word)| format!("{path}:{line}: `{word}` cannot be drawn again")).collect()
    };
    none(rust().into_iter().flat_map(named).collect());
}

/// Names of what the programs are made of, without their tests, that are among `words`; `exempt` is the one place.
fn past_the_one_way(words: &[&str], exempt: &str) -> Vec<String> {
    let own = [sources("src", &["rs"]), sources("analysis/src", &["rs"])].concat();
    assert!(own.iter().any(|(path, _)| path == exempt), "{exempt} is gone");
    let named = |(path, text): (String, String)| -> Vec<String> {
        let text = text.split("\n#[cfg(test)]").next().unwrap_or_default();
        naming(text, words).iter().map(|(line, word)| format!("{path}:{line}: `{word}`; see {exempt}")).collect()
    };
    own.into_iter().filter(|(path, _)| path != exempt).flat_map(named).collect()
}

#[test]
fn files_are_read_and_words_are_printed_in_one_way() {
    none(past_the_one_way(READING, "analysis/src/files.rs"));
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
            found.push(format!("{path}: nobody uses it"));
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

fn modules(path: &str, text: &str) -> Vec<String> {
    named_modules(text, &module_of(path)).into_iter().map(|(_, named)| named.join("::")).collect()
}

#[test]
fn comments_strings_and_characters_are_no_code() {
    let text = "a // crate::gpu\n/* b /* c */ d */ e \"crate::\\\"f\" g r#\"h\"i\"# 'j' '\\'' '\\u{41}' k<'l> b\"m\" n";
    let words: Vec<String> = tokens(text).into_iter().map(|t| t.text).filter(|t| t.len() == 1).collect();
    assert_eq!(words.concat(), "aegk<'l>bn");
    let lines: Vec<usize> = tokens("a\n\"b\nc\"\nd").iter().map(|t| t.line).collect();
    assert_eq!(lines, [1, 4]);
    assert_eq!(code("x'y'\nz").lines().count(), 2);
}

#[test]
fn names_are_resolved_from_where_they_stand() {
    assert_eq!(modules("src/study/a.rs", "use crate::gpu::Gpu;"), ["gpu::Gpu"]);
    assert_eq!(
        modules("src/study/a.rs", "use crate::{gpu::{Gpu, Frame as F}, scene as s, render};"),
        ["gpu::Gpu", "gpu::Frame", "scene", "render"]
    );
    assert_eq!(modules("src/study/a.rs", "fn f(x: crate::gpu::Gpu<u8>) {}"), ["gpu::Gpu"]);
    assert_eq!(modules("src/study/a.rs", "use super::super::gpu;"), ["gpu"]);
    assert_eq!(modules("src/study/mod.rs", "use super::gpu::Gpu;"), ["gpu::Gpu"]);
    assert_eq!(modules("src/study/a.rs", "use super::gpu::Gpu;"), ["study::gpu::Gpu"]);
    let inner = "mod tests { use super::super::super::gpu; } use super::b;";
    assert_eq!(modules("src/study/a.rs", inner), ["gpu", "study::b"]);
    assert_eq!(modules("src/study/a.rs", "pub(crate) fn f(&self) { self.gpu.go() }"), [""; 0]);
    assert_eq!(modules("src/study/a.rs", "use crate as c;"), ["*"]);
    assert_eq!(modules("src/study/a.rs", "use crate::*;"), ["*"]);
    assert_eq!(modules("src/study/a.rs", "// use crate::gpu;\nlet s = \"crate::gpu\";"), [""; 0]);
}

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
