//! `ao.json`. Its keys may be parsed by others: they are added to, never renamed.

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
    /// A pixel's rays of the oracle.
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
    /// Pixels of the left eye whose place the right one shows.
    pub pairs: u64,
    /// Share of the left eye's pixels.
    pub paired: f64,
    /// The methods of the views; the first is `mono`, what the ratios are divided by.
    pub methods: Vec<AoRow>,
    /// The adaptive methods at every threshold, the one above included.
    pub thresholds: Vec<AoRow>,
    pub ray_traced: Oracle,
    /// `None` where no path was asked for.
    pub path: Option<AoPath>,
}

/// A method over the rounds.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct AoRow {
    pub method: Ao,
    pub threshold: f32,
    /// Of all its passes, both eyes, milliseconds: median over rounds, first and third quartile.
    pub ms: f64,
    pub ms_quartiles: [f64; 2],
    /// Over the time of `mono` in the same round: first quartile, median, third quartile.
    pub ratio: [f64; 3],
    /// Medians by pass.
    pub passes: BTreeMap<String, f64>,
    /// Means over the rounds, here and below. `None` without pairs.
    pub inconsistency: Option<f64>,
    /// Mean absolute error against `fsa` of the same seed.
    pub mae_fsa: Option<f64>,
    pub mae_ray_traced: Option<f64>,
    /// Share of the pixels that an adaptive method worked on again; `None` of the others.
    pub again: Option<f64>,
}

/// What the rays found.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Oracle {
    pub ms: f64,
    /// How the rays found what they hit: `bvh` or `ray-query`.
    pub trace: Option<String>,
    pub inconsistency: Option<f64>,
    /// Of both eyes.
    pub mean_visibility: Option<f64>,
}

/// The methods along a path of the head.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct AoPath {
    pub poses: u32,
    /// By method, in the order of the table.
    pub methods: Vec<AoAlong>,
}

/// One method along the path.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct AoAlong {
    pub method: Ao,
    /// Means over the poses.
    pub mean_inconsistency: Option<f64>,
    pub mean_mae_fsa: Option<f64>,
    /// By pose.
    pub inconsistency: Vec<Option<f64>>,
    pub mae_fsa: Vec<Option<f64>>,
}
