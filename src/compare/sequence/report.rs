//! `sequence.json`. Its keys may be parsed by others: they are added to, never renamed.

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
    /// Paths a pixel of each of a frame's two references.
    pub reference_spp: u32,
    /// What all configurations share.
    pub settings: Settings,
    pub scenes: Vec<SequenceScene>,
    /// Ratios to the first method, over all scenes.
    pub summary: Vec<SequenceSummary>,
    pub failed: Vec<Failure>,
}

/// One scene.
#[derive(Debug, Clone, Serialize)]
pub struct SequenceScene {
    pub scene: String,
    pub scene_sha256: String,
    pub view: String,
    pub frames: u32,
    pub rate_hz: f64,
    /// Frames before which the head jumps.
    pub cuts: Vec<u32>,
    /// What the ratios are divided by, without `@N`.
    pub baseline: String,
    pub results: Vec<SequenceRow>,
}

/// One method with its samples. Errors are means over eyes and frames, the first frame left out, unless said.
#[derive(Debug, Clone, Serialize)]
pub struct SequenceRow {
    /// Without `@N`.
    pub method: String,
    pub rendered_method: String,
    pub spp: u32,
    /// Medians over frames and both runs, milliseconds on the device, both eyes.
    pub ms: Groups,
    /// By measure: `mse`, `bias2`, `variance` of the outgoing reflection over the pixels that trace; the same as
    /// `glossy_mse` where the roughness lies between a mirror's and 0.3, and as `uncovered_mse` where the frame before did
    /// not show the place; `flicker` and `noise_flicker`; `lasting_contrast2` and `noise` between the eyes. See `metrics::sequence`.
    pub means: BTreeMap<&'static str, Option<f64>>,
    /// Frames from the first cut on until the squared error has lost half of what it loses until the next cut or the end;
    /// 0: the frame after the cut has no more error than those that follow. `None`: no cut.
    pub lag_frames: Option<u32>,
    /// By measure, frame by frame.
    pub by_frame: BTreeMap<&'static str, Vec<Option<f64>>>,
    /// The baseline's error at this method's time; `None` where fewer than two counts of its samples were measured.
    pub equal_time: Option<SequenceEqualTime>,
}

/// At equal time, on lines between the baseline's measured points in logarithms.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct SequenceEqualTime {
    pub mse: f64,
    pub baseline_mse: f64,
    pub ratio: f64,
    pub extrapolated: bool,
}

/// Geometric mean over scenes of a measure's ratio to the baseline with as many samples.
#[derive(Debug, Clone, Serialize)]
pub struct SequenceSummary {
    pub method: String,
    pub spp: u32,
    /// A key of `means`, `equal_time_mse`, or `ms_total`.
    pub measure: String,
    pub geomean: f64,
    /// 95 % Student t over the scenes' logarithms; null for one scene.
    pub interval: Option<[f64; 2]>,
    pub worst: f64,
    pub scenes: usize,
}
