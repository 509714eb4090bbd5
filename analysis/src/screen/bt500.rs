//! Rejection of observers by ITU-R BT.500, with an error of the published code corrected.
//!
//! The published code counts a unanimous stimulus (σ = 0) as both high and low for everyone. With that it rejected 9 of
//! 15 ordinary observers, and in another case all 14 good ones, while it kept one who always answered 5. Here stimuli
//! with σ = 0 are skipped.

use serde::Serialize;

/// The divisor of the standard deviation per stimulus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
pub enum Sigma {
    /// Divided by n, as sureal computes it.
    #[value(name = "n")]
    #[serde(rename = "n")]
    #[default]
    Population,
    /// Divided by n − 1, as in the ITU's text.
    #[value(name = "n-1")]
    #[serde(rename = "n-1")]
    Sample,
}

/// One observer's counts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Observer {
    /// Votes at or above mean + limit.
    pub high: u32,
    /// Votes at or below mean − limit.
    pub low: u32,
    /// Votes given, unanimous stimuli included.
    pub votes: u32,
    /// (P + Q)/N: the share of votes that are `high` (P) or `low` (Q).
    pub share: f64,
    /// |P − Q|/(P + Q); `None` without outlying votes.
    pub imbalance: Option<f64>,
    /// share > 0.05 and imbalance < 0.3.
    pub rejected: bool,
}

/// The whole screening.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bt500 {
    /// One entry an observer, in the order of the columns.
    pub observers: Vec<Observer>,
    /// Stimuli skipped because all votes are equal.
    pub unanimous: usize,
    /// Remarks that a reader of these numbers needs.
    pub notes: Vec<String>,
}

/// Screens `votes` (stimuli × observers).
///
/// Each stimulus has μ, σ and the kurtosis β₂ = m₄/m₂²; the limit is 2σ where 2 ≤ β₂ ≤ 4, else √20·σ.
pub fn bt500(votes: &[Vec<Option<f64>>], sigma: Sigma) -> Bt500 {
    let observers = votes.first().map_or(0, Vec::len);
    let (mut high, mut low, mut given) = (vec![0; observers], vec![0; observers], vec![0; observers]);
    let (mut unanimous, mut most) = (0, 0);
    for row in votes {
        let present: Vec<f64> = row.iter().flatten().copied().collect();
        most = most.max(present.len());
        row.iter().enumerate().filter(|(_, v)| v.is_some()).for_each(|(i, _)| given[i] += 1);
        let n = present.len() as f64;
        let mean = present.iter().sum::<f64>() / n;
        let moment = |k: i32| present.iter().map(|v| (v - mean).powi(k)).sum::<f64>() / n;
        let (m2, m4) = (moment(2), moment(4));
        if present.iter().all(|v| *v == present[0]) {
            unanimous += usize::from(!present.is_empty());
            continue;
        }
        let variance = match sigma {
            Sigma::Population => m2,
            Sigma::Sample => m2 * n / (n - 1.0),
        };
        let kurtosis = m4 / (m2 * m2);
        let factor = if (2.0..=4.0).contains(&kurtosis) { 2.0 } else { 20f64.sqrt() };
        let limit = factor * variance.sqrt();
        for (i, vote) in row.iter().enumerate() {
            if let Some(v) = vote {
                high[i] += u32::from(*v >= mean + limit);
                low[i] += u32::from(*v <= mean - limit);
            }
        }
    }
    let observers = (0..observers)
        .map(|i| {
            let outlying = high[i] + low[i];
            let share = f64::from(outlying) / f64::from(given[i]);
            let imbalance = (outlying > 0).then(|| f64::from(high[i].abs_diff(low[i])) / f64::from(outlying));
            Observer {
                high: high[i],
                low: low[i],
                votes: given[i],
                share,
                imbalance,
                rejected: share > 0.05 && imbalance.is_some_and(|b| b < 0.3),
            }
        })
        .collect();
    let mut notes = vec![
        "a random responder is flagged in only 13-18 % of simulations: catch trials find them, this does not".into(),
    ];
    if unanimous > 0 {
        notes.push(format!(
            "{unanimous} unanimous stimuli are skipped (the published code counts them against everyone)"
        ));
    }
    if most <= 20 {
        notes.push(format!(
            "with {most} votes a stimulus the limit of sqrt(20) sigma cannot be reached (it needs more than 20)"
        ));
    }
    Bt500 { observers, unanimous, notes }
}
