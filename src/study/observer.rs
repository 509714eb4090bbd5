//! The simulated observers that answer headless sessions, through the same inputs as a person.

use std::collections::BTreeMap;

use cyclopean_analysis::journal::record::{Planned, Question, Side};

use super::definition::{Definition, Simulation};
use super::plan::Plan;
use super::protocol::{Input, Screen, ScreeningTrial};
use super::random::Stream;
use super::stimulus::split_method;

/// Sees each new screen once. Answers with inputs, each with its nanoseconds after the one before.
pub trait Observer {
    fn respond(&mut self, screen: &Screen) -> Vec<(u64, Input)>;
}

/// A study does not say how a simulated observer judges.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ObserverError {
    #[error("simulation: is missing; simulated observers need it (`latent`, `noise_sd`, …)")]
    NoSimulation,
    #[error(
        "simulation.latent: has no value for method `{0}`, and its stimuli carry no measured inconsistency to derive \
         one from; add it, or `from_inconsistency`"
    )]
    NoLatent(String),
}

/// Judges by latent quality + bias + noise. Every draw depends only on (study seed, participant, presentation), so that
/// a resumed session gets the same answers as an uninterrupted one.
#[derive(Debug, Clone)]
pub struct SimulatedObserver {
    seed: u64,
    participant: String,
    question: Question,
    simulation: Simulation,
    planned: Vec<Planned>,
    screening: Vec<ScreeningTrial>,
    bias: f64,
    /// For each condition: perceived quality of `method`, and of `other` where there is one.
    quality: Vec<(f64, Option<f64>)>,
}

impl SimulatedObserver {
    /// `inconsistency` holds the measured values, by the plan's index of the stimulus.
    ///
    /// # Errors
    /// [`ObserverError`]: the study file does not say enough.
    pub fn new(
        definition: &Definition,
        plan: &Plan,
        screening: &[ScreeningTrial],
        participant: &str,
        inconsistency: &[Option<f64>],
    ) -> Result<SimulatedObserver, ObserverError> {
        let simulation = definition.simulation.clone().ok_or(ObserverError::NoSimulation)?;
        let seed = definition.seed;
        let mut person = Stream::new(seed, 0, &format!("observer {participant}"));
        let bias = simulation.bias_sd * person.normal();
        let mut leaning: BTreeMap<String, f64> = BTreeMap::new();
        let mut of = |factors: &BTreeMap<String, String>, key: &str| -> Result<Option<f64>, ObserverError> {
            let Some(method) = factors.get(key) else { return Ok(None) };
            let measured = || {
                let at = plan.stimuli.iter().position(|s| {
                    Some(&s.scene) == factors.get("scene")
                        && s.view.as_ref() == factors.get("view")
                        && s.path.as_ref() == factors.get("path")
                        && s.method == split_method(method).0
                })?;
                let rule = simulation.from_inconsistency?;
                Some(rule.at_zero + rule.slope * inconsistency.get(at).copied().flatten()?)
            };
            let latent = simulation.latent.get(method).or_else(|| simulation.latent.get(split_method(method).0));
            let latent = latent.copied().or_else(measured).ok_or_else(|| ObserverError::NoLatent(method.clone()))?;
            let scene = factors.get("scene").and_then(|s| simulation.scene.get(s)).copied().unwrap_or(0.0);
            let leaning = leaning.entry(method.clone()).or_insert_with(|| {
                simulation.method_sd * Stream::new(seed, 0, &format!("observer {participant} method {method}")).normal()
            });
            Ok(Some(latent + scene + *leaning))
        };
        let quality = plan
            .conditions
            .iter()
            .map(|c| Ok((of(&c.factors, "method")?.unwrap_or(0.0), of(&c.factors, "other")?)))
            .collect::<Result<_, ObserverError>>()?;
        Ok(SimulatedObserver {
            seed,
            participant: participant.to_owned(),
            question: definition.journal_question(),
            simulation,
            planned: plan.presentations.clone(),
            screening: screening.to_vec(),
            bias,
            quality,
        })
    }

    /// The choice that this observer will confirm.
    pub fn choice(&self, presentation: u32) -> u32 {
        self.judge(presentation).0
    }

    /// The final choice, the first choice (which may differ), and the response time in nanoseconds.
    fn judge(&self, presentation: u32) -> (u32, u32, u64) {
        let mut stream =
            Stream::new(self.seed, u64::from(presentation), &format!("observer {} answer", self.participant));
        let s = &self.simulation;
        let seconds = s.response_seconds * (0.4 * stream.normal()).exp();
        let lapses = stream.unit() < s.lapse;
        let at_random = stream.below(u64::from(self.question.choices().max(1))) as u32;
        let noise = stream.normal();
        let hesitates = stream.unit() < 0.1;
        let choice = match (lapses, self.planned.get(presentation as usize)) {
            (false, Some(planned)) => self.choose(planned, noise),
            _ => at_random,
        };
        (choice, if hesitates { at_random } else { choice }, (seconds * 1e9) as u64)
    }

    fn choose(&self, planned: &Planned, noise: f64) -> u32 {
        let (method, other) = self.quality[planned.condition as usize];
        let s = &self.simulation;
        match (&self.question, other) {
            (Question::Compare { .. }, Some(other)) => {
                // These are two judgements, each with its noise; a bias of the scale cancels.
                let difference = method - other + std::f64::consts::SQRT_2 * s.noise_sd * noise;
                let better = if difference > 0.0 { Side::Method } else { Side::Other };
                match difference.abs() < s.threshold {
                    true => 1,
                    false if planned.a_is == Some(better) => 0,
                    false => 2,
                }
            }
            (Question::Rate { options }, _) => {
                let felt = method + self.bias + s.noise_sd * noise;
                let distance = |i: &usize| (f64::from(options[*i].value) - felt).abs();
                (0..options.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0) as u32
            }
            (Question::Compare { .. }, None) => 1,
        }
    }
}

const SECOND_NS: u64 = 1_000_000_000;

impl Observer for SimulatedObserver {
    fn respond(&mut self, screen: &Screen) -> Vec<(u64, Input)> {
        match screen {
            Screen::Page(_) => vec![(SECOND_NS, Input::Continue)],
            Screen::Item(at) => {
                let choice =
                    Stream::new(self.seed, *at as u64, &format!("observer {} item", self.participant)).below(2);
                vec![(SECOND_NS, Input::Choose(choice as u32))]
            }
            // A simulated observer sees depth: it chooses the alternative that stands out.
            Screen::Dots(at) => {
                vec![(SECOND_NS, Input::Choose(self.screening.get(*at).map_or(0, |trial| trial.shown)))]
            }
            Screen::Stimulus { .. } | Screen::Blank => Vec::new(),
            Screen::Panel { presentation, chosen, .. } => {
                let (choice, first, delay_ns) = self.judge(*presentation);
                match chosen {
                    None => vec![(delay_ns, Input::Choose(first))],
                    Some(chosen) if *chosen == choice => vec![(SECOND_NS / 2, Input::Confirm)],
                    Some(_) => vec![(SECOND_NS, Input::Choose(choice))],
                }
            }
        }
    }
}
