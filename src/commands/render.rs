//! `cyclopean render`: renders one stereo still, or with `--path` a sequence.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use clap::Args as ClapArgs;
use cyclopean_analysis::{escape, files};
use serde::Serialize;

use crate::console::{Console, check_interrupted};
use crate::gpu::{DeviceInfo, PassTime};
use crate::picture::{self, Part};
use crate::render::needs;
use crate::render::shared::Counts;
use crate::render::{
    Ao, Firefly, Method, Rendered, Renderer, Request, Reuse, Settings, ShadingReuse, Shadows, Streams, Temporal, Trace,
    median_of_sorted,
};
use crate::scene::{self, Fallback};

use super::WrongUsage;
use super::ao::AoArgs;
use super::device::{self, Size};
use super::outside::OutsideArgs;
use super::sequence::{self, Sequence};

/// Render a stereo image as multi-view EXR and side-by-side PNG, with render.json; with --path, a sequence of images.
#[derive(Debug, ClapArgs)]
#[command(after_help = methods())]
pub struct Args {
    /// The scene: a built-in name, a manifest (.json), or a .gltf or .glb file.
    scene: String,
    #[command(flatten)]
    outside: OutsideArgs,
    /// The method's name, or NAME@N for N rays per pixel.
    #[arg(long, short)]
    method: String,
    /// One of the scene's views; by default its first.
    #[arg(long)]
    view: Option<String>,
    /// Pixels of one eye, WIDTHxHEIGHT.
    #[arg(long)]
    size: Option<Size>,
    /// Rays (or paths) per pixel.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=65536))]
    spp: Option<u32>,
    /// Number of equal frames to time; 1 by default. Times are medians, and the first of several frames only warms up.
    /// With --path, the number of its first frames to render; all by default.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// Render the frames along a path of the head as numbered files. The path is one of the scene's paths, `still`,
    /// `sway` or `cut`, or a file of recorded head poses (SESSION.poses.jsonl).
    #[arg(long)]
    path: Option<String>,
    /// How methods that accumulate frames weigh a new frame against those before it.
    #[arg(long, value_enum, default_value_t = Temporal::Variance)]
    temporal: Temporal,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Folder for the files; it is made when missing.
    #[arg(long, short, default_value = "out")]
    out: PathBuf,
    /// Part of the device's name; by default the best device.
    #[arg(long)]
    device: Option<String>,
    /// What stands in for what lost rays would have seen, instead of what the scene says.
    #[arg(long, value_enum)]
    fallback: Option<FallbackArg>,
    /// How the taps of the spatial reuse are weighted. `ratio` is the published estimator, with everything that belongs
    /// to it.
    #[arg(long, value_enum, default_value_t = Reuse::Balance)]
    reuse: Reuse,
    /// What is done with taps that are much brighter than their pixel: `bounded-share` with --reuse balance, else
    /// `none`.
    #[arg(long, value_enum)]
    firefly: Option<Firefly>,
    /// How the random numbers of the two eyes are related.
    #[arg(long, value_enum, default_value_t = Streams::Independent)]
    streams: Streams,
    /// Width of the fade at a view's border, as a fraction of its size; 0 = none.
    #[arg(long, default_value_t = 0.1)]
    edge_fade: f32,
    /// The method of ambient occlusion.
    #[arg(long, value_enum, default_value_t = Ao::None)]
    ao: Ao,
    #[command(flatten)]
    reach: AoArgs,
    /// How rays through the scene's geometry find what they hit.
    #[arg(long, value_enum, default_value_t = Trace::Auto)]
    trace: Trace,
    /// Samples along a side of each pixel, for surfaces and their light; reflections keep their rate. 1: no
    /// antialiasing.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4))]
    antialias: u32,
    /// How the shadows that lights cast in the views are found.
    #[arg(long, value_enum, default_value_t = Shadows::Rays)]
    shadows: Shadows,
    /// Let lights cast no shadows, as in the paper.
    #[arg(long, conflicts_with = "shadows")]
    no_shadows: bool,
    /// Reuse for the right eye what the left eye computed of the lights, on places that both eyes see. `auto`: where
    /// the lights cost more than the test; `always`: wherever there is a light.
    #[arg(long, value_enum, default_value_t = ShadingReuse::Off, num_args = 0..=1, default_missing_value = "auto",
          require_equals = true)]
    shading_reuse: ShadingReuse,
    /// Use indirect diffuse light, gathered once for each scene and kept in the user's cache folder. It replaces the
    /// environment's diffuse light in everything that the views and the rays see.
    #[arg(long)]
    indirect: bool,
    /// Print which parts of the frame run, which are left out, and why.
    #[arg(long)]
    explain: bool,
    /// Run every pass, whether needed or not; the image must not change.
    #[arg(long)]
    all_passes: bool,
}

