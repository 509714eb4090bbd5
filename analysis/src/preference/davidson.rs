//! Davidson's extension of the Bradley–Terry model to ties.
//!
//! P(a wins) = π_a/D, P(tie) = ν√(π_a π_b)/D, D = π_a + π_b + ν√(π_a π_b) (Davidson 1970). A prior N(0, 2²) on each
//! log-strength keeps it finite where votes are unanimous; ν has no prior.

use serde::Serialize;

use super::Votes;
use crate::chance::Stream;

/// Votes between two methods, by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Duel {
    /// Index of the method that `wins` counts for.
    pub a: usize,
    /// Index of the other.
    pub b: usize,
    /// The votes.
    pub votes: Votes,
}

/// A method's strength.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Strength {
    /// The method.
    pub name: String,
    /// Log-strength; the mean over all methods is 0.
    pub log_strength: f64,
    /// Lower end of the bootstrap interval over participants.
    pub lo: Option<f64>,
    /// Upper end.
    pub hi: Option<f64>,
}

/// The fitted model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Davidson {
    /// Methods, strongest first.
    pub strengths: Vec<Strength>,
    /// The tie parameter ν; 0 without ties.
    pub nu: f64,
    /// For exactly two methods, without a prior: wins/losses and ν; null where undefined.
    pub two_methods: Option<(Option<f64>, Option<f64>)>,
    /// The prior, the interval and its level, in words.
    pub convention: String,
}

/// Standard deviation of the prior on a log-strength.
const PRIOR_SD: f64 = 2.0;

/// Maximum likelihood for two methods: strength ratio n₁/n₂ and ν = n_t/√(n₁n₂); `None` where a side has no win.
///
/// ```
/// use cyclopean_analysis::preference::{Votes, two_methods};
/// let (ratio, nu) = two_methods(Votes { wins: 17, ties: 8, losses: 5 });
/// assert_eq!(ratio, Some(3.4));
/// assert!((nu.unwrap() - 0.8677).abs() < 5e-5);
/// ```
pub fn two_methods(votes: Votes) -> (Option<f64>, Option<f64>) {
    let (w, l, t) = (votes.wins as f64, votes.losses as f64, votes.ties as f64);
    ((votes.losses > 0).then(|| w / l), (votes.wins * votes.losses > 0).then(|| t / (w * l).sqrt()))
}

/// Fits all duels; intervals from `resamples` bootstraps over the participants in `people`.
pub fn davidson(
    names: &[String],
    duels: &[Duel],
    people: &[Vec<Duel>],
    level: f64,
    resamples: u32,
    stream: &mut Stream,
) -> Davidson {
    let merged = merge(duels.iter());
    let (strengths, nu) = fit(names.len(), &merged);
    let mut draws: Vec<Vec<f64>> = vec![Vec::with_capacity(resamples as usize); names.len()];
    if people.len() > 1 {
        for _ in 0..resamples {
            let chosen: Vec<usize> = (0..people.len()).map(|_| stream.index(people.len() as u32) as usize).collect();
            let (s, _) = fit(names.len(), &merge(chosen.iter().flat_map(|p| &people[*p])));
            draws.iter_mut().zip(s).for_each(|(d, s)| d.push(s));
        }
    }
    let tail = 0.5 * (1.0 - level);
    let mut out: Vec<Strength> = names
        .iter()
        .zip(strengths)
        .zip(&mut draws)
        .map(|((name, log_strength), d)| {
            d.sort_unstable_by(f64::total_cmp);
            let at = |p: f64| (!d.is_empty()).then(|| d[(((d.len() + 1) as f64 * p) as usize).clamp(1, d.len()) - 1]);
            Strength { name: name.clone(), log_strength, lo: at(tail), hi: at(1.0 - tail) }
        })
        .collect();
    out.sort_by(|a, b| b.log_strength.total_cmp(&a.log_strength));
    let two = (names.len() == 2).then(|| {
        let votes = merged.iter().fold(Votes::default(), |mut v, d| {
            let (wins, losses) = if d.a == 0 { (d.votes.wins, d.votes.losses) } else { (d.votes.losses, d.votes.wins) };
            v.wins += wins;
            v.losses += losses;
            v.ties += d.votes.ties;
            v
        });
        two_methods(votes)
    });
    Davidson {
        strengths: out,
        nu,
        two_methods: two,
        convention: format!(
            "Davidson (1970); prior N(0, 2^2) on log-strengths, their mean set to 0; {} percentile bootstrap over \
             {} participants, B = {resamples}",
            crate::wilcoxon::percent(level),
            people.len()
        ),
    }
}

