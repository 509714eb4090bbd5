//! Renders every stimulus of a study into the store. It can be resumed and divided into shards; damaged entries are
//! rendered again. `cyclopean prepare` and `demo` call it.

use std::collections::BTreeMap;

use super::definition::Definition;
use super::plan::Plan;
use super::stimulus::{StimulusRenderer, StimulusRequest};
use super::store::{Store, StoreError};

pub use crate::shard::Shard;

/// What the store holds for one stimulus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StimulusState {
    /// Whole; nothing to do.
    Whole,
    /// Never rendered, or the scene, shaders or settings have changed.
    Missing,
    /// There, but damaged; it will be rendered again.
    Damaged,
}

/// What was done, or in a dry run would be done.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    pub whole: Vec<String>,
    pub missing: Vec<String>,
    pub damaged: Vec<String>,
    /// Estimated time for what is missing or damaged, from what the same methods took before; none when nothing is
    /// known.
    pub estimate_seconds: Option<f64>,
}

/// Renders what is missing. A run over the whole study also removes what killed preparations left half-made. `progress`
/// is called before each stimulus, and with `None` after the last.
///
/// # Errors
/// The first stimulus that cannot be rendered; those before it are in the store. `progress` can stop the work.
pub fn prepare(
    definition: &Definition,
    store: &Store,
    renderer: &mut dyn StimulusRenderer,
    shard: Shard,
    progress: &mut dyn FnMut(&StimulusRequest, StimulusState) -> anyhow::Result<()>,
) -> anyhow::Result<Report> {
    let mut report = Report::default();
    if shard == Shard::WHOLE {
        store.sweep()?;
    }
    for request in requests(definition, shard) {
        let (key, found) = look(store, renderer, &request)?;
        progress(&request, found)?;
        if found != StimulusState::Whole {
            store.render(renderer, &request, &key)?;
        }
        store.point(&request, &key)?;
        report.count(&request, found);
    }
    Ok(report)
}

/// What [`prepare`] would do.
///
/// # Errors
/// A scene cannot be loaded.
pub fn survey(
    definition: &Definition,
    store: &Store,
    renderer: &dyn StimulusRenderer,
    shard: Shard,
) -> anyhow::Result<Report> {
    let mut report = Report::default();
    let mut took: BTreeMap<String, (f64, u32)> = BTreeMap::new();
    let mut needed: Vec<String> = Vec::new();
    let like = |request: &StimulusRequest| match request.path {
        Some(_) => format!("{} along a path", request.method),
        None => request.method.clone(),
    };
    for request in requests(definition, shard) {
        let (key, found) = look(store, renderer, &request)?;
        match (found, store.seconds(&key)) {
            (StimulusState::Whole, Some(seconds)) => {
                let entry = took.entry(like(&request)).or_default();
                *entry = (entry.0 + seconds, entry.1 + 1);
            }
            (StimulusState::Whole, None) => {}
            _ => needed.push(like(&request)),
        }
        report.count(&request, found);
    }
    let mean = |method: &String| took.get(method).map(|(sum, n)| sum / f64::from(*n));
    report.estimate_seconds = needed.iter().map(mean).sum();
    Ok(report)
}

/// The stimuli that belong to a shard.
pub fn requests(definition: &Definition, shard: Shard) -> Vec<StimulusRequest> {
    shard.of(Plan::all_stimuli(definition)).collect()
}

fn look(
    store: &Store,
    renderer: &dyn StimulusRenderer,
    request: &StimulusRequest,
) -> anyhow::Result<(String, StimulusState)> {
    let key = renderer.identity(request).map_err(|error| StoreError::Render { label: request.label(), error })?;
    match store.check(&key) {
        Ok(Some(_)) => Ok((key, StimulusState::Whole)),
        Ok(None) => Ok((key, StimulusState::Missing)),
        Err(StoreError::Damaged { .. }) => Ok((key, StimulusState::Damaged)),
        Err(error) => Err(error.into()),
    }
}

impl Report {
    fn count(&mut self, request: &StimulusRequest, found: StimulusState) {
        match found {
            StimulusState::Whole => &mut self.whole,
            StimulusState::Missing => &mut self.missing,
            StimulusState::Damaged => &mut self.damaged,
        }
        .push(request.label());
    }
}
