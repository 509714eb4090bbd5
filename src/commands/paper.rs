//! `cyclopean paper`: makes the publications' tables and figures again, on one page.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::Context as _;
use cyclopean_analysis::data::Selection;
use cyclopean_analysis::files;
use cyclopean_analysis::parts;
use cyclopean_analysis::report::{ReportInput, ReportOptions};

use super::WrongUsage;
use super::catalogue::catalogue;
use super::device::{self, Size};
use super::networks::NetworkFiles;
use super::outside::OutsideArgs;
use super::simulated::{self, STUDIES, SimulationScale};
use super::stimulus::GpuStimuli;
use crate::console::Console;
use crate::gpu::Gpu;
use crate::paper::{self, Kind, Part, Piece, Progress, Request, Scale, Sessions, Speeds, in_words};
use crate::scene::SceneCache;
use crate::study::prepare::{self, Shard};
use crate::study::sha256_hex;
use crate::study::stimulus::{StimulusRenderer as _, StimulusRequest};
use crate::study::store::Store;
use crate::study::validate;

/// Make the publications' tables and figures again, and show them beside the printed numbers on one page.
///
/// Everything that is finished is kept in OUT/work. After Ctrl-C, a crash or a power cut, the same command goes on. In
/// a finished folder it measures nothing and writes the same page again. See docs/paper.md.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for the page, the comparisons and what is kept of them; it is made when missing.
    #[arg(long, short, default_value = "paper")]
    out: PathBuf,
    /// Use small pictures and few rounds, which takes at most ten minutes on two processor cores. Without this,
    /// everything has the publications' sizes and counts; the time for it is measured and stated beforehand.
    #[arg(long)]
    quick: bool,
    /// Only say what would be made, and how long it would take on this device.
    #[arg(long)]
    dry_run: bool,
    /// The parts to make; the page says which were left out.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "methods,ao,sessions")]
    parts: Vec<Part>,
    /// The scenes of the tables: built-in names, manifests, .gltf or .glb files. A figure that needs one scene of the
    /// publication takes the first of these if that scene is not among them.
    #[arg(long, value_delimiter = ',', default_value = "pica,room,wine,pink,temple")]
    scenes: Vec<String>,
    /// Pixels of one eye in every picture, WIDTHxHEIGHT.
    #[arg(long)]
    size: Option<Size>,
    /// Number of rounds of every table.
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    seeds: Option<u32>,
    /// Paths per pixel of every reference.
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=65536))]
    reference_spp: Option<u32>,
    /// Journals of the studies `consistency`, `quality` and `ablation`, or folders of them. By default sessions are
    /// simulated, and everything that follows from them is stamped so.
    #[arg(long, num_args = 1.., value_name = "DIR")]
    sessions: Vec<PathBuf>,
    /// Number of simulated observers in each study.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=1000), conflicts_with = "sessions")]
    observers: u32,
    /// Folder in which references are kept; by default `references` in the user's cache folder.
    #[arg(long)]
    cache: Option<PathBuf>,
    /// Part of the device's name; by default the best device.
    #[arg(long)]
    device: Option<String>,
    #[command(flatten)]
    networks: NetworkFiles,
    #[command(flatten)]
    outside: OutsideArgs,
}

