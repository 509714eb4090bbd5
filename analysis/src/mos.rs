//! Mean opinion scores: one row for each combination of levels of the chosen factors.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::{Map, Value};

use crate::data::{Dataset, Score, UNIT};
use crate::error::{Error, Result};
use crate::interval::{self, Bootstrap, Interval, Method, Scale};
use crate::special::mean_sd;

/// What a table shows.
#[derive(Clone, Debug, PartialEq)]
pub struct TableOptions {
    /// Factors whose combinations make the rows; empty: every factor of the study.
    pub by: Vec<String>,
    /// The interval.
    pub method: Method,
    /// Its level, in (0, 1); the paper uses 0.9.
    pub level: f64,
    /// Bootstrap size and seed.
    pub boot: Bootstrap,
    /// Lowest and highest rating; `None`: as the data say.
    pub scale: Option<Scale>,
}

impl Default for TableOptions {
    fn default() -> Self {
        Self { by: Vec::new(), method: Method::T, level: 0.9, boot: Bootstrap::default(), scale: None }
    }
}

/// One row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Study id; empty when the source has none.
    pub study: String,
    /// Factor and level.
    pub factors: Vec<(String, String)>,
    /// Participants with a vote in this row: the units of the interval.
    pub n: usize,
    /// Votes; more than `n` when a row covers several cells or repetitions.
    pub votes: u64,
    /// Mean of the participants' mean votes, in scale steps.
    pub mean: f64,
    /// Standard deviation (n − 1) of the participants' mean votes.
    pub sd: Option<f64>,
    /// The interval with its warnings.
    pub interval: Interval,
    /// Whether all votes are equal.
    pub unanimous: bool,
    /// Variance of the votes divided by that of the binomial model; above 1 that model is too narrow. Only where each
    /// participant has a single vote.
    pub dispersion: Option<f64>,
    /// Number of votes for each rating, including the steps of a short scale that nobody chose.
    pub counts: BTreeMap<Score, u64>,
    /// The scale's ends, if known.
    pub scale: Option<Scale>,
}

impl Row {
    /// The row as an object: the factors by name, then the numbers.
    pub fn to_json(&self) -> Value {
        let mut o = Map::new();
        if !self.study.is_empty() {
            o.insert("study".into(), self.study.clone().into());
        }
        for (name, level) in &self.factors {
            o.insert(name.clone(), level.clone().into());
        }
        let counts: Map<String, Value> = self.counts.iter().map(|(s, n)| (s.to_string(), (*n).into())).collect();
        for (name, value) in [
            ("n", self.n.into()),
            ("votes", self.votes.into()),
            ("mean", self.mean.into()),
            ("sd", self.sd.into()),
            ("lo", self.interval.lo.into()),
            ("hi", self.interval.hi.into()),
            ("unanimous", self.unanimous.into()),
            ("dispersion", self.dispersion.into()),
            ("counts", counts.into()),
            ("notes", self.interval.notes.clone().into()),
        ] {
            o.insert(name.into(), value);
        }
        o.into()
    }

    /// The level of a factor in this row.
    pub fn level(&self, factor: &str) -> Option<&str> {
        self.factors.iter().find(|f| f.0 == factor).map(|f| f.1.as_str())
    }
}

/// The table with the conventions that made it.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The options it was made with.
    pub options: TableOptions,
    /// Rows, by study, then levels in natural order.
    pub rows: Vec<Row>,
    /// `simulated`, `pilot` or a mix; `None` for real or unstated sessions.
    pub stamp: Option<String>,
    /// How the numbers were made.
    pub convention: String,
    /// Remarks on the data as a whole.
    pub notes: Vec<String>,
}

/// The fields of a table's JSON object.
#[derive(Serialize)]
struct TableJson<'a> {
    level: f64,
    ci: Method,
    rows: Vec<Value>,
    stamp: &'a Option<String>,
    convention: &'a str,
    bootstrap: Option<Bootstrap>,
    notes: &'a [String],
}

impl Table {
    /// `{level, ci, rows: [{…factors, n, mean, sd, lo, hi, counts, …}], …}`.
    pub fn to_json(&self) -> Value {
        let boot = matches!(self.options.method, Method::Bootstrap | Method::Bca).then_some(self.options.boot);
        let head = TableJson {
            level: self.options.level,
            ci: self.options.method,
            rows: self.rows.iter().map(Row::to_json).collect(),
            stamp: &self.stamp,
            convention: &self.convention,
            bootstrap: boot,
            notes: &self.notes,
        };
        serde_json::to_value(head).unwrap_or_default()
    }
}

