//! `cyclopean compare`: methods over scenes against the reference, or one picture against another.

use std::path::Path;
#[cfg(feature = "gpu")]
use std::path::PathBuf;

use super::WrongUsage;
#[cfg(feature = "gpu")]
use super::ao::AoArgs;
#[cfg(feature = "gpu")]
use super::device::{self, Size};
use super::networks::NetworkFiles;
#[cfg(feature = "gpu")]
use super::outside::OutsideArgs;
use super::pictures::{self, ViewingConditions};
#[cfg(feature = "gpu")]
use crate::compare::{self, Failure, Options, PartOutput, ao, sequence};
use crate::console::Console;
#[cfg(feature = "gpu")]
use crate::gpu::Gpu;
use crate::metrics::flip;
#[cfg(feature = "gpu")]
use crate::render::{Ao, Firefly, Method, Reuse, Settings, ShadingReuse, Temporal, Trace};
#[cfg(feature = "gpu")]
use crate::scene::{Fallback, Scene, SceneCache, View};
#[cfg(feature = "gpu")]
use crate::shard::Shard;

/// Compare the error and the run time of methods over scenes with the path-traced reference, or picture B with picture
/// A.
///
/// With scenes, every method is rendered at every sample count, round by round; compare.json, compare.md and a plot for
/// each scene are written. With two pictures, the metrics of B.exr against A.exr are computed, without a GPU.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scenes (a built-in name, a manifest, a .gltf or .glb file), or two pictures: A.exr, the reference, and B.exr.
    #[arg(required = true, value_name = "SCENE… | A.exr B.exr")]
    inputs: Vec<String>,
    /// Pixels per degree of visual angle, for FLIP; the default belongs to a screen 0.7 m wide with 3840 pixels, seen
    /// from 0.7 m.
    #[arg(long, default_value_t = flip::PIXELS_PER_DEGREE)]
    pixels_per_degree: f32,
    /// Linear factor before the tone map, for two pictures; scenes have their own.
    #[arg(long)]
    exposure: Option<f32>,
    #[command(flatten)]
    networks: NetworkFiles,
    #[cfg(feature = "gpu")]
    #[command(flatten)]
    scenes: SceneArgs,
}

