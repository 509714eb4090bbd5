//! Displays: events go to the session, frames to the participant, and the times of display back to the session. All
//! displays drive the same state machine.
//!
//! A session's loop is `wait` → machine → `present`, once for each frame. A display never decides what is shown.

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

/// An event, and the time of the session clock at which it is handled, nanoseconds.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedEvent {
    pub now_ns: u64,
    pub event: Event,
}

/// What a session must know about a display before it begins.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayInfo {
    /// `headless`, `desktop` or `openxr`.
    pub kind: String,
    pub system: String,
    pub runtime: String,
    /// How far its times can be trusted.
    pub trust: record::Trust,
    pub nominal_hz: f64,
    /// The rate measured over warm-up frames; none when nothing is measured.
    pub measured_hz: Option<f64>,
    pub interval_sd_ms: Option<f64>,
    /// Pixels per eye.
    pub width_px: u32,
    pub height_px: u32,
    /// Half angles of each eye's view to the left, right, up and down, degrees.
    pub fov_deg: Option<[[f64; 4]; 2]>,
    pub ipd_m: Option<f64>,
    /// Angular size of a pixel, arc seconds.
    pub arcsec_per_px: f64,
    /// Whether it can say where the head is: see [`Display::take_poses`].
    pub tracks_head: bool,
    pub device: Option<record::Device>,
}

impl DisplayInfo {
    /// Whether the compositor shows only every second frame, or fewer. Such a display cannot run a study.
    pub fn is_at_reduced_rate(&self) -> bool {
        self.measured_hz.is_some_and(|measured| self.nominal_hz / measured >= 1.5)
    }
}

/// Where a head was when a frame was displayed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeadPose {
    /// Time of the frame on the session's clock, nanoseconds.
    pub t_ns: u64,
    /// Position to the right, up and backward, metres, in the display's own space.
    pub position: [f32; 3],
    /// Unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
}

/// A stimulus whose files were checked. Its position in the slice is its index in the plan.
#[derive(Debug, Clone, PartialEq)]
pub struct StimulusFiles {
    /// The linear, multi-view EXR file.
    pub exr: PathBuf,
    /// PNG files of display values, the left and the right eye's side by side: one for a still, one for each frame of a
    /// moving stimulus; at least one.
    pub frames: Vec<PathBuf>,
    /// Horizontal field of view per eye that it was rendered with, degrees; none where it is not known.
    pub fov_deg: Option<f64>,
}

impl StimulusFiles {
    /// The still, or the first frame; empty where there is none.
    pub fn first(&self) -> &Path {
        self.frames.first().map_or(Path::new(""), PathBuf::as_path)
    }
}

/// A display failed. The session's journal is whole, and the session can be resumed.
#[derive(Debug, thiserror::Error)]
#[error("the {display} display failed: {what}")]
pub struct DisplayError {
    pub display: &'static str,
    pub what: String,
}

/// See the module's documentation.
pub trait Display {
    fn info(&self) -> &DisplayInfo;

    /// Loads every stimulus, so that showing one is only a change of layer. It is called once, before trial 1.
    ///
    /// # Errors
    /// A file cannot be read, or does not fit the device.
    fn load(&mut self, stimuli: &[StimulusFiles]) -> Result<(), DisplayError>;

    /// Waits for the next event. After a frame, the session calls [`Display::present`] for it. A display that can skip
    /// time skips at most `idle_frames` frames in one [`Event::Frames`].
    ///
    /// # Errors
    /// The display is gone, or it waits for an observer who does not answer.
    fn wait(&mut self, idle_frames: u64) -> Result<TimedEvent, DisplayError>;

    /// Draws the screen for the frame that [`Display::wait`] announced. It stays the same until the next call.
    ///
    /// # Errors
    /// The display is gone.
    fn present(&mut self, screen: &Screen) -> Result<(), DisplayError>;

    /// The poses of the head since the last call, oldest first, on the session's clock. They are asked for only where
    /// the study keeps head poses. A display whose information says that it tracks no head returns none.
    fn take_poses(&mut self) -> Vec<HeadPose> {
        Vec::new()
    }
}
