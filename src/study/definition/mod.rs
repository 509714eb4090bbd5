//! The study file: everything that is fixed before the first participant. Unknown keys are refused. `validate` reads
//! it.

mod conditions;
mod people;
pub(in crate::study) mod presentation;

use cyclopean_analysis::journal::AnalysisPlan;
use cyclopean_analysis::journal::record::{PreferenceValues, Question, ScaleOption};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use super::questionnaire::Questionnaire;
pub use crate::display::content::Geometry;
pub use conditions::{CatchTrial, ConditionSpec, Conditions, Cross, EyeName, OrderKind, OrderSpec};
pub use people::{ConsentText, FromInconsistency, Screening, Simulation};
pub use presentation::{Blank, Breaks, Layout, Panel, SegmentSpec, Stimuli, Task, Validity};

/// A study, as written in `studies/*.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Definition {
    /// Version of this file's format: 1.
    #[schemars(range(min = 1, max = 1))]
    pub format: u32,
    /// The study's identifier, which also names its folder: 1 to 40 lower-case letters, digits and `-`, beginning with
    /// a letter.
    pub id: String,
    /// The title that people read.
    pub title: String,
    /// Language of pages, questionnaires and buttons: `en`, `de`, `fr`, `zh`, or a file beside this one (`my.json`, in
    /// the form of those in `languages/`). The study's own texts are shown as they are written.
    #[serde(default = "english", skip_serializing_if = "is_english")]
    pub language: String,
    /// Seed of every random stream of the study. JSON limits it to 2⁵³ − 1.
    #[schemars(range(min = 0, max = 9007199254740991u64))]
    pub seed: u64,
    /// How many participants are planned.
    #[schemars(range(min = 1, max = 100000))]
    pub participants: u32,
    /// The task of each presentation.
    pub task: Task,
    /// How the stimuli are laid out on the display.
    #[serde(default)]
    pub layout: Layout,
    /// How the stimuli are placed when the head moves (headsets only).
    #[serde(default, skip_serializing_if = "is_world")]
    pub geometry: Geometry,
    /// Text that is shown before the practice presentations.
    pub instructions: String,
    /// Text that is shown first; without agreement there is no session. None: nobody is asked (dry runs).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub consent: Option<ConsentText>,
    /// The question on the panel.
    pub question: String,
    /// The words of the choices, in the order of the panel. For `compare`: A, same, B.
    pub labels: Vec<String>,
    /// For `rate`: the rating of each label, rising.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scale: Vec<i32>,
    /// For `compare`: the rating for each side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preference: Option<PreferenceValues>,
    /// What is shown in one presentation, in order.
    pub protocol: Vec<SegmentSpec>,
    /// The blank frame between every two presentations, and between a presentation and its panel.
    #[serde(default)]
    pub blank: Blank,
    /// How long the panel waits for an answer.
    #[serde(default)]
    pub panel: Panel,
    /// How the stimuli are rendered.
    #[serde(default)]
    pub stimuli: Stimuli,
    /// The conditions that are compared.
    pub conditions: Conditions,
    /// How often each condition is shown.
    #[serde(default = "one")]
    #[schemars(range(min = 1, max = 1000))]
    pub repetitions: u32,
    /// Presentations that are shown first, in this order, and never analysed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub practice: Vec<ConditionSpec>,
    /// Presentations whose answers show whether the participant attends.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub catch_trials: Vec<CatchTrial>,
    /// The order in which the conditions are shown.
    #[serde(default)]
    pub order: OrderSpec,
    /// When a break is offered.
    #[serde(default)]
    pub breaks: Breaks,
    /// The test of stereo vision that decides who can take part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub screening: Option<Screening>,
    /// Questionnaires before and after the presentations.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub questionnaires: Vec<Questionnaire>,
    /// Record the pose of the head at each frame, from the consent on, in a file beside the journal, where the display
    /// tracks heads. Motion identifies people: say so in the consent.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub head_poses: bool,
    /// When a presentation does not count.
    #[serde(default)]
    pub validity: Validity,
    /// How simulated observers answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulation: Option<Simulation>,
    /// The analysis that will be computed.
    #[serde(default = "plain_analysis")]
    pub analysis: AnalysisPlan,
}

fn english() -> String {
    "en".to_owned()
}

fn is_english(language: &str) -> bool {
    language == "en"
}

fn is_world(geometry: &Geometry) -> bool {
    *geometry == Geometry::World
}

fn one() -> u32 {
    1
}

fn plain_analysis() -> AnalysisPlan {
    AnalysisPlan {
        contrasts: Vec::new(),
        against: None,
        test: Default::default(),
        zeros: Default::default(),
        alternative: Default::default(),
        interval: Default::default(),
        correction: Default::default(),
        equivalence: None,
        exclusion: None,
        stopping: None,
    }
}

impl Definition {
    /// The conditions, crossed or listed, in the order of their indices.
    pub fn conditions(&self) -> Vec<ConditionSpec> {
        fn levels<T: Clone>(list: &[T]) -> Vec<Option<T>> {
            if list.is_empty() { vec![None] } else { list.iter().cloned().map(Some).collect() }
        }
        if let Some(list) = &self.conditions.list {
            return list.clone();
        }
        let Some(cross) = &self.conditions.cross else { return Vec::new() };
        let mut out = Vec::new();
        for scene in &cross.scene {
            for view in levels(&cross.view) {
                for path in levels(&cross.path) {
                    for eye in levels(&cross.eye) {
                        for method in &cross.method {
                            for other in levels(&cross.other) {
                                let (scene, method) = (scene.clone(), method.clone());
                                let (view, path) = (view.clone(), path.clone());
                                let reference = cross.reference.clone();
                                out.push(ConditionSpec { scene, view, path, eye, method, other, reference });
                            }
                        }
                    }
                }
            }
        }
        out
    }

    /// The question as the journal states it.
    pub fn journal_question(&self) -> Question {
        match (self.task, self.preference) {
            (Task::Compare, Some(values)) => Question::Compare { values },
            _ => Question::Rate {
                options: self
                    .scale
                    .iter()
                    .zip(&self.labels)
                    .map(|(&value, label)| ScaleOption { value, label: label.clone() })
                    .collect(),
            },
        }
    }
}
