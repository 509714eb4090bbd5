//! Runs the paper's three studies with small pictures and simulated observers, for the demo and for `cyclopean paper`.

use std::path::Path;

use anyhow::Context as _;
use cyclopean_analysis::files;
use cyclopean_analysis::journal::record::Kind;

use crate::console::{Console, check_interrupted};
use crate::study::prepare::{self, Shard, StimulusState};
use crate::study::session::{self, Options};
use crate::study::store::Store;
use crate::study::validate::{self, Study};

use super::stimulus::GpuStimuli;

/// The paper's three studies: name and text.
pub const STUDIES: [(&str, &str); 3] = [
    ("consistency", include_str!("../../studies/consistency.json")),
    ("quality", include_str!("../../studies/quality.json")),
    ("ablation", include_str!("../../studies/ablation.json")),
];

/// The sizes and counts of a small setting.
pub struct SimulationScale {
    pub width_px: u32,
    pub height_px: u32,
    pub reference_samples: u32,
}

/// The text of a study, changed to small pictures and few samples.
///
/// # Errors
/// A built-in study that is not JSON.
pub fn small_text(text: &str, scale: &SimulationScale, observers: u32) -> anyhow::Result<String> {
    let mut study: serde_json::Value = serde_json::from_str(text).context("a built-in study is no JSON")?;
    let stimuli = &mut study["stimuli"];
    stimuli["width_px"] = scale.width_px.into();
    stimuli["height_px"] = scale.height_px.into();
    stimuli["samples"]["path-traced"] = scale.reference_samples.into();
    study["participants"] = observers.into();
    Ok(serde_json::to_string_pretty(&study)?)
}

/// Writes such a study beside what it produces, and loads it.
///
/// # Errors
/// A file that cannot be written.
pub fn small_study(
    out: &Path,
    name: &str,
    text: &str,
    scale: &SimulationScale,
    observers: u32,
) -> anyhow::Result<Study> {
    let folder = out.join("studies");
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let path = folder.join(format!("{name}.json"));
    let text = small_text(text, scale, observers)?;
    files::write_bytes(&path, text.as_bytes())?;
    Ok(validate::parse(&path, text)?)
}

/// Renders the stimuli that the study still lacks.
///
/// # Errors
/// A stimulus that cannot be made, or Ctrl-C.
pub fn prepare_stimuli(
    study: &Study,
    store: &Store,
    renderer: &mut GpuStimuli,
    console: &Console,
) -> anyhow::Result<()> {
    let total = prepare::requests(&study.definition, Shard::WHOLE).len() as u64;
    let mut progress = console.progress(&format!("{} stimuli", study.definition.id), total);
    prepare::prepare(&study.definition, store, renderer, Shard::WHOLE, &mut |request, found| {
        check_interrupted()?;
        let what = if found == StimulusState::Whole { "is there" } else { "rendering" };
        progress.step(&format!("{} {what}", request.label()));
        Ok(())
    })?;
    Ok(())
}

/// Simulates one session of each observer, in the folder `sessions`.
///
/// # Errors
/// A session that cannot be written, or Ctrl-C.
pub fn simulate(
    study: &Study,
    store: &Store,
    sessions: &Path,
    observers: u32,
    console: &Console,
) -> anyhow::Result<()> {
    let mut progress = console.progress(&format!("{} sessions", study.definition.id), u64::from(observers));
    for number in 1..=observers {
        check_interrupted()?;
        let participant = format!("sim{number:02}");
        session::simulate(study, store, sessions, &participant, 90.0, &Options::new(Kind::Simulated))?;
        progress.step(&participant);
    }
    Ok(())
}
