//! Simulated observers who judge on a latent Thurstone scale.

use serde::Serialize;

use crate::chance::Stream;
use crate::data::{Builder, Dataset, Response, Score};
use crate::error::{Error, Result};

/// Scenes and repetitions of every method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Design {
    /// Scenes.
    pub scenes: u32,
    /// Showings of every condition.
    pub repetitions: u32,
}

impl Design {
    pub(super) fn check(self) -> Result<()> {
        if (1..=100).contains(&self.scenes) && (1..=60).contains(&self.repetitions) {
            Ok(())
        } else {
            Err(Error::usage("scenes are 1 to 100 and repetitions 1 to 60"))
        }
    }
}

/// How simulated people answer; every standard deviation is in scale steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Observer {
    /// Latent quality half-way between the methods.
    pub base: f64,
    /// Latent difference a − b.
    pub effect: f64,
    /// SD, between persons, of a bias that is the same for all conditions.
    pub bias: f64,
    /// SD, between persons, of the opinion of each method.
    pub person_method: f64,
    /// SD of a single answer.
    pub noise: f64,
    /// Share of answers given at random.
    pub lapse: f64,
    /// Steps of the scale, 1..=points.
    pub points: u32,
}

impl Default for Observer {
    fn default() -> Self {
        Self { base: 3.0, effect: 0.75, bias: 0.5, person_method: 0.4, noise: 0.7, lapse: 0.02, points: 5 }
    }
}

impl Observer {
    pub(super) fn check(&self) -> Result<()> {
        let sds = [self.bias, self.person_method, self.noise];
        let finite = [self.base, self.effect].iter().all(|v| v.is_finite() && v.abs() < 1e6);
        if finite
            && sds.iter().all(|v| (0.0..1e6).contains(v))
            && (0.0..=1.0).contains(&self.lapse)
            && (2..=101).contains(&self.points)
        {
            Ok(())
        } else {
            Err(Error::usage(
                "an observer needs finite base and effect, standard deviations from 0, a lapse rate of 0 to 1 and 2 to 101 points",
            ))
        }
    }

    /// One answer to a stimulus of latent quality `latent`.
    fn answer(&self, latent: f64, stream: &mut Stream) -> i32 {
        let noise = self.noise * stream.normal();
        if stream.unit() < self.lapse {
            return stream.index(self.points) as i32 + 1;
        }
        (latent + noise).round().clamp(1.0, f64::from(self.points)) as i32
    }
}

/// One study of `n` people with methods `a` and `b`; the same seed and study give the same answers.
///
/// # Errors
/// None for values that [`super::power`] accepts.
pub fn simulate(n: u32, design: Design, observer: &Observer, seed: u64, study: u64) -> Result<Dataset> {
    let mut stream = Stream::new(seed, study);
    let mut builder = Builder::default();
    let scenes: Vec<String> = (0..design.scenes).map(|s| format!("scene{s:02}")).collect();
    for person in 0..n {
        let id = format!("p{person:04}");
        let bias = observer.bias * stream.normal();
        for (method, sign) in [("a", 0.5), ("b", -0.5)] {
            let own = observer.person_method * stream.normal();
            for scene in &scenes {
                for repetition in 0..design.repetitions {
                    let latent = observer.base + sign * observer.effect + bias + own;
                    let response = Response {
                        participant: &id,
                        study: "",
                        kind: None,
                        factors: &[("scene", scene), ("method", method)],
                        repetition: Some(repetition),
                        rating: Score::whole(observer.answer(latent, &mut stream)),
                    };
                    builder.add(&response).map_err(Error::Data)?;
                }
            }
        }
    }
    Ok(builder.finish())
}
