//! `mos power`.

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::Error;
use cyclopean_analysis::power::{Design, Observer, Plan, Rate, power, rejection_of_votes};
use cyclopean_analysis::report::text;
use serde_json::json;

use super::input::{print, print_json};

/// `mos power`
#[derive(Args)]
pub struct Power {
    /// Numbers of participants to try
    #[arg(long, value_delimiter = ',', default_values_t = [6, 8, 10, 12, 15, 20, 24, 30])]
    n: Vec<u32>,
    /// Latent difference between the methods, in scale steps
    #[arg(long, default_value_t = 0.75, allow_hyphen_values = true)]
    effect: f64,
    /// Latent quality half-way between the methods, in scale steps
    #[arg(long, default_value_t = 3.0)]
    base: f64,
    /// Standard deviation of the observers' biases, in scale steps
    #[arg(long, default_value_t = 0.5)]
    bias: f64,
    /// Standard deviation between observers in their opinion of each method, in scale steps
    #[arg(long, default_value_t = 0.4)]
    person_method: f64,
    /// Standard deviation of a single answer, in scale steps
    #[arg(long, default_value_t = 0.7)]
    noise: f64,
    /// Share of answers that are given at random
    #[arg(long, default_value_t = 0.02)]
    lapse: f64,
    /// Number of steps of the scale
    #[arg(long, default_value_t = 5)]
    points: u32,
    /// Number of scenes
    #[arg(long, default_value_t = 3)]
    scenes: u32,
    /// How often every condition is shown
    #[arg(long, default_value_t = 1)]
    repetitions: u32,
    /// Significance level of the test
    #[arg(long, default_value_t = 0.05)]
    alpha: f64,
    /// Also compute the power of showing equivalence within this margin, in scale steps
    #[arg(long)]
    equivalence: Option<f64>,
    /// Number of simulated studies for each number of participants
    #[arg(long, default_value_t = 2_000)]
    studies: u32,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Instead of simulating, compute the exact rejection rate for independent votes with these shares of the ratings
    /// 1, 2, …
    #[arg(long, value_delimiter = ',', requires = "votes_b")]
    votes_a: Vec<f64>,
    /// The shares of the ratings for the other method
    #[arg(long, value_delimiter = ',', requires = "votes_a")]
    votes_b: Vec<f64>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl Power {
    /// Simulates and prints.
    pub fn run(self) -> Result<()> {
        if !self.votes_a.is_empty() {
            return self.shapes();
        }
        let observer = Observer {
            base: self.base,
            effect: self.effect,
            bias: self.bias,
            person_method: self.person_method,
            noise: self.noise,
            lapse: self.lapse,
            points: self.points,
        };
        let plan = Plan {
            participants: self.n.clone(),
            design: Design { scenes: self.scenes, repetitions: self.repetitions },
            observer: observer.clone(),
            alpha: self.alpha,
            margin: self.equivalence,
            studies: self.studies,
            seed: self.seed,
        };
        if let Some(m) = self.equivalence
            && !(m > 0.0 && m.is_finite())
        {
            return Err(Error::usage(format!("margin {m} must be above 0 scale steps, for example 0.5")).into());
        }
        let points = power(&plan)?;
        if self.json {
            return print_json(&json!({
                "points": points, "observer": observer, "design": plan.design, "alpha": plan.alpha,
                "margin": plan.margin, "studies": plan.studies, "seed": plan.seed,
            }));
        }
        let mut rows = vec![
            [
                "n",
                "power exact",
                "mid-p",
                "asymptotic",
                "size exact",
                "mid-p",
                "asymptotic",
                "equivalence",
                "observed effect",
            ]
            .map(str::to_owned)
            .to_vec(),
        ];
        let rate = |r: Rate| format!("{:.3} ±{:.3}", r.rate, r.se);
        for p in &points {
            let mut row = vec![p.n.to_string()];
            row.extend([p.power, p.power_mid, p.power_asymptotic, p.size, p.size_mid, p.size_asymptotic].map(rate));
            row.push(p.equivalence.map_or_else(|| "-".into(), rate));
            row.push(format!("{:.3}", p.observed_effect));
            rows.push(row);
        }
        print(&format!(
            "{}\nsimulated observers through the analysis of real sessions; rate ±Monte Carlo standard error; {} studies a \
             number, seed {}, alpha {}, {} scenes x {} repetitions\nequivalence: margin {}, true difference 0\n",
            text::align(&rows),
            self.studies,
            self.seed,
            self.alpha,
            self.scenes,
            self.repetitions,
            self.equivalence.map_or_else(|| "none given".into(), |m| m.to_string())
        ))
    }

    fn shapes(&self) -> Result<()> {
        let rates = self
            .n
            .iter()
            .map(|n| Ok((*n, rejection_of_votes(&self.votes_a, &self.votes_b, *n, self.alpha)?)))
            .collect::<Result<Vec<_>, Error>>()?;
        if self.json {
            let points: Vec<_> = rates.iter().map(|(n, r)| json!({ "n": n, "rejection": r })).collect();
            return print_json(&json!({ "points": points, "alpha": self.alpha }));
        }
        let mut rows = vec![["n", "exact", "mid-p", "asymptotic"].map(str::to_owned).to_vec()];
        for (n, r) in &rates {
            rows.push(vec![
                n.to_string(),
                format!("{:.4}", r.exact),
                format!("{:.4}", r.mid),
                format!("{:.4}", r.asymptotic),
            ]);
        }
        let means = rates.first().map(|r| (r.1.mean_a, r.1.mean_b)).unwrap_or_default();
        print(&format!(
            "{}exact rejection rates, all samples enumerated; means {:.3} and {:.3}\nthe null of the test is symmetry of the \
             differences, not equal means\n",
            text::align(&rows),
            means.0,
            means.1
        ))
    }
}
