//! What a journal can state: one variant for each kind of event, in the order in which a session writes them.
//!
//! Within a format version, fields may be added with a default. A reader ignores fields that it does not know.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::plan::AnalysisPlan;

/// Whose answers these are. It stands on every line, and by default kinds are never analysed together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A participant of the study.
    Real,
    /// A person trying the study out.
    Pilot,
    /// A seeded simulated observer.
    Simulated,
}

impl Kind {
    /// The word that stands on every line, table and plot.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Real => "real",
            Kind::Pilot => "pilot",
            Kind::Simulated => "simulated",
        }
    }
}

/// One event of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Record {
    /// Always line 1: the study, the program, the display and the device.
    Header(Box<Header>),
    /// One for each stimulus file set, before trial 1.
    Stimulus(Stimulus),
    /// One for each condition, before trial 1.
    Condition(Condition),
    /// How the order was made. The `planned` records that follow hold the order itself.
    Order(Order),
    /// One for each presentation of the session, in order, before trial 1.
    Planned(Planned),
    /// Everything before this line is written and synced: the session may begin.
    Ready(Ready),
    /// A state was entered that is not a presentation (consent, instructions, break, …).
    Phase(Phase),
    /// An answer to a question about the person, or to a questionnaire's item.
    Item(Item),
    /// One forced choice of the stereo screening.
    Screening(Screening),
    /// Written and synced before the stimulus appears.
    Begin(Begin),
    /// The stimulus was shown: when, how exactly, and whether it counts.
    Presentation(Presentation),
    /// The participant chose, or changed the choice, and has not confirmed it yet.
    Change(Change),
    /// The participant confirmed; synced before anything else appears.
    Answer(Answer),
    /// The stimulus was cut off (pause, kill): this attempt never gets an answer that counts.
    Interrupted(Interrupted),
    /// A presentation that will not be shown again and has no answer that counts.
    Missing(Missing),
    /// The session was paused.
    Pause(Pause),
    /// The session goes on after a pause.
    Continue(Continue),
    /// The file was opened again after the program had ended.
    Resume(Resume),
    /// The operator skipped a state.
    Skip(Skip),
    /// The operator wrote something down.
    Note(Note),
    /// The last line of a session that is over.
    End(End),
}

/// The study, the program, the display and the device of a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Format version of this file, 1 ..= [`super::FORMAT`].
    pub format: u32,
    /// The study as it was at the start.
    pub study: Study,
    /// A pseudonym, `[A-Za-z0-9][A-Za-z0-9_-]{0,31}`.
    pub participant: String,
    /// Unique within study and participant.
    pub session: String,
    /// The reserved row of the order, from 0.
    pub row: u64,
    /// What the participant is asked, and what each choice means.
    pub question: Question,
    /// The analysis fixed by the study file.
    pub analysis: AnalysisPlan,
    /// The program.
    pub program: Program,
    /// The display that showed the session.
    pub display: Display,
    /// The graphics device that drew it; none for a display without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<Device>,
    /// Operating system and architecture.
    pub os: String,
    /// What the participant consented to; none when nobody is asked (simulated).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub consent: Option<Consent>,
    /// SHA-256 of the manifest of the frozen study that this session was checked against.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frozen_sha256: Option<String>,
    /// Name of the file of head poses beside the journal; none: no poses are kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses: Option<String>,
}

/// The study as it was at the start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// The file's `id`.
    pub id: String,
    /// The file's `title`.
    pub title: String,
    /// SHA-256 (hex) of the file's bytes.
    pub sha256: String,
    /// The whole file.
    pub text: String,
    /// The seed of every random stream.
    pub seed: u64,
}

/// What the participant is asked. A choice is an index from 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// Choice i gives `options[i].value`.
    Rate {
        /// The scale, lowest first.
        options: Vec<ScaleOption>,
    },
    /// Choice 0 = A, 1 = same, 2 = B; the planned presentation says which of the two was A.
    Compare {
        /// The rating for each side that can be chosen.
        values: PreferenceValues,
    },
}

