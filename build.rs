//! Compiles `shaders/*.{comp,vert,frag}` and those of `shaders/display/` to SPIR-V, with `glslc` or the compiler that the
//! variable `GLSLC` names, and writes `shaders.rs` and `display_shaders.rs`, which `render::shaders` and `display::shaders`
//! include.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Shaders that are compiled again with these macros defined (separated by spaces). Variants are named like
/// `shadows_reuse_ray_query.comp`.
const VARIANTS: &[(&str, &str)] = &[
    ("ao_blend.comp", "LISTED"),
    ("ao_filter.comp", "LISTED"),
    ("ao_obscurance.comp", "LISTED"),
    ("ao_rays.comp", "RAY_QUERY"),
    ("gather.comp", "RAY_QUERY"),
    ("indirect.comp", "RAY_QUERY"),
    ("path_rays.comp", "RAY_QUERY"),
    ("path_trace.comp", "RAY_QUERY"),
    ("probe.comp", "RAY_QUERY"),
    ("shadows.comp", "RAY_QUERY"),
    ("shadows.comp", "REUSE"),
    ("shadows.comp", "REUSE RAY_QUERY"),
    ("trace_geometry.comp", "RAY_QUERY"),
];

fn main() {
    println!("cargo::rerun-if-changed=shaders");
    println!("cargo::rerun-if-env-changed=GLSLC");
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_GPU").is_none() {
        return;
    }
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    // The displays' shaders have a list of their own, because they are no part of a stimulus' address.
    let all = compile_all(Path::new("shaders"), &out, "shaders.rs")
        .and_then(|()| compile_all(Path::new("shaders/display"), &out, "display_shaders.rs"));
    if let Err(message) = all {
        println!("cargo::error={}", message.replace('\n', "\ncargo::error="));
        std::process::exit(1);
    }
}

/// Compiles every shader stage of a folder, and writes Rust code with a static for each shader and a list of all of them.
fn compile_all(folder: &Path, out: &Path, list_file: &str) -> Result<(), String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("cannot read {}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries
        .filter_map(|e| e.ok().map(|e| e.path()))
        .filter(|p| p.extension().is_some_and(|e| e == "comp" || e == "vert" || e == "frag"))
        .collect();
    files.sort();
    let mut code = String::new();
    let mut list = String::new();
    let mut of_views = Vec::new();
    for file in &files {
        let name = file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let mut made = vec![(name.clone(), "")];
        for (_, words) in VARIANTS.iter().filter(|(of, _)| *of == name) {
            made.push((name.replace('.', &format!("_{}.", words.to_lowercase().replace(' ', "_"))), *words));
        }
        let text = std::fs::read_to_string(file).map_err(|e| format!("cannot read {}: {e}", file.display()))?;
        for (name, words) in made {
            if is_of_views(&text, words) {
                of_views.push(name.clone());
            }
            let target = out.join(format!("{name}.spv"));
            compile(file, &target, words)?;
            add(&mut code, &mut list, &name, &target);
        }
    }
    let _ = writeln!(code, "/// Every shader.\n#[allow(dead_code)]\npub static ALL: &[&Shader] = &[{list}];");
    let _ = writeln!(
        code,
        "/// Those that no picture of the reference passes through.\n#[allow(dead_code)]\npub const OF_VIEWS: &[&str] = &{of_views:?};"
    );
    std::fs::write(out.join(list_file), code).map_err(|e| format!("cannot write {list_file}: {e}"))
}

/// Whether no picture of the reference depends on a shader with these macros defined. The comment at the shader's head says
/// so, by a line `// Reference: never.`, or `// Reference: never with MACRO.` for the variants with that macro.
fn is_of_views(text: &str, words: &str) -> bool {
    let head = text.lines().skip(1).take_while(|line| line.starts_with("//"));
    let mut said = head.filter_map(|line| line.strip_prefix("// Reference: never")?.strip_suffix('.'));
    said.any(|with| match with.strip_prefix(" with ") {
        Some(word) => words.split_whitespace().any(|w| w == word),
        None => true,
    })
}

/// Appends the static of one shader to `code`, and its name to `list`.
fn add(code: &mut String, list: &mut String, name: &str, target: &Path) {
    let symbol = name.replace('.', "_").to_uppercase();
    // The wrapper's first field aligns the SPIR-V bytes to words.
    let _ = writeln!(
        code,
        "static {symbol}_BYTES: &Aligned<[u8]> = &Aligned {{ _word: [], bytes: *include_bytes!({target:?}) }};\n\
         /// `shaders/{name}`\npub static {symbol}: Shader = Shader {{ name: {name:?}, bytes: &{symbol}_BYTES.bytes }};"
    );
    let _ = write!(list, "&{symbol}, ");
}

fn compile(file: &Path, target: &Path, words: &str) -> Result<(), String> {
    let compiler = std::env::var_os("GLSLC").unwrap_or_else(|| "glslc".into());
    let run = Command::new(&compiler)
        .args(["--target-env=vulkan1.3", "-Werror", "-I", "shaders"])
        .args(words.split_whitespace().map(|word| format!("-D{word}")))
        .arg("-o")
        .arg(target)
        .arg(file)
        .output();
    match run {
        Err(error) => Err(format!(
            "the shader compiler `{}` cannot be run ({error}); Debian: apt-get install glslc, elsewhere it comes \
             with the Vulkan SDK; GLSLC names another one",
            compiler.to_string_lossy()
        )),
        Ok(done) if done.status.success() => Ok(()),
        Ok(done) => Err(String::from_utf8_lossy(&done.stderr).into_owned()),
    }
}