/// Every method with its description, for `--help`.
fn methods() -> String {
    let lines = Method::described().map(|(name, about)| format!("  {name:<24} {about}\n"));
    format!("Methods (each also as NAME@N, with N rays a pixel):\n{}", lines.collect::<String>())
}

/// [`Fallback`] on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum FallbackArg {
    Black,
    Probe,
    Environment,
}

impl From<FallbackArg> for Fallback {
    fn from(arg: FallbackArg) -> Fallback {
        match arg {
            FallbackArg::Black => Fallback::Black,
            FallbackArg::Probe => Fallback::Probe,
            FallbackArg::Environment => Fallback::Environment,
        }
    }
}

/// `render.json`.
#[derive(Debug, Serialize)]
struct Report<'a> {
    scene: &'a str,
    scene_sha256: &'a str,
    view: &'a str,
    method: String,
    /// The method that was rendered; its name differs where the requested method stands for the one that suits the
    /// device.
    rendered_method: &'a str,
    width: u32,
    height: u32,
    seed: u32,
    spp: u32,
    frames: u32,
    device: &'a DeviceInfo,
    passes: &'a [PassTime],
    total_ms: f64,
    frame_wall_ms: f64,
    left_out: &'a [needs::PassDecision],
    nan: u64,
    inf: u64,
    clamped: u64,
    missed: u64,
    counters: Counts,
    triangles: usize,
    /// `bvh` or `ray-query`; null where no ray asks the geometry.
    trace: Option<&'static str>,
    settings: &'a Settings,
    repairs: &'a [String],
    files: Vec<PathBuf>,
}

/// See [`Args`].
///
/// # Errors
/// Wrong usage, an unreadable scene, no device, no memory, an unwritable folder; nothing is left half written.
pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    let method = Method::parse(&args.method).map_err(|e| WrongUsage(e.to_string()))?;
    if !(0.0..=0.5).contains(&args.edge_fade) {
        return Err(WrongUsage(format!("--edge-fade {} is outside 0 to 0.5", args.edge_fade)).into());
    }
    let ao = args.reach.settings(args.ao)?;
    let scene = Arc::new(scene::load_with(&args.scene, args.outside.loading())?);
    let view = device::view(&scene, args.view.as_deref())?;
    let path = args.path.as_deref().map(|name| super::path::head_path(&scene, view, name)).transpose()?;
    let gpu = device::open(args.device.as_deref())?;
    let size = device::size_or_default(&gpu, args.size, console);
    let method = device::samples_or_default(&gpu, method, args.spp, console);
    let settings = Settings {
        reuse: args.reuse,
        firefly: args.firefly,
        temporal: args.temporal,
        streams: args.streams,
        fallback: args.fallback.map(Fallback::from),
        edge_fade: args.edge_fade,
        all_passes: args.all_passes,
        trace: args.trace,
        shadows: !args.no_shadows,
        shadows_by: args.shadows,
        shading_reuse: args.shading_reuse,
        antialias: args.antialias,
        indirect: args.indirect,
        ao,
        ..device::settings(size, args.seed)
    };
    if let Some(path) = &path {
        let (scene, out) = (&scene, args.out.as_path());
        let of = Sequence { scene, view, path, frames: args.frames, method: &method, settings: &settings, out };
        return sequence::run(&gpu, &of, console);
    }
    let frames = args.frames.unwrap_or(1);
    // The folder is made first, so that an error comes before the work and not after it.
    std::fs::create_dir_all(&args.out).with_context(|| format!("cannot make the folder {}", args.out.display()))?;

    let camera = view.stereo_camera(settings.aspect());
    let mut renderer = Renderer::new(&gpu, Arc::clone(&scene))?.keep_light_in(device::light_folder());
    let request = Request { camera: &camera, method: &method, settings: &settings, frames };
    let mut progress = None;
    let rendered = renderer.render(&request, &mut |done, total| {
        let bar = progress.get_or_insert_with(|| console.progress("samples", u64::from(total)));
        bar.advance_to(u64::from(done), "");
        check_interrupted()
    })?;
    drop(progress);

    let stem = escape::file_name(&format!("{}_{}_{}", scene.name, view.name, method));
    let files = write(&args.out, &stem, &rendered)?;
    let report = Report {
        scene: &scene.name,
        scene_sha256: &scene.content_sha256,
        view: &view.name,
        method: method.to_string(),
        rendered_method: &rendered.method,
        width: settings.width,
        height: settings.height,
        seed: settings.seed,
        spp: rendered.samples,
        frames,
        device: gpu.info(),
        passes: &rendered.passes,
        total_ms: rendered.passes.iter().map(|p| p.ms).sum(),
        frame_wall_ms: median(&rendered.frame_ms),
        left_out: &rendered.left_out,
        nan: rendered.counters.nan,
        inf: rendered.counters.inf,
        clamped: rendered.counters.clamped,
        missed: rendered.counters.missed(),
        counters: rendered.counters,
        triangles: scene.triangle_count(),
        trace: rendered.tracer,
        settings: &settings,
        repairs: &scene.repairs,
        files,
    };
    let path = args.out.join("render.json");
    files::write_bytes(&path, &serde_json::to_vec_pretty(&report)?)?;
    say(console, &report, &rendered, args.explain);
    console.object(&report)?;
    Ok(())
}

