//! The people who take part, real or simulated, and what they are asked.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the participant agrees to. It never holds a name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConsentText {
    /// Version of the text.
    pub version: String,
    /// What the data is for.
    pub purpose: String,
    /// Day after which the data is deleted, `YYYY-MM-DD`.
    pub retain_until: String,
    /// The text that is shown to the participant.
    pub text: String,
}

/// A test of stereo vision by random-dot stereograms with four alternatives: ten trials for each disparity, passed with
/// 7 right answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Screening {
    /// Disparities, arc seconds, largest first. Each is shown to the nearest pixel, at least one.
    pub disparities_arcsec: Vec<f64>,
    /// The disparity that must be passed for the session to go on, arc seconds.
    pub required_arcsec: f64,
}

/// How simulated observers answer: by the choice nearest to latent quality + bias + noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Simulation {
    /// Method → latent quality in steps of the scale. For `rate` it is a value on the scale; for `compare` only
    /// differences count.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub latent: BTreeMap<String, f64>,
    /// Scene → number that is added to the latent quality.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub scene: BTreeMap<String, f64>,
    /// How to derive the latent quality of a method that has none above from the stimulus's measured inconsistency.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_inconsistency: Option<FromInconsistency>,
    /// Standard deviation between observers of a bias over the whole scale.
    #[serde(default)]
    #[schemars(range(min = 0, max = 100))]
    pub bias_sd: f64,
    /// Standard deviation between observers of the quality of each method (the effect differs between people).
    #[serde(default)]
    #[schemars(range(min = 0, max = 100))]
    pub method_sd: f64,
    /// Standard deviation within an observer of one judgement.
    #[serde(default)]
    #[schemars(range(min = 0, max = 100))]
    pub noise_sd: f64,
    /// Share of answers given at random.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1))]
    pub lapse: f64,
    /// For `compare`: smaller perceived differences are answered with "same".
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

/// Latent quality = at_zero + slope × inconsistency, for stimuli whose inconsistency the renderer measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FromInconsistency {
    /// The latent quality without inconsistency.
    pub at_zero: f64,
    /// Change of the latent quality per unit of inconsistency; negative.
    pub slope: f64,
}