/// Options of comparisons over scenes.
#[cfg(feature = "gpu")]
#[derive(Debug, clap::Args)]
struct SceneArgs {
    #[command(flatten)]
    outside: OutsideArgs,
    /// What is compared: reflections, or methods of ambient occlusion (--seeds, --size, --view, -o and --device work
    /// for both).
    #[arg(long, value_enum, default_value_t = Effect::Reflections)]
    effect: Effect,
    #[command(flatten)]
    ao: AoArgs,
    /// With --effect ao, the number of poses along a path on which the methods are compared; 0: no path.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    poses: u32,
    /// Follow a path of the head instead of standing still, and compare each frame with its own reference. The path is
    /// one of the scenes' paths, `still`, `sway` or `cut`, or a file of recorded head poses. Writes sequence.json,
    /// sequence.md and a drawing for each scene.
    #[arg(long, conflicts_with_all = ["effect", "fallback", "sheets", "cache", "seeds", "poses"])]
    path: Option<String>,
    /// With --path, the number of its first frames to render; all by default.
    #[arg(long, requires = "path", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    frames: Option<u32>,
    /// How methods that accumulate frames weigh a new frame against those before it.
    #[arg(long, value_enum, default_value_t = Temporal::Variance)]
    temporal: Temporal,
    /// Methods to compare. The first is the baseline, by which the others are divided. NAME@N has N rays per pixel
    /// whatever --spp says.
    #[arg(long, value_delimiter = ',', default_value = "sssr,stereo")]
    methods: Vec<String>,
    /// Numbers of rays per pixel. The equal-time table needs two or more.
    #[arg(long, value_delimiter = ',', default_value = "1,2,4", value_parser = clap::value_parser!(u32).range(1..=65536))]
    spp: Vec<u32>,
    /// Number of rounds, each with its own random seed. With 64 or more the systematic inconsistency becomes precise.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    seeds: u32,
    /// Pixels of one eye, WIDTHxHEIGHT.
    #[arg(long)]
    size: Option<Size>,
    /// Paths per pixel of the reference.
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=65536))]
    reference_spp: Option<u32>,
    /// Stop a reference when the mean relative standard error of its reflecting pixels is at most this, such as 1%.
    /// Without --reference-spp it may then take up to 65536 paths. Not with --path or --effect ao.
    #[arg(long, value_name = "PERCENT", value_parser = percent, conflicts_with = "path")]
    until: Option<f64>,
    /// What stands in for what lost rays would have seen; `both`: once black, and once the scene's own fallback.
    #[arg(long, value_enum, default_value_t = FallbackArg::Black)]
    fallback: FallbackArg,
    /// Width of the fade at a view's border, as a fraction of its size; 0 = none.
    #[arg(long, default_value_t = 0.1)]
    edge_fade: f32,
    /// How the taps of the spatial reuse are weighted. `ratio` is the published estimator, with everything that belongs
    /// to it.
    #[arg(long, value_enum, default_value_t = Reuse::Balance)]
    reuse: Reuse,
    /// What is done with taps that are much brighter than their pixel: `bounded-share` with --reuse balance, else
    /// `none`.
    #[arg(long, value_enum)]
    firefly: Option<Firefly>,
    /// How rays through the scene's geometry find what they hit; this includes the rays of the reference.
    #[arg(long, value_enum, default_value_t = Trace::Auto)]
    trace: Trace,
    /// Samples along a side of each pixel, for surfaces and their light; reflections keep their rate. 1: no
    /// antialiasing.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4))]
    antialias: u32,
    /// Use indirect diffuse light, gathered once for each scene, instead of the environment's.
    #[arg(long)]
    indirect: bool,
    /// Let lights cast no shadows, as in the paper.
    #[arg(long)]
    no_shadows: bool,
    /// Reuse for the right eye what the left eye computed of the lights, on places that both eyes see. `auto`: where
    /// the lights cost more than the test; `always`: wherever there is a light.
    #[arg(long, value_enum, default_value_t = ShadingReuse::Off, num_args = 0..=1, default_missing_value = "auto",
          require_equals = true)]
    shading_reuse: ShadingReuse,
    /// One of the scenes' views; by default each scene's first.
    #[arg(long)]
    view: Option<String>,
    /// Folder in which references are kept; by default `references` in the user's cache folder.
    #[arg(long)]
    cache: Option<PathBuf>,
    /// Keep each scene's results in this folder as soon as they are measured. Results that an earlier run with the same
    /// options, program and device has kept there are used, their times included, instead of measuring again. Not with
    /// --path.
    #[arg(long, value_name = "DIR", conflicts_with = "path")]
    keep: Option<PathBuf>,
    /// Do one part of the scenes, `i/n` with i from 0 to n − 1, so that many machines can share them. The results go to
    /// --keep, or the references to --cache, and no report is written. The same command without --shard then finds all
    /// of them there and writes the report; see docs/cluster.md.
    #[arg(long, value_name = "i/n", conflicts_with = "path")]
    shard: Option<Shard>,
    /// Make only the references of the scenes.
    #[arg(long, conflicts_with = "path")]
    references_only: bool,
    /// Folder for the files; it is made when missing.
    #[arg(long, short, default_value = "out")]
    out: PathBuf,
    /// Also write SCENE_steps.png: the pictures of every method, the places where the methods differ most, and where
    /// the eyes disagree.
    #[arg(long)]
    sheets: bool,
    /// Part of the device's name; by default the best device.
    #[arg(long)]
    device: Option<String>,
}

/// Parses a share above 0 and below 100 %, written `1%` or `0.5%`.
#[cfg(feature = "gpu")]
fn percent(text: &str) -> Result<f64, String> {
    let number = text.strip_suffix('%').and_then(|n| n.trim().parse::<f64>().ok());
    let share = number.filter(|n| *n > 0.0 && *n < 100.0).map(|n| n / 100.0);
    share.ok_or_else(|| format!("`{text}` is no percentage above 0 and below 100, such as 1%"))
}

/// What a comparison compares.
#[cfg(feature = "gpu")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Effect {
    /// Methods of reflection against the path-traced reference: compare.json, compare.md.
    Reflections,
    /// Ambient occlusion: ao.json, ao.md.
    Ao,
}

/// [`Fallback`] on the command line, or two of them.
#[cfg(feature = "gpu")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum FallbackArg {
    Black,
    Probe,
    Environment,
    Both,
}

