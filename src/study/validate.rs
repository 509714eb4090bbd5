//! Turns a study file's text into a definition, or lists every problem at once: JSON path, value, and what is allowed.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use cyclopean_analysis::escape;
use cyclopean_analysis::files::{self, MOST_TEXT};
use cyclopean_analysis::journal::record::Shown;

use super::definition::{ConditionSpec, Definition, Layout, OrderKind, Task};
use super::problem::Problem;
use super::schema;
use super::stimulus::Catalogue;

/// A study file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    #[error("cannot read study {}: {source}", path.display())]
    Read {
        path: PathBuf,
        #[source]
        source: std::io::Error,
    },
    #[error("{}: {}", escape::line(&path.to_string_lossy()), list(problems))]
    Invalid { path: PathBuf, problems: Vec<Problem> },
}

/// The most problems that a message lists.
const MOST_SHOWN: usize = 100;

fn list(problems: &[Problem]) -> String {
    match problems {
        [one] => escape::line(&one.to_string()).into_owned(),
        many => {
            let shown = many.iter().take(MOST_SHOWN);
            let lines: String = shown.map(|p| format!("\n  {}", escape::line(&p.to_string()))).collect();
            let more = many.len().saturating_sub(MOST_SHOWN);
            let more = if more > 0 { format!("\n  and {more} more") } else { String::new() };
            format!("{} problems{lines}{more}", many.len())
        }
    }
}

/// A loaded study: the definition, and the text that it was made from.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    pub path: PathBuf,
    pub text: String,
    /// SHA-256 (hex) of the text.
    pub sha256: String,
    pub definition: Definition,
}

/// Reads and checks a study file; names of scenes and methods are checked by [`resolve`].
///
/// # Errors
/// [`StudyError`] with every problem found.
pub fn load(path: &Path) -> Result<Study, StudyError> {
    let text =
        files::read_text(path, MOST_TEXT).map_err(|source| StudyError::Read { path: path.to_owned(), source })?;
    parse(path, text)
}

/// [`load`] for a text in memory; `path` is only used in messages.
///
/// # Errors
/// As [`load`].
pub fn parse(path: &Path, text: String) -> Result<Study, StudyError> {
    let invalid = |problems| StudyError::Invalid { path: path.to_owned(), problems };
    let one = |path: &str, what: String| vec![Problem { path: path.to_owned(), what }];
    let value: serde_json::Value =
        serde_json::from_str(&text).map_err(|e| invalid(one("", format!("not JSON: {e}"))))?;
    let problems = schema::check(&value);
    if !problems.is_empty() {
        return Err(invalid(problems));
    }
    let definition: Definition = serde_json::from_str(&text).map_err(|e| invalid(one("", e.to_string())))?;
    // The size is checked before conditions are crossed, shown or ordered: a few numbers can ask for billions.
    let problems = judge_size(&definition);
    if !problems.is_empty() {
        return Err(invalid(problems));
    }
    let problems = judge(&definition);
    if !problems.is_empty() {
        return Err(invalid(problems));
    }
    let sha256 = super::sha256_hex(text.as_bytes());
    Ok(Study { path: path.to_owned(), text, sha256, definition })
}

/// Whether a text can be a participant id: a pseudonym that is valid as the name of a folder.
pub fn is_participant_id(id: &str) -> bool {
    let mut bytes = id.bytes();
    id.len() <= 32
        && bytes.next().is_some_and(|b| b.is_ascii_alphanumeric())
        && bytes.all(|b| b.is_ascii_alphanumeric() || b == b'-' || b == b'_')
}

fn is_study_id(id: &str) -> bool {
    id.len() <= 40
        && id.starts_with(|c: char| c.is_ascii_lowercase())
        && id.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-')
}

#[derive(Default)]
struct Problems(Vec<Problem>);

impl Problems {
    fn add(&mut self, path: impl Into<String>, what: impl Into<String>) {
        self.0.push(Problem { path: path.into(), what: what.into() });
    }
}

/// Limits that are more than anybody answers, and that can still be ordered in reasonable time.
const MOST_CONDITIONS: usize = 10_000;
const MOST_PRESENTATIONS: usize = 100_000;
const MOST_IN_ALL: usize = 4_000_000;
const MOST_CHOICES: usize = 100;
const MOST_ENTRIES: usize = 1000;