/// See [`Args`].
///
/// # Errors
/// Wrong usage, no device, a disk that cannot be written, Ctrl-C, or a scene that failed: the page is written all the same.
pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    let mut request = request(&args)?;
    // Networks and sessions are read first, so that an error comes before the work and not after it.
    let [width, height] = request.scale.size;
    request.networks = args.networks.load((width as usize, height as usize))?;
    let given = (!args.sessions.is_empty()).then(|| gather(&args.sessions)).transpose()?;
    let gpu = device::open(args.device.as_deref())?;
    let mut pieces = paper::pieces(&request)?;
    let simulates = request.parts.contains(&Part::Sessions) && given.is_none();
    if simulates {
        pieces.extend(study_pieces(&request, args.observers)?);
    }
    let speeds = if args.quick && !args.dry_run { None } else { Some(paper::speeds(&gpu, &request, console)?) };
    let mut progress = Progress::new(&gpu, &request, &pieces, speeds.as_ref(), console);
    say_plan(&request, &pieces, speeds.as_ref(), &progress, console);
    if args.dry_run {
        return print_plan(&pieces, speeds.as_ref(), &progress, console);
    }
    sweep(&request)?;
    let made = paper::run(&gpu, &request, &mut progress, console)?;
    let sessions: Sessions = match given {
        _ if !request.parts.contains(&Part::Sessions) => Err("left out by --parts".to_owned()),
        Some(input) => Ok(input),
        None => {
            request.sessions = simulate(&gpu, &request, args.observers, &mut progress, console)?;
            Ok(gather(&request.sessions)?)
        }
    };
    let files = paper::write(&request, gpu.info(), &made, &sessions)?;
    console.line(format!("page: {}", files[0].display()));
    let failures = made.failures();
    console.object(
        &serde_json::json!({ "page": files[0], "json": files[1], "pieces": pieces.len(), "failed": failures }),
    )?;
    anyhow::ensure!(failures.is_empty(), "{} scenes failed: {}", failures.len(), failures.join("; "));
    Ok(())
}

fn request(args: &Args) -> Result<Request, WrongUsage> {
    let mut scale = if args.quick { Scale::QUICK } else { Scale::FULL };
    if let Some(Size { width, height }) = args.size {
        (scale.size, scale.ao_size, scale.study_size) = ([width, height], [width, height], [width, height]);
    }
    if let Some(seeds) = args.seeds {
        (scale.seeds, scale.ao_seeds) = ([seeds; 3], seeds);
    }
    if let Some(paths) = args.reference_spp {
        (scale.reference_paths, scale.study_paths) = (paths, paths);
    }
    let twice = args.scenes.iter().enumerate().find(|(i, scene)| args.scenes[..*i].contains(scene));
    if let Some((_, scene)) = twice {
        return Err(WrongUsage(format!("--scenes names {scene} twice; the tables have one line for each scene")));
    }
    Ok(Request {
        out: args.out.clone(),
        cache: args.cache.clone().unwrap_or_else(|| device::cache_folder().join("references")),
        scenes: args.scenes.clone(),
        scale,
        parts: args.parts.clone(),
        sessions: args.sessions.clone(),
        scene_cache: SceneCache::new(args.outside.loading()),
        networks: Default::default(),
        network_options: args.networks.named().map(|(option, file)| (option, file.to_owned())).collect(),
    })
}

/// Reads sessions and analyses them.
fn gather(folders: &[PathBuf]) -> anyhow::Result<ReportInput> {
    let options = ReportOptions { title: "Sessions".to_owned(), ..ReportOptions::default() };
    Ok(ReportInput::gather(folders, &Selection::default(), &options)?)
}

/// Removes what killed runs left half-made.
fn sweep(request: &Request) -> anyhow::Result<()> {
    let work = request.work();
    let folders = [request.out.clone(), work.clone(), work.join("sessions"), work.join("studies"), request.kept()];
    let comparisons = request.comparisons().into_iter().map(|c| request.out.join(c.id));
    for folder in folders.into_iter().chain(comparisons).chain([request.out.join("ao")]) {
        parts::sweep(&folder).with_context(|| format!("cannot tidy {}", folder.display()))?;
    }
    Ok(())
}

fn simulation_scale(request: &Request) -> SimulationScale {
    let [width_px, height_px] = request.scale.study_size;
    SimulationScale { width_px, height_px, reference_samples: request.scale.study_paths }
}

/// The pieces of work: one for each study of which sessions are simulated.
fn study_pieces(request: &Request, observers: u32) -> anyhow::Result<Vec<Piece>> {
    let mut known: Vec<StimulusRequest> = Vec::new();
    let mut pieces = Vec::new();
    for (name, text) in STUDIES {
        let text = simulated::small_text(text, &simulation_scale(request), observers)?;
        let call = sha256_hex(text.as_bytes());
        let study = validate::parse(Path::new(name), text)?;
        let mut new = prepare::requests(&study.definition, Shard::WHOLE);
        new.retain(|r| !known.contains(r));
        let references = new.iter().filter(|r| r.method.starts_with("path-traced")).count();
        let mut scenes: Vec<&str> = new.iter().map(|r| r.scene.as_str()).collect();
        scenes.dedup();
        let load = paper::stills(request, new.len() - references, references, scenes.len());
        pieces.push(Piece { name: format!("study {name}"), kind: Kind::Reflections, load, call });
        known.extend(new);
    }
    Ok(pieces)
}

