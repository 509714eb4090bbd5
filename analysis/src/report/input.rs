//! Gathers everything that a report shows, once for all of its formats. `mos report` and `cyclopean paper` call it.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::contrast::{ContrastResult, default_contrasts, planned_options, scores, test};
use crate::data::{Columns, Dataset, LoadedData, Selection, SessionSummary, Study, load};
use crate::equivalence::{NamedEquivalence, planned_equivalences};
use crate::error::{Error, Result};
use crate::files;
use crate::friedman::{Friedman, friedman};
use crate::inspect::{Inspection, inspect_all};
use crate::interval::{Bootstrap, Method};
use crate::journal::plan;
use crate::mos::{Table, TableOptions, table};
use crate::preference::{Preference, preference};
use crate::screen::{Alpha, Bt500, P910, P910Options, Sigma, bt500, krippendorff_ordinal, matrix, p910};

/// A picture with its caption, embedded in the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// What it shows.
    pub caption: String,
    /// The bytes of a PNG file.
    pub png: Vec<u8>,
}

/// What was measured on the stimuli of one scene and method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metric {
    /// Scene.
    pub scene: String,
    /// Method.
    pub method: String,
    /// The measured inconsistency between the eyes.
    pub value: f64,
}

/// The options of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportOptions {
    /// Title of the page.
    pub title: String,
    /// Kind of interval of every MOS; `None`: the study file's, else Student t.
    pub method: Option<Method>,
    /// Level of the interval; `None`: the study file's, else 0.9.
    pub level: Option<f64>,
    /// Size and seed of bootstraps.
    pub boot: Bootstrap,
    /// Margin of equivalence for studies that fixed none; `None`: nothing is claimed for them.
    pub margin: Option<f64>,
}

impl Default for ReportOptions {
    fn default() -> Self {
        Self { title: "Study report".into(), method: None, level: None, boot: Bootstrap::default(), margin: None }
    }
}

/// Screening of one study's observers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Screening {
    /// Participants, in the order of what follows.
    pub participants: Vec<String>,
    /// BT.500 with σ divided by n.
    pub bt500: Bt500,
    /// P.910 with a floor under the inconsistencies.
    pub p910: P910,
    /// Agreement between the observers.
    pub krippendorff: Alpha,
}

/// The analysis of a set of participants.
#[derive(Clone, Debug, PartialEq)]
pub struct Results {
    /// MOS by condition.
    pub table: Table,
    /// Contrasts; empty for forced choices.
    pub contrasts: Vec<ContrastResult>,
    /// Equivalence tests that were fixed beforehand or asked for.
    pub equivalences: Vec<NamedEquivalence>,
    /// Friedman's test of the methods, with their names in order.
    pub friedman: Option<(Vec<String>, Friedman)>,
    /// Forced choices.
    pub preference: Option<Preference>,
    /// What could not be computed, and why.
    pub notes: Vec<String>,
}

/// One study's part of the report.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyReport {
    /// The study's scale, plan and text.
    pub study: Study,
    /// All participants.
    pub all: Results,
    /// Without those whom the study file's rule excludes; `None` when it excludes nobody.
    pub kept: Option<Results>,
    /// Screening of the observers; it leaves nobody out.
    pub screening: Option<Screening>,
    /// Participants with at least one vote.
    pub participants: usize,
}

/// Everything a report shows.
#[derive(Clone, Debug)]
pub struct ReportInput {
    /// Title of the page.
    pub title: String,
    /// `simulated`, `pilot` or a mix; stamped on every table and plot.
    pub stamp: Option<String>,
    /// The studies.
    pub studies: Vec<StudyReport>,
    /// One entry a journal.
    pub sessions: Vec<SessionSummary>,
    /// Form and timing of each journal.
    pub inspections: Vec<Inspection>,
    /// Participants whom a rule excludes, with the reason.
    pub excluded: Vec<(String, String)>,
    /// Files read.
    pub sources: Vec<PathBuf>,
    /// Remarks on the data.
    pub notes: Vec<String>,
    /// Pictures to embed.
    pub figures: Vec<Figure>,
    /// Measurements of the stimuli.
    pub metrics: Vec<Metric>,
}

