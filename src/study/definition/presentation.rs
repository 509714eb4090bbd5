//! What a presentation shows, for how long, and when it counts.

use std::collections::BTreeMap;

use cyclopean_analysis::journal::record::Shown;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The task of a presentation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Task {
    /// Rate one stimulus by a step of a scale.
    Rate,
    /// Compare two stimuli that are shown in turn: A, same or B.
    Compare,
}

/// How the stimuli are laid out on the display.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// Each eye sees its own image.
    #[default]
    Stereo,
    /// Both eyes see one flat picture: the reference at the left, and at the right the test image mirrored about its
    /// vertical axis.
    MirroredPair,
}

/// One part of a presentation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SegmentSpec {
    /// `stimulus` in a rating, `a` or `b` in a comparison, `blank` in both.
    pub show: Shown,
    /// Duration, seconds; it is shown for round(seconds × nominal refresh rate) frames.
    #[schemars(range(min = 0.05, max = 3600))]
    pub seconds: f64,
}

/// The blank frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Blank {
    /// Duration of the blank frame, seconds; 0: there is none.
    #[schemars(range(min = 0, max = 60))]
    pub seconds: f64,
    /// Its grey as a displayed (not linear) value, 0 black ..= 1 white.
    #[schemars(range(min = 0, max = 1))]
    pub grey: f64,
    /// Whether it shows a fixation cross at screen depth.
    pub fixation: bool,
}

impl Default for Blank {
    fn default() -> Blank {
        Blank { seconds: 2.0, grey: 0.5, fixation: true }
    }
}

/// How long the panel waits. It never answers by itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Panel {
    /// Seconds until the panel reminds the participant.
    #[schemars(range(min = 1, max = 3600))]
    pub reminder_seconds: f64,
    /// Seconds until the session pauses.
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
    /// Width of each eye's image, pixels.
    #[schemars(range(min = 16, max = 16384))]
    pub width_px: u32,
    /// Height of each eye's image, pixels.
    #[schemars(range(min = 16, max = 16384))]
    pub height_px: u32,
    /// Distance between the eyes, metres, the same for all participants.
    #[schemars(range(min = 0.02, max = 0.12))]
    pub ipd_m: f64,
    /// Horizontal field of view per eye, degrees; none: the view's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 10, max = 140))]
    pub horizontal_fov_deg: Option<f64>,
    /// Largest width of a stimulus on a flat display or quad, degrees.
    #[schemars(range(min = 5, max = 100))]
    pub quad_deg: f64,
    /// Seed of the renderer's samples.
    #[schemars(range(min = 0, max = 9007199254740991u64))]
    pub seed: u64,
    /// Samples along a side of each pixel, for surfaces and their light; 1: no antialiasing; none: 2 where graphics
    /// hardware renders, 1 in software.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 4))]
    pub antialias: Option<u32>,
    /// Whether lights cast shadows.
    #[serde(skip_serializing_if = "is_true")]
    pub shadows: bool,
    /// Whether indirect diffuse light, gathered once for each scene, is used instead of the environment's.
    #[serde(skip_serializing_if = "is_false")]
    pub indirect: bool,
    /// Method of ambient occlusion: `mono`, `fsa`, `variant1`, `variant2` or `ray-traced`. Without a method, or with
    /// `none`, nothing occludes ambient light.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ao: Option<String>,
    /// Method → samples per pixel. A method that is not listed here, nor written `NAME@N`, has its own default.
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
            antialias: None,
            shadows: true,
            indirect: false,
            ao: None,
            samples: BTreeMap::new(),
        }
    }
}

pub(in crate::study) fn is_true(b: &bool) -> bool {
    *b
}

pub(in crate::study) fn is_false(b: &bool) -> bool {
    !b
}

pub(in crate::study) fn yes() -> bool {
    true
}

/// When a break is offered. It ends when the participant goes on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Breaks {
    /// Minutes since the last break; 0: there are no breaks.
    #[schemars(range(min = 0, max = 240))]
    pub every_minutes: f64,
}

impl Default for Breaks {
    fn default() -> Breaks {
        Breaks { every_minutes: 15.0 }
    }
}

/// When a presentation does not count. It is repeated at the end of its block.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Validity {
    /// It does not count when focus, visibility or drawing was lost for longer than this in all, milliseconds.
    #[schemars(range(min = 0, max = 60000))]
    pub lost_ms: f64,
    /// It does not count when one interval between frames is longer than this, milliseconds.
    #[schemars(range(min = 1, max = 60000))]
    pub gap_ms: f64,
    /// It does not count when its duration is off by more than this, percent.
    #[schemars(range(min = 0.01, max = 100))]
    pub duration_percent: f64,
    /// It does not count when a toggle is off by more than this and by more than `toggle_ms`, frames.
    #[schemars(range(min = 0, max = 1000))]
    pub toggle_frames: f64,
    /// It does not count when a toggle is off by more than this and by more than `toggle_frames`, milliseconds.
    #[schemars(range(min = 0, max = 60000))]
    pub toggle_ms: f64,
    /// It does not count when more of the frames of a moving stimulus that were due were never displayed, percent.
    #[schemars(range(min = 0, max = 100))]
    pub skipped_percent: f64,
    /// How often an invalid presentation is repeated; after that it counts as missing.
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
            skipped_percent: 2.0,
            repeats: 2,
        }
    }
}
