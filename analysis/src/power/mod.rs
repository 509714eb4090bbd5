//! Planning of studies: simulated observers' votes are analysed by the code that analyses real sessions.

mod coverage;
mod observer;
mod size;

use serde::Serialize;

pub use coverage::{Coverage, VoteShape, coverage, shapes};
pub use observer::{Design, Observer, simulate};
pub use size::{Rejection, rejection_of_votes};

use crate::contrast::pairs;
use crate::equivalence::equivalence;
use crate::error::{Error, Result};
use crate::wilcoxon::{Options, signed_rank};

/// A rate from repeated simulation, with its Monte Carlo standard error √(r(1−r)/N).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// Share of studies.
    pub rate: f64,
    /// Its standard error.
    pub se: f64,
}

impl Rate {
    /// The rate of `k` in `n`.
    pub fn of(k: u32, n: u32) -> Self {
        let rate = f64::from(k) / f64::from(n);
        Self { rate, se: (rate * (1.0 - rate) / f64::from(n)).sqrt() }
    }
}

/// A planned study.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Numbers of participants to try.
    pub participants: Vec<u32>,
    /// Scenes and repetitions.
    pub design: Design,
    /// How the observers answer.
    pub observer: Observer,
    /// Level of the two-sided test.
    pub alpha: f64,
    /// Equivalence margin in scale steps, tested on pairs without a true difference.
    pub margin: Option<f64>,
    /// Simulated studies for each number of participants.
    pub studies: u32,
    /// Seed.
    pub seed: u64,
}

/// Rates for one number of participants.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Participants.
    pub n: u32,
    /// Rate of rejections with the effect, by the exact test.
    pub power: Rate,
    /// The same by exact mid-p.
    pub power_mid: Rate,
    /// The same by the asymptotic test.
    pub power_asymptotic: Rate,
    /// Rate of rejections without an effect, by the exact test.
    pub size: Rate,
    /// The same by exact mid-p.
    pub size_mid: Rate,
    /// The same by the asymptotic test.
    pub size_asymptotic: Rate,
    /// How often equivalence is shown without an effect; `None` without a margin.
    pub equivalence: Option<Rate>,
    /// Mean observed difference with the effect, in scale steps; the ends of the scale make it smaller than the latent
    /// one.
    pub observed_effect: f64,
}

/// Simulates every number of participants in `plan`.
///
/// # Errors
/// [`Error::Usage`] for a plan outside its ranges.
pub fn power(plan: &Plan) -> Result<Vec<Point>> {
    plan.check()?;
    plan.participants.iter().map(|n| point(plan, *n)).collect()
}

impl Plan {
    fn check(&self) -> Result<()> {
        let bad = |what: &str| Err(Error::usage(what.to_owned()));
        if self.participants.is_empty() || self.participants.iter().any(|n| !(2..=1000).contains(n)) {
            return bad("numbers of participants are 2 to 1000");
        }
        if self.studies < 10 || self.studies > 1_000_000 {
            return bad("studies are 10 to 1000000");
        }
        if !(self.alpha > 0.0 && self.alpha < 0.5) {
            return bad("alpha is between 0 and 0.5, for example 0.05");
        }
        self.observer.check()?;
        self.design.check()
    }
}

fn point(plan: &Plan, n: u32) -> Result<Point> {
    let mut rejected = [[0u32; 3]; 2];
    let (mut equivalent, mut observed) = (0, 0.0);
    for study in 0..plan.studies {
        for (with, effect) in [(0, plan.observer.effect), (1, 0.0)] {
            let observer = Observer { effect, ..plan.observer.clone() };
            let data = simulate(n, plan.design, &observer, plan.seed, 2 * u64::from(study) + with as u64)?;
            let pairs = pairs(&data, &data.cells_of(0), "method", "a", "b")?;
            let test = signed_rank(&pairs.sums(), &Options::default())?;
            for (count, p) in rejected[with].iter_mut().zip([test.p_exact, test.p_mid, test.p_asymptotic]) {
                *count += u32::from(p.is_some_and(|p| p <= plan.alpha));
            }
            if with == 0 {
                observed += pairs.steps().iter().sum::<f64>() / f64::from(n);
            } else if let Some(margin) = plan.margin {
                equivalent += u32::from(equivalence(&pairs, margin, plan.alpha)?.equivalent);
            }
        }
    }
    let rate = |k| Rate::of(k, plan.studies);
    Ok(Point {
        n,
        power: rate(rejected[0][0]),
        power_mid: rate(rejected[0][1]),
        power_asymptotic: rate(rejected[0][2]),
        size: rate(rejected[1][0]),
        size_mid: rate(rejected[1][1]),
        size_asymptotic: rate(rejected[1][2]),
        equivalence: plan.margin.map(|_| rate(equivalent)),
        observed_effect: observed / f64::from(plan.studies),
    })
}
