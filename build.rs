//! Compiles the shaders in `shaders/` and in `shaders/display/` (`*.comp`, `*.vert`, `*.frag`) to SPIR-V. The compiler
//! is `glslc`, or the one that the environment variable `GLSLC` names. Cargo runs this before it builds the crate. The
//! results are the files `shaders.rs` and `display_shaders.rs`, which `render::shaders` and `display::shaders` include.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Shaders that are compiled once more with the macros behind them defined (separated by spaces). The variants' names
/// are like `shadows_reuse_ray_query.comp`.
const VARIANTS: &[(&str, &str)] = &[
    ("ao_blend.comp", "LISTED"),
    ("ao_filter.comp", "LISTED"),
    ("ao_obscurance.comp", "LISTED"),
    ("ao_rays.comp", "RAY_QUERY"),
    ("gather.comp", "RAY_QUERY"),
    ("gbuffer.frag", "EMISSION"),
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
    // The displays' shaders have a list of their own, because a stimulus' address does not depend on them.
    let all = compile_all(Path::new("shaders"), &out, "shaders.rs")
        .and_then(|()| compile_all(Path::new("shaders/display"), &out, "display_shaders.rs"));
    if let Err(message) = all {
        println!("cargo::error={}", message.replace('\n', "\ncargo::error="));
        std::process::exit(1);
    }
}

/// Compiles every shader in a folder. Writes Rust code to `list_file`: a static for each shader and a list of all of
/// them.
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
        "/// The names of the shaders that no picture of the reference depends on.\n#[allow(dead_code)]\n\
         pub const OF_VIEWS: &[&str] = &{of_views:?};"
    );
    std::fs::write(out.join(list_file), code).map_err(|e| format!("cannot write {list_file}: {e}"))
}

/// Whether no picture of the reference depends on a shader that is compiled with these macros. The comment at the head
/// of the shader says so in the line `// Reference: never.`. For the variants with one macro the line is
/// `// Reference: never with MACRO.`.
fn is_of_views(text: &str, words: &str) -> bool {
    let head = text.lines().skip(1).take_while(|line| line.starts_with("//"));
    let mut said = head.filter_map(|line| line.strip_prefix("// Reference: never")?.strip_suffix('.'));
    said.any(|with| match with.strip_prefix(" with ") {
        Some(word) => words.split_whitespace().any(|w| w == word),
        None => true,
    })
}

/// Appends the static of one shader to `code` and a reference to it to `list`.
fn add(code: &mut String, list: &mut String, name: &str, target: &Path) {
    let symbol = name.replace('.', "_").to_uppercase();
    // The first field of `Aligned` makes the SPIR-V bytes begin at a multiple of four.
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
            "the shader compiler `{}` cannot be run ({error}). On Debian, `apt-get install glslc` installs it. \
             Elsewhere it comes with the Vulkan SDK. The environment variable GLSLC may name another compiler",
            compiler.to_string_lossy()
        )),
        Ok(done) if done.status.success() => Ok(()),
        Ok(done) => Err(String::from_utf8_lossy(&done.stderr).into_owned()),
    }
}
