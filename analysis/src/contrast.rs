//! Two levels of a factor compared, participant by participant.
//!
//! The unit is the participant: a test pairs one score per person and level, the sum of that person's
//! ratings over the other factors and repetitions. The sum is a whole number of millionths, so ties are
//! exact; estimates are divided by the number of votes and stand in scale steps. Trials of one person
//! are never pooled as if they were independent (with person × method effects a pooled test rejects a
//! true null 15 % of the time, this one 4.5 %).

use serde::Serialize;

use crate::adjust::{Correction, adjust};
use crate::data::{Dataset, UNIT, level_key};
use crate::error::{Error, Result};
use crate::journal::plan;
use crate::special::{mean_sd, student_quantile};
use crate::wilcoxon::{Alternative, Exact, Options, SignedRank, Zeros, signed_rank};

/// One comparison a − b.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Contrast {
    /// The factor whose levels are compared.
    pub factor: String,
    /// The level from which `b` is subtracted.
    pub a: String,
    /// The level that is subtracted.
    pub b: String,
    /// The family of the comparison; p-values are adjusted within a family.
    pub family: String,
    /// One test for each level of this factor; such families are exploratory.
    pub per: Option<String>,
}

/// Scores of both levels for the participants who have every cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Pairs {
    /// Participants, in order.
    pub participants: Vec<String>,
    /// a − b of the sums, in millionths of a step.
    pub differences: Vec<i64>,
    /// Votes behind each sum: scenes × repetitions.
    pub votes: u32,
    /// Participants left out, with what they lack.
    pub incomplete: Vec<(String, String)>,
    /// Cells that only one of the levels has.
    pub unmatched: Vec<String>,
}

/// How contrasts are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TestOptions {
    /// The signed-rank test's choices.
    pub test: Options,
    /// How p-values are adjusted within a family.
    pub correction: Correction,
    /// Level of the t interval of the mean paired difference; 0.9 belongs to two one-sided tests at 5 %.
    pub difference_level: f64,
    /// Also test all participant × cell pairs as if independent, "as the paper may have done".
    pub pooled: bool,
}

impl Default for TestOptions {
    fn default() -> Self {
        Self { test: Options::default(), correction: Correction::Holm, difference_level: 0.9, pooled: false }
    }
}

/// The mean paired difference in scale steps, with its t interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Mean of (a − b).
    pub mean: f64,
    /// Standard deviation, n − 1.
    pub sd: Option<f64>,
    /// Lower end.
    pub lo: Option<f64>,
    /// Upper end.
    pub hi: Option<f64>,
    /// Level of the interval.
    pub level: f64,
}

/// A contrast's result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContrastResult {
    /// Study id; empty when the source has none.
    pub study: String,
    /// What is compared.
    #[serde(flatten)]
    pub contrast: Contrast,
    /// The level of `per` that this test is about.
    pub at: Option<String>,
    /// The test on participants' sums; estimates in scale steps.
    #[serde(flatten)]
    pub test: SignedRank,
    /// The exact p-value where it exists, else the asymptotic one, adjusted within the family.
    pub p_adjusted: f64,
    /// The adjustment.
    pub correction: Correction,
    /// Number of tests in the family.
    pub family_size: usize,
    /// The paired difference.
    pub difference: Difference,
    /// Votes behind each participant's sum.
    pub votes_per_sum: u32,
    /// Participants left out, with what they lack.
    pub incomplete: Vec<(String, String)>,
    /// The pooled test on request, labelled.
    pub pooled: Option<Pooled>,
}

/// All participant × cell pairs as if they were independent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pooled {
    /// A label that says that this test is not valid when people differ.
    pub label: &'static str,
    /// The test.
    #[serde(flatten)]
    pub test: SignedRank,
}

