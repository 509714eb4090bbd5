//! Forced choices with three answers: A is better, no difference is perceptible, B is better.
//!
//! Single votes coded −1/0/+1 form one tie group, so their signed-rank test is the sign test. Each condition therefore
//! gets exact binomial tests. All conditions together are tested on the participants' summed votes: a binomial test of
//! everyone's votes would pool people (its size is 22 % with strong person effects).

mod davidson;

use serde::Serialize;

pub use davidson::{Davidson, Duel, Strength, davidson, two_methods};

use crate::adjust::{Correction, adjust};
use crate::chance::Stream;
use crate::data::{Dataset, Score, UNIT, level_key};
use crate::error::{Error, Result};
use crate::interval::share;
use crate::special::{ln_choose, sum};
use crate::wilcoxon::{Options, SignedRank, signed_rank};

/// Votes of one condition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Votes {
    /// Votes for the method.
    pub wins: u64,
    /// Votes for "imperceptible".
    pub ties: u64,
    /// Votes for the other.
    pub losses: u64,
}

impl Votes {
    /// The number of all votes.
    pub fn total(self) -> u64 {
        self.wins + self.ties + self.losses
    }
}

/// An exact binomial test against one half, with the Clopper–Pearson interval of the share.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Binomial {
    /// Successes.
    pub k: u64,
    /// Trials.
    pub n: u64,
    /// Two-sided p, twice the smaller tail; `None` without trials.
    pub p: Option<f64>,
    /// k/n.
    pub share: Option<f64>,
    /// Lower end.
    pub lo: Option<f64>,
    /// Upper end.
    pub hi: Option<f64>,
}

/// One condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Condition {
    /// Study id.
    pub study: String,
    /// Factors and levels.
    pub factors: Vec<(String, String)>,
    /// The votes.
    pub votes: Votes,
    /// Shares of wins, ties, losses.
    pub shares: [f64; 3],
    /// Mean on the study's scale (the paper: 1 other, 2 imperceptible, 3 method).
    pub mos: f64,
    /// The test of the decided votes: wins against losses.
    pub decided: Binomial,
    /// The p-value of the decided votes, adjusted over the study's conditions by Holm.
    pub p_adjusted: Option<f64>,
    /// The test with ties split evenly between the two sides; an odd tie is dropped.
    pub split: Binomial,
}

/// One study's choices.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Preference {
    /// Study id.
    pub study: String,
    /// Conditions, in order.
    pub conditions: Vec<Condition>,
    /// Signed-rank test of each participant's sum of votes coded −1/0/+1.
    pub overall: SignedRank,
    /// Participants left out of the overall test because they lack a vote.
    pub incomplete: Vec<String>,
    /// Davidson's model; its closed form is in `two_methods` where there are just two.
    pub davidson: Davidson,
    /// How the numbers were made.
    pub convention: String,
}

/// P(X ≤ k) of the binomial distribution with probability ½.
fn binomial_lower(k: u64, n: u64) -> f64 {
    let ln_half = -(n as f64) * std::f64::consts::LN_2;
    sum((0..=k).map(|i| (ln_choose(n, i) + ln_half).exp())).min(1.0)
}

/// Exact test of `k` in `n` against one half, and the Clopper–Pearson interval at `level`.
///
/// ```
/// // scipy 1.17.1: binomtest(17, 22).pvalue → 0.01690053939819336
/// let b = cyclopean_analysis::preference::binomial_test(17, 22, 0.95);
/// assert!((b.p.unwrap() / 0.01690053939819336 - 1.0).abs() < 1e-12);
/// ```
pub fn binomial_test(k: u64, n: u64, level: f64) -> Binomial {
    if n == 0 {
        return Binomial { k, n, p: None, share: None, lo: None, hi: None };
    }
    // Small counts are summed exactly in whole numbers; a double holds binomial coefficients of up to 53 bits.
    let near = k.min(n - k);
    let lower = if n <= 50 {
        let mut c = 1u128;
        let mut total = 1u128;
        for i in 0..near {
            c = c * u128::from(n - i) / u128::from(i + 1);
            total += c;
        }
        total as f64 / 2f64.powi(n as i32)
    } else {
        binomial_lower(near, n)
    };
    let (lo, hi) = share(k as f64, n as f64, level, false);
    Binomial { k, n, p: Some((2.0 * lower).min(1.0)), share: Some(k as f64 / n as f64), lo: Some(lo), hi: Some(hi) }
}