/// See [`Args`].
///
/// # Errors
/// Wrong usage, an unreadable picture, no device, an unwritable folder, or a scene that failed: the others are written.
pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    let positive = |name: &str, value: f32| match value.is_finite() && value > 0.0 {
        true => Ok(value),
        false => Err(WrongUsage(format!("--{name} {value} is not above 0"))),
    };
    let pixels_per_degree = args.pixels_per_degree;
    if !(1.0..=1000.0).contains(&pixels_per_degree) {
        return Err(WrongUsage(format!("--pixels-per-degree {pixels_per_degree} is not within 1 to 1000")).into());
    }
    let exposure = args.exposure.map(|e| positive("exposure", e)).transpose()?;
    let is_picture = |name: &String| Path::new(name).extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
    match (args.inputs.as_slice(), args.inputs.iter().any(is_picture)) {
        ([a, b], true) if is_picture(a) && is_picture(b) => {
            let display = ViewingConditions { exposure: exposure.unwrap_or(1.0), pixels_per_degree };
            pictures::compare(a.as_ref(), b.as_ref(), (&display, &args.networks), console)
        }
        (_, true) => Err(WrongUsage("two pictures are compared, A.exr (the reference) and B.exr".to_owned()).into()),
        _ if exposure.is_some() => {
            Err(WrongUsage("--exposure is for two pictures; a scene says its own".to_owned()).into())
        }
        (scenes, false) => compare_scenes(&args, scenes, console),
    }
}

#[cfg(not(feature = "gpu"))]
fn compare_scenes(_: &Args, _: &[String], _: &Console) -> anyhow::Result<()> {
    anyhow::bail!("this build renders nothing (no feature `gpu`); it compares two pictures: A.exr B.exr")
}

#[cfg(feature = "gpu")]
fn compare_scenes(args: &Args, scenes: &[String], console: &Console) -> anyhow::Result<()> {
    let of = &args.scenes;
    if of.effect == Effect::Ao {
        no_networks(&args.networks, "--effect ao")?;
        return compare_ao(of, scenes, console);
    }
    let shard = of.shard.unwrap_or(Shard::WHOLE);
    if of.shard.is_some() && of.keep.is_none() && !of.references_only {
        let needs = "--shard needs --keep DIR, where the results of all parts come together, or --references-only";
        return Err(WrongUsage(needs.to_owned()).into());
    }
    let own: Vec<String> = shard.of(scenes.iter().cloned()).collect();
    let methods = of.methods.iter().map(|m| Method::parse(m).map_err(|e| WrongUsage(e.to_string())));
    let methods = methods.collect::<Result<Vec<_>, _>>()?;
    if !(0.0..=0.5).contains(&of.edge_fade) {
        return Err(WrongUsage(format!("--edge-fade {} is outside 0 to 0.5", of.edge_fade)).into());
    }
    if own.is_empty() {
        console.line(format!("part {shard} has nothing to do: there are {} scenes", scenes.len()));
        return part_done(shard, &own, &[], console);
    }
    let gpu = device::open(of.device.as_deref())?;
    let size = device::size_or_default(&gpu, of.size, console);
    let reference = Method::parse("path-traced").map_err(|e| WrongUsage(e.to_string()))?;
    let most = of.reference_spp.or(of.until.map(|_| 65536));
    let reference = device::samples_or_default(&gpu, reference, most, console);
    let settings = Settings {
        edge_fade: of.edge_fade,
        reuse: of.reuse,
        firefly: of.firefly,
        temporal: of.temporal,
        shadows: !of.no_shadows,
        shading_reuse: of.shading_reuse,
        trace: of.trace,
        antialias: of.antialias,
        indirect: of.indirect,
        ..device::settings(size, 0)
    };
    if let Some(name) = &of.path {
        no_networks(&args.networks, "--path")?;
        return compare_sequences(of, (&gpu, scenes), name, (methods, reference, settings), console);
    }
    let options = Options {
        methods,
        spp: of.spp.clone(),
        seeds: of.seeds,
        reference,
        until: of.until,
        settings,
        fallback: match of.fallback {
            FallbackArg::Black => compare::Fallbacks::One(Fallback::Black),
            FallbackArg::Probe => compare::Fallbacks::One(Fallback::Probe),
            FallbackArg::Environment => compare::Fallbacks::One(Fallback::Environment),
            FallbackArg::Both => compare::Fallbacks::Both,
        },
        view: of.view.clone(),
        pixels_per_degree: args.pixels_per_degree,
        networks: args.networks.load((size.width as usize, size.height as usize))?,
        cache: of.cache.clone().unwrap_or_else(|| device::cache_folder().join("references")),
        keep: of.keep.clone(),
        out: of.out.clone(),
        sheets: of.sheets,
        scenes: SceneCache::new(of.outside.loading()),
    };
    if of.shard.is_some() || of.references_only {
        let output = if of.references_only { PartOutput::References } else { PartOutput::Results };
        let failed = compare::run_part(&gpu, &own, &options, output, console)?;
        return part_done(shard, &own, &failed, console);
    }
    let report = compare::compare(&gpu, scenes, &options, console)?;
    console.page(compare::markdown(&report));
    for name in ["compare.json", "compare.md"] {
        console.line(format!("  {}", of.out.join(name).display()));
    }
    console.object(&report)?;
    all_done(&report.failed, scenes.len())
}