/// Pairs the sums of two levels within `cells`.
///
/// # Errors
/// [`Error::Usage`] for an unknown factor or level (the known ones are named), [`Error::Data`] when the
/// levels share no cell.
pub fn pairs(data: &Dataset, cells: &[usize], factor: &str, a: &str, b: &str) -> Result<Pairs> {
    let f = data
        .factor(factor)
        .ok_or_else(|| Error::usage(format!("unknown factor `{factor}`; known: {}", data.factors.join(", "))))?;
    let of = |level: &str| -> Result<Vec<usize>> {
        let found: Vec<usize> =
            cells.iter().copied().filter(|c| data.cells[*c].levels[f].as_deref() == Some(level)).collect();
        if found.is_empty() {
            let known = data.levels(f, cells).join(", ");
            return Err(Error::usage(format!("no answers for {factor} `{level}`; known: {known}")));
        }
        Ok(found)
    };
    let (of_a, of_b) = (of(a)?, of(b)?);
    let others = |c: usize| {
        let mut levels = data.cells[c].levels.clone();
        levels[f] = None;
        levels
    };
    let mut matched = Vec::new();
    let mut unmatched = Vec::new();
    for ca in &of_a {
        match of_b.iter().find(|cb| others(**cb) == others(*ca)) {
            Some(cb) => matched.push((*ca, *cb)),
            None => unmatched.push(data.describe(*ca)),
        }
    }
    unmatched.extend(of_b.iter().filter(|cb| !matched.iter().any(|m| m.1 == **cb)).map(|c| data.describe(*c)));
    if matched.is_empty() {
        return Err(Error::data(format!("{a} and {b} share no cell: nothing can be paired")));
    }
    pair_up(data, &matched, unmatched)
}

fn pair_up(data: &Dataset, matched: &[(usize, usize)], unmatched: Vec<String>) -> Result<Pairs> {
    // A complete participant has as many votes in every cell as the design has showings.
    let showings: Vec<u32> = matched
        .iter()
        .map(|(a, b)| data.participants.iter().map(|p| p.tally(*a).n.max(p.tally(*b).n)).max().unwrap_or(0))
        .collect();
    let mut out = Pairs {
        participants: Vec::new(),
        differences: Vec::new(),
        votes: showings.iter().sum(),
        incomplete: Vec::new(),
        unmatched,
    };
    for p in &data.participants {
        let lacks = matched.iter().zip(&showings).flat_map(|((a, b), n)| {
            [*a, *b].into_iter().filter(|c| p.tally(*c).n < *n).map(|c| (c, *n)).collect::<Vec<_>>()
        });
        let lacks: Vec<(usize, u32)> = lacks.collect();
        if let Some((cell, n)) = lacks.first() {
            let votes: u32 = matched.iter().map(|(a, b)| p.tally(*a).n + p.tally(*b).n).sum();
            if votes > 0 {
                let more = if lacks.len() > 1 { format!(" and {} more cells", lacks.len() - 1) } else { String::new() };
                let what = format!("{} of {n} votes for {}{more}", p.tally(*cell).n, data.describe(*cell));
                out.incomplete.push((p.id.clone(), what));
            }
            continue;
        }
        let sum = |side: fn(&(usize, usize)) -> usize| matched.iter().map(|m| p.tally(side(m)).sum).sum::<i64>();
        out.participants.push(p.id.clone());
        out.differences.push(sum(|m| m.0) - sum(|m| m.1));
    }
    Ok(out)
}

impl Pairs {
    /// Differences of the sums of ratings; they are whole numbers where the ratings are.
    pub fn sums(&self) -> Vec<f64> {
        self.differences.iter().map(|d| *d as f64 / UNIT as f64).collect()
    }

    /// Differences of the mean ratings, in scale steps.
    pub fn steps(&self) -> Vec<f64> {
        self.differences.iter().map(|d| *d as f64 / (UNIT as f64 * f64::from(self.votes))).collect()
    }
}

/// The mean of `steps` with its t interval.
pub fn difference(steps: &[f64], level: f64) -> Difference {
    let (mean, sd) = mean_sd(steps);
    let n = steps.len() as f64;
    let reach = sd.map(|s| student_quantile(0.5 + 0.5 * level, n - 1.0) * s / n.sqrt());
    Difference { mean, sd, lo: reach.map(|r| mean - r), hi: reach.map(|r| mean + r), level }
}

/// Tests contrasts in every study that has both levels, and adjusts p-values within study and family.
///
/// # Errors
/// As [`pairs`]; [`Error::Data`] when no participant is complete, with the names of those who are not.
pub fn test(data: &Dataset, contrasts: &[Contrast], options: &TestOptions) -> Result<Vec<ContrastResult>> {
    let mut results: Vec<ContrastResult> = Vec::new();
    let mut refused = None;
    for (s, study) in data.studies.iter().enumerate() {
        let cells = data.cells_of(s);
        for contrast in contrasts {
            let strata = strata(data, &cells, contrast)?;
            for (at, cells) in strata {
                match one(data, &study.id, contrast, at, &cells, options) {
                    Ok(r) => results.push(r),
                    // Another study may have these levels. It is an error only when no study has them.
                    Err(e @ Error::Usage(_)) if data.studies.len() > 1 || contrast.per.is_some() => {
                        refused.get_or_insert(e);
                    }
                    Err(e) => return Err(e),
                }
            }
        }
    }
    if let (true, Some(e)) = (results.is_empty(), refused) {
        return Err(e);
    }
    adjust_families(&mut results, options.correction);
    Ok(results)
}