/// Analyses every study in `data`, which must have been read with ratings as cells
/// ([`crate::data::Columns::by_rating`]).
///
/// `values` are the ratings of (other, same, method) where the study does not say; the paper's 1, 2, 3.
///
/// # Errors
/// [`Error::Data`] when a rating is none of the three values, or there is no vote.
pub fn preference(data: &Dataset, values: [i32; 3], level: f64, resamples: u32, seed: u64) -> Result<Vec<Preference>> {
    let mut out = Vec::new();
    let rating =
        data.factor("rating").ok_or_else(|| Error::data("forced choices must be read with ratings as cells"))?;
    for (s, study) in data.studies.iter().enumerate() {
        let cells = data.cells_of(s);
        // A study that states that it asks for ratings holds no choices.
        if cells.is_empty() || (!study.scale.is_empty() && !study.forced_choice) {
            continue;
        }
        let values = match &study.scale[..] {
            [a, b, c] if study.forced_choice => [a.0, b.0, c.0],
            _ => values,
        };
        out.push(one(data, s, &cells, rating, values, level, resamples, seed)?);
    }
    if out.is_empty() {
        return Err(Error::data("no study here asks for a forced choice; `mos table` and `mos test` analyse ratings"));
    }
    Ok(out)
}

/// The cells of a condition: one for each of the three ratings, with equal levels of all other factors.
struct Group {
    levels: Vec<Option<String>>,
    /// The cells of losses, ties and wins.
    cells: [Option<usize>; 3],
}

#[expect(clippy::too_many_arguments, reason = "one study's share of the public function's arguments")]
fn one(
    data: &Dataset,
    study: usize,
    cells: &[usize],
    rating: usize,
    values: [i32; 3],
    level: f64,
    resamples: u32,
    seed: u64,
) -> Result<Preference> {
    let mut groups: Vec<Group> = Vec::new();
    for c in cells {
        let mut levels = data.cells[*c].levels.clone();
        let text = levels[rating].take().unwrap_or_default();
        let score = Score::parse(text.as_bytes()).map_err(Error::Data)?;
        let which = values.iter().position(|v| i64::from(*v) * UNIT == score.0).ok_or_else(|| {
            Error::data(format!(
                "rating {score} of {} is none of {} (other better), {} (imperceptible), {} (method better); \
                 give the three with --values",
                data.describe(*c),
                values[0],
                values[1],
                values[2]
            ))
        })?;
        let at = match groups.iter().position(|g| g.levels == levels) {
            Some(at) => at,
            None => {
                groups.push(Group { levels, cells: [None; 3] });
                groups.len() - 1
            }
        };
        groups[at].cells[which] = Some(*c);
    }
    let mut conditions: Vec<Condition> = groups.iter().map(|g| condition(data, study, g, values, level)).collect();
    conditions.sort_by_cached_key(|c| c.factors.iter().map(|f| level_key(&f.1)).collect::<Vec<_>>());
    let p: Vec<f64> = conditions.iter().filter_map(|c| c.decided.p).collect();
    let mut adjusted = adjust(&p, Correction::Holm).into_iter();
    conditions.iter_mut().filter(|c| c.decided.p.is_some()).for_each(|c| c.p_adjusted = adjusted.next());
    let (sums, incomplete) = sums(data, &groups);
    if sums.is_empty() {
        return Err(Error::data("no participant has a vote for every condition"));
    }
    Ok(Preference {
        study: data.studies[study].id.clone(),
        conditions,
        overall: signed_rank(&sums, &Options { level, ..Options::default() })?,
        incomplete,
        davidson: duels(data, &groups, level, resamples, seed),
        convention:
            "exact binomial on decided votes (adjusted over conditions by Holm) and with ties split (an odd tie dropped), Clopper-Pearson shares; \
                     overall: signed-rank test of each participant's sum of votes coded -1/0/+1"
                .into(),
    })
}