/// Checks how much a study asks for.
fn judge_size(d: &Definition) -> Vec<Problem> {
    let mut p = Problems::default();
    let mut at_most = |path: &str, count: usize, most: usize, what: &str| {
        if count > most {
            p.add(path, format!("{count} {what}; at most {most} can be studied"));
        }
    };
    at_most("labels", d.labels.len(), MOST_CHOICES, "choices");
    at_most("scale", d.scale.len(), MOST_CHOICES, "ratings");
    at_most("protocol", d.protocol.len(), MOST_ENTRIES, "segments");
    at_most("practice", d.practice.len(), MOST_ENTRIES, "presentations");
    at_most("catch_trials", d.catch_trials.len(), MOST_ENTRIES, "catch trials");
    at_most("questionnaires", d.questionnaires.len(), MOST_ENTRIES, "questionnaires");
    at_most("analysis.contrasts", d.analysis.contrasts.len(), MOST_ENTRIES, "contrasts");
    let disparities = d.screening.as_ref().map_or(0, |s| s.disparities_arcsec.len());
    at_most("screening.disparities_arcsec", disparities, MOST_ENTRIES, "disparities");
    let crossed = d.conditions.cross.as_ref().map_or(0, |c| {
        let levels = [c.view.len(), c.path.len(), c.eye.len(), c.other.len()].map(|n| n.max(1));
        levels.iter().fold(c.scene.len().saturating_mul(c.method.len()), |all, n| all.saturating_mul(*n))
    });
    let conditions = d.conditions.list.as_ref().map_or(crossed, Vec::len);
    at_most("conditions", conditions, MOST_CONDITIONS, "conditions");
    let catches = d.catch_trials.len();
    let presentations = conditions.saturating_mul(d.repetitions as usize).saturating_add(catches);
    at_most("repetitions", presentations, MOST_PRESENTATIONS, "presentations a participant");
    let all = presentations.saturating_mul(d.participants as usize);
    at_most("participants", all, MOST_IN_ALL, "presentations in all");
    p.0
}

/// Checks the rules that the schema cannot express.
fn judge(d: &Definition) -> Vec<Problem> {
    let mut p = Problems::default();
    if !is_study_id(&d.id) {
        p.add("id", format!("`{}` is not 1 to 40 lower-case letters, digits and `-`, beginning with a letter", d.id));
    }
    judge_question(d, &mut p);
    judge_protocol(d, &mut p);
    judge_conditions(d, &mut p);
    judge_analysis(d, &mut p);
    if let Some(consent) = &d.consent
        && chrono::NaiveDate::parse_from_str(&consent.retain_until, "%Y-%m-%d").is_err()
    {
        p.add("consent.retain_until", format!("`{}` is not a day of the form YYYY-MM-DD", consent.retain_until));
    }
    if d.panel.pause_seconds < d.panel.reminder_seconds {
        p.add("panel.pause_seconds", "must not be shorter than `panel.reminder_seconds`");
    }
    if let Some(s) = &d.screening {
        if s.disparities_arcsec.is_empty() || s.disparities_arcsec.iter().any(|a| !(1.0..=7200.0).contains(a)) {
            p.add("screening.disparities_arcsec", "needs one or more values from 1 to 7200");
        }
        if !s.disparities_arcsec.contains(&s.required_arcsec) {
            p.add("screening.required_arcsec", format!("{} is not one of `disparities_arcsec`", s.required_arcsec));
        }
    }
    p.0
}

fn judge_question(d: &Definition, p: &mut Problems) {
    match d.task {
        Task::Rate => {
            if d.labels.len() < 2 {
                p.add("labels", format!("a scale has two steps or more, here are {}", d.labels.len()));
            }
            if d.scale.len() != d.labels.len() {
                p.add("scale", format!("{} ratings for {} labels; one for each", d.scale.len(), d.labels.len()));
            }
            if d.scale.windows(2).any(|w| w[0] >= w[1]) {
                p.add("scale", format!("{:?} does not rise from step to step", d.scale));
            }
            if d.preference.is_some() {
                p.add("preference", "belongs to the task `compare`; remove it");
            }
            if d.layout == Layout::MirroredPair {
                p.add("layout", "`mirrored-pair` belongs to the task `compare`; allowed here: `stereo`");
            }
        }
        Task::Compare => {
            if d.labels.len() != 3 {
                p.add("labels", format!("{} labels; `compare` has three: A, same, B", d.labels.len()));
            }
            if !d.scale.is_empty() {
                p.add("scale", "belongs to the task `rate`; remove it");
            }
            match d.preference {
                None => p.add("preference", "is missing; `compare` needs {\"other\": 1, \"same\": 2, \"method\": 3}"),
                Some(v) if !(v.other < v.same && v.same < v.method) => {
                    p.add("preference", "must rise from `other` over `same` to `method`");
                }
                Some(_) => {}
            }
        }
    }
}