/// Tests every study's mean votes against a fixed value: the plan's `against`, or `value` for every study.
///
/// The participant's sum of votes is compared with value × votes; the result's `a` is `vote`, its `b` the
/// value. Studies without a value are passed over.
///
/// # Errors
/// [`Error::Data`] when no participant has every cell.
pub fn against(data: &Dataset, value: Option<i32>, options: &TestOptions) -> Result<Vec<ContrastResult>> {
    let mut results = Vec::new();
    for (s, study) in data.studies.iter().enumerate() {
        let planned = study.plan.as_ref().and_then(|p| p.against);
        let (Some(value), cells) = (value.or(planned), data.cells_of(s)) else { continue };
        let showings: Vec<u32> =
            cells.iter().map(|c| data.participants.iter().map(|p| p.tally(*c).n).max().unwrap_or(0)).collect();
        let votes: u32 = showings.iter().sum();
        let (mut differences, mut incomplete) = (Vec::new(), Vec::new());
        for p in &data.participants {
            let lacks = cells.iter().zip(&showings).find(|(c, n)| p.tally(**c).n < **n);
            let all = p.over(&cells);
            match lacks {
                None => differences.push(all.sum - i64::from(value) * UNIT * i64::from(votes)),
                Some((c, n)) if all.n > 0 => {
                    incomplete
                        .push((p.id.clone(), format!("{} of {n} votes for {}", p.tally(*c).n, data.describe(*c))));
                }
                Some(_) => {}
            }
        }
        let pairs = Pairs { participants: Vec::new(), differences, votes, incomplete, unmatched: Vec::new() };
        if pairs.differences.is_empty() {
            return Err(Error::data(format!("study {}: no participant has every cell", study.id)));
        }
        let mut test = signed_rank(&pairs.sums(), &options.test)?;
        in_steps(&mut test, votes);
        if !pairs.incomplete.is_empty() {
            let who: Vec<&str> = pairs.incomplete.iter().map(|i| i.0.as_str()).collect();
            test.notes.push(format!("participants without every cell are left out of this test: {}", who.join(", ")));
        }
        results.push(ContrastResult {
            study: study.id.clone(),
            contrast: Contrast {
                factor: "rating".into(),
                a: "vote".into(),
                b: value.to_string(),
                family: "against a value".into(),
                per: None,
            },
            at: None,
            p_adjusted: test.p(),
            test,
            correction: options.correction,
            family_size: 1,
            difference: difference(&pairs.steps(), options.difference_level),
            votes_per_sum: votes,
            incomplete: pairs.incomplete,
            pooled: None,
        });
    }
    Ok(results)
}

/// The cells of each level of the contrast's factor `per`; all cells as one group where it names no factor.
fn strata(data: &Dataset, cells: &[usize], contrast: &Contrast) -> Result<Vec<(Option<String>, Vec<usize>)>> {
    let Some(per) = &contrast.per else { return Ok(vec![(None, cells.to_vec())]) };
    let f = data
        .factor(per)
        .ok_or_else(|| Error::usage(format!("unknown factor `{per}`; known: {}", data.factors.join(", "))))?;
    Ok(data
        .levels(f, cells)
        .into_iter()
        .map(|l| {
            let of = cells.iter().copied().filter(|c| data.cells[*c].levels[f].as_deref() == Some(l)).collect();
            (Some(l.to_owned()), of)
        })
        .collect())
}