/// Simulates the sessions of all three studies; they are kept under the hash of everything they follow from. Returns
/// their folders.
fn simulate(
    gpu: &Rc<Gpu>,
    request: &Request,
    observers: u32,
    progress: &mut Progress<'_>,
    console: &Console,
) -> anyhow::Result<Vec<PathBuf>> {
    let work = request.work();
    let root = work.join("sessions");
    std::fs::create_dir_all(&root).with_context(|| format!("cannot make {}", root.display()))?;
    let mut renderer = GpuStimuli::on(Rc::clone(gpu), request.scene_cache.clone());
    let store = Store::new(work.join("store"));
    let mut folders = Vec::new();
    for (name, text) in STUDIES {
        let study = simulated::small_study(&work, name, text, &simulation_scale(request), observers)?;
        if let Some(first) = validate::resolve(&study.definition, &catalogue()).first() {
            anyhow::bail!("study `{name}` cannot be shown by this build: {first}");
        }
        let requests = prepare::requests(&study.definition, Shard::WHOLE);
        let keys = requests.iter().map(|r| renderer.identity(r)).collect::<anyhow::Result<Vec<_>>>()?;
        let all = serde_json::json!([env!("CARGO_PKG_VERSION"), study.text, keys]);
        let folder = root.join(format!("{name}-{}", &sha256_hex(&serde_json::to_vec(&all)?)[..16]));
        // The folder gets its final name when every session in it is whole.
        if folder.is_dir() {
            console.note(format!("{name}: kept from {}", folder.display()));
        } else {
            simulated::prepare_stimuli(&study, &store, &mut renderer, console)?;
            let fill = |into: &Path| simulated::simulate(&study, &store, into, observers, console);
            files::write_folder(&folder, || folder.is_dir(), fill)?;
        }
        folders.push(folder);
        progress.step()?;
    }
    Ok(folders)
}

/// Prints what will be made, comparison by comparison.
fn say_plan(request: &Request, pieces: &[Piece], speeds: Option<&Speeds>, progress: &Progress<'_>, console: &Console) {
    let [width, height] = request.scale.size;
    console.note(format!(
        "{} pieces, {} of them kept from an earlier run; {width}x{height} pixels an eye, {} paths a pixel in the reference",
        pieces.len(),
        progress.kept(),
        request.scale.reference_paths
    ));
    let mut groups: Vec<(&str, usize, f64, f64)> = Vec::new();
    for piece in pieces {
        let name = piece.name.split(' ').next().unwrap_or_default();
        let seconds = speeds.map_or(0.0, |s| s.of(piece));
        match groups.last_mut().filter(|g| g.0 == name) {
            Some(group) => (group.1, group.2, group.3) = (group.1 + 1, group.2 + piece.load.frames, group.3 + seconds),
            None => groups.push((name, 1, piece.load.frames, seconds)),
        }
    }
    for (name, count, frames, seconds) in groups {
        let time = speeds.map_or(String::new(), |_| format!(", {}", in_words(seconds)));
        console.note(format!("  {name:10} {count:2} pieces, {frames:9.1} million pixels drawn{time}"));
    }
    if let (Some(speeds), Some(left)) = (speeds, progress.left()) {
        console.note(format!(
            "{} left on {}, from a short probe in {}: other scenes and other work on the machine change it",
            in_words(left),
            speeds.device,
            speeds.scene
        ));
    }
}

fn print_plan(
    pieces: &[Piece],
    speeds: Option<&Speeds>,
    progress: &Progress<'_>,
    console: &Console,
) -> anyhow::Result<()> {
    let left = progress.left().unwrap_or_default();
    console.line(format!("{} left; nothing was made", in_words(left)));
    let list: Vec<_> = pieces
        .iter()
        .map(
            |p| serde_json::json!({ "piece": p.name, "seconds": speeds.map(|s| s.of(p)), "kept": progress.is_kept(p) }),
        )
        .collect();
    console.object(&serde_json::json!({ "pieces": list, "seconds_left": left }))?;
    Ok(())
}
