//! The content of `compare.json`. Other programs may read its keys, so keys are added but never renamed.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::plan::Options;
use super::times::Groups;
use crate::gpu::DeviceInfo;
use crate::metrics::lasting_contrast::{JackknifeReplicates, Unbiased};
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
    /// The SHA-256 of the networks' files under `lpips` and `dists`. The key is absent where no network was named.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub networks: BTreeMap<String, String>,
    /// The settings that all configurations share. Seed and fallback differ between them.
    pub settings: Settings,
    pub scenes: Vec<SceneReport>,
    /// The ratios over all scenes.
    pub summary: Vec<Summary>,
    pub failed: Vec<Failure>,
}

/// A scene that could not be compared.
#[derive(Debug, Clone, Serialize)]
pub struct Failure {
    pub scene: String,
    pub error: String,
}

/// The results of one scene.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SceneReport {
    pub scene: String,
    pub scene_sha256: String,
    pub view: String,
    /// The exposure of the scene, with which every picture here is tone-mapped.
    pub exposure: f32,
    /// The share of the pixels of both eyes that trace a reflection ray.
    pub reflective: f64,
    /// The name of the method by which the others are divided, without `@N`.
    pub baseline: String,
    pub reference: ReferenceReport,
    pub pairs: PairsReport,
    pub results: Vec<Row>,
    /// The measures of every method over the baseline's with the same number of samples.
    pub equal_sample: Vec<Ratio>,
    /// The errors of every method, and the baseline's error in the same time.
    pub equal_time: Vec<EqualTime>,
    /// The times of every method over the baseline's, taken in each round.
    pub overhead: Vec<Overhead>,
    /// The ratios that the three lists above do not have, and why: a value is 0, negative, infinite or undefined.
    pub left_out: Vec<MissingRatio>,
}

/// A comparison with the baseline that has no ratio.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MissingRatio {
    pub method: String,
    pub spp: u32,
    pub fallback: String,
    /// As in [`Summary::measure`].
    pub measure: String,
    pub why: String,
}

/// The reference, and how noisy it is.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ReferenceReport {
    /// The name of its folder in the cache, which is a hash.
    pub key: String,
    pub files: PathBuf,
    pub spp: u32,
    /// The mean variance of a pixel's reflection in the left and in the right eye, linear radiance squared. It is
    /// measured as half the mean squared difference between two references with different seeds. Every `mse` and
    /// `bias2` here includes it.
    pub variance: [f64; 2],
}

/// How many pairs of pixels there are; see `metrics::pairs`.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct PairsReport {
    pub candidates: u64,
    pub used: u64,
    /// The share of the candidates for which the reference is too noisy to tell whether they match.
    pub undecided: Option<f64>,
    /// The share of the candidates that differ in the reference.
    pub different: Option<f64>,
    /// The share of the used pairs whose contrast is above 2 % in a reference with another seed; its noise counts too.
    /// It is above 0 because the pairs were chosen with a noisy reference. A method's share of that size says little.
    pub floor: Option<f64>,
}

/// The results of one method with its number of samples and its fallback.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Row {
    /// The method's name without `@N`.
    pub method: String,
    /// The method that was rendered, with `@N`. It has another name where the method stands for one that the device
    /// decides.
    pub rendered_method: String,
    pub spp: u32,
    pub fallback: String,
    pub seeds: u32,
    /// The median times over the rounds for both eyes, in milliseconds on the device.
    pub ms: Groups,
    /// The first and the third quartile of the same times.
    pub ms_quartiles: BTreeMap<String, [f64; 2]>,
    /// The median time of every pass of the frame, by its name.
    pub passes: BTreeMap<String, f64>,
    pub left: EyeReport,
    pub right: EyeReport,
    /// The share of pairs that differ by more than 2 % whatever the seed is. Null: there are no pairs.
    pub systematic_inconsistency: Option<f64>,
    /// Its 95 % interval over the seeds by the delete-a-group jackknife. It is approximate, because the share counts
    /// what lies beyond a threshold.
    pub systematic_inconsistency_interval: Option<[f64; 2]>,
    pub systematic: Option<Systematic>,
    /// The squared lasting contrast that the reference does not have itself, free of the noise of both.
    pub systematic_unbiased: Option<Unbiased>,
    /// The same share beyond other thresholds, by per cent.
    pub systematic_over: Option<BTreeMap<u32, f64>>,
    pub noise_variance: Option<f64>,
    /// Its 95 % interval over the seeds by the delete-a-group jackknife.
    pub noise_variance_interval: Option<[f64; 2]>,
    pub noise_variance_relative: Option<f64>,
    /// The share of pairs beyond each threshold in single frames, by per cent.
    pub noise_over: Option<BTreeMap<u32, f64>>,
    /// The figures from which those intervals are made, without each group of seeds in turn.
    pub jackknife: Option<JackknifeReplicates>,
    /// The number of fireflies in both eyes with all seeds; see `metrics::fireflies`.
    pub fireflies_total: u64,
    /// The number of values of radiance that were clamped because fp16 cannot hold them, summed over the seeds.
    pub clamped: u64,
    /// The values by round, for statistics that are not in this report.
    pub rounds: Rounds,
}