fn one(
    data: &Dataset,
    study: &str,
    contrast: &Contrast,
    at: Option<String>,
    cells: &[usize],
    options: &TestOptions,
) -> Result<ContrastResult> {
    let pairs = pairs(data, cells, &contrast.factor, &contrast.a, &contrast.b)?;
    if pairs.differences.is_empty() {
        let who = pairs.incomplete.iter().map(|(p, what)| format!("{p} ({what})")).collect::<Vec<_>>().join("; ");
        return Err(Error::data(format!(
            "{} - {}: no participant has every cell of both; incomplete: {who}",
            contrast.a, contrast.b
        )));
    }
    let mut test = signed_rank(&pairs.sums(), &options.test)?;
    in_steps(&mut test, pairs.votes);
    test.notes.extend(pairs.unmatched.iter().map(|c| format!("{c}: only one of the two levels has it; left out")));
    if !pairs.incomplete.is_empty() {
        let who = pairs.incomplete.iter().map(|(p, what)| format!("{p} ({what})")).collect::<Vec<_>>().join("; ");
        test.notes.push(format!("participants without every cell of both levels are left out of this test: {who}"));
    }
    let pooled = options.pooled.then(|| pooled(data, cells, contrast, &options.test)).transpose()?;
    Ok(ContrastResult {
        study: study.to_owned(),
        contrast: contrast.clone(),
        at,
        p_adjusted: test.p(),
        test,
        correction: options.correction,
        family_size: 1,
        difference: difference(&pairs.steps(), options.difference_level),
        votes_per_sum: pairs.votes,
        incomplete: pairs.incomplete,
        pooled,
    })
}

/// Turns the shift estimates of sums over `votes` votes into scale steps.
fn in_steps(test: &mut SignedRank, votes: u32) {
    let v = f64::from(votes);
    for x in [&mut test.hodges_lehmann, &mut test.hodges_lehmann_lo, &mut test.hodges_lehmann_hi] {
        *x = x.map(|x| x / v);
    }
}

fn pooled(data: &Dataset, cells: &[usize], contrast: &Contrast, options: &Options) -> Result<Pooled> {
    let f = data.factor(&contrast.factor).unwrap_or_default();
    let mut d = Vec::new();
    let mut strata: Vec<Vec<Option<String>>> = Vec::new();
    for c in cells {
        let mut levels = data.cells[*c].levels.clone();
        levels[f] = None;
        if !strata.contains(&levels) {
            strata.push(levels);
        }
    }
    for levels in strata {
        let of: Vec<usize> = cells
            .iter()
            .copied()
            .filter(|c| (0..levels.len()).all(|i| i == f || data.cells[*c].levels[i] == levels[i]))
            .collect();
        if let Ok(p) = pairs(data, &of, &contrast.factor, &contrast.a, &contrast.b) {
            d.extend(p.sums());
        }
    }
    Ok(Pooled {
        label: "as the paper may have done: participant x scene pairs pooled as if independent; not valid when people differ",
        test: signed_rank(&d, options)?,
    })
}

fn adjust_families(results: &mut [ContrastResult], correction: Correction) {
    let mut families: Vec<(String, String)> =
        results.iter().map(|r| (r.study.clone(), r.contrast.family.clone())).collect();
    families.sort();
    families.dedup();
    for (study, family) in families {
        let members: Vec<usize> = (0..results.len())
            .filter(|i| results[*i].study == study && results[*i].contrast.family == family)
            .collect();
        let p: Vec<f64> = members.iter().map(|i| results[*i].test.p()).collect();
        for (i, p) in members.iter().zip(adjust(&p, correction)) {
            results[*i].p_adjusted = p;
            results[*i].family_size = members.len();
        }
    }
}

/// The contrasts to test when the request names none.
///
/// The study file's own contrasts where it has some. Else, where the factor has the levels `stereo` and `sssr`: stereo
/// − sssr in a family of its own, {stereo, sssr} − path-traced as a second family, and stereo − sssr for each scene as
/// an exploratory family. Else all pairs of levels of `method`, or of the first factor where there is no `method`.
pub fn default_contrasts(data: &Dataset) -> Vec<Contrast> {
    let planned: Vec<Contrast> =
        data.studies.iter().filter_map(|s| s.plan.as_ref()).flat_map(|p| &p.contrasts).map(from_plan).collect();
    if !planned.is_empty() {
        let mut unique: Vec<Contrast> = Vec::new();
        planned.into_iter().for_each(|c| {
            if !unique.contains(&c) {
                unique.push(c);
            }
        });
        return unique;
    }
    let Some(f) = data.factor("method").or(if data.factors.is_empty() { None } else { Some(0) }) else {
        return Vec::new();
    };
    let factor = &data.factors[f];
    let mut levels: Vec<&str> = data.cells.iter().filter_map(|c| c.levels[f].as_deref()).collect();
    levels.sort_by_key(|l| level_key(l));
    levels.dedup();
    let contrast = |a: &str, b: &str, family: &str, per: Option<&str>| Contrast {
        factor: factor.clone(),
        a: a.to_owned(),
        b: b.to_owned(),
        family: family.to_owned(),
        per: per.map(str::to_owned),
    };
    let mut out = Vec::new();
    let has = |l: &str| levels.contains(&l);
    if has("stereo") && has("sssr") {
        out.push(contrast("stereo", "sssr", "primary", None));
        if has("path-traced") {
            out.push(contrast("stereo", "path-traced", "reference", None));
            out.push(contrast("sssr", "path-traced", "reference", None));
        }
        if data.factor("scene").is_some() {
            out.push(contrast("stereo", "sssr", "per scene (exploratory)", Some("scene")));
        }
    } else {
        for (i, a) in levels.iter().enumerate() {
            out.extend(levels[i + 1..].iter().map(|b| contrast(a, b, "all pairs", None)));
        }
    }
    out
}