fn merge<'a>(duels: impl Iterator<Item = &'a Duel>) -> Vec<Duel> {
    let mut out: Vec<Duel> = Vec::new();
    for d in duels {
        match out.iter_mut().find(|o| (o.a, o.b) == (d.a, d.b)) {
            Some(o) => {
                o.votes.wins += d.votes.wins;
                o.votes.ties += d.votes.ties;
                o.votes.losses += d.votes.losses;
            }
            None => out.push(*d),
        }
    }
    out
}

/// Posterior mode by Newton's steps with halving; the log-posterior is concave in (log π, log ν).
fn fit(methods: usize, duels: &[Duel]) -> (Vec<f64>, f64) {
    let ties: u64 = duels.iter().map(|d| d.votes.ties).sum();
    // Without ties log ν goes to −∞, so the parameter is left out.
    let size = methods + usize::from(ties > 0);
    let mut x = vec![0.0; size];
    let mut value = objective(methods, duels, &x);
    for _ in 0..100 {
        let (gradient, mut hessian) = derivatives(methods, duels, &x);
        let step = solve(&mut hessian, gradient);
        let mut scale = 1.0;
        let moved = loop {
            let next: Vec<f64> = x.iter().zip(&step).map(|(x, s)| x + scale * s).collect();
            let there = objective(methods, duels, &next);
            if there >= value || scale < 1e-6 {
                value = there;
                break next;
            }
            scale *= 0.5;
        };
        let change: f64 = x.iter().zip(&moved).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        x = moved;
        if change < 1e-12 {
            break;
        }
    }
    let nu = if ties > 0 { x[methods].exp() } else { 0.0 };
    let mean = x[..methods].iter().sum::<f64>() / methods as f64;
    (x[..methods].iter().map(|v| v - mean).collect(), nu)
}

/// Log-weights of win, tie and loss.
fn weights(methods: usize, d: &Duel, x: &[f64]) -> [f64; 3] {
    let nu = x.get(methods).copied().unwrap_or(f64::NEG_INFINITY);
    [x[d.a], nu + 0.5 * (x[d.a] + x[d.b]), x[d.b]]
}

fn shares(w: [f64; 3]) -> ([f64; 3], f64) {
    let top = w.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let e = w.map(|v| (v - top).exp());
    let total: f64 = e.iter().sum();
    (e.map(|v| v / total), top + total.ln())
}

fn objective(methods: usize, duels: &[Duel], x: &[f64]) -> f64 {
    let prior: f64 = x[..methods].iter().map(|v| -0.5 * (v / PRIOR_SD).powi(2)).sum();
    let likelihood: f64 = duels
        .iter()
        .map(|d| {
            let w = weights(methods, d, x);
            let (_, norm) = shares(w);
            let counts = [d.votes.wins, d.votes.ties, d.votes.losses].map(|v| v as f64);
            (0..3).filter(|i| counts[*i] > 0.0).map(|i| counts[i] * (w[i] - norm)).sum::<f64>()
        })
        .sum();
    prior + likelihood
}