fn judge_protocol(d: &Definition, p: &mut Problems) {
    let allowed: &[Shown] = match d.task {
        Task::Rate => &[Shown::Stimulus, Shown::Blank],
        Task::Compare => &[Shown::A, Shown::B, Shown::Blank],
    };
    for (i, segment) in d.protocol.iter().enumerate() {
        if !allowed.contains(&segment.show) {
            let what = format!("`{:?}` cannot be shown here; allowed: {allowed:?}", segment.show).to_lowercase();
            p.add(format!("protocol[{i}].show"), what);
        }
    }
    for needed in allowed.iter().filter(|s| **s != Shown::Blank) {
        if !d.protocol.iter().any(|s| s.show == *needed) {
            p.add("protocol", format!("never shows `{needed:?}`").to_lowercase());
        }
    }
}

fn judge_conditions(d: &Definition, p: &mut Problems) {
    if d.conditions.cross.is_some() == d.conditions.list.is_some() {
        p.add("conditions", "needs either `cross` or `list`, not both");
    }
    let specs = d.conditions();
    if specs.is_empty() {
        p.add("conditions", "no condition: every crossed factor needs a level");
    }
    let mut seen = BTreeSet::new();
    for (i, spec) in specs.iter().enumerate() {
        if !seen.insert(spec) {
            p.add("conditions", format!("condition {i} ({:?}) is there twice; use `repetitions`", spec.factors()));
        }
    }
    let mut check = |path: String, spec: &ConditionSpec, is_catch: bool| {
        let compare = d.task == Task::Compare;
        let mirrored = d.layout == Layout::MirroredPair;
        for (key, there, wanted, task) in [
            ("other", spec.other.is_some(), compare, "the task `compare`"),
            ("reference", spec.reference.is_some(), mirrored, "the layout `mirrored-pair`"),
            ("eye", spec.eye.is_some(), mirrored, "the layout `mirrored-pair`"),
        ] {
            if there && !wanted {
                p.add(format!("{path}.{key}"), format!("belongs to {task} only; remove it"));
            } else if wanted && !there {
                p.add(format!("{path}.{key}"), format!("is missing; {task} needs it"));
            }
        }
        if !is_catch && spec.other.as_ref() == Some(&spec.method) {
            p.add(format!("{path}.other"), format!("`{}` is compared with itself", spec.method));
        }
    };
    let place = if d.conditions.list.is_some() { "conditions.list" } else { "conditions.cross" };
    if d.conditions.list.is_some() {
        specs.iter().enumerate().for_each(|(i, s)| check(format!("{place}[{i}]"), s, false));
    } else if let Some(first) = specs.first() {
        check(place.to_owned(), first, false);
    }
    d.practice.iter().enumerate().for_each(|(i, s)| check(format!("practice[{i}]"), s, false));
    d.catch_trials.iter().enumerate().for_each(|(i, c)| check(format!("catch_trials[{i}].show"), &c.show, true));
    let ratings: Vec<i32> = match d.preference {
        Some(v) => vec![v.other, v.same, v.method],
        None => d.scale.clone(),
    };
    for (i, catch) in d.catch_trials.iter().enumerate() {
        if catch.passes.is_empty() || catch.passes.iter().any(|r| !ratings.contains(r)) {
            let what = format!("{:?}: needs one or more of the ratings {ratings:?}", catch.passes);
            p.add(format!("catch_trials[{i}].passes"), what);
        }
    }
    if !d.catch_trials.is_empty() && d.catch_trials.len() >= specs.len() * d.repetitions as usize {
        p.add("catch_trials", "there must be fewer than trials");
    }
    match (&d.order.block_by, d.order.kind) {
        (Some(factor), OrderKind::Blocked) if specs.first().is_some_and(|s| !s.factors().contains_key(factor)) => {
            p.add("order.block_by", format!("`{factor}` is no factor of the conditions"));
        }
        (None, OrderKind::Blocked) => p.add("order.block_by", "is missing; `blocked` needs a factor such as `scene`"),
        (Some(_), kind) if kind != OrderKind::Blocked => {
            p.add("order.block_by", format!("belongs to `blocked`, the order is `{}`; remove it", kind.name()));
        }
        _ => {}
    }
}

