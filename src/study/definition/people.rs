//! Who takes part, real or simulated, and what they are asked.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

/// Stereo vision, by random-dot stereograms: four alternatives, ten trials a disparity, passed with 7 right.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Screening {
    /// Disparities, arc seconds, largest first; shown to the nearest pixel, at least one.
    pub disparities_arcsec: Vec<f64>,
    /// The session goes on only if this one is passed.
    pub required_arcsec: f64,
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
