//! The content of `ao.json`. Other programs may read its keys, so keys are added but never renamed.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::compare::report::Failure;
use crate::gpu::DeviceInfo;
use crate::render::Ao;

/// The whole file.
#[derive(Debug, Clone, Serialize)]
pub struct AoReport {
    pub device: DeviceInfo,
    /// Pixels of one eye.
    pub width: u32,
    pub height: u32,
    /// Rounds, each with its own random seed.
    pub seeds: u32,
    pub radius_m: f32,
    pub threshold: f32,
    /// The number of rays of `ray-traced` for each pixel.
    pub rays: u32,
    pub scenes: Vec<AoScene>,
    pub failed: Vec<Failure>,
}

/// One scene.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct AoScene {
    pub scene: String,
    pub scene_sha256: String,
    pub view: String,
    /// The number of pixels of the left eye whose place the right eye shows too.
    pub pairs: u64,
    /// The same as a share of the left eye's pixels.
    pub paired: f64,
    /// The methods that estimate occlusion from the views. The first is `mono`, by whose time the ratios are divided.
    pub methods: Vec<AoRow>,
    /// The adaptive methods at every threshold, including the one that was asked for.
    pub thresholds: Vec<AoRow>,
    pub ray_traced: Oracle,
    /// `None`: no path was asked for.
    pub path: Option<AoPath>,
}

/// The results of a method over the rounds.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct AoRow {
    pub method: Ao,
    pub threshold: f32,
    /// The time of all its passes for both eyes, milliseconds: the median over the rounds, then the first and third
    /// quartile.
    pub ms: f64,
    pub ms_quartiles: [f64; 2],
    /// The time over that of `mono` in the same round: first quartile, median, third quartile.
    pub ratio: [f64; 3],
    /// The median time of each pass, milliseconds.
    pub passes: BTreeMap<String, f64>,
    /// The mean share of paired pixels that differ visibly between the eyes. `None` without pairs. This and the figures
    /// below are means over the rounds.
    pub inconsistency: Option<f64>,
    /// The mean absolute error against `fsa` with the same seed.
    pub mae_fsa: Option<f64>,
    pub mae_ray_traced: Option<f64>,
    /// The share of the pixels that an adaptive method processed further. `None` for the other methods.
    pub again: Option<f64>,
}

/// The results of `ray-traced`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Oracle {
    pub ms: f64,
    /// What found the hits of the rays, such as `bvh` or `ray-query`.
    pub trace: Option<String>,
    pub inconsistency: Option<f64>,
    /// The mean over the pixels of both eyes.
    pub mean_visibility: Option<f64>,
}

/// The results along a path of the head.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct AoPath {
    pub poses: u32,
    /// The methods in the order of the table.
    pub methods: Vec<AoPathRow>,
}

/// The results of one method along the path.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct AoPathRow {
    pub method: Ao,
    /// The means over the poses.
    pub mean_inconsistency: Option<f64>,
    pub mean_mae_fsa: Option<f64>,
    /// The values by pose.
    pub inconsistency: Vec<Option<f64>>,
    pub mae_fsa: Vec<Option<f64>>,
}