/// Gradient, and the negated Hessian (positive definite by the prior, singular in ν only without ties).
fn derivatives(methods: usize, duels: &[Duel], x: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let size = x.len();
    let mut g = vec![0.0; size];
    let mut h = vec![vec![0.0; size]; size];
    for i in 0..methods {
        g[i] -= x[i] / (PRIOR_SD * PRIOR_SD);
        h[i][i] += 1.0 / (PRIOR_SD * PRIOR_SD);
    }
    for d in duels {
        let (p, _) = shares(weights(methods, d, x));
        let n = d.votes.total() as f64;
        let counts = [d.votes.wins, d.votes.ties, d.votes.losses].map(|v| v as f64);
        // Each outcome's log-weight is linear in the parameters: its coefficients for a, b, ν.
        let coefficients = [[1.0, 0.0, 0.0], [0.5, 0.5, 1.0], [0.0, 1.0, 0.0]];
        let places = [Some(d.a), Some(d.b), (size > methods).then_some(methods)];
        let mean: [f64; 3] = std::array::from_fn(|c| (0..3).map(|o| p[o] * coefficients[o][c]).sum());
        for (c, at) in places.iter().enumerate() {
            let Some(at) = at else { continue };
            g[*at] += (0..3).map(|o| counts[o] * (coefficients[o][c] - mean[c])).sum::<f64>();
            for (c2, at2) in places.iter().enumerate() {
                let Some(at2) = at2 else { continue };
                let covariance: f64 =
                    (0..3).map(|o| p[o] * (coefficients[o][c] - mean[c]) * (coefficients[o][c2] - mean[c2])).sum();
                h[*at][*at2] += n * covariance;
            }
        }
    }
    for (i, row) in h.iter_mut().enumerate().skip(methods) {
        // A little damping for votes that are all ties, for which ν is infinite.
        row[i] += 1e-9;
    }
    (g, h)
}

/// Solves h·x = g by elimination with pivots; the systems have a handful of rows.
fn solve(h: &mut [Vec<f64>], mut g: Vec<f64>) -> Vec<f64> {
    let n = g.len();
    for c in 0..n {
        let pivot = (c..n).max_by(|a, b| h[*a][c].abs().total_cmp(&h[*b][c].abs())).unwrap_or(c);
        h.swap(c, pivot);
        g.swap(c, pivot);
        if h[c][c] == 0.0 {
            continue;
        }
        for r in c + 1..n {
            let f = h[r][c] / h[c][c];
            let (above, below) = h.split_at_mut(r);
            below[0].iter_mut().zip(&above[c]).skip(c).for_each(|(x, pivot)| *x -= f * pivot);
            g[r] -= f * g[c];
        }
    }
    for c in (0..n).rev() {
        for k in c + 1..n {
            g[c] -= h[c][k] * g[k];
        }
        g[c] = if h[c][c] == 0.0 { 0.0 } else { g[c] / h[c][c] };
    }
    // Far from the mode a full step may run away in ν; the halving in `fit` needs a finite start.
    g.iter().map(|v| v.clamp(-5.0, 5.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn duel(a: usize, b: usize, wins: u64, ties: u64, losses: u64) -> Duel {
        Duel { a, b, votes: Votes { wins, ties, losses } }
    }

    #[test]
    fn many_votes_approach_the_closed_form() {
        let (s, nu) = fit(2, &[duel(0, 1, 17_000, 8_000, 5_000)]);
        assert!(((s[0] - s[1]).exp() - 3.4).abs() < 0.01 && (nu - 0.8677).abs() < 1e-3, "{s:?} {nu}");
    }

    #[test]
    fn unanimity_stays_finite_and_order_is_kept() {
        let (s, nu) = fit(3, &[duel(0, 1, 10, 0, 0), duel(1, 2, 10, 0, 0), duel(0, 2, 10, 0, 0)]);
        assert!(s[0] > s[1] && s[1] > s[2] && s[0].is_finite() && nu == 0.0);
        // By symmetry the middle method has the middle strength.
        assert!(s[1].abs() < 1e-9 && (s[0] + s[2]).abs() < 1e-9);
        let (s, nu) = fit(2, &[duel(0, 1, 0, 10, 0)]);
        assert!(s[0].abs() < 1e-9 && nu > 1.0 && nu.is_finite());
    }
}