impl Question {
    /// How many choices there are.
    pub fn choices(&self) -> u32 {
        match self {
            Question::Rate { options } => u32::try_from(options.len()).unwrap_or(u32::MAX),
            Question::Compare { .. } => 3,
        }
    }

    /// The rating of a choice, by the study's one-to-one mapping. `a_is` says which side the presentation called A.
    ///
    /// None when the choice does not exist, or when a comparison does not say which side was A.
    pub fn rating(&self, choice: u32, a_is: Option<Side>) -> Option<i32> {
        match self {
            Question::Rate { options } => options.get(choice as usize).map(|o| o.value),
            Question::Compare { values } => match (choice, a_is?) {
                (1, _) => Some(values.same),
                (0, Side::Method) | (2, Side::Other) => Some(values.method),
                (0, Side::Other) | (2, Side::Method) => Some(values.other),
                _ => None,
            },
        }
    }
}

/// One step of a scale.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ScaleOption {
    /// The rating.
    pub value: i32,
    /// The words on the panel.
    pub label: String,
}

/// The rating for each side of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PreferenceValues {
    /// The condition's `other` was preferred (the paper: 1).
    pub other: i32,
    /// No difference was perceived (the paper: 2).
    pub same: i32,
    /// The condition's `method` was preferred (the paper: 3).
    pub method: i32,
}

/// One of the two methods of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The condition's `method`.
    Method,
    /// The condition's `other`.
    Other,
}

impl Side {
    /// The other of the two.
    pub fn opposite(self) -> Side {
        match self {
            Side::Method => Side::Other,
            Side::Other => Side::Method,
        }
    }
}

/// The program that ran the session.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// The commit it was built from, or `unknown`.
    pub commit: String,
}

/// The display that showed a session.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Display {
    /// `headless`, `desktop` or `openxr`.
    pub kind: String,
    /// The headset's or monitor's name.
    pub system: String,
    /// The runtime or presentation engine and its version.
    pub runtime: String,
    /// How far the times of this journal can be trusted.
    pub trust: Trust,
    /// Nominal refresh rate, Hz; frame counts are computed from it.
    pub nominal_hz: f64,
    /// Rate of the mean measured frame interval, Hz; none when it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured_hz: Option<f64>,
    /// Standard deviation of the measured frame intervals, milliseconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval_sd_ms: Option<f64>,
    /// Width of each eye's image, pixels.
    pub width_px: u32,
    /// Height of each eye's image, pixels.
    pub height_px: u32,
    /// Half angles of each eye's view (left eye first) to the left, right, up and down, degrees; none on a flat
    /// display.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov_deg: Option<[[f64; 4]; 2]>,
    /// The interpupillary distance that the display measured or is set to, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ipd_m: Option<f64>,
    /// The interpupillary distance that the stimuli were rendered with, metres.
    pub rendered_ipd_m: f64,
}

/// How far the times of display can be trusted; no record claims more than its display's level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Trust {
    /// The time of a virtual clock; nothing was shown.
    Virtual,
    /// The time that the runtime predicts.
    Predicted,
    /// The time that the runtime or the presentation engine reports afterwards.
    Reported,
    /// The time at which a photodiode saw the frame.
    Measured,
}

/// The graphics device that drew a session.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Device {
    /// Name of the graphics device.
    pub gpu: String,
    /// Driver name and version.
    pub driver: String,
    /// Vulkan version.
    pub vulkan: String,
}

/// What the participant consented to. It never holds a name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Consent {
    /// Version of the text.
    pub version: String,
    /// What the data is for.
    pub purpose: String,
    /// Day after which the data is deleted, `YYYY-MM-DD`.
    pub retain_until: String,
}

/// The frames of a moving stimulus.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Film {
    /// Frames a second at which it is shown.
    pub rate_hz: f64,
    /// Number of frames, at least 1. After the last one, the last one stays on the display.
    pub frames: u32,
}

