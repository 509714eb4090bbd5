//! Turns a study's texts, plan and stereograms into the `Content` that a display shows. `cyclopean run` calls it before
//! a session.

use std::collections::BTreeMap;

use cyclopean_analysis::journal::record::{Kind, Purpose};

use super::definition::{EyeName, Layout, Task};
use super::language::{Language, LanguageError};
use super::plan::Plan;
use super::protocol::{Input, Page, Setup};
use super::questionnaire::Form;
use super::stereogram::Stereogram;
use super::validate::Study;
use crate::display::content::{Blank, Content, Dots, ItemText, PageText, Presentation};

/// Angular size of a stereogram, degrees; larger where the largest disparity needs it.
const STEREOGRAM_DEG: f64 = 7.0;

/// Everything that a display can be asked to show in a session of this plan. Sessions whose `kind` is not real are
/// marked.
///
/// # Errors
/// The study's language cannot be used.
pub fn content(study: &Study, plan: &Plan, setup: &Setup, kind: Kind) -> Result<Content, LanguageError> {
    let definition = &study.definition;
    let language = Language::of(study)?;
    let words = &language.words;
    Ok(Content {
        pages: pages(study, &language),
        items: items(setup, &language),
        dots: dots(study, plan, setup),
        question: definition.question.clone(),
        choices: definition.labels.clone(),
        presentations: presentations(plan),
        is_mirrored_pair: definition.layout == Layout::MirroredPair,
        geometry: definition.geometry,
        has_letters: definition.task == Task::Compare,
        blank: Blank { grey: definition.blank.grey, fixation: definition.blank.fixation },
        stimulus_px: [definition.stimuli.width_px, definition.stimuli.height_px],
        stimulus_fov_deg: definition.stimuli.horizontal_fov_deg,
        quad_deg: definition.stimuli.quad_deg,
        pause_seconds: definition.panel.pause_seconds,
        mark: match kind {
            Kind::Real => None,
            Kind::Pilot => Some(words.pilot.clone()),
            Kind::Simulated => Some(words.simulated.clone()),
        },
        font: language.font()?,
        words: language.words,
    })
}

fn pages(study: &Study, language: &Language) -> BTreeMap<Page, PageText> {
    let (definition, words) = (&study.definition, &language.words);
    let page = |title: &str, body: &str, button: &str| PageText {
        title: title.to_owned(),
        body: body.to_owned(),
        small: None,
        buttons: vec![(button.to_owned(), Input::Continue)],
    };
    let text = |page_of: Page| match page_of {
        Page::Consent => {
            let consent = definition.consent.as_ref();
            let mut text = page(&words.consent_title, consent.map_or("", |c| &c.text), &words.agree);
            text.small = consent.map(|c| {
                let purpose = c.purpose.trim_end_matches('.');
                words.consent_small.replace("{purpose}", purpose).replace("{until}", &c.retain_until)
            });
            text.buttons.push((words.disagree.clone(), Input::Decline));
            text
        }
        Page::Instructions => page(&words.instructions_title, &definition.instructions, &words.go_on),
        Page::Ready => page(&words.ready_title, &words.ready, &words.begin),
        Page::Break => page(&words.break_title, &words.break_text, &words.go_on),
        Page::Paused => page(&words.paused_title, &words.paused, &words.go_on),
        Page::WelcomeBack => page(&words.welcome_back_title, &words.welcome_back, &words.go_on),
        Page::Thanks => page(&words.thanks_title, &words.thanks, &words.finish),
    };
    Page::ALL.iter().map(|&p| (p, text(p))).collect()
}

fn items(setup: &Setup, language: &Language) -> Vec<ItemText> {
    let of = |questionnaire: &str| setup.items.iter().filter(|i| i.questionnaire == questionnaire).count();
    let mut at = BTreeMap::new();
    let mut texts = Vec::new();
    for item in &setup.items {
        let number = at.entry(item.questionnaire).or_insert(0);
        *number += 1;
        let lead = Form::of_phase(item.questionnaire).map_or("", |form| (form.lead)(language));
        texts.push(ItemText {
            lead: lead.to_owned(),
            question: language.item(item.name, item.question).to_owned(),
            options: item.options.iter().map(|option| language.option(item.name, option)).collect(),
            progress: (*number, of(item.questionnaire)),
        });
    }
    texts
}

fn dots(study: &Study, plan: &Plan, setup: &Setup) -> Vec<Dots> {
    let largest = setup.screening.iter().map(|trial| trial.disparity_px as usize).max().unwrap_or(0);
    let one = |(index, trial): (usize, &super::protocol::ScreeningTrial)| {
        let fit = (STEREOGRAM_DEG * 3600.0 / trial.arcsec_per_px) as usize;
        let size = fit.max(16 * largest).max(64).next_multiple_of(16);
        let made = Stereogram::new(study.definition.seed, plan.order.row, index, trial, size);
        Dots { size, eyes: [made.left, made.right] }
    };
    setup.screening.iter().enumerate().map(one).collect()
}

/// Catch trials are counted like trials, so that the participant cannot tell them apart.
fn presentations(plan: &Plan) -> Vec<Presentation> {
    let counts = |purpose: Purpose| purpose != Purpose::Practice;
    let of = plan.presentations.iter().filter(|p| counts(p.purpose)).count();
    let mut at = 0;
    plan.presentations
        .iter()
        .map(|planned| {
            at += usize::from(counts(planned.purpose));
            let factors = plan.conditions.get(planned.condition as usize).map(|c| &c.factors);
            let is_right = factors.and_then(|f| f.get("eye")).is_some_and(|eye| eye.as_str() == EyeName::Right.name());
            Presentation { progress: counts(planned.purpose).then_some((at, of)), eye: usize::from(is_right) }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use cyclopean_analysis::journal::record::Trust;

    use super::*;
    use crate::study::validate;

    #[test]
    fn no_page_names_a_method_and_every_screen_has_its_words() {
        for name in ["consistency", "quality", "ablation", "recommended", "motion"] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("studies/{name}.json"));
            let study = validate::load(&path).unwrap();
            let plan = Plan::draw(&study.definition, 3);
            let setup = Setup::new(&study.definition, &plan, 60.0, Trust::Predicted, 60.0);
            let content = content(&study, &plan, &setup, Kind::Pilot).unwrap();
            assert_eq!(content.items.len(), setup.items.len());
            assert_eq!(content.dots.len(), setup.screening.len());
            assert_eq!(content.choices.len() as u32, setup.choices);
            assert_eq!(content.presentations.len(), plan.presentations.len());
            let (at, of) = content.presentations.last().unwrap().progress.unwrap();
            assert_eq!(at, of);
            let shown = format!("{:?} {:?} {:?}", content.pages, content.question, content.choices).to_lowercase();
            for method in ["sssr", "path-traced", "path traced", "no-traversal", "no-fade", "no-reprojection"] {
                assert!(!shown.contains(method), "{name}: {method}");
            }
        }
    }
}
