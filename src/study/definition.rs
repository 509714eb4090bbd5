//! The study file: everything that is fixed before the first participant. Unknown keys are refused.

use std::collections::BTreeMap;

use cyclopean_analysis::journal::AnalysisPlan;
use cyclopean_analysis::journal::record::{PreferenceValues, Question, ScaleOption, Shown};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A study, as written in `studies/*.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Definition {
    /// Version of this file's form: 1.
    #[schemars(range(min = 1, max = 1))]
    pub format: u32,
    /// Names the study's folder: lower-case letters, digits and `-`, 1 to 40, beginning with a letter.
    pub id: String,
    /// For people.
    pub title: String,
    /// Root of every random stream of the study. Written in JSON, so at most 2⁵³ − 1.
    #[schemars(range(min = 0, max = 9007199254740991u64))]
    pub seed: u64,
    /// How many participants are planned.
    #[schemars(range(min = 1, max = 100000))]
    pub participants: u32,
    /// What is asked of a presentation.
    pub task: Task,
    /// How the stimuli stand on the display.
    #[serde(default)]
    pub layout: Layout,
    /// Shown before the practice presentations.
    pub instructions: String,
    /// Shown first; without agreement there is no session. None: nobody is asked (dry runs).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub consent: Option<ConsentText>,
    /// The question on the panel.
    pub question: String,
    /// The words of the choices, in the order of the panel. `compare`: A, same, B.
    pub labels: Vec<String>,
    /// `rate`: the rating of each label, rising.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scale: Vec<i32>,
    /// `compare`: the rating for each side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preference: Option<PreferenceValues>,
    /// What is shown in one presentation, in order.
    pub protocol: Vec<SegmentSpec>,
    /// Between every two presentations, and between a presentation and its panel.
    #[serde(default)]
    pub blank: Blank,
    /// The panel's patience.
    #[serde(default)]
    pub panel: Panel,
    /// How the stimuli are rendered.
    #[serde(default)]
    pub stimuli: Stimuli,
    /// What is compared.
    pub conditions: Conditions,
    /// How often each condition is shown.
    #[serde(default = "one")]
    #[schemars(range(min = 1, max = 1000))]
    pub repetitions: u32,
    /// Shown first, in this order, never analysed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub practice: Vec<ConditionSpec>,
    /// Presentations whose answer says whether the participant attends.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub catch_trials: Vec<CatchTrial>,
    /// In which order.
    #[serde(default)]
    pub order: OrderSpec,
    /// When a break is offered.
    #[serde(default)]
    pub breaks: Breaks,
    /// Who can take part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub screening: Option<Screening>,
    /// Asked before and after.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub questionnaires: Vec<Questionnaire>,
    /// When a presentation does not count.
    #[serde(default)]
    pub validity: Validity,
    /// How simulated observers answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulation: Option<Simulation>,
    /// What will be computed.
    #[serde(default = "plain_analysis")]
    pub analysis: AnalysisPlan,
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

/// What is asked of a presentation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Task {
    /// One stimulus, a step of a scale.
    Rate,
    /// Two stimuli in turn, A, same or B.
    Compare,
}

/// How the stimuli stand on the display.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// Each eye sees its own image.
    #[default]
    Stereo,
    /// Both eyes see one flat picture: left the reference, right the test image mirrored about its vertical axis.
    MirroredPair,
}

/// What the participant agrees to. Never a name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConsentText {
    /// Of the text.
    pub version: String,
    /// What the data is for.
    pub purpose: String,
    /// Day after which the data is deleted, `YYYY-MM-DD`.
    pub retain_until: String,
    /// Shown to the participant.
    pub text: String,
}

/// One part of a presentation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SegmentSpec {
    /// `stimulus` in a rating, `a` or `b` in a comparison, `blank` in both.
    pub show: Shown,
    /// Shown for round(seconds × nominal refresh rate) frames.
    #[schemars(range(min = 0.05, max = 3600))]
    pub seconds: f64,
}

/// The blank frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Blank {
    /// 0: none.
    #[schemars(range(min = 0, max = 60))]
    pub seconds: f64,
    /// Displayed value (not linear), 0 black ..= 1 white.
    #[schemars(range(min = 0, max = 1))]
    pub grey: f64,
    /// A cross at screen depth.
    pub fixation: bool,
}

impl Default for Blank {
    fn default() -> Blank {
        Blank { seconds: 2.0, grey: 0.5, fixation: true }
    }
}

/// The panel's patience. It never answers by itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Panel {
    /// Then it reminds.
    #[schemars(range(min = 1, max = 3600))]
    pub reminder_seconds: f64,
    /// Then the session pauses.
    #[schemars(range(min = 1, max = 3600))]
    pub pause_seconds: f64,
}

impl Default for Panel {
    fn default() -> Panel {
        Panel { reminder_seconds: 30.0, pause_seconds: 120.0 }
    }
}

/// How the stimuli are rendered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Stimuli {
    /// Pixels per eye.
    #[schemars(range(min = 16, max = 16384))]
    pub width_px: u32,
    /// Pixels per eye.
    #[schemars(range(min = 16, max = 16384))]
    pub height_px: u32,
    /// Distance between the eyes, metres, the same for all.
    #[schemars(range(min = 0.02, max = 0.12))]
    pub ipd_m: f64,
    /// Horizontal field of view per eye, degrees; none: the view's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 10, max = 140))]
    pub horizontal_fov_deg: Option<f64>,
    /// On a flat display or quad: at most this wide, degrees.
    #[schemars(range(min = 5, max = 100))]
    pub quad_deg: f64,
    /// Of the renderer's samples.
    #[schemars(range(min = 0, max = 9007199254740991u64))]
    pub seed: u64,
    /// Method → samples a pixel; a method's own default where it is not named, or written `NAME@N`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub samples: BTreeMap<String, u32>,
}

impl Default for Stimuli {
    fn default() -> Stimuli {
        Stimuli {
            width_px: 1920,
            height_px: 1080,
            ipd_m: 0.063,
            horizontal_fov_deg: None,
            quad_deg: 70.0,
            seed: 0,
            samples: BTreeMap::new(),
        }
    }
}

/// What is compared: factors crossed, or conditions listed; one of the two.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// Every combination of these levels, the first factor slowest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross: Option<Cross>,
    /// These and no other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub list: Option<Vec<ConditionSpec>>,
}

/// Levels to cross, in this order of factors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cross {
    /// Scenes.
    pub scene: Vec<String>,
    /// Views; none: each scene's first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub view: Vec<String>,
    /// Eyes (`mirrored-pair` only).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub eye: Vec<EyeName>,
    /// Methods.
    pub method: Vec<String>,
    /// What each is compared with (`compare` only).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other: Vec<String>,
    /// What both are compared to (`mirrored-pair` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
}

/// One of the two eyes' images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum EyeName {
    /// The left.
    Left,
    /// The right.
    Right,
}

impl EyeName {
    pub fn name(self) -> &'static str {
        match self {
            EyeName::Left => "left",
            EyeName::Right => "right",
        }
    }
}

/// One condition.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConditionSpec {
    /// Scene name.
    pub scene: String,
    /// View name; none: the scene's first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
    /// Which eye's image (`mirrored-pair` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<EyeName>,
    /// Method name, `NAME` or `NAME@samples`.
    pub method: String,
    /// The method it is compared with (`compare` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other: Option<String>,
    /// The method both are compared to (`mirrored-pair` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
}

impl ConditionSpec {
    /// Factor → level, as the journal and the analysis name them.
    pub fn factors(&self) -> BTreeMap<String, String> {
        let eye = self.eye.map(|e| e.name().to_owned());
        let optional = [("view", &self.view), ("eye", &eye), ("other", &self.other), ("reference", &self.reference)];
        [("scene", self.scene.clone()), ("method", self.method.clone())]
            .into_iter()
            .chain(optional.into_iter().filter_map(|(name, level)| Some((name, level.clone()?))))
            .map(|(name, level)| (name.to_owned(), level))
            .collect()
    }
}

/// A presentation whose right answer is known.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CatchTrial {
    /// What is shown; `compare`: `other` equal to `method` shows one image twice.
    pub show: ConditionSpec,
    /// Ratings that pass.
    pub passes: Vec<i32>,
}

/// In which order the conditions are shown.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OrderSpec {
    /// The design.
    pub kind: OrderKind,
    /// `blocked`: conditions that agree in this factor stay together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub block_by: Option<String>,
}

impl Default for OrderSpec {
    fn default() -> OrderSpec {
        OrderSpec { kind: OrderKind::LatinSquare, block_by: None }
    }
}

/// The design of the order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OrderKind {
    /// A random order for each participant.
    Random,
    /// Williams: balanced for first-order carry-over; n rows for even n, 2n for odd.
    LatinSquare,
    /// As in the file, for all.
    Fixed,
    /// Blocks in random order, conditions in random order within a block.
    Blocked,
}

impl OrderKind {
    pub fn name(self) -> &'static str {
        match self {
            OrderKind::Random => "random",
            OrderKind::LatinSquare => "latin-square",
            OrderKind::Fixed => "fixed",
            OrderKind::Blocked => "blocked",
        }
    }
}

/// When a break is offered; it ends when the participant says so.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Breaks {
    /// Minutes since the last one; 0: never.
    #[schemars(range(min = 0, max = 240))]
    pub every_minutes: f64,
}

impl Default for Breaks {
    fn default() -> Breaks {
        Breaks { every_minutes: 15.0 }
    }
}

/// Stereo vision, by random-dot stereograms: four alternatives, ten trials a disparity, passed with 7 right.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Screening {
    /// Disparities, arc seconds, largest first; shown to the nearest pixel, at least one.
    pub disparities_arcsec: Vec<f64>,
    /// The session goes on only if this one is passed.
    pub required_arcsec: f64,
}

/// What can be asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Questionnaire {
    /// Age band, gender, correction, experience; each may be declined.
    Person,
    /// Simulator sickness, sixteen symptoms 0 ..= 3, before and after.
    Ssq,
}

/// When a presentation does not count. It is repeated at the end of its block.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Validity {
    /// Focus, visibility or drawing lost for longer, in all, milliseconds.
    #[schemars(range(min = 0, max = 60000))]
    pub lost_ms: f64,
    /// One interval between frames is longer, milliseconds.
    #[schemars(range(min = 1, max = 60000))]
    pub gap_ms: f64,
    /// The duration is off by more, percent.
    #[schemars(range(min = 0.01, max = 100))]
    pub duration_percent: f64,
    /// A toggle is off by more than this and than `toggle_ms`, frames.
    #[schemars(range(min = 0, max = 1000))]
    pub toggle_frames: f64,
    /// A toggle is off by more than this and than `toggle_frames`, milliseconds.
    #[schemars(range(min = 0, max = 60000))]
    pub toggle_ms: f64,
    /// How often an invalid presentation is repeated; then it is missing.
    #[schemars(range(min = 0, max = 10))]
    pub repeats: u32,
}

impl Default for Validity {
    fn default() -> Validity {
        Validity {
            lost_ms: 250.0,
            gap_ms: 100.0,
            duration_percent: 1.0,
            toggle_frames: 2.0,
            toggle_ms: 25.0,
            repeats: 2,
        }
    }
}

/// How simulated observers answer: latent quality + bias + noise → the nearest choice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Simulation {
    /// Method → latent quality in steps of the scale (`rate`: on it; `compare`: differences count).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub latent: BTreeMap<String, f64>,
    /// Scene → added to the latent quality.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub scene: BTreeMap<String, f64>,
    /// Where a method has no latent quality: derive it from the stimulus's measured inconsistency.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_inconsistency: Option<FromInconsistency>,
    /// Between observers, of the whole scale.
    #[serde(default)]
    #[schemars(range(min = 0, max = 100))]
    pub bias_sd: f64,
    /// Between observers, of each method (the effect differs between people).
    #[serde(default)]
    #[schemars(range(min = 0, max = 100))]
    pub method_sd: f64,
    /// Within an observer, of one judgement.
    #[serde(default)]
    #[schemars(range(min = 0, max = 100))]
    pub noise_sd: f64,
    /// Share of answers given at random.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1))]
    pub lapse: f64,
    /// `compare`: smaller perceived differences are "same".
    #[serde(default = "half")]
    #[schemars(range(min = 0, max = 100))]
    pub threshold: f64,
    /// Median time to the answer, seconds.
    #[serde(default = "two_seconds")]
    #[schemars(range(min = 0.05, max = 600))]
    pub response_seconds: f64,
}

fn half() -> f64 {
    0.5
}

fn two_seconds() -> f64 {
    2.0
}

/// latent = at_zero + slope × inconsistency, where the renderer measured it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FromInconsistency {
    /// The latent quality without inconsistency.
    pub at_zero: f64,
    /// Per unit of inconsistency; negative.
    pub slope: f64,
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
                for eye in levels(&cross.eye) {
                    for method in &cross.method {
                        for other in levels(&cross.other) {
                            let (scene, method) = (scene.clone(), method.clone());
                            let (view, reference) = (view.clone(), cross.reference.clone());
                            out.push(ConditionSpec { scene, view, eye, method, other, reference });
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
