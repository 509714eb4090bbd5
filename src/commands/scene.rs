//! `cyclopean scene list|check|export`: lists the scenes, reports what is in one, and writes a built-in one as glTF.

use std::path::{Path, PathBuf};

use anyhow::Context;
use cyclopean_analysis::files::write_bytes;
use serde_json::json;

use super::WrongUsage;
use super::outside::OutsideArgs;
use crate::console::Console;
use crate::scene::manifest::{Geometry, Manifest};
use crate::scene::survey::{Survey, survey};
use crate::scene::{self, Loading, Treatment, builtin};

/// List, check and export scenes.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// List the built-in scenes with their counts and views.
    List,
    /// Load a scene and report what it holds, what was repaired, and what to be careful about.
    Check {
        /// The scene: a built-in name, a manifest (.json), or a .gltf or .glb file.
        scene: String,
        /// Scale the triangle count of a built-in scene by this factor (0.01–4).
        #[arg(long)]
        detail: Option<f64>,
        #[command(flatten)]
        outside: OutsideArgs,
    },
    /// Write a built-in scene as NAME.gltf with its .bin, PNG textures and manifest.
    Export {
        /// The name of a built-in scene.
        name: String,
        /// The folder to write into; it is made when missing. By default out/NAME.
        #[arg(short, long)]
        out: Option<PathBuf>,
        /// Scale the triangle count by this factor (0.01–4).
        #[arg(long)]
        detail: Option<f64>,
    },
}

pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    match args.action {
        Action::List => list(console),
        Action::Check { scene, detail, outside } => check(&scene, Loading { detail, ..outside.loading() }, console),
        Action::Export { name, out, detail } => export(&name, out, detail, console),
    }
}

fn list(console: &Console) -> anyhow::Result<()> {
    let mut rows = Vec::new();
    console.line(format!("{:8} {:>9} {:>9}  {:22} description", "name", "triangles", "materials", "views"));
    for name in builtin::NAMES {
        let manifest = built_in(name)?;
        let detail = detail_of(&manifest);
        let (triangles, materials) = builtin::count(name, detail).map_err(anyhow::Error::msg)?;
        let views: Vec<&str> = manifest.views.iter().map(|v| v.name.as_str()).collect();
        let shown = views.join(", ");
        console.line(format!("{name:8} {triangles:>9} {materials:>9}  {shown:22} {}", manifest.description));
        rows.push(json!({
            "name": name, "triangles": triangles, "materials": materials, "detail": detail,
            "views": views, "description": manifest.description,
        }));
    }
    console.object(&json!({ "scenes": rows }))?;
    Ok(())
}

fn check(source: &str, loading: Loading, console: &Console) -> anyhow::Result<()> {
    in_range(loading.detail)?;
    let started = std::time::Instant::now();
    let scene = scene::load_with(source, loading)?;
    let found = survey(&scene);
    console.object(&found)?;
    say(&found, console);
    console.note(format!("loaded in {:.1} s", started.elapsed().as_secs_f64()));
    Ok(())
}

fn say(found: &Survey, console: &Console) {
    console.line(format!("scene      {}", found.name));
    console.line(format!("content    sha256 {}", found.content_sha256));
    console.line(format!(
        "geometry   {} triangles in {} instances of {} primitives, {:.1} MiB; {:.0} % in closed meshes",
        found.triangles,
        found.instances,
        found.primitives,
        found.geometry_mib,
        found.closed_share * 100.0
    ));
    let rough = match found.roughness {
        Some([low, high, mean]) => format!("roughness {low:.3} to {high:.3}, mean {mean:.3}"),
        None => "none reflective".to_owned(),
    };
    console.line(format!("materials  {}, {} reflective ({rough})", found.materials, found.reflective_materials));
    console.line(format!("textures   {}, {:.1} MiB", found.textures, found.texture_mib));
    console.line(format!("lights     {}", found.lights));
    console.line(format!("views      {}", found.views.join(", ")));
    console.line(format!("moving     {} instances", found.moving));
    let section = |title: &str, lines: &[String]| {
        for (i, line) in lines.iter().enumerate() {
            console.line(format!("{:10} {line}", if i == 0 { title } else { "" }));
        }
    };
    for (title, treatment) in
        [("read", Treatment::Read), ("approx.", Treatment::Approximated), ("ignored", Treatment::Ignored)]
    {
        let of = found.extensions.iter().filter(|e| e.treatment == treatment);
        let lines: Vec<String> = of.map(|e| format!("{}: {}", e.name, e.how)).collect();
        section(title, &lines);
    }
    section("repaired", &found.repairs);
    section("warning", &found.warnings);
}

fn export(name: &str, out: Option<PathBuf>, detail: Option<f64>, console: &Console) -> anyhow::Result<()> {
    in_range(detail)?;
    if !builtin::NAMES.contains(&name) {
        let known = builtin::NAMES.join(", ");
        return Err(WrongUsage(format!("`{name}` is not a built-in scene; only these are exported: {known}")).into());
    }
    let manifest = built_in(name)?;
    let made = builtin::generate(name, detail.unwrap_or(detail_of(&manifest))).map_err(anyhow::Error::msg)?;
    let folder = out.unwrap_or_else(|| Path::new("out").join(name));
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let mut written = Vec::new();
    let mut write = |file: String, bytes: &[u8]| -> anyhow::Result<()> {
        crate::console::check_interrupted()?;
        let path = folder.join(file);
        write_bytes(&path, bytes)?;
        written.push(path.display().to_string());
        Ok(())
    };
    for (file, bytes) in &made.files {
        write(file.clone(), bytes)?;
    }
    let gltf = format!("{name}.gltf");
    let beside = Manifest { geometry: Some(Geometry::File(gltf.clone())), ..manifest };
    write(format!("{name}.cyclopean.json"), &serde_json::to_vec_pretty(&beside)?)?;
    // The glTF file is written last: whoever finds it also finds all files that it names.
    write(gltf.clone(), &made.gltf)?;
    console.line(format!("{} files; the scene is {}", written.len(), folder.join(&gltf).display()));
    console.object(&json!({ "scene": folder.join(&gltf).display().to_string(), "files": written }))?;
    Ok(())
}

fn built_in(name: &str) -> anyhow::Result<Manifest> {
    let text = builtin::manifest(name).with_context(|| format!("`{name}` has no manifest"))?;
    serde_json::from_str(text).with_context(|| format!("scenes/{name}.json"))
}

fn detail_of(manifest: &Manifest) -> f64 {
    match manifest.geometry {
        Some(Geometry::Builtin { detail, .. }) => detail,
        _ => 1.0,
    }
}

fn in_range(detail: Option<f64>) -> Result<(), WrongUsage> {
    match detail {
        Some(d) if !(0.01..=4.0).contains(&d) => Err(WrongUsage(format!("--detail is {d}; it must be 0.01 to 4"))),
        _ => Ok(()),
    }
}