fn from_plan(c: &plan::Contrast) -> Contrast {
    Contrast { factor: c.factor.clone(), a: c.a.clone(), b: c.b.clone(), family: c.family.clone(), per: c.per.clone() }
}

/// The options that the study file fixed, or the defaults.
pub fn planned_options(data: &Dataset) -> TestOptions {
    let mut options = TestOptions::default();
    if let Some(plan) = data.studies.iter().find_map(|s| s.plan.as_ref().filter(|p| !p.contrasts.is_empty())) {
        options.test.zeros = match plan.zeros {
            plan::Zeros::Wilcox => Zeros::Wilcox,
            plan::Zeros::Pratt => Zeros::Pratt,
            plan::Zeros::Zsplit => Zeros::Zsplit,
        };
        options.test.alternative = match plan.alternative {
            plan::Alternative::TwoSided => Alternative::TwoSided,
            plan::Alternative::Greater => Alternative::Greater,
            plan::Alternative::Less => Alternative::Less,
        };
        if plan.test == plan::Test::SignedRankAsymptotic {
            options.test.exact = Exact::Never;
        }
        options.correction = match plan.correction {
            plan::Correction::Holm => Correction::Holm,
            plan::Correction::BenjaminiHochberg => Correction::BenjaminiHochberg,
            plan::Correction::None => Correction::None,
        };
    }
    options
}

/// Each complete participant's sum for every level of a factor, in scale steps; and the participants who are not
/// complete.
///
/// # Errors
/// [`Error::Data`] when the levels have no cell in common.
pub fn scores(
    data: &Dataset,
    cells: &[usize],
    factor: usize,
    levels: &[String],
) -> Result<(Vec<Vec<f64>>, Vec<String>)> {
    let others = |c: usize| {
        let mut l = data.cells[c].levels.clone();
        l[factor] = None;
        l
    };
    let of = |level: &str| -> Vec<usize> {
        cells.iter().copied().filter(|c| data.cells[*c].levels[factor].as_deref() == Some(level)).collect()
    };
    let Some(first) = levels.first() else { return Err(Error::data("no levels to compare")) };
    // Each block holds one cell for each level, with equal levels of all other factors. Only whole blocks are compared.
    let blocks: Vec<Vec<usize>> = of(first)
        .into_iter()
        .filter_map(|c| {
            levels.iter().map(|l| of(l).into_iter().find(|o| others(*o) == others(c))).collect::<Option<Vec<_>>>()
        })
        .collect();
    if blocks.is_empty() {
        return Err(Error::data(format!("{} share no cell: nothing can be compared", levels.join(", "))));
    }
    let showings: Vec<u32> = blocks
        .iter()
        .map(|b| data.participants.iter().flat_map(|p| b.iter().map(|c| p.tally(*c).n)).max().unwrap_or(0))
        .collect();
    let (mut rows, mut incomplete) = (Vec::new(), Vec::new());
    for p in &data.participants {
        let given: u32 = blocks.iter().flatten().map(|c| p.tally(*c).n).sum();
        if given == 0 {
            continue;
        }
        if blocks.iter().zip(&showings).any(|(b, n)| b.iter().any(|c| p.tally(*c).n < *n)) {
            incomplete.push(p.id.clone());
            continue;
        }
        let sum = |l: usize| blocks.iter().map(|b| p.tally(b[l]).sum).sum::<i64>() as f64 / UNIT as f64;
        rows.push((0..levels.len()).map(sum).collect());
    }
    Ok((rows, incomplete))
}