impl ReportInput {
    /// Reads `paths` and computes everything.
    ///
    /// # Errors
    /// As [`load`] and the analyses; what a study's data do not allow becomes a note in its part instead.
    pub fn gather(paths: &[PathBuf], selection: &Selection, options: &ReportOptions) -> Result<Self> {
        let loaded = load(paths, selection)?;
        let mut kept_selection = selection.clone();
        kept_selection.exclude.extend(loaded.excluded_ids());
        let kept = if loaded.excluded.is_empty() { None } else { Some(load(paths, &kept_selection)?) };
        let mut studies = Vec::new();
        for s in 0..loaded.data.studies.len() {
            if !loaded.data.cells_of(s).is_empty() {
                studies.push(study(paths, selection, &kept_selection, &loaded, kept.as_ref(), s, options)?);
            }
        }
        let journals: Vec<PathBuf> = loaded.sessions.iter().map(|s| s.path.clone()).collect();
        let mut inspections = Vec::with_capacity(journals.len());
        inspect_all(&journals, |i| inspections.push(i));
        Ok(Self {
            title: options.title.clone(),
            stamp: loaded.data.stamp(),
            studies,
            inspections,
            excluded: loaded.excluded,
            sources: loaded.sources,
            notes: loaded.data.notes,
            sessions: loaded.sessions,
            figures: Vec::new(),
            metrics: Vec::new(),
        })
    }
}

/// Selects only one study's responses.
fn only(selection: &Selection, study: &Study, columns: Columns) -> Selection {
    let mut s = selection.clone();
    // An empty id means that the source names no study, so nothing can be filtered.
    s.study = (!study.id.is_empty()).then(|| study.id.clone()).or(s.study);
    s.columns = Columns { extra: s.columns.extra, ..columns };
    s
}

fn study(
    paths: &[PathBuf],
    selection: &Selection,
    kept_selection: &Selection,
    loaded: &LoadedData,
    kept: Option<&LoadedData>,
    s: usize,
    options: &ReportOptions,
) -> Result<StudyReport> {
    let study = loaded.data.studies[s].clone();
    let reload = |selection: &Selection, columns| load(paths, &only(selection, &study, columns));
    let plain = Columns::default();
    let one = reload(selection, plain.clone())?;
    let choices = Columns { by_rating: true, ..Columns::default() };
    let votes = study.forced_choice.then(|| reload(selection, choices.clone())).transpose()?;
    let all = results(&one.data, votes.as_ref().map(|v| &v.data), options)?;
    let kept = match kept {
        None => None,
        Some(_) => {
            let one = reload(kept_selection, plain)?;
            let votes = study.forced_choice.then(|| reload(kept_selection, choices)).transpose()?;
            Some(results(&one.data, votes.as_ref().map(|v| &v.data), options)?)
        }
    };
    let single = reload(selection, Columns { by_repetition: true, ..Columns::default() })?;
    let (_, participants, matrix) = matrix(&single.data, 0);
    let screening = (participants.len() > 1).then(|| Screening {
        participants,
        bt500: bt500(&matrix, Sigma::Population),
        p910: p910(&matrix, P910Options::default()),
        krippendorff: krippendorff_ordinal(&matrix),
    });
    Ok(StudyReport { study, all, kept, screening, participants: one.data.participants.len() })
}

/// The interval that the study file fixed.
pub fn planned_interval(plan: Option<&plan::AnalysisPlan>) -> (Method, f64) {
    let Some(p) = plan else { return (Method::T, 0.9) };
    let method = match p.interval.kind {
        plan::IntervalKind::T => Method::T,
        plan::IntervalKind::Normal => Method::Normal,
        plan::IntervalKind::Percentile => Method::Bootstrap,
        plan::IntervalKind::Bca => Method::Bca,
        plan::IntervalKind::ClopperPearson => Method::ClopperPearson,
        plan::IntervalKind::Jeffreys => Method::Jeffreys,
    };
    (method, p.interval.level)
}