/// The results of one eye: means over the seeds.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct EyeReport {
    /// The means by measure. `mse`, `rse`, `relmse` and `tonemapped_mse` are of the outgoing reflection over the pixels
    /// that trace, and so are `reflection_ssim` and `reflection_flip`, of the tone-mapped reflection. `ssim` and `flip`
    /// are of the tone-mapped composite. `composite_mse`, `composite_rse` and `composite_tonemapped_mse` are of the
    /// composite. `fireflies` are those of the composite, per million pixels that trace. Where the networks were named,
    /// `lpips` and `dists` are of the tone-mapped composite, and `reflection_lpips` and `reflection_dists` of the
    /// tone-mapped reflection. Null: undefined.
    #[serde(flatten)]
    pub means: BTreeMap<String, Option<f64>>,
    pub bias2: Option<f64>,
    pub variance: Option<f64>,
    /// The 95 % intervals over the seeds by Student's t, by measure.
    pub intervals: BTreeMap<String, [f64; 2]>,
}

/// The values by round.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Rounds {
    pub ms: Vec<Groups>,
    /// The mean of the eyes by round, by measure.
    pub measures: BTreeMap<String, Vec<f64>>,
}

/// A measure of a method, divided by the baseline's with the same number of samples.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Ratio {
    pub method: String,
    pub spp: u32,
    pub fallback: String,
    /// One of `mse`, `rse`, `relmse`, `tonemapped_mse`, `composite_tonemapped_mse`, `flip`, `reflection_flip`, `lpips`,
    /// `dists`, `reflection_lpips`, `reflection_dists`, `one_minus_ssim`, `one_minus_reflection_ssim`, `bias2` and
    /// `variance`, which are means of the eyes, or `systematic_inconsistency`, `systematic_unbiased` (its `squared`)
    /// and `noise_variance`.
    pub measure: String,
    /// The ratio of the means over the seeds. Below 1 the method is better.
    pub ratio: f64,
    /// Its 95 % interval by Student's t on the logarithm, with the two methods paired by seed. Figures of consistency
    /// have no value for a single seed, so theirs is by the delete-a-group jackknife. Null for bias and variance, and
    /// where a logarithm does not exist.
    pub interval: Option<[f64; 2]>,
}

/// Errors at equal time: those of the method and of the baseline, as means of the eyes.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct EqualTime {
    pub method: String,
    pub spp: u32,
    pub fallback: String,
    /// The method's median time for reflections.
    pub ms: f64,
    pub mse: f64,
    /// The baseline's at that time. It is read from a curve of log error over log time, which is linear between the
    /// measured sample counts.
    pub baseline_mse: f64,
    /// The ratio of the mean squared errors.
    pub ratio: f64,
    /// Null where it is undefined or there is no curve; the scene's `left_out` says which.
    pub relmse: Option<f64>,
    pub baseline_relmse: Option<f64>,
    pub relmse_ratio: Option<f64>,
    pub tonemapped_mse: Option<f64>,
    pub baseline_tonemapped_mse: Option<f64>,
    pub tonemapped_mse_ratio: Option<f64>,
    /// Whether the time is outside the times that were measured of the baseline. Then the nearest segment was
    /// prolonged.
    pub extrapolated: bool,
}

/// The time of a group of passes over the baseline's, taken in each round.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Overhead {
    pub method: String,
    pub spp: u32,
    pub fallback: String,
    /// The group: a key of [`Row::ms`].
    pub group: String,
    pub median: f64,
    pub quartiles: [f64; 2],
}

/// The geometric mean of a ratio over the scenes.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    pub method: String,
    pub spp: u32,
    pub fallback: String,
    /// A measure as in [`Ratio::measure`], or `equal_time_mse`, `equal_time_relmse`, `equal_time_tonemapped_mse`, or
    /// `ms_` with a key of [`Row::ms`] behind it.
    pub measure: String,
    /// Null: no scene has a ratio.
    pub geomean: Option<f64>,
    /// Its 95 % interval by Student's t over the scenes' logarithms. Null for one scene.
    pub interval: Option<[f64; 2]>,
    /// The largest ratio of a scene. Null: no scene has a ratio.
    pub worst: Option<f64>,
    /// The number of scenes that have a ratio.
    pub scenes: usize,
    /// The other scenes in which this method was measured with these samples and this fallback.
    pub left_out: Vec<SceneWithoutRatio>,
}

/// A scene that has no ratio which could be part of a geometric mean.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneWithoutRatio {
    pub scene: String,
    pub why: String,
}

impl Report {
    /// A report without any scene yet.
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
    /// The mean of the two eyes' means.
    pub fn both(&self, measure: &str) -> Option<f64> {
        let value = |eye: &EyeReport| eye.means.get(measure).copied().flatten();
        Some((value(&self.left)? + value(&self.right)?) / 2.0)
    }

    /// Whether another row has the same number of samples and the same fallback.
    pub fn is_peer(&self, other: &Row) -> bool {
        self.spp == other.spp && self.fallback == other.fallback
    }
}

/// Shares by their threshold in per cent.
pub fn by_percent(shares: [f64; THRESHOLDS.len()]) -> BTreeMap<u32, f64> {
    THRESHOLDS.iter().zip(shares).map(|(t, share)| ((t * 100.0).round() as u32, share)).collect()
}