/// Only pictures of reflections that stand still are compared by networks.
#[cfg(feature = "gpu")]
fn no_networks(named: &NetworkFiles, with: &str) -> Result<(), WrongUsage> {
    match named.named().next() {
        None => Ok(()),
        Some((option, _)) => Err(WrongUsage(format!("{option} has no use with {with}"))),
    }
}

/// Reports what was done in a comparison that writes no report.
#[cfg(feature = "gpu")]
fn part_done(shard: Shard, scenes: &[String], failed: &[Failure], console: &Console) -> anyhow::Result<()> {
    let done = serde_json::json!({ "shard": shard.to_string(), "scenes": scenes, "failed": failed });
    console.object(&done)?;
    all_done(failed, scenes.len())
}

#[cfg(feature = "gpu")]
fn compare_sequences(
    of: &SceneArgs,
    (gpu, scenes): (&std::rc::Rc<Gpu>, &[String]),
    name: &str,
    (methods, reference, settings): (Vec<Method>, Method, Settings),
    console: &Console,
) -> anyhow::Result<()> {
    let path = |scene: &Scene, view: &View| super::path::head_path(scene, view, name).map_err(|e| format!("{e:#}"));
    let options = sequence::SequenceOptions {
        methods,
        spp: of.spp.clone(),
        reference,
        settings,
        path_name: name.to_owned(),
        path: &path,
        frames: of.frames,
        view: of.view.clone(),
        out: of.out.clone(),
        loading: of.outside.loading(),
    };
    let report = sequence::compare(gpu, scenes, &options, console)?;
    console.page(sequence::markdown(&report));
    for name in ["sequence.json", "sequence.md"] {
        console.line(format!("  {}", of.out.join(name).display()));
    }
    console.object(&report)?;
    all_done(&report.failed, scenes.len())
}

#[cfg(feature = "gpu")]
fn compare_ao(of: &SceneArgs, scenes: &[String], console: &Console) -> anyhow::Result<()> {
    if of.until.is_some() {
        return Err(WrongUsage("--until is for the reference of reflections; --effect ao has none".to_owned()).into());
    }
    if of.shard.is_some() || of.references_only {
        let wrong = "--shard and --references-only are for comparisons of reflections, not for --effect ao";
        return Err(WrongUsage(wrong.to_owned()).into());
    }
    // The comparison sets the method itself.
    let reach = of.ao.settings(Ao::None)?;
    let gpu = device::open(of.device.as_deref())?;
    let size = device::size_or_default(&gpu, of.size, console);
    let options = ao::AoOptions {
        settings: Settings { ao: reach, ..device::settings(size, 0) },
        seeds: of.seeds,
        poses: of.poses,
        view: of.view.clone(),
        keep: of.keep.clone(),
        out: of.out.clone(),
        scenes: SceneCache::new(of.outside.loading()),
    };
    let report = ao::compare(&gpu, scenes, &options, console)?;
    console.page(ao::markdown(&report));
    for name in ["ao.json", "ao.md"] {
        console.line(format!("  {}", of.out.join(name).display()));
    }
    console.object(&report)?;
    all_done(&report.failed, scenes.len())
}

/// An error if any scene failed.
#[cfg(feature = "gpu")]
fn all_done(failed: &[Failure], scenes: usize) -> anyhow::Result<()> {
    if failed.is_empty() {
        return Ok(());
    }
    let names: Vec<String> = failed.iter().map(|f| format!("{}: {}", f.scene, f.error)).collect();
    anyhow::bail!("{} of {scenes} scenes failed: {}", failed.len(), names.join("; "))
}
