//! Bias and inconsistency of observers by alternating projection (ITU-T P.910, Annex E).

use serde::Serialize;

/// Choices of the estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct P910Options {
    /// Smallest inconsistency used for a weight. `None` reproduces the reference implementation, in which one observer
    /// takes nearly all the weight when there are few stimuli. The default, step/√12, is the rounding error of a
    /// rating.
    pub floor: Option<f64>,
}

impl Default for P910Options {
    /// The floor of a scale with steps of one: 1/√12.
    fn default() -> Self {
        Self { floor: Some(1.0 / 12f64.sqrt()) }
    }
}

/// The estimate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct P910 {
    /// Quality ψ of every stimulus, in scale steps.
    pub quality: Vec<f64>,
    /// Standard error of the bias-corrected votes of every stimulus, σ with n.
    pub standard_error: Vec<f64>,
    /// Bias b of every observer; their mean is 0.
    pub bias: Vec<f64>,
    /// Inconsistency σ of every observer, as estimated, before any floor.
    pub inconsistency: Vec<f64>,
    /// Largest share of the weight that one observer has.
    pub largest_weight: f64,
    /// Index of that observer.
    pub heaviest: usize,
    /// Rounds until ‖Δψ‖₂ < 1e-8, at most 1000.
    pub rounds: u32,
    /// Remarks that a reader of these numbers needs.
    pub notes: Vec<String>,
}

const EPSILON: f64 = 1e-8;
const CHANGE: f64 = 1e-8;
const ROUNDS: u32 = 1000;

fn mean(x: impl Iterator<Item = f64>) -> f64 {
    let (n, s) = x.fold((0.0, 0.0), |(n, s), v| (n + 1.0, s + v));
    s / n
}

/// Subtracts each observer's bias (mean deviation from the mean opinion scores) from the votes; returns the votes and
/// the biases.
pub fn remove_bias(votes: &[Vec<Option<f64>>]) -> (Vec<Vec<Option<f64>>>, Vec<f64>) {
    let observers = votes.first().map_or(0, Vec::len);
    let psi: Vec<f64> = votes.iter().map(|r| mean(r.iter().flatten().copied())).collect();
    let bias = biases(votes, &psi, observers);
    let removed = votes.iter().map(|r| r.iter().zip(&bias).map(|(v, b)| v.map(|v| v - b)).collect()).collect();
    (removed, bias)
}

fn biases(votes: &[Vec<Option<f64>>], psi: &[f64], observers: usize) -> Vec<f64> {
    (0..observers).map(|i| mean(votes.iter().zip(psi).filter_map(|(r, p)| r[i].map(|v| v - p)))).collect()
}

/// Estimates from `votes` (stimuli × observers; every row and column has a vote).
///
/// It starts with ψ_j = mean_i u_ij and b_i = mean_j(u_ij − ψ_j). Until ψ stays the same it repeats: σ_i from the
/// residuals (divided by n), w_i = 1/(max(σ_i, floor)² + 1e-8), ψ_j = Σ w_i(u_ij − b_i)/Σ w_i, b_i as before. In the
/// end the mean bias is moved into ψ.
pub fn p910(votes: &[Vec<Option<f64>>], options: P910Options) -> P910 {
    let observers = votes.first().map_or(0, Vec::len);
    let mut psi: Vec<f64> = votes.iter().map(|r| mean(r.iter().flatten().copied())).collect();
    let mut bias = biases(votes, &psi, observers);
    let residuals = |psi: &[f64], bias: &[f64], i: usize| -> Vec<f64> {
        votes.iter().zip(psi).filter_map(|(r, p)| r[i].map(|v| v - p - bias[i])).collect()
    };
    let spread = |r: Vec<f64>| {
        let m = mean(r.iter().copied());
        mean(r.iter().map(|v| (v - m).powi(2))).sqrt()
    };
    let mut rounds = 0;
    let mut sigma: Vec<f64>;
    let mut weights: Vec<f64>;
    loop {
        sigma = (0..observers).map(|i| spread(residuals(&psi, &bias, i))).collect();
        weights = sigma.iter().map(|s| 1.0 / (s.max(options.floor.unwrap_or(0.0)).powi(2) + EPSILON)).collect();
        let next: Vec<f64> = votes
            .iter()
            .map(|r| {
                let present = || r.iter().enumerate().filter_map(|(i, v)| v.map(|v| (i, v)));
                let total: f64 = present().map(|(i, _)| weights[i]).sum();
                present().map(|(i, v)| weights[i] * (v - bias[i])).sum::<f64>() / total
            })
            .collect();
        let change = psi.iter().zip(&next).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        psi = next;
        bias = biases(votes, &psi, observers);
        rounds += 1;
        if change < CHANGE || rounds >= ROUNDS {
            break;
        }
    }
    let shift = mean(bias.iter().copied());
    psi.iter_mut().for_each(|p| *p += shift);
    bias.iter_mut().for_each(|b| *b -= shift);
    let standard_error = votes
        .iter()
        .map(|r| {
            let corrected: Vec<f64> = r.iter().zip(&bias).filter_map(|(v, b)| v.map(|v| v - b)).collect();
            let n = corrected.len() as f64;
            spread(corrected) / n.sqrt()
        })
        .collect();
    let total: f64 = weights.iter().sum();
    let heaviest = (0..observers).max_by(|a, b| weights[*a].total_cmp(&weights[*b])).unwrap_or(0);
    let largest_weight = weights.get(heaviest).map_or(f64::NAN, |w| w / total);
    let mut notes = Vec::new();
    if largest_weight > 0.5 {
        notes.push(format!(
            "one observer has {:.0} % of the weight: the estimate has locked on",
            100.0 * largest_weight
        ));
    }
    if votes.len() < 20 {
        notes.push(format!("{} stimuli are fewer than 20: inconsistencies are poorly known", votes.len()));
    }
    P910 { quality: psi, standard_error, bias, inconsistency: sigma, largest_weight, heaviest, rounds, notes }
}
