//! The fixed data of a session, with all durations in frames; computed from a study, a plan and a display's nominal
//! rate.

use cyclopean_analysis::journal::record::{Film, Planned, Question, Shown, Trust};

use crate::study::definition::{Definition, Layout, Validity};
use crate::study::plan::Plan;
use crate::study::questionnaire::{FORMS, ItemText};
use crate::study::random::Stream;

use super::Page;

/// Trials at each disparity of the screening.
const TRIALS_A_DISPARITY: u32 = 10;
/// Right answers with which a disparity is passed; guessing reaches them with probability 0.0035.
pub const SCREENING_PASS: u32 = 7;

/// One stage of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    Page(Page),
    /// Items of one questionnaire: a range of [`Setup::items`].
    Items {
        name: &'static str,
        from: usize,
        to: usize,
    },
    Screening,
    Presentations,
}

impl Stage {
    /// The journal's name for the stage.
    pub fn phase(self) -> &'static str {
        match self {
            Stage::Page(page) => page.phase(),
            Stage::Items { name, .. } => name,
            Stage::Screening => "screening",
            Stage::Presentations => "trials",
        }
    }
}

/// One question that is not about a stimulus.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Item {
    pub questionnaire: &'static str,
    pub name: &'static str,
    pub question: &'static str,
    pub options: &'static [&'static str],
}

/// One trial of the screening: a forced choice among four places.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreeningTrial {
    /// The disparity as it is shown, in whole pixels.
    pub disparity_arcsec: f64,
    pub disparity_px: u32,
    pub arcsec_per_px: f64,
    pub trial: u32,
    /// The place of the square, 0 ..= 3.
    pub shown: u32,
    /// Whether this is the disparity that must be passed.
    pub required: bool,
}

/// A segment, with its duration in frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Segment {
    pub show: Shown,
    pub frames: u64,
}

/// Everything that the machine needs to know. Nothing of it changes during a session.
#[derive(Debug, Clone)]
pub struct Setup {
    pub stages: Vec<Stage>,
    pub items: Vec<Item>,
    pub screening: Vec<ScreeningTrial>,
    pub presentations: Vec<Planned>,
    /// For each stimulus its frames, if it moves. Stimuli beyond the end of the list are stills.
    pub films: Vec<Option<Film>>,
    pub segments: Vec<Segment>,
    /// Whether the first stimulus of each presentation is the reference.
    pub has_reference: bool,
    pub blank_frames: u64,
    pub reminder_frames: u64,
    pub pause_frames: u64,
    /// Time between two breaks; 0: there are no breaks.
    pub break_ns: u64,
    pub choices: u32,
    pub validity: Validity,
    pub nominal_hz: f64,
    pub trust: Trust,
}

impl Setup {
    /// `arcsec_per_px`: angular size of a display pixel, for the screening.
    pub fn new(definition: &Definition, plan: &Plan, nominal_hz: f64, trust: Trust, arcsec_per_px: f64) -> Setup {
        let frames = |seconds: f64| (seconds * nominal_hz).round() as u64;
        let question: Question = definition.journal_question();
        let asked = || FORMS.iter().filter(|form| definition.questionnaires.contains(&form.which));
        let mut stages = Vec::new();
        let mut items = Vec::new();
        if definition.consent.is_some() {
            stages.push(Stage::Page(Page::Consent));
        }
        for (form, phase) in asked().filter_map(|form| Some((form, form.before?))) {
            push_items(&mut stages, &mut items, phase, form.items);
        }
        let screening = screening(definition, plan, arcsec_per_px);
        if !screening.is_empty() {
            stages.push(Stage::Screening);
        }
        stages.extend([Stage::Page(Page::Instructions), Stage::Presentations]);
        for (form, phase) in asked().filter_map(|form| Some((form, form.after?))) {
            push_items(&mut stages, &mut items, phase, form.items);
        }
        stages.push(Stage::Page(Page::Thanks));
        Setup {
            stages,
            items,
            screening,
            presentations: plan.presentations.clone(),
            films: Vec::new(),
            segments: definition
                .protocol
                .iter()
                .map(|s| Segment { show: s.show, frames: frames(s.seconds).max(1) })
                .collect(),
            has_reference: definition.layout == Layout::MirroredPair,
            blank_frames: frames(definition.blank.seconds),
            reminder_frames: frames(definition.panel.reminder_seconds).max(1),
            pause_frames: frames(definition.panel.pause_seconds).max(1),
            break_ns: (definition.breaks.every_minutes * 60e9) as u64,
            choices: question.choices(),
            validity: definition.validity,
            nominal_hz,
            trust,
        }
    }

    /// Duration of a nominal frame, nanoseconds.
    pub fn period_ns(&self) -> f64 {
        1e9 / self.nominal_hz
    }

    /// Index of a segment's stimulus, and of the reference beside it; none for a blank segment.
    pub fn stimulus(&self, presentation: u32, show: Shown) -> Option<(u32, Option<u32>)> {
        let stimuli = &self.presentations.get(presentation as usize)?.stimuli;
        let base = usize::from(self.has_reference);
        let at = match show {
            Shown::Stimulus | Shown::A => base,
            Shown::B => base + 1,
            Shown::Blank => return None,
        };
        Some((*stimuli.get(at)?, self.has_reference.then(|| stimuli[0])))
    }

    /// The frames of a segment's stimulus, if it moves.
    pub fn film_of(&self, presentation: u32, show: Shown) -> Option<Film> {
        let (stimulus, _) = self.stimulus(presentation, show)?;
        self.films.get(stimulus as usize).copied().flatten()
    }

    /// The frame of a film that is due this many nominal display periods after the first frame.
    pub fn film_frame(&self, film: Film, periods: u64) -> u32 {
        // A film at the display's own rate changes with every period; the small term keeps rounding from preventing
        // that.
        let due = (periods as f64 * film.rate_hz / self.nominal_hz + 1e-6).floor();
        due.min(f64::from(film.frames.max(1) - 1)) as u32
    }
}

fn push_items(stages: &mut Vec<Stage>, items: &mut Vec<Item>, name: &'static str, source: &[ItemText]) {
    let from = items.len();
    items.extend(source.iter().map(|&(item, question, options)| Item {
        questionnaire: name,
        name: item,
        question,
        options,
    }));
    stages.push(Stage::Items { name, from, to: items.len() });
}

fn screening(definition: &Definition, plan: &Plan, arcsec_per_px: f64) -> Vec<ScreeningTrial> {
    let Some(screening) = &definition.screening else { return Vec::new() };
    let mut stream = Stream::new(definition.seed, plan.order.row, "screening");
    let mut trials = Vec::new();
    for &asked in &screening.disparities_arcsec {
        let disparity_px = (asked / arcsec_per_px).round().max(1.0) as u32;
        for trial in 0..TRIALS_A_DISPARITY {
            trials.push(ScreeningTrial {
                disparity_arcsec: f64::from(disparity_px) * arcsec_per_px,
                disparity_px,
                arcsec_per_px,
                trial,
                shown: stream.below(4) as u32,
                required: asked == screening.required_arcsec,
            });
        }
    }
    trials
}
