//! What the tests of every display have alike: the questions, and what was found.

use serde::Serialize;

use crate::console::Console;
use crate::display::content::{Content, Dots};
use crate::display::intervals::Intervals;
use crate::study::protocol::ScreeningTrial;
use crate::study::stereogram::Stereogram;

/// Frames between two changes of the flickering square.
pub const FLICKER: u64 = 30;
/// Linear value of the background, display value 128.
pub const GROUND: f32 = 0.21586;
/// Number of stereograms that the viewer is asked about.
const STEREOGRAMS: u32 = 4;
/// Number of dots along a side of a stereogram.
const DOTS: usize = 256;

/// What a test found.
#[derive(Debug, Serialize)]
pub struct DisplayTestResult {
    pub display: String,
    /// Where the times of display come from.
    pub timing: String,
    pub intervals: Option<Intervals>,
    /// Whether each eye saw its own picture; none: nobody was asked, or the mode shows only one eye's picture.
    pub eyes_right: Option<bool>,
    /// Squares that were found in stereograms, and the number of stereograms; guessing finds a quarter.
    pub depth_right: Option<(u32, u32)>,
}

/// What the operator reads while the participant is asked which word an eye sees.
pub const WHICH_WORD: &str = "question: which word does the open eye see?";

/// Asks for squares that only two eyes together can see, four dots in front. `ask` shows a stereogram of the content by
/// its index and gives the quarter (0 to 3) that was answered. Gives the right answers and the number of questions.
///
/// # Errors
/// What `ask` says.
pub fn ask_depth(
    console: &Console,
    mut ask: impl FnMut(&Content, usize) -> anyhow::Result<u32>,
) -> anyhow::Result<(u32, u32)> {
    let trial = |trial: u32| ScreeningTrial {
        disparity_arcsec: 0.0,
        disparity_px: 4,
        arcsec_per_px: 1.0,
        trial,
        shown: [2, 1, 3, 0][trial as usize % 4],
        required: false,
    };
    let trials: Vec<ScreeningTrial> = (0..STEREOGRAMS).map(trial).collect();
    let dots = |(i, trial): (usize, &ScreeningTrial)| {
        let made = Stereogram::new(1, 0, i, trial, DOTS);
        Dots { size: made.size, eyes: [made.left, made.right] }
    };
    let content = Content::of_dots(trials.iter().enumerate().map(dots).collect());
    let mut right = 0;
    for (at, trial) in trials.iter().enumerate() {
        let (number, count) = (at + 1, trials.len());
        console.note(format!("question: in which quarter of stereogram {number} of {count} does a square float?"));
        right += u32::from(ask(&content, at)? == trial.shown);
    }
    Ok((right, STEREOGRAMS))
}
