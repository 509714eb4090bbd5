//! `cyclopean demo`: runs the whole procedure once, in small: stimuli, sessions with simulated observers, analysis,
//! report.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use cyclopean_analysis::data::Selection;
use cyclopean_analysis::files::{self, MOST_DATA};
use cyclopean_analysis::report::{self, Figure, ReportInput, ReportOptions};

use crate::console::Console;
use crate::study::prepare::{self, Shard};
use crate::study::stimulus::{StimulusRenderer as _, StimulusRequest};
use crate::study::store::Store;
use crate::study::validate::{self, Study};

use super::catalogue::catalogue;
use super::device::Size;
use super::simulated::{STUDIES, SimulationScale, prepare_stimuli, simulate, small_study};
use super::stimulus::GpuStimuli;

/// Prepare, run and analyse the three studies with simulated observers, on small pictures.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for everything that the demo makes. Stimuli stay for the next time; sessions are made again.
    #[arg(long, short, default_value = "demo")]
    out: PathBuf,
    /// Number of simulated observers in each study.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(2..=1000))]
    observers: u32,
    /// Pixels of one eye, WIDTHxHEIGHT; by default they depend on the device.
    #[arg(long)]
    size: Option<Size>,
    /// Part of the device's name; by default the best device.
    #[arg(long)]
    device: Option<String>,
}

/// Marks a folder whose sessions the demo may delete.
const MARK: &str = ".cyclopean-demo";

/// See [`Args`].
///
/// # Errors
/// No device, a disk that cannot be written, or an error of a study's preparation, sessions or analysis.
pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    let out = &args.out;
    let sessions = fresh_sessions(out)?;
    let mut renderer = GpuStimuli::new(args.device.as_deref())?;
    let scale = match renderer.gpu().is_cpu() {
        true => SimulationScale { width_px: 480, height_px: 270, reference_samples: 32 },
        false => SimulationScale { width_px: 960, height_px: 540, reference_samples: 256 },
    };
    let scale = match args.size {
        Some(size) => SimulationScale { width_px: size.width, height_px: size.height, ..scale },
        None => scale,
    };
    console.note(format!(
        "device: {}; pictures of {}x{} per eye, {} paths a pixel in the reference (a study uses 1920x1080 and 1024)",
        renderer.gpu().info().name,
        scale.width_px,
        scale.height_px,
        scale.reference_samples
    ));
    let store = Store::new(out.join("store"));
    let mut ran = Vec::new();
    for (name, text) in STUDIES {
        let study = small_study(out, name, text, &scale, args.observers)?;
        let problems = validate::resolve(&study.definition, &catalogue());
        if let Some(first) = problems.first() {
            console.note(format!("study `{name}` is left out: {first}"));
            continue;
        }
        prepare_stimuli(&study, &store, &mut renderer, console)?;
        simulate(&study, &store, &sessions, args.observers, console)?;
        ran.push(study);
    }
    anyhow::ensure!(!ran.is_empty(), "this build can show none of the studies");

    let options = ReportOptions { title: "Cyclopean demo".to_owned(), ..ReportOptions::default() };
    let mut input = ReportInput::gather(&[sessions], &Selection::default(), &options)?;
    input.figures = figures(&ran, &store, &renderer)?;
    let page = out.join("report.html");
    files::write_bytes(&page, report::html(&input).as_bytes())?;
    let tables: Vec<_> = input.studies.iter().map(|s| s.all.table.to_json()).collect();
    for study in &input.studies {
        console.page(report::text::grid(&study.all.table));
        if let Some(preference) = &study.all.preference {
            console.page(report::text::winners(preference));
        }
    }
    console.line(format!("report: {}", page.display()));
    console.object(&serde_json::json!({ "report": page, "tables": tables, "kind": "simulated" }))?;
    Ok(())
}

/// Makes the folder of this run's sessions, empty. Only a folder that a demo made is ever emptied.
fn fresh_sessions(out: &Path) -> anyhow::Result<PathBuf> {
    let sessions = out.join("sessions");
    let mark = out.join(MARK);
    if sessions.exists() {
        anyhow::ensure!(
            mark.is_file(),
            "{} holds sessions that no demo made; choose another folder with --out",
            out.display()
        );
        std::fs::remove_dir_all(&sessions).with_context(|| format!("cannot empty {}", sessions.display()))?;
    }
    std::fs::create_dir_all(&sessions).with_context(|| format!("cannot make {}", sessions.display()))?;
    files::write_bytes(&mark, b"The sessions in this folder are simulated and made anew by each demo.\n")?;
    Ok(sessions)
}

/// The stills as figures, one for each condition and method, without repeats.
fn figures(studies: &[Study], store: &Store, renderer: &GpuStimuli) -> anyhow::Result<Vec<Figure>> {
    let mut seen: Vec<StimulusRequest> = Vec::new();
    let mut figures = Vec::new();
    for study in studies {
        for request in prepare::requests(&study.definition, Shard::WHOLE) {
            if seen.contains(&request) {
                continue;
            }
            let key = renderer.identity(&request)?;
            let Some(stored) = store.check(&key)? else { continue };
            let png =
                files::read(&stored.folder.join("sbs.png"), MOST_DATA).context("a prepared still cannot be read")?;
            figures.push(Figure { caption: format!("{} (left eye, right eye)", request.label()), png });
            seen.push(request);
        }
    }
    Ok(figures)
}
