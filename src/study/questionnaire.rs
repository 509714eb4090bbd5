//! The questionnaires, when they are asked, and their items. docs/contributing.md says how to add one.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::language::Language;

/// Item name, question, options. Each item may be declined.
pub type ItemText = (&'static str, &'static str, &'static [&'static str]);

/// The questionnaires that a study can ask.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Questionnaire {
    /// Age band, gender, vision correction and experience; each may be declined.
    Person,
    /// Simulator sickness: sixteen symptoms, each 0 ..= 3, before and after the presentations.
    Ssq,
}

/// One questionnaire.
pub struct Form {
    pub which: Questionnaire,
    /// The phase of a session in which it is asked before the presentations, as journals name it; none: it is not asked
    /// then.
    pub before: Option<&'static str>,
    /// The same for after the presentations.
    pub after: Option<&'static str>,
    /// The text above each item.
    pub lead: fn(&Language) -> &str,
    pub items: &'static [ItemText],
}

/// Every questionnaire, in the order in which they are asked.
pub const FORMS: &[Form] = &[
    Form {
        which: Questionnaire::Person,
        before: Some("person"),
        after: None,
        lead: |language| &language.words.person_lead,
        items: PERSON,
    },
    Form {
        which: Questionnaire::Ssq,
        before: Some("ssq-before"),
        after: Some("ssq-after"),
        lead: |language| &language.words.ssq_lead,
        items: SSQ,
    },
];

impl Form {
    /// The questionnaire that is asked in this phase.
    pub fn of_phase(phase: &str) -> Option<&'static Form> {
        FORMS.iter().find(|form| form.before == Some(phase) || form.after == Some(phase))
    }
}

/// Age bands instead of ages, because they identify people less.
const PERSON: &[ItemText] = &[
    ("age-band", "How old are you?", &["18-24", "25-34", "35-44", "45-54", "55-64", "65 or more"]),
    ("gender", "Your gender?", &["woman", "man", "non-binary", "another"]),
    ("correction", "Do you wear glasses or lenses now?", &["none", "glasses", "contact lenses"]),
    ("vr-experience", "How often did you use a headset before?", &["never", "once or twice", "sometimes", "often"]),
];

const DEGREES: &[&str] = &["none", "slight", "moderate", "severe"];

/// Kennedy et al. 1993, in their order; option i scores i.
const SSQ: &[ItemText] = &[
    ("general-discomfort", "General discomfort", DEGREES),
    ("fatigue", "Fatigue", DEGREES),
    ("headache", "Headache", DEGREES),
    ("eye-strain", "Eye strain", DEGREES),
    ("difficulty-focusing", "Difficulty focusing", DEGREES),
    ("increased-salivation", "Increased salivation", DEGREES),
    ("sweating", "Sweating", DEGREES),
    ("nausea", "Nausea", DEGREES),
    ("difficulty-concentrating", "Difficulty concentrating", DEGREES),
    ("fullness-of-head", "Fullness of head", DEGREES),
    ("blurred-vision", "Blurred vision", DEGREES),
    ("dizzy-eyes-open", "Dizziness with eyes open", DEGREES),
    ("dizzy-eyes-closed", "Dizziness with eyes closed", DEGREES),
    ("vertigo", "Vertigo", DEGREES),
    ("stomach-awareness", "Stomach awareness", DEGREES),
    ("burping", "Burping", DEGREES),
];

/// Scores of one filled-in questionnaire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SsqScores {
    /// Nausea, 0 ..= 200.34.
    pub nausea: f64,
    /// Oculomotor disturbance, 0 ..= 159.18.
    pub oculomotor: f64,
    /// Disorientation, 0 ..= 292.32.
    pub disorientation: f64,
    /// Total score, 0 ..= 235.62.
    pub total: f64,
}

/// Item numbers from 1 (Kennedy et al. 1993, table 5).
const NAUSEA: [usize; 7] = [1, 6, 7, 8, 9, 15, 16];
const OCULOMOTOR: [usize; 7] = [1, 2, 3, 4, 5, 9, 11];
const DISORIENTATION: [usize; 7] = [5, 8, 10, 11, 12, 13, 14];

/// The scores; none unless every item has an answer from 0 to 3 (by item name).
pub fn ssq_scores(answers: &BTreeMap<String, u32>) -> Option<SsqScores> {
    let values: Vec<u32> =
        SSQ.iter().map(|(name, ..)| answers.get(*name).copied().filter(|v| *v <= 3)).collect::<Option<_>>()?;
    let sum = |items: [usize; 7]| f64::from(items.iter().map(|i| values[i - 1]).sum::<u32>());
    let (n, o, d) = (sum(NAUSEA), sum(OCULOMOTOR), sum(DISORIENTATION));
    Some(SsqScores { nausea: 9.54 * n, oculomotor: 7.58 * o, disorientation: 13.92 * d, total: 3.74 * (n + o + d) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_maxima_are_the_published_ones() {
        let worst = SSQ.iter().map(|(name, ..)| ((*name).to_owned(), 3)).collect();
        let s = ssq_scores(&worst).unwrap();
        for (score, published) in
            [(s.nausea, 200.34), (s.oculomotor, 159.18), (s.disorientation, 292.32), (s.total, 235.62)]
        {
            assert!((score - published).abs() < 1e-9, "{score} {published}");
        }
    }

    #[test]
    fn no_two_items_or_phases_have_one_name() {
        let items: Vec<&str> = FORMS.iter().flat_map(|form| form.items).map(|(name, ..)| *name).collect();
        let phases: Vec<&str> = FORMS.iter().flat_map(|form| [form.before, form.after]).flatten().collect();
        for names in [&items, &phases] {
            let distinct: std::collections::BTreeSet<_> = names.iter().collect();
            assert_eq!(distinct.len(), names.len(), "{names:?}");
        }
        assert!(FORMS.iter().all(|form| form.items.iter().all(|(_, _, options)| options.len() > 1)));
        for (i, form) in FORMS.iter().enumerate() {
            let asked = serde_json::to_value(form.which).unwrap();
            assert!(
                FORMS[..i].iter().all(|other| serde_json::to_value(other.which).unwrap() != asked),
                "{asked} is there twice"
            );
        }
    }

    #[test]
    fn an_item_without_an_answer_gives_no_score() {
        let mut answers: BTreeMap<String, u32> = SSQ.iter().map(|(name, ..)| ((*name).to_owned(), 0)).collect();
        assert_eq!(ssq_scores(&answers).unwrap().total, 0.0);
        answers.remove("nausea");
        assert_eq!(ssq_scores(&answers), None);
    }

    #[test]
    fn five_items_count_twice() {
        let twice = (1..=16)
            .filter(|i| [NAUSEA, OCULOMOTOR, DISORIENTATION].iter().filter(|s| s.contains(i)).count() == 2)
            .count();
        assert_eq!(twice, 5);
    }
}
