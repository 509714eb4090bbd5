//! What each [`Screen`] says in words and pictures. `study::content` makes it once, before a session; a display shows
//! it and knows nothing else of the study. No method's name is in it.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::study::protocol::{Input, Page, Screen};

/// Everything that a display can be asked to show, in the study's language.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Content {
    pub words: Words,
    pub pages: BTreeMap<Page, PageText>,
    /// Items of questionnaires, by the index in `Screen::Item`.
    pub items: Vec<ItemText>,
    /// Stereograms, by the index in `Screen::Dots`.
    pub dots: Vec<Dots>,
    /// The question on the panel.
    pub question: String,
    /// The words of the panel's choices, in order.
    pub choices: Vec<String>,
    /// What a display must know of each presentation, by its number.
    pub presentations: Vec<Presentation>,
    /// Whether both eyes see one flat picture: the reference, and the test image mirrored about its vertical axis.
    pub is_mirrored_pair: bool,
    pub geometry: Geometry,
    /// Whether stimuli are called A and B, by a letter below them.
    pub has_letters: bool,
    pub blank: Blank,
    /// Width and height of each eye's image of a stimulus, pixels.
    pub stimulus_px: [u32; 2],
    /// Horizontal field of view that the stimuli were rendered with, degrees; none: each view has its own.
    pub stimulus_fov_deg: Option<f64>,
    /// Largest width of a stimulus on a flat display or quad, degrees.
    pub quad_deg: f64,
    /// Seconds from the opening of the panel to the session's pause.
    pub pause_seconds: f64,
    /// A word that is shown, with a frame, on everything in a pilot or simulated session. None in a real one.
    pub mark: Option<String>,
    /// A font file for letters that the built-in fonts lack.
    pub font: Option<Vec<u8>>,
}

/// How stimuli are placed when the head moves. On a flat display all of these are the same.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Geometry {
    /// One flat picture for each eye, fixed in the room where the participant looked when the view was centred.
    #[default]
    World,
    /// The same pictures, fixed to the head.
    HeadLocked,
    /// A projection layer, rendered from where the head was when the view was centred. It turns with the room, as the
    /// scene itself would.
    Projection,
}

/// A page of text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageText {
    pub title: String,
    pub body: String,
    /// Small text below the body.
    pub small: Option<String>,
    /// The buttons, each with its input; the one that goes on comes first.
    pub buttons: Vec<(String, Input)>,
}

/// One item of a questionnaire.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ItemText {
    /// Small text above the question: what is asked in general.
    pub lead: String,
    pub question: String,
    pub options: Vec<String>,
    /// Number of the item, from 1, and number of all items.
    pub progress: (usize, usize),
}

/// A random-dot stereogram: both eyes' images of black (0) and white (255) dots, rows from the top. A dot is a display
/// pixel.
#[derive(Clone, PartialEq, Eq)]
pub struct Dots {
    /// Number of dots along a side.
    pub size: usize,
    /// The left and the right eye's image.
    pub eyes: [Vec<u8>; 2],
}

impl std::fmt::Debug for Dots {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Dots {{ {0} × {0} }}", self.size)
    }
}

/// What a display must know of a presentation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Presentation {
    /// Number of the presentation, from 1, among those that are counted for the participant, and number of all of
    /// these; none: practice.
    pub progress: Option<(usize, usize)>,
    /// For a mirrored pair: 0 shows the left eye's images, 1 the right eye's.
    pub eye: usize,
}

/// The blank frame, whose grey is also the background of every page.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Blank {
    /// Displayed value (not linear), 0 black ..= 1 white.
    pub grey: f64,
    /// Whether it shows a fixation cross at screen depth.
    pub fixation: bool,
}

impl Blank {
    /// The grey as a byte, 0 to 255.
    pub fn byte(&self) -> u8 {
        (self.grey * 255.0).round() as u8
    }

    /// The linear value of that byte (IEC 61966-2-1).
    pub fn linear(&self) -> f32 {
        let v = f32::from(self.byte()) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    }
}

/// Sentences and buttons of this program, from `languages/*.json`. `{…}` is a place that is filled in.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Words {
    pub agree: String,
    pub disagree: String,
    pub go_on: String,
    pub begin: String,
    pub finish: String,
    pub confirm: String,
    pub rather_not_say: String,
    pub consent_title: String,
    /// With `{purpose}` and `{until}`.
    pub consent_small: String,
    pub instructions_title: String,
    pub ready_title: String,
    pub ready: String,
    pub break_title: String,
    pub break_text: String,
    pub paused_title: String,
    pub paused: String,
    pub welcome_back_title: String,
    pub welcome_back: String,
    pub thanks_title: String,
    pub thanks: String,
    /// Text above the questions about the person.
    pub person_lead: String,
    /// Text above the symptoms.
    pub ssq_lead: String,
    pub dots: String,
    pub practice: String,
    /// With `{at}` and `{of}`.
    pub progress: String,
    pub reminder: String,
    /// With `{seconds}`.
    pub time_left: String,
    pub pilot: String,
    pub simulated: String,
}

impl Words {
    /// Fills in a text such as `7 of 27`.
    pub fn progress((at, of): (usize, usize), text: &str) -> String {
        text.replace("{at}", &at.to_string()).replace("{of}", &of.to_string())
    }
}

impl Content {
    /// Content of nothing but stereograms, in English, for the test of a display.
    pub fn of_dots(dots: Vec<Dots>) -> Content {
        Content {
            words: Words {
                dots: "One square floats in front. Press its number.".to_owned(),
                progress: "{at} of {of}".to_owned(),
                ..Words::default()
            },
            dots,
            blank: Blank { grey: 0.5, fixation: true },
            quad_deg: 70.0,
            ..Content::default()
        }
    }

    /// Seconds until the session pauses, in steps of five, for a panel that shows its reminder. `open_s`: seconds since
    /// the panel opened.
    pub fn time_left_s(&self, open_s: f64) -> u32 {
        let left = (self.pause_seconds - open_s).max(0.0);
        (5.0 * (left / 5.0).ceil()) as u32
    }

    /// How many alternatives can be chosen on this screen.
    pub fn choices_of(&self, screen: &Screen) -> usize {
        match screen {
            Screen::Item(at) => self.items.get(*at).map_or(0, |item| item.options.len()),
            Screen::Dots(_) => 4,
            Screen::Panel { .. } => self.choices.len(),
            Screen::Page(_) | Screen::Stimulus { .. } | Screen::Blank => 0,
        }
    }
}