fn votes_of(data: &Dataset, group: &Group, participant: Option<usize>) -> Votes {
    let count = |i: usize| match (group.cells[i], participant) {
        (None, _) => 0,
        (Some(c), None) => data.cells[c].counts.values().sum(),
        (Some(c), Some(p)) => u64::from(data.participants[p].tally(c).n),
    };
    Votes { losses: count(0), ties: count(1), wins: count(2) }
}

fn condition(data: &Dataset, study: usize, group: &Group, values: [i32; 3], level: f64) -> Condition {
    let votes = votes_of(data, group, None);
    let total = votes.total() as f64;
    let shares = [votes.wins, votes.ties, votes.losses].map(|v| v as f64 / total);
    let weighted = votes.losses as f64 * f64::from(values[0])
        + votes.ties as f64 * f64::from(values[1])
        + votes.wins as f64 * f64::from(values[2]);
    let half = votes.ties / 2;
    Condition {
        study: data.studies[study].id.clone(),
        factors: {
            let named = data.factors.iter().zip(&group.levels);
            let mut factors: Vec<_> = named.filter_map(|(f, l)| l.as_ref().map(|l| (f.clone(), l.clone()))).collect();
            // The scene comes first, as in the tables.
            factors.sort_by_key(|f| f.0 != "scene");
            factors
        },
        votes,
        shares,
        mos: weighted / total,
        decided: binomial_test(votes.wins, votes.wins + votes.losses, level),
        p_adjusted: None,
        split: binomial_test(votes.wins + half, votes.wins + votes.losses + 2 * half, level),
    }
}

/// Each complete participant's wins − losses over all conditions; and the participants who are not complete.
fn sums(data: &Dataset, groups: &[Group]) -> (Vec<f64>, Vec<String>) {
    let all: Vec<Vec<Votes>> =
        (0..data.participants.len()).map(|p| groups.iter().map(|g| votes_of(data, g, Some(p))).collect()).collect();
    let showings: Vec<u64> = (0..groups.len()).map(|g| all.iter().map(|v| v[g].total()).max().unwrap_or(0)).collect();
    let (mut sums, mut incomplete) = (Vec::new(), Vec::new());
    for (p, votes) in all.iter().enumerate() {
        if votes.iter().all(|v| v.total() == 0) {
            continue;
        }
        if votes.iter().zip(&showings).any(|(v, n)| v.total() < *n) {
            incomplete.push(data.participants[p].id.clone());
            continue;
        }
        sums.push(votes.iter().map(|v| v.wins as f64 - v.losses as f64).sum());
    }
    (sums, incomplete)
}

/// Fits Davidson's model to duels of `method` against `other`, where those factors exist.
fn duels(data: &Dataset, groups: &[Group], level: f64, resamples: u32, seed: u64) -> Davidson {
    let side = |g: &Group, factor: &str, default: &str| {
        data.factor(factor).and_then(|f| g.levels[f].clone()).unwrap_or_else(|| default.to_owned())
    };
    let mut names: Vec<String> = Vec::new();
    let mut index = |name: String| match names.iter().position(|n| *n == name) {
        Some(i) => i,
        None => {
            names.push(name);
            names.len() - 1
        }
    };
    let sides: Vec<(usize, usize)> =
        groups.iter().map(|g| (index(side(g, "method", "method")), index(side(g, "other", "other")))).collect();
    let of = |p: Option<usize>| -> Vec<Duel> {
        let duel = |(g, (a, b)): (&Group, &(usize, usize))| Duel { a: *a, b: *b, votes: votes_of(data, g, p) };
        groups.iter().zip(&sides).map(duel).collect()
    };
    let people: Vec<Vec<Duel>> =
        (0..data.participants.len()).map(|p| of(Some(p))).filter(|d| d.iter().any(|d| d.votes.total() > 0)).collect();
    davidson(&names, &of(None), &people, level, resamples, &mut Stream::new(seed, 0))
}