/// Writes `STEM.exr`, `STEM.png` and, where ambient light is occluded, `STEM_ao.png`; returns their paths.
///
/// # Errors
/// [`picture::PictureError`] naming the file.
pub fn write(folder: &Path, stem: &str, rendered: &Rendered) -> Result<Vec<PathBuf>, picture::PictureError> {
    let (exr, png) = (folder.join(format!("{stem}.exr")), folder.join(format!("{stem}.png")));
    let mut parts = vec![
        Part { layer: "", picture: &rendered.linear },
        Part { layer: "reflection", picture: &rendered.reflection },
    ];
    parts.extend(rendered.error.as_ref().map(|picture| Part { layer: "error", picture }));
    let ambient = rendered.ambient_visibility.as_ref();
    parts.extend(ambient.map(|picture| Part { layer: "ambient_visibility", picture }));
    picture::write_exr(&exr, &parts)?;
    let (width, height) = (rendered.linear.width, rendered.linear.height);
    let [left, right] = &rendered.display;
    picture::write_side_by_side(&png, width, height, [left, right])?;
    let mut files = vec![exr, png];
    if let Some(ambient) = ambient {
        let path = folder.join(format!("{stem}_ao.png"));
        let grey = |eye: &Vec<[f32; 3]>| eye.iter().flat_map(|t| grey(t[0])).collect::<Vec<u8>>();
        let [left, right] = ambient.eyes.each_ref().map(grey);
        picture::write_side_by_side(&path, width, height, [&left, &right])?;
        files.push(path);
    }
    Ok(files)
}

/// A visibility as RGBA bytes: black for 0, white for 1, linear in between.
fn grey(visibility: f32) -> [u8; 4] {
    let level = (visibility.clamp(0.0, 1.0) * 255.0).round() as u8;
    [level, level, level, 255]
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    median_of_sorted(&sorted)
}

fn say(console: &Console, report: &Report<'_>, rendered: &Rendered, explain: bool) {
    console.line(format!(
        "{} · {} · {} · {}×{} per eye · {} spp · {}",
        report.scene, report.view, report.method, report.width, report.height, report.spp, report.device.name
    ));
    for pass in report.passes {
        console.line(format!("  {:<16} {:>9.2} ms", pass.name, pass.ms));
    }
    console.line(format!("  {:<16} {:>9.2} ms on the device", "total", report.total_ms));
    let c = &report.counters;
    console.line(format!(
        "  {} rays: {} hit, {} sky, {} missed ({} left the view, {} behind, {} back faces, {} out of steps)",
        c.rays, c.hits, c.sky, report.missed, c.left_view, c.behind, c.back_facing, c.budget
    ));
    if c.asked + c.skipped > 0 {
        console.line(format!(
            "  {} rays that the views lost asked the geometry; {} lost ones did not, and those that asked carry their weight",
            c.asked, c.skipped
        ));
    }
    if let Some(way) = report.trace {
        console.line(format!("  rays through the geometry by {way}"));
    }
    if report.clamped > 0 {
        console.line(format!("  {} values were beyond fp16 and clamped", report.clamped));
    }
    if rendered.method != report.method {
        console.line(format!("  {} is {} on this device", report.method, rendered.method));
    }
    if explain {
        for part in &rendered.parts {
            let word = if part.runs { "runs    " } else { "left out" };
            console.line(format!("  {word} {:<22} {}", part.name, part.why));
        }
    }
    for file in &report.files {
        console.line(format!("  {}", file.display()));
    }
}