/// One set of stimulus files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stimulus {
    /// Index in this session; `begin` records point here.
    pub id: u32,
    /// Content address in the store: SHA-256 (hex) over scene bytes, shaders, method, camera, settings, renderer.
    pub key: String,
    /// Scene name.
    pub scene: String,
    /// View name.
    pub view: String,
    /// Method name.
    pub method: String,
    /// File name → SHA-256 (hex).
    pub files: BTreeMap<String, String>,
    /// SHA-256 of the scene's bytes, where the renderer stated it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene_sha256: Option<String>,
    /// SHA-256 of the shaders, where the renderer stated it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shaders_sha256: Option<String>,
    /// The renderer, where it stated its name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub renderer: Option<String>,
    /// Its frames, if it moves; none: a still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub film: Option<Film>,
}

/// One condition: a combination of factor levels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Condition {
    /// Index in the study; `planned` records point here.
    pub id: u32,
    /// Factor → level: `scene`, `method`, and where they apply `view`, `path`, `eye`, `other`, `reference`.
    pub factors: BTreeMap<String, String>,
}

/// How the order was made.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Order {
    /// `random`, `fixed`, `blocked` or `latin-square`.
    pub ordering: String,
    /// Name and version of the procedure that turns (seed, row) into the order.
    pub procedure: String,
    /// Rows after which the design repeats; 0 when it does not.
    pub rows: u64,
    /// This session's row.
    pub row: u64,
    /// Number of `planned` records that follow.
    pub presentations: u32,
    /// SHA-256 (hex) over the planned records, computed as the procedure's documentation says.
    pub sha256: String,
}

/// What a presentation is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Purpose {
    /// Never analysed.
    Practice,
    /// Analysed.
    Trial,
    /// Shows whether the participant attends; it never enters a mean.
    Catch,
}

/// One presentation of the order.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Planned {
    /// Position in the order, from 0; half of the key (presentation, attempt).
    pub presentation: u32,
    /// What it is for.
    pub purpose: Purpose,
    /// Index of its condition record.
    pub condition: u32,
    /// Which showing of this condition, from 0.
    pub repetition: u32,
    /// Its block, at the end of which invalid presentations are shown again.
    pub block: u32,
    /// Which side is called A; none when there is nothing to compare.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub a_is: Option<Side>,
    /// Indices of the stimulus records it shows: one; or A, B; or reference, A, B.
    pub stimuli: Vec<u32>,
    /// The ratings with which a catch trial is passed; empty for other presentations.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub passes: Vec<i32>,
}

/// The session may begin.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ready {
    /// Lines before this one.
    pub lines: u64,
}

/// A state of the session was entered.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Phase {
    /// `consent`, `person`, `screening`, `ssq-before`, `instructions`, `practice`, `trials`, `break`, `ssq-after`, `thanks`.
    pub phase: String,
}

/// An answer to a question about the person, or to a questionnaire's item.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Item {
    /// `person`, `ssq-before` or `ssq-after`.
    pub questionnaire: String,
    /// The item's name.
    pub item: String,
    /// The answer; none: declined.
    pub answer: Option<String>,
}

/// One forced choice of the stereo screening.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Screening {
    /// Disparity, arc seconds.
    pub disparity_arcsec: f64,
    /// Angular size of a pixel, arc seconds.
    pub arcsec_per_px: f64,
    /// The trial at this disparity, from 0.
    pub trial: u32,
    /// The alternative that was shown, 0 ..= 3.
    pub shown: u32,
    /// The alternative that was chosen, 0 ..= 3.
    pub chosen: u32,
}

/// A stimulus is about to appear.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Begin {
    /// The planned presentation.
    pub presentation: u32,
    /// The attempt, from 0. Together with `presentation` it identifies the attempt in everything that follows.
    pub attempt: u32,
}

