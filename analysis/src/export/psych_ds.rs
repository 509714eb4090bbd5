//! The Psych-DS layout: `dataset_description.json` and `data/study-x_subject-y_data.csv`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::{Value, json};

use super::ExportRow;
use crate::escape::markdown;

/// One column of the data files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its header.
    pub name: String,
    /// `string`, `integer`, `number` or `boolean`.
    pub kind: &'static str,
    /// Unit; empty for none.
    pub unit: &'static str,
    /// What it holds.
    pub description: String,
}

/// The columns of the data files, with one for each factor.
pub fn columns(factors: &[String]) -> Vec<Column> {
    let column = |name: &str, kind, unit, description: &str| Column {
        name: name.to_owned(),
        kind,
        unit,
        description: description.to_owned(),
    };
    let mut out = vec![
        column("participant", "string", "", "Pseudonym of the participant"),
        column("session", "string", "", "Session, unique within study and participant"),
        column("study", "string", "", "Identifier of the study"),
        column("kind", "string", "", "real: a participant; pilot: a trial run; simulated: an observer made by code"),
        column("presentation", "integer", "", "Position in the participant's order, from 0"),
        column(
            "purpose",
            "string",
            "",
            "trial: analysed; catch: shows whether the participant attends, never in a mean",
        ),
        column("repetition", "integer", "", "Which showing of the condition, from 0"),
    ];
    for f in factors {
        let words = match f.as_str() {
            "scene" => "Scene shown".to_owned(),
            "method" => "Rendering method shown; in a forced choice the method under test".to_owned(),
            "other" => "In a forced choice the method it was compared with".to_owned(),
            "view" => "Camera view of the scene".to_owned(),
            "path" => "Path that the head follows in a moving stimulus".to_owned(),
            "eye" => "Eye whose image was shown".to_owned(),
            "reference" => "Method of the reference image beside".to_owned(),
            other => format!("Level of the factor {other}"),
        };
        out.push(column(f, "string", "", &words));
    }
    out.extend([
        column(
            "rating",
            "integer",
            "scale steps",
            "The answer on the study's scale; forced choices by the study's one-to-one mapping",
        ),
        column("attempt", "integer", "", "Attempt that was answered, from 0; later ones follow invalid presentations"),
        column("answer_ms", "number", "ms", "From the opening of the panel to the confirmation"),
        column(
            "passed",
            "boolean",
            "",
            "Catch trials: whether the answer was one of those that pass; empty for trials",
        ),
        column("outcome", "string", "", "How the session ended"),
    ]);
    out
}

/// A text reduced to what a Psych-DS file name allows: letters and digits.
///
/// ```
/// assert_eq!(cyclopean_analysis::export::name_part("p-03_b"), "p03b");
/// ```
pub fn name_part(text: &str) -> String {
    text.chars().filter(char::is_ascii_alphanumeric).collect()
}

/// The lines of each file, by its name below `data/`.
pub(super) fn files(lines: &[ExportRow]) -> BTreeMap<PathBuf, Vec<&ExportRow>> {
    // Two pseudonyms may differ only in a dash; a number keeps their files apart.
    let mut names: BTreeMap<(&str, &str), String> = BTreeMap::new();
    for line in lines {
        let key = (line.study.as_str(), line.participant.as_str());
        if names.contains_key(&key) {
            continue;
        }
        let base = format!("study-{}_subject-{}", name_part(&line.study), name_part(&line.participant));
        let mut name = base.clone();
        let mut number = 2;
        while names.values().any(|n| *n == name) {
            name = format!("{base}x{number}");
            number += 1;
        }
        names.insert(key, name);
    }
    let mut out: BTreeMap<PathBuf, Vec<&ExportRow>> = BTreeMap::new();
    for line in lines {
        let name = &names[&(line.study.as_str(), line.participant.as_str())];
        out.entry(PathBuf::from(format!("{name}_data.csv"))).or_default().push(line);
    }
    out
}

/// The metadata file, in JSON-LD with the vocabulary of schema.org; every column is in `variableMeasured`.
pub(super) fn description(columns: &[Column], studies: &[(String, String)], lines: &[ExportRow]) -> String {
    let mut kinds: Vec<&str> = lines.iter().map(|l| l.kind.name()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let titles: Vec<&str> = studies.iter().map(|s| s.1.as_str()).collect();
    let variables: Vec<Value> = columns
        .iter()
        .map(|c| {
            let mut v = json!({ "@type": "PropertyValue", "name": c.name, "description": c.description });
            if !c.unit.is_empty() {
                v["unitText"] = c.unit.into();
            }
            v
        })
        .collect();
    let value = json!({
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": titles.join("; "),
        "description": format!("Answers of {} sessions, one row an answer, by the journals' verified lines.", kinds.join(" and ")),
        "schemaVersion": "Psych-DS 0.4.0",
        "keywords": ["stereo rendering", "perceptual study", "mean opinion score"],
        "variableMeasured": variables,
    });
    format!("{value:#}\n")
}

pub(super) fn readme(studies: &[(String, String)]) -> String {
    let list: String = studies.iter().map(|(id, title)| format!("- {}: {}\n", markdown(id), markdown(title))).collect();
    format!(
        "# Answers of perceptual studies\n\n{list}\nOne file a study and participant, one row an answer. Pseudonyms only; no wall \
         times, no hosts.\nEvery column is described in `dataset_description.json`.\n"
    )
}