fn judge_analysis(d: &Definition, p: &mut Problems) {
    let a = &d.analysis;
    if !(0.5..=0.999).contains(&a.interval.level) {
        p.add("analysis.interval.level", format!("{} is not within 0.5 to 0.999", a.interval.level));
    }
    let specs = d.conditions();
    let level_exists =
        |factor: &str, level: &str| specs.iter().any(|s| s.factors().get(factor).is_some_and(|l| l == level));
    for (i, c) in a.contrasts.iter().enumerate() {
        for (key, level) in [("a", &c.a), ("b", &c.b)] {
            if !level_exists(&c.factor, level) {
                p.add(
                    format!("analysis.contrasts[{i}].{key}"),
                    format!("`{level}` is no level of `{}` here", c.factor),
                );
            }
        }
    }
    if let Some(e) = &a.equivalence {
        if !(e.margin > 0.0 && e.margin.is_finite()) {
            p.add("analysis.equivalence.margin", format!("{} is not above 0", e.margin));
        }
        for (key, level) in [("a", &e.a), ("b", &e.b)] {
            if !level_exists("method", level) {
                p.add(format!("analysis.equivalence.{key}"), format!("`{level}` is no method of the conditions"));
            }
        }
    }
}

/// Finds every name that the study uses and this build does not have.
pub fn resolve(definition: &Definition, catalogue: &Catalogue) -> Vec<Problem> {
    let mut problems: Vec<Problem> = Vec::new();
    let mut add = |path: String, what: String| {
        let problem = Problem { path, what };
        if !problems.contains(&problem) {
            problems.push(problem);
        }
    };
    if let Some(ao) = definition.stimuli.ao.as_ref().filter(|ao| *ao != "none" && !catalogue.ao.contains(ao)) {
        let known = catalogue.ao.join(", ");
        let what = format!("ambient occlusion `{ao}` is not available in this build; available: none, {known}");
        add("stimuli.ao".to_owned(), what);
    }
    let scenes: Vec<&str> = catalogue.scenes.iter().map(|s| s.name.as_str()).collect();
    let cross = definition.conditions.cross.as_ref();
    let specs = definition.conditions();
    let mut all: Vec<(String, &ConditionSpec)> = Vec::new();
    all.extend(specs.iter().enumerate().map(|(i, s)| (format!("conditions.list[{i}]"), s)));
    all.extend(definition.practice.iter().enumerate().map(|(i, s)| (format!("practice[{i}]"), s)));
    all.extend(definition.catch_trials.iter().enumerate().map(|(i, c)| (format!("catch_trials[{i}].show"), &c.show)));
    for (path, spec) in all {
        // A crossed condition's name is reported at its level, not at a condition.
        let at = |key: &str, level: &str| match cross.filter(|_| path.starts_with("conditions")) {
            Some(cross) => {
                let levels: &[String] = match key {
                    "scene" => &cross.scene,
                    "view" => &cross.view,
                    "path" => &cross.path,
                    "method" => &cross.method,
                    "other" => &cross.other,
                    _ => &[],
                };
                match levels.iter().position(|l| l == level) {
                    Some(i) => format!("conditions.cross.{key}[{i}]"),
                    None => format!("conditions.cross.{key}"),
                }
            }
            None => format!("{path}.{key}"),
        };
        match catalogue.scenes.iter().find(|s| s.name == spec.scene) {
            None => add(
                at("scene", &spec.scene),
                format!("scene `{}` is not available in this build; available: {}", spec.scene, scenes.join(", ")),
            ),
            Some(scene) => {
                if let Some(view) = spec.view.as_ref().filter(|v| !scene.views.contains(v)) {
                    let views =
                        if scene.views.is_empty() { "its default only".to_owned() } else { scene.views.join(", ") };
                    add(at("view", view), format!("scene `{}` has no view `{view}`; available: {views}", scene.name));
                }
                let paths = catalogue.paths_of(scene);
                if let Some(path) = spec.path.as_ref().filter(|p| !paths.contains(&p.as_str())) {
                    let paths = paths.join(", ");
                    add(at("path", path), format!("scene `{}` has no path `{path}`; available: {paths}", scene.name));
                }
            }
        }
        for (key, method) in
            [("method", Some(&spec.method)), ("other", spec.other.as_ref()), ("reference", spec.reference.as_ref())]
        {
            let Some(method) = method else { continue };
            if !catalogue.has_method(method) {
                let known = catalogue.methods.join(", ");
                add(at(key, method), format!("method `{method}` is not available in this build; available: {known}"));
            }
        }
    }
    problems
}