/// Makes the table.
///
/// A row that covers one cell, with one vote of each participant, uses the votes themselves. A row that covers more
/// averages each participant first, because votes of one person are not independent. It then has only t, normal or
/// bootstrap intervals.
///
/// # Errors
/// [`Error::Usage`] for an unknown factor (the known ones are named) or a level outside (0, 1).
pub fn table(data: &Dataset, options: &TableOptions) -> Result<Table> {
    if !(options.level > 0.0 && options.level < 1.0) {
        return Err(Error::usage(format!("level {} is not between 0 and 1, for example 0.9", options.level)));
    }
    for factor in &options.by {
        if factor != "study" && data.factor(factor).is_none() {
            return Err(Error::usage(format!("unknown factor `{factor}`; known: {}", data.factors.join(", "))));
        }
    }
    let mut rows = Vec::new();
    for (s, study) in data.studies.iter().enumerate() {
        let cells = data.cells_of(s);
        let by = used_factors(data, &cells, &options.by);
        let seen = cells.iter().flat_map(|c| data.cells[*c].counts.keys().copied());
        let scale = study.ends(seen).map(|(low, high)| Scale { low: low.into(), high: high.into() }).or(options.scale);
        let scale = options.scale.or(scale);
        let mut groups: Vec<(Vec<String>, Vec<usize>)> = Vec::new();
        for c in cells {
            let key: Vec<String> =
                by.iter().map(|f| data.cells[c].levels[*f].clone().unwrap_or_else(|| "-".into())).collect();
            match groups.iter_mut().find(|g| g.0 == key) {
                Some(g) => g.1.push(c),
                None => groups.push((key, vec![c])),
            }
        }
        groups.sort_by_cached_key(|g| g.0.iter().map(|l| crate::data::level_key(l)).collect::<Vec<_>>());
        for (levels, cells) in groups {
            let factors = by.iter().map(|f| data.factors[*f].clone()).zip(levels).collect();
            let purpose = rows.len() as u64;
            rows.extend(row(data, study.id.clone(), factors, &cells, scale, options, purpose));
        }
    }
    let mut notes = data.notes.clone();
    notes.extend(missing_votes(data));
    Ok(Table {
        options: options.clone(),
        rows,
        stamp: data.stamp(),
        convention: format!(
            "mean of the participants' mean votes; sd with n - 1; {} {} interval; the votes there are, n shown",
            crate::wilcoxon::percent(options.level),
            options.method.words()
        ),
        notes,
    })
}

/// The factors of the request that this study has; all factors of the study when the request names none.
fn used_factors(data: &Dataset, cells: &[usize], by: &[String]) -> Vec<usize> {
    let has = |f: &usize| cells.iter().any(|c| data.cells[*c].levels[*f].is_some());
    if by.is_empty() {
        // A factor with one level says nothing about the rows, except the two that every reader looks for.
        let varies =
            |f: &usize| matches!(data.factors[*f].as_str(), "scene" | "method") || data.levels(*f, cells).len() > 1;
        return order_factors(data, (0..data.factors.len()).filter(has).filter(varies).collect());
    }
    by.iter().filter_map(|name| data.factor(name)).filter(has).collect()
}

/// `scene` first and `method` after it, as the paper's tables have them; others as they were met.
fn order_factors(data: &Dataset, mut factors: Vec<usize>) -> Vec<usize> {
    factors.sort_by_key(|f| match data.factors[*f].as_str() {
        "scene" => 0,
        "method" => 1,
        _ => 2 + f,
    });
    factors
}

