//! `compare.json`. Its keys may be parsed by others: they are added to, never renamed.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::plan::Options;
use super::times::Groups;
use crate::gpu::DeviceInfo;
use crate::metrics::lasting::{Unbiased, Without};
use crate::metrics::stereo::{Systematic, THRESHOLDS};
use crate::render::Settings;

/// The whole file.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    pub device: DeviceInfo,
    /// Pixels of one eye.
    pub width: u32,
    pub height: u32,
    pub seeds: u32,
    pub reference_spp: u32,
    pub pixels_per_degree: f32,
    /// SHA-256 of the networks' files, by `lpips` and `dists`; absent: none was named.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub networks: BTreeMap<String, String>,
    /// What all configurations share; seed and fallback are theirs.
    pub settings: Settings,
    pub scenes: Vec<SceneReport>,
    /// Ratios over all scenes.
    pub summary: Vec<Summary>,
    pub failed: Vec<Failure>,
}

/// A scene that could not be compared.
#[derive(Debug, Clone, Serialize)]
pub struct Failure {
    pub scene: String,
    pub error: String,
}

/// One scene.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SceneReport {
    pub scene: String,
    pub scene_sha256: String,
    pub view: String,
    /// Of every tone map here: the reference's.
    pub exposure: f32,
    /// Share of the pixels, both eyes, that trace a reflection ray.
    pub reflective: f64,
    /// What the ratios are divided by, without `@N`.
    pub baseline: String,
    pub reference: ReferenceReport,
    pub pairs: PairsReport,
    pub results: Vec<Row>,
    /// Every method over the baseline with as many samples.
    pub equal_sample: Vec<Ratio>,
    /// Every method over the baseline's error curve at the method's own time.
    pub equal_time: Vec<EqualTime>,
    /// Times over the baseline's, taken within each round.
    pub overhead: Vec<Overhead>,
    /// Ratios that the three lists above lack, and why: 0, without end or undefined.
    pub left_out: Vec<LeftOut>,
}

/// A comparison with the baseline that has no ratio.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    pub method: String,
    pub spp: u32,
    pub fallback: String,
    /// As [`Summary::measure`].
    pub measure: String,
    pub why: String,
}

/// What the reference is worth.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ReferenceReport {
    /// Its folder in the cache.
    pub key: String,
    pub files: PathBuf,
    pub spp: u32,
    /// Mean variance of a pixel's reflection (linear radiance squared), left and right, measured as half the mean
    /// squared difference between two references of different seeds. Every `mse` and `bias2` here holds it.
    pub variance: [f64; 2],
}

/// Pairs of pixels, see `metrics::pairs`.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct PairsReport {
    pub candidates: u64,
    pub used: u64,
    /// Share of the candidates that the reference's noise leaves open.
    pub undecided: Option<f64>,
    /// Share of the candidates that differ in the reference.
    pub different: Option<f64>,
    /// Share of the used pairs beyond 2 % in a reference with another seed, its noise included: what the choice of pairs
    /// owes to the noise of the reference that chose them. A method's share of that size says little.
    pub floor: Option<f64>,
}

/// One method with its samples and fallback.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Row {
    /// Without `@N`.
    pub method: String,
    /// What was rendered, with `@N`: another name where the method stands for what suits the device.
    pub rendered_method: String,
    pub spp: u32,
    pub fallback: String,
    pub seeds: u32,
    /// Medians over rounds, milliseconds on the device, both eyes.
    pub ms: Groups,
    /// First and third quartile.
    pub ms_quartiles: BTreeMap<String, [f64; 2]>,
    /// Every pass of the frame under its own name, medians.
    pub passes: BTreeMap<String, f64>,
    pub left: EyeReport,
    pub right: EyeReport,
    /// Null: no pairs.
    pub systematic_inconsistency: Option<f64>,
    /// 95 % over seeds, delete-a-group jackknife; approximate, as the share counts what lies beyond a threshold.
    pub systematic_inconsistency_interval: Option<[f64; 2]>,
    pub systematic: Option<Systematic>,
    /// The squared lasting contrast that is not owed to the reference, without the noise of either.
    pub systematic_unbiased: Option<Unbiased>,
    /// The same share beyond so many per cent.
    pub systematic_over: Option<BTreeMap<u32, f64>>,
    pub noise_variance: Option<f64>,
    /// 95 % over seeds, delete-a-group jackknife.
    pub noise_variance_interval: Option<[f64; 2]>,
    pub noise_variance_relative: Option<f64>,
    /// Share of pairs beyond so many per cent in single frames.
    pub noise_over: Option<BTreeMap<u32, f64>>,
    /// What those intervals are made of: the three figures without each group of seeds in turn.
    pub jackknife: Option<Without>,
    /// Fireflies of both eyes and all seeds together; see `metrics::fireflies`.
    pub fireflies_total: u64,
    /// Radiance beyond fp16 that was clamped, summed over the seeds.
    pub clamped: u64,
    /// By round, for other statistics than ours.
    pub rounds: Rounds,
}

