//! Displays: events in, frames out, the time of showing reported back. All drive the same state machine.
//!
//! A session's loop is `wait` → machine → `present`, once a frame; a display never decides what is shown.

pub mod content;
#[cfg(feature = "gpu")]
pub mod desktop;
pub mod headless;
pub mod intervals;
#[cfg(feature = "gpu")]
mod memory;
#[cfg(feature = "gpu")]
pub mod openxr;
#[cfg(feature = "gpu")]
pub mod operator;
#[cfg(feature = "gpu")]
pub mod panel;
#[cfg(feature = "gpu")]
mod shaders;

use std::path::{Path, PathBuf};

use cyclopean_analysis::journal::record;
use serde::{Deserialize, Serialize};

use crate::study::protocol::{Event, Screen};

/// An event and the session clock at which it is handled, nanoseconds.
#[derive(Debug, Clone, PartialEq)]
pub struct Timed {
    pub now_ns: u64,
    pub event: Event,
}

/// What a session must know of a display before it begins.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayInfo {
    /// `headless`, `desktop` or `openxr`.
    pub kind: String,
    pub system: String,
    pub runtime: String,
    /// How far its times can be trusted.
    pub trust: record::Trust,
    pub nominal_hz: f64,
    /// From warm-up frames; none when nothing is measured.
    pub measured_hz: Option<f64>,
    pub interval_sd_ms: Option<f64>,
    /// Pixels per eye.
    pub width_px: u32,
    pub height_px: u32,
    /// Left, right, up, down half angles per eye, degrees.
    pub fov_deg: Option<[[f64; 4]; 2]>,
    pub ipd_m: Option<f64>,
    /// Angular size of a pixel, arc seconds.
    pub arcsec_per_px: f64,
    /// It can say where the head is: see [`Display::take_poses`].
    pub tracks_head: bool,
    pub device: Option<record::Device>,
}

impl DisplayInfo {
    /// A compositor that shows every second frame (or fewer) cannot run a study.
    pub fn is_at_reduced_rate(&self) -> bool {
        self.measured_hz.is_some_and(|measured| self.nominal_hz / measured >= 1.5)
    }
}

/// Where a head was when a frame was displayed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeadPose {
    /// On the session's clock, nanoseconds.
    pub t_ns: u64,
    /// Right, up, backward, metres, in the display's own space.
    pub position: [f32; 3],
    /// Unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
}

/// A stimulus whose files were checked; its position in the slice is the plan's index.
#[derive(Debug, Clone, PartialEq)]
pub struct StimulusFiles {
    /// Linear, multi-view.
    pub exr: PathBuf,
    /// Left and right half, display values: one picture of a still, one a frame of a moving stimulus; at least one.
    pub frames: Vec<PathBuf>,
    /// Horizontal field of view per eye that it was rendered with, degrees; none where nobody says.
    pub fov_deg: Option<f64>,
}

impl StimulusFiles {
    /// The still, or the first frame; empty where there is none.
    pub fn first(&self) -> &Path {
        self.frames.first().map_or(Path::new(""), PathBuf::as_path)
    }
}

/// A display failed; the session is closed whole and can be resumed.
#[derive(Debug, thiserror::Error)]
#[error("the {display} display failed: {what}")]
pub struct DisplayError {
    pub display: &'static str,
    pub what: String,
}

/// See the module's documentation.
pub trait Display {
    fn info(&self) -> &DisplayInfo;

    /// Makes every stimulus ready, so that showing one is a change of layer; once, before trial 1.
    ///
    /// # Errors
    /// A file cannot be read, or does not fit the device.
    fn load(&mut self, stimuli: &[StimulusFiles]) -> Result<(), DisplayError>;

    /// The next event. After a frame the session calls [`Display::present`] for it. A display that can skip time
    /// passes over at most `idle_frames` frames in one [`Event::Frames`].
    ///
    /// # Errors
    /// The display is gone, or waits for somebody who is not there.
    fn wait(&mut self, idle_frames: u64) -> Result<Timed, DisplayError>;

    /// Draws the screen for the frame that [`Display::wait`] announced; the same until the next call.
    ///
    /// # Errors
    /// The display is gone.
    fn present(&mut self, screen: &Screen) -> Result<(), DisplayError>;

    /// Where the head was since the last call, oldest first, on the session's clock. Asked for only where the study
    /// keeps head poses; a display whose information says that it tracks no head has none.
    fn take_poses(&mut self) -> Vec<HeadPose> {
        Vec::new()
    }
}