/// The stimulus was shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Presentation {
    /// The planned presentation.
    pub presentation: u32,
    /// The attempt.
    pub attempt: u32,
    /// What was shown, in order.
    pub segments: Vec<Segment>,
    /// Missed frames: Σ (round(Δ/period) − 1) over the frame intervals Δ.
    pub missed: u64,
    /// Frames that the runtime asked the program not to draw.
    pub unrendered: u64,
    /// Total time without focus, visibility or drawing, milliseconds.
    pub lost_ms: f64,
    /// The longest interval between two frames, milliseconds.
    pub longest_gap_ms: f64,
    /// From the first frame to the first frame of what follows, milliseconds.
    pub duration_ms: f64,
    /// How far these times can be trusted.
    pub trust: Trust,
    /// Why this attempt does not count; empty: it counts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub invalid: Vec<String>,
}

/// One part of a presentation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Segment {
    /// What was on the display.
    pub show: Shown,
    /// Frames that the study asked for: round(seconds × nominal rate).
    pub frames_asked: u64,
    /// Frames that were displayed.
    pub frames_shown: u64,
    /// Display time of its first frame, nanoseconds on the journal's clock.
    pub first_ns: u64,
    /// Display time of its last frame.
    pub last_ns: u64,
    /// For a moving stimulus: when each of its frames was first displayed, nanoseconds on the journal's clock; null:
    /// that frame was never displayed. Empty for stills and blank frames.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub film_onsets_ns: Vec<Option<u64>>,
}

/// What one part of a presentation shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Shown {
    /// The one stimulus of a rating.
    Stimulus,
    /// The side called A.
    A,
    /// The side called B.
    B,
    /// The blank frame.
    Blank,
}

/// A choice, not yet confirmed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Change {
    /// The planned presentation.
    pub presentation: u32,
    /// The attempt.
    pub attempt: u32,
    /// The choice, as [`Question`] counts it.
    pub choice: u32,
    /// Time since the panel opened, nanoseconds.
    pub after_ns: u64,
}

/// A confirmed choice.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Answer {
    /// The planned presentation.
    pub presentation: u32,
    /// The attempt.
    pub attempt: u32,
    /// The choice, as [`Question`] counts it. The analysis turns it into a rating.
    pub choice: u32,
    /// Time since the panel opened, nanoseconds.
    pub after_ns: u64,
    /// How many `change` records led to it.
    pub changes: u32,
    /// Whether the attempt was valid. Answers to invalid attempts are kept and never used.
    pub counts: bool,
}

/// An attempt was cut off.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Interrupted {
    /// The planned presentation.
    pub presentation: u32,
    /// The attempt.
    pub attempt: u32,
    /// `pause`, `skip`, `repeat`, `withdraw`, `quit`, `abandon` or `killed`.
    pub reason: String,
}

/// A presentation that stays without an answer that counts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Missing {
    /// The planned presentation.
    pub presentation: u32,
    /// `invalid` (all attempts were invalid) or `skipped`.
    pub reason: String,
}

/// The session was paused.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pause {
    /// `operator`, `participant`, `no-answer`, or `not-seen`: focus or visibility was gone for a second.
    pub reason: String,
}

/// The session goes on after a pause.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Continue {
    /// How long the pause lasted, nanoseconds.
    pub after_ns: u64,
}

/// The file was opened again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resume {
    /// Wall time between the last line and this one, milliseconds; negative if the clock was set back.
    pub gap_ms: i64,
    /// Bytes of a torn last line that were set aside.
    pub cut_bytes: u64,
    /// The program that goes on with the session.
    pub program: Program,
}

/// The operator skipped a state.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skip {
    /// The state, as in [`Phase`], or `presentation`.
    pub phase: String,
}

/// Something that the operator wrote down; never a name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    /// The text as it was typed.
    pub text: String,
}

/// Why a session is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// The session ran to its end.
    Completed,
    /// The participant did not consent.
    Declined,
    /// The participant did not pass the screening.
    Screened,
    /// The participant withdrew, together with the data.
    Withdrawn,
    /// The operator gave the session up.
    Abandoned,
}

/// The session is over.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct End {
    /// Why.
    pub outcome: Outcome,
    /// Trials (purpose `trial`) with an answer that counts.
    pub answered: u32,
    /// Trials without such an answer.
    pub missing: u32,
}
