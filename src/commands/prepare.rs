//! `cyclopean prepare`: renders a study's stimuli into the store.

use std::path::PathBuf;

use super::catalogue::catalogue;
use super::find_study::find_study;
use crate::console::{self, Console};
use crate::study::prepare::{self, Shard, StimulusState};
use crate::study::stimulus::StimulusRenderer;
use crate::study::store::Store;
use crate::study::validate::{self, StudyError};

/// Render a study's stimuli into the store; stimuli that are there and whole are not rendered again.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The study: a file, or the name of a study in `studies/`.
    study: PathBuf,
    /// The folder of prepared stimuli.
    #[arg(long, default_value = "store")]
    store: PathBuf,
    /// Do one part of the work, `i/n` with i from 0 to n − 1. When all parts are done, the same command without --shard
    /// finds everything. For many machines see docs/cluster.md.
    #[arg(long, value_name = "i/n")]
    shard: Option<Shard>,
    /// List what is missing and estimate the time, but render nothing.
    #[arg(long)]
    dry_run: bool,
}

/// The renderer of this build.
///
/// # Errors
/// No device.
#[cfg(feature = "gpu")]
pub(super) fn renderer() -> anyhow::Result<Box<dyn StimulusRenderer>> {
    Ok(Box::new(super::stimulus::GpuStimuli::new(None)?))
}

/// The renderer of this build.
///
/// # Errors
/// This build has none.
#[cfg(not(feature = "gpu"))]
pub(super) fn renderer() -> anyhow::Result<Box<dyn StimulusRenderer>> {
    anyhow::bail!("this build cannot render: it was made without its GPU parts; build with the feature `gpu`")
}

/// See [`Args`].
///
/// # Errors
/// Wrong usage, a study that this build cannot render, or the first stimulus that fails.
pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    let study = find_study(&args.study)?;
    let problems = validate::resolve(&study.definition, &catalogue());
    if !problems.is_empty() {
        return Err(StudyError::Invalid { path: study.path, problems }.into());
    }
    run_with(args, console, &mut *renderer()?)
}

/// [`run`] with a renderer that the caller has.
///
/// # Errors
/// As [`run`].
pub fn run_with(args: Args, console: &Console, renderer: &mut dyn StimulusRenderer) -> anyhow::Result<()> {
    let study = find_study(&args.study)?;
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let store = Store::new(&args.store);
    let report = if args.dry_run {
        prepare::survey(&study.definition, &store, renderer, shard)?
    } else {
        let total = prepare::requests(&study.definition, shard).len() as u64;
        let mut progress = console.progress("preparing", total);
        prepare::prepare(&study.definition, &store, renderer, shard, &mut |request, found| {
            console::check_interrupted()?;
            let what = if found == StimulusState::Whole { "is there" } else { "rendering" };
            progress.step(&format!("{} {what}", request.label()));
            Ok(())
        })?
    };
    console.object(&serde_json::json!({
        "study": study.definition.id, "store": args.store, "dry_run": args.dry_run, "whole": report.whole,
        "missing": report.missing, "damaged": report.damaged, "estimate_seconds": report.estimate_seconds,
    }))?;
    let (did, estimate) = match (args.dry_run, report.estimate_seconds) {
        (false, _) => ("rendered", String::new()),
        (true, Some(seconds)) => ("to render", format!(", about {:.1} minutes", seconds / 60.0)),
        (true, None) => ("to render", ", time unknown until one of each method was rendered".to_owned()),
    };
    for (what, list) in [("missing", &report.missing), ("damaged", &report.damaged)] {
        list.iter().for_each(|label| console.line(format!("{did} ({what}): {label}")));
    }
    let needed = report.missing.len() + report.damaged.len();
    if report.whole.len() + needed == 0 {
        let all = prepare::requests(&study.definition, Shard::WHOLE).len();
        console.line(format!("part {shard} has nothing to do: the study has {all} stimuli"));
        return Ok(());
    }
    console.line(format!("{} whole, {needed} {did}{estimate}", report.whole.len()));
    Ok(())
}