fn row(
    data: &Dataset,
    study: String,
    factors: Vec<(String, String)>,
    cells: &[usize],
    scale: Option<Scale>,
    options: &TableOptions,
    purpose: u64,
) -> Option<Row> {
    let tallies: Vec<_> = data.participants.iter().map(|p| p.over(cells)).filter(|t| t.n > 0).collect();
    if tallies.is_empty() {
        return None;
    }
    let units: Vec<f64> = tallies.iter().map(|t| t.mean()).collect();
    let single = tallies.iter().all(|t| t.n == 1);
    let mut counts: BTreeMap<Score, u64> = BTreeMap::new();
    // The empty steps of a short scale are worth seeing; those of a slider are not.
    if let Some(s) = scale.filter(|s| s.high - s.low <= 10.0) {
        for step in s.low as i64..=s.high as i64 {
            counts.insert(Score(step * UNIT), 0);
        }
    }
    for c in cells {
        for (score, n) in &data.cells[*c].counts {
            *counts.entry(*score).or_default() += n;
        }
    }
    let (mean, sd) = mean_sd(&units);
    let used: Vec<Score> = counts.iter().filter(|c| *c.1 > 0).map(|c| *c.0).collect();
    let unanimous = used.len() == 1;
    let dispersion = if single { scale.and_then(|s| interval::dispersion(&units, s)) } else { None };
    let mut interval = interval_of(&units, single, scale, options, purpose);
    flag(&mut interval, options, unanimous, scale, mean, units.len(), dispersion);
    let votes = tallies.iter().map(|t| u64::from(t.n)).sum();
    Some(Row { study, factors, n: units.len(), votes, mean, sd, interval, unanimous, dispersion, counts, scale })
}

fn interval_of(units: &[f64], single: bool, scale: Option<Scale>, options: &TableOptions, purpose: u64) -> Interval {
    let (level, boot) = (options.level, options.boot);
    let model = matches!(options.method, Method::ClopperPearson | Method::Jeffreys);
    let none = |why: &str| Interval { notes: vec![why.to_owned()], ..Interval::default() };
    match (options.method, scale) {
        (Method::T, _) => interval::student_t(units, level),
        (Method::Normal, _) => interval::normal(units, level),
        (Method::Bootstrap, _) => interval::percentile(units, level, boot, purpose),
        (Method::Bca, _) => interval::bca(units, level, boot, purpose),
        _ if model && !single => {
            none("several votes a participant are averaged first: no binomial model, use t or bootstrap")
        }
        (_, None) => none("the scale is unknown: give it with --scale, for example --scale 1,5"),
        (_, Some(_)) if units.len() < 2 => none("one vote: no interval"),
        (method, Some(s)) => interval::binomial_model(units, s, level, method == Method::Jeffreys),
    }
}

/// Adds warnings about these votes, and replaces the interval where all votes stand at one end of the scale.
fn flag(
    interval: &mut Interval,
    options: &TableOptions,
    unanimous: bool,
    scale: Option<Scale>,
    mean: f64,
    n: usize,
    dispersion: Option<f64>,
) {
    let model = matches!(options.method, Method::ClopperPearson | Method::Jeffreys);
    if model && let Some(d) = dispersion {
        interval.notes.push(if d > 1.0 {
            format!("votes spread {d:.2} times the binomial model's variance: the interval is too narrow")
        } else {
            format!("variance {d:.2} of the binomial model's")
        });
    }
    if !unanimous || n < 2 {
        return;
    }
    interval.notes.push("all votes equal: s = 0 says nothing about other observers".to_owned());
    if let (false, Some(s)) = (model, scale)
        && let Some(honest) = interval::unanimous(mean, n, s, options.level)
    {
        (interval.lo, interval.hi) = (honest.lo, honest.hi);
        interval
            .notes
            .push("interval: bound for a unanimous end, low + (K-1)(alpha/2)^(1/n), mirrored at the bottom".to_owned());
    }
}

/// Names the participants who lack votes that others gave in the same study.
fn missing_votes(data: &Dataset) -> Vec<String> {
    let mut notes = Vec::new();
    for s in 0..data.studies.len() {
        let cells = data.cells_of(s);
        let most: Vec<u32> =
            cells.iter().map(|c| data.participants.iter().map(|p| p.tally(*c).n).max().unwrap_or(0)).collect();
        for p in &data.participants {
            let has: u32 = cells.iter().map(|c| p.tally(*c).n).sum();
            if has == 0 {
                continue;
            }
            let lacks: Vec<usize> =
                cells.iter().zip(&most).filter(|(c, m)| p.tally(**c).n < **m).map(|x| *x.0).collect();
            if let Some(first) = lacks.first() {
                let more = if lacks.len() > 1 { format!(" and {} more", lacks.len() - 1) } else { String::new() };
                notes.push(format!(
                    "participant {} lacks votes for {}{more}; rows use the votes there are",
                    p.id,
                    data.describe(*first)
                ));
            }
        }
    }
    const SHOWN: usize = 20;
    if notes.len() > SHOWN {
        let rest = notes.len() - SHOWN;
        notes.truncate(SHOWN);
        notes.push(format!("{rest} more participants lack votes"));
    }
    notes
}
