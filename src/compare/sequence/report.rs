//! The content of `sequence.json`. Other programs may read its keys, so keys are added but never renamed.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::compare::report::Failure;
use crate::compare::times::Groups;
use crate::gpu::DeviceInfo;
use crate::render::Settings;

/// The whole file.
#[derive(Debug, Clone, Serialize)]
pub struct SequenceReport {
    pub device: DeviceInfo,
    /// Pixels of one eye.
    pub width: u32,
    pub height: u32,
    pub path: String,
    /// The paths a pixel of each of the two references of a frame.
    pub reference_spp: u32,
    /// The settings that all configurations share.
    pub settings: Settings,
    pub scenes: Vec<SequenceScene>,
    /// The ratios to the first method, over all scenes.
    pub summary: Vec<SequenceSummary>,
    pub failed: Vec<Failure>,
}

/// The results of one scene.
#[derive(Debug, Clone, Serialize)]
pub struct SequenceScene {
    pub scene: String,
    pub scene_sha256: String,
    pub view: String,
    pub frames: u32,
    pub rate_hz: f64,
    /// The frames before which the head jumps.
    pub cuts: Vec<u32>,
    /// The name of the method by which the others are divided, without `@N`.
    pub baseline: String,
    pub results: Vec<SequenceRow>,
}

/// The results of one method with its number of samples. Unless something else is said, errors are means over the eyes
/// and over all frames but the first.
#[derive(Debug, Clone, Serialize)]
pub struct SequenceRow {
    /// The method's name without `@N`.
    pub method: String,
    pub rendered_method: String,
    pub spp: u32,
    /// The median times over the frames and both runs for both eyes, in milliseconds on the device.
    pub ms: Groups,
    /// The means by measure. `mse`, `bias2` and `variance` are of the outgoing reflection over the pixels that trace.
    /// `glossy_mse` is the MSE where the roughness is between that of a mirror and 0.3. `uncovered_mse` is the MSE
    /// where the frame before did not show the place. `flicker` and `noise_flicker` are changes from frame to frame,
    /// and `lasting_contrast2` and `noise` are differences between the eyes. See `metrics::sequence`.
    pub means: BTreeMap<&'static str, Option<f64>>,
    /// The number of frames after the first cut until the squared error has lost half of what it loses until the next
    /// cut or the end. 0: the first frame after the cut has no more error than the later ones. `None`: there is no cut.
    pub lag_frames: Option<u32>,
    /// The values by measure, frame by frame, without the first frame.
    pub by_frame: BTreeMap<&'static str, Vec<Option<f64>>>,
    /// The baseline's error at this method's time. `None` where fewer than two sample counts of the baseline were
    /// measured.
    pub equal_time: Option<SequenceEqualTime>,
}

/// Errors at equal time. The baseline's is read from straight lines between its measured points, in logarithms.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct SequenceEqualTime {
    pub mse: f64,
    pub baseline_mse: f64,
    pub ratio: f64,
    pub extrapolated: bool,
}

/// The geometric mean over the scenes of a measure's ratio to the baseline with the same number of samples.
#[derive(Debug, Clone, Serialize)]
pub struct SequenceSummary {
    pub method: String,
    pub spp: u32,
    /// A key of [`SequenceRow::means`], or `equal_time_mse`, or `ms_total`.
    pub measure: String,
    pub geomean: f64,
    /// Its 95 % interval by Student's t over the scenes' logarithms. Null for one scene.
    pub interval: Option<[f64; 2]>,
    pub worst: f64,
    pub scenes: usize,
}