/// One eye of a row: means over the seeds.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct EyeReport {
    /// `mse`, `rse`, `relmse`, `tonemapped_mse` of the outgoing reflection over the pixels that trace; `ssim`, `flip` of
    /// the tone-mapped composite; `reflection_ssim`, `reflection_flip`, `composite_mse`, `composite_rse`,
    /// `composite_tonemapped_mse`; `fireflies` of the composite per million pixels that trace. Null: undefined. Where their
    /// networks were named, `lpips`, `dists` of the tone-mapped composite and `reflection_lpips`, `reflection_dists`.
    #[serde(flatten)]
    pub means: BTreeMap<String, Option<f64>>,
    pub bias2: Option<f64>,
    pub variance: Option<f64>,
    /// 95 % Student t over the seeds, by measure.
    pub intervals: BTreeMap<String, [f64; 2]>,
}

/// Values by round.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Rounds {
    pub ms: Vec<Groups>,
    /// By measure, mean of the eyes.
    pub measures: BTreeMap<String, Vec<f64>>,
}

/// A measure of a method over the baseline's with as many samples.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Ratio {
    pub method: String,
    pub spp: u32,
    pub fallback: String,
    /// `mse`, `rse`, `relmse`, `tonemapped_mse`, `composite_tonemapped_mse`, `flip`, `reflection_flip`, `lpips`, `dists`,
    /// `reflection_lpips`, `reflection_dists`,
    /// `one_minus_ssim`, `one_minus_reflection_ssim`, `bias2`, `variance` (means of the eyes),
    /// `systematic_inconsistency`, `systematic_unbiased` (of `squared`), `noise_variance`.
    pub measure: String,
    /// Of the means over seeds; below 1: the method is better.
    pub ratio: f64,
    /// 95 % Student t of its logarithm over pairs of seeds; for consistency, which has no value a seed, the delete-a-group
    /// jackknife's. Null for bias and variance, and where a logarithm does not exist.
    pub interval: Option<[f64; 2]>,
}

/// Errors at equal time: the method's and the baseline's, means of the eyes.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct EqualTime {
    pub method: String,
    pub spp: u32,
    pub fallback: String,
    /// The method's median reflection time.
    pub ms: f64,
    pub mse: f64,
    /// Of the baseline at that time: log error over log time, linear between its measured sample counts.
    pub baseline_mse: f64,
    /// Of the mean squared errors.
    pub ratio: f64,
    /// Null: undefined, or without a curve; see `left_out` of the scene.
    pub relmse: Option<f64>,
    pub baseline_relmse: Option<f64>,
    pub relmse_ratio: Option<f64>,
    pub tonemapped_mse: Option<f64>,
    pub baseline_tonemapped_mse: Option<f64>,
    pub tonemapped_mse_ratio: Option<f64>,
    /// The time lies outside what was measured of the baseline; the nearest segment was prolonged.
    pub extrapolated: bool,
}

/// Time over the baseline's.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Overhead {
    pub method: String,
    pub spp: u32,
    pub fallback: String,
    /// A key of `ms`.
    pub group: String,
    pub median: f64,
    pub quartiles: [f64; 2],
}

/// Geometric mean over scenes of a ratio.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    pub method: String,
    pub spp: u32,
    pub fallback: String,
    /// As in [`Ratio`], or `equal_time_mse`, `equal_time_relmse`, `equal_time_tonemapped_mse`, or `ms_` and a key of `ms`.
    pub measure: String,
    /// Null: no scene has a ratio.
    pub geomean: Option<f64>,
    /// 95 % Student t over the scenes' logarithms; null for one scene.
    pub interval: Option<[f64; 2]>,
    /// The largest of the scenes; null without any.
    pub worst: Option<f64>,
    /// Scenes that have a ratio.
    pub scenes: usize,
    /// The other scenes that measured this method, samples and fallback.
    pub left_out: Vec<SceneLeftOut>,
}

/// A scene whose ratio no geometric mean can hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneLeftOut {
    pub scene: String,
    pub why: String,
}

impl Report {
    /// Nothing compared yet.
    pub fn new(device: DeviceInfo, options: &Options) -> Report {
        Report {
            device,
            width: options.settings.width,
            height: options.settings.height,
            seeds: options.seeds,
            reference_spp: options.reference.samples(),
            pixels_per_degree: options.pixels_per_degree,
            networks: options.networks.iter().map(|n| (n.measure().to_owned(), n.sha256().to_owned())).collect(),
            settings: options.settings.clone(),
            scenes: Vec::new(),
            summary: Vec::new(),
            failed: Vec::new(),
        }
    }
}

impl Row {
    /// Mean of both eyes' means.
    pub fn both(&self, measure: &str) -> Option<f64> {
        let value = |eye: &EyeReport| eye.means.get(measure).copied().flatten();
        Some((value(&self.left)? + value(&self.right)?) / 2.0)
    }

    /// The same configuration by another method.
    pub fn is_peer(&self, other: &Row) -> bool {
        self.spp == other.spp && self.fallback == other.fallback
    }
}

/// Shares by threshold in per cent.
pub fn by_percent(shares: [f64; THRESHOLDS.len()]) -> BTreeMap<u32, f64> {
    THRESHOLDS.iter().zip(shares).map(|(t, share)| ((t * 100.0).round() as u32, share)).collect()
}