fn results(data: &Dataset, votes: Option<&Dataset>, options: &ReportOptions) -> Result<Results> {
    let (method, level) = planned_interval(data.studies.iter().find_map(|s| s.plan.as_ref()));
    let table_options = TableOptions {
        method: options.method.unwrap_or(method),
        level: options.level.unwrap_or(level),
        boot: options.boot,
        ..TableOptions::default()
    };
    let table = table(data, &table_options)?;
    let mut notes = Vec::new();
    // An analysis that the data do not allow becomes a note: a report with one gap is better than none.
    let mut or_note = |e: Error| notes.push(e.to_string());
    let preference = match votes {
        Some(v) => preference(v, [1, 2, 3], table_options.level, 1_999, options.boot.seed).map_err(&mut or_note).ok(),
        None => None,
    };
    let preference = preference.and_then(|p| p.into_iter().next());
    let rating = votes.is_none();
    let contrasts = if rating { default_contrasts(data) } else { Vec::new() };
    let contrasts = if contrasts.is_empty() {
        Vec::new()
    } else {
        test(data, &contrasts, &planned_options(data)).unwrap_or_else(|e| {
            or_note(e);
            Vec::new()
        })
    };
    let equivalences = if rating {
        planned_equivalences(data, options.margin, 0.05).unwrap_or_else(|e| {
            or_note(e);
            Vec::new()
        })
    } else {
        Vec::new()
    };
    let friedman = if rating {
        friedman_of(data).unwrap_or_else(|e| {
            or_note(e);
            None
        })
    } else {
        None
    };
    Ok(Results { table, contrasts, equivalences, friedman, preference, notes })
}

fn friedman_of(data: &Dataset) -> Result<Option<(Vec<String>, Friedman)>> {
    let cells: Vec<usize> = (0..data.cells.len()).collect();
    let Some(f) = data.factor("method") else { return Ok(None) };
    let levels: Vec<String> = data.levels(f, &cells).into_iter().map(str::to_owned).collect();
    if levels.len() < 3 {
        return Ok(None);
    }
    let (rows, _) = scores(data, &cells, f, &levels)?;
    Ok(Some((levels, friedman(&rows)?)))
}

/// Reads the systematic inconsistency of every scene and method from a `compare.json`, at the largest number of
/// samples.
///
/// # Errors
/// [`Error::Read`] for a file that cannot be read, and [`Error::Data`] for one that is no `compare.json`.
pub fn metrics_from_compare(path: &Path) -> Result<Vec<Metric>> {
    let text =
        files::read_text(path, files::MOST_DATA).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    let wrong = |what: &str| {
        Error::data(format!("{}: {what}; a compare.json of `cyclopean compare` is expected", path.display()))
    };
    let file: serde_json::Value = serde_json::from_str(&text).map_err(|e| wrong(&format!("not JSON ({e})")))?;
    let mut best: Vec<(f64, Metric)> = Vec::new();
    for scene in file["scenes"].as_array().ok_or_else(|| wrong("no list `scenes`"))? {
        let name = scene["scene"].as_str().ok_or_else(|| wrong("a scene without a name"))?;
        for r in scene["results"].as_array().ok_or_else(|| wrong("a scene without results"))? {
            let (Some(method), Some(value)) = (r["method"].as_str(), r["systematic_inconsistency"].as_f64()) else {
                continue;
            };
            let spp = r["spp"].as_f64().unwrap_or(0.0);
            let metric = Metric { scene: name.to_owned(), method: method.to_owned(), value };
            match best.iter_mut().find(|b| b.1.scene == metric.scene && b.1.method == metric.method) {
                Some(b) if spp > b.0 => *b = (spp, metric),
                Some(_) => {}
                None => best.push((spp, metric)),
            }
        }
    }
    Ok(best.into_iter().map(|b| b.1).collect())
}

/// Spearman's rank correlation with mid-ranks; `None` below three points or when one side is constant.
///
/// ```
/// use cyclopean_analysis::report::spearman;
/// // Squared rank differences 0, 1, 1, 0: 1 − 6·2/(4·15) = 0.8
/// assert!((spearman(&[(1.0, 2.0), (2.0, 5.0), (3.0, 4.0), (4.0, 9.0)]).unwrap() - 0.8).abs() < 1e-12);
/// ```
pub fn spearman(points: &[(f64, f64)]) -> Option<f64> {
    if points.len() < 3 {
        return None;
    }
    let ranks = |x: Vec<f64>| -> Vec<f64> {
        x.iter()
            .map(|v| {
                let below = x.iter().filter(|o| *o < v).count() as f64;
                let equal = x.iter().filter(|o| *o == v).count() as f64;
                below + (equal + 1.0) / 2.0
            })
            .collect()
    };
    let (a, b) = (ranks(points.iter().map(|p| p.0).collect()), ranks(points.iter().map(|p| p.1).collect()));
    let middle = (points.len() as f64 + 1.0) / 2.0;
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(p, q)| (p - middle) * (q - middle)).sum::<f64>();
    let spread = dot(&a, &a) * dot(&b, &b);
    (spread > 0.0).then(|| dot(&a, &b) / spread.sqrt())
}
