//! Responses, reduced to what every statistic needs: one tally for each participant and cell.
//!
//! Memory grows with participants × cells, never with responses, so ten million answers of ten
//! thousand people fit in a few megabytes.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::{Response, Score, Selection};
use crate::journal::{AnalysisPlan, Kind};

/// Limits of memory that no study reaches: one tally is kept for each participant and condition.
const MOST_TALLIES: usize = 1 << 25;
const MOST_CELLS: usize = 100_000;
const MOST_STUDIES: usize = 1000;

/// Votes of one participant in one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Number of votes.
    pub n: u32,
    /// Their sum, in millionths.
    pub sum: i64,
    /// The first 64 repetitions, a bit for each that was seen: a second answer to the same showing is refused.
    seen: u64,
}

impl Tally {
    /// Mean vote in scale steps; NaN without votes.
    pub fn mean(self) -> f64 {
        Score(self.sum).value() / f64::from(self.n)
    }
}

/// One combination of study and factor levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Index into [`Dataset::studies`].
    pub study: usize,
    /// Level of each factor, by index into [`Dataset::factors`]; `None`: the study has no such factor.
    pub levels: Vec<Option<String>>,
    /// Votes by rating, over all participants.
    pub counts: BTreeMap<Score, u64>,
}

/// A participant and the tallies of every cell, in the cells' order.
#[derive(Clone, Debug)]
pub struct Participant {
    /// Pseudonym.
    pub id: String,
    /// The kinds of this participant's responses.
    pub kinds: BTreeSet<Option<Kind>>,
    tallies: Vec<Tally>,
}

impl Participant {
    /// The votes in a cell.
    pub fn tally(&self, cell: usize) -> Tally {
        self.tallies.get(cell).copied().unwrap_or_default()
    }

    /// Votes and their sum over several cells.
    pub fn over(&self, cells: &[usize]) -> Tally {
        cells.iter().map(|c| self.tally(*c)).fold(Tally::default(), |a, b| Tally {
            n: a.n + b.n,
            sum: a.sum + b.sum,
            seen: 0,
        })
    }
}

/// A study's scale and plan, as far as its sources say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Study {
    /// The study's id; empty when the source does not say.
    pub id: String,
    /// Its title.
    pub title: Option<String>,
    /// SHA-256 of the study file.
    pub sha256: Option<String>,
    /// The whole study file.
    pub text: Option<String>,
    /// The scale's values and words, lowest first; empty when unknown.
    pub scale: Vec<(i32, String)>,
    /// Whether the study asks for a forced choice between two images, not for a rating.
    pub forced_choice: bool,
    /// The analysis that the study fixed beforehand.
    pub plan: Option<AnalysisPlan>,
}

impl Study {
    /// Lowest and highest value of the scale: as stated; else 1 and 3 for a forced choice; else 1 and 5 if the votes
    /// fit.
    pub fn ends(&self, seen: impl Iterator<Item = Score>) -> Option<(i32, i32)> {
        if let (Some(first), Some(last)) = (self.scale.iter().map(|s| s.0).min(), self.scale.iter().map(|s| s.0).max())
        {
            return Some((first, last));
        }
        let fits = seen.into_iter().all(|s| s.0 % super::UNIT == 0 && (super::UNIT..=5 * super::UNIT).contains(&s.0));
        fits.then_some((1, 5))
    }
}

/// All responses that were read, reduced to tallies.
#[derive(Clone, Debug, Default)]
pub struct Dataset {
    /// Names of the factors; the cells' levels follow this order.
    pub factors: Vec<String>,
    /// The studies that occur.
    pub studies: Vec<Study>,
    /// The cells, sorted by study and levels.
    pub cells: Vec<Cell>,
    /// Participants, sorted by id.
    pub participants: Vec<Participant>,
    /// Responses of each kind.
    pub kinds: BTreeMap<Option<Kind>, u64>,
    /// What a reader should know: empty ratings, unfinished sessions.
    pub notes: Vec<String>,
}

impl Dataset {
    /// Number of responses.
    pub fn responses(&self) -> u64 {
        self.kinds.values().sum()
    }

    /// Index of a factor.
    pub fn factor(&self, name: &str) -> Option<usize> {
        self.factors.iter().position(|f| f == name)
    }

    /// Levels of a factor that occur among `cells`, in their natural order.
    pub fn levels<'a>(&'a self, factor: usize, cells: &[usize]) -> Vec<&'a str> {
        let mut levels: Vec<&str> = cells.iter().filter_map(|c| self.cells[*c].levels[factor].as_deref()).collect();
        levels.sort_by_key(|l| level_key(l));
        levels.dedup();
        levels
    }

    /// Cells of one study, in order.
    pub fn cells_of(&self, study: usize) -> Vec<usize> {
        (0..self.cells.len()).filter(|c| self.cells[*c].study == study).collect()
    }

    /// Words for a cell: `scene pica, method stereo`.
    pub fn describe(&self, cell: usize) -> String {
        let levels = self.factors.iter().zip(&self.cells[cell].levels);
        levels.filter_map(|(f, l)| l.as_ref().map(|l| format!("{f} {l}"))).collect::<Vec<_>>().join(", ")
    }

    /// The stamp of every table and plot whose data are not all real; `None` for real sessions and unstated kinds.
    pub fn stamp(&self) -> Option<String> {
        let other = self.kinds.keys().any(|k| matches!(k, Some(Kind::Pilot | Kind::Simulated)));
        other.then(|| self.kinds.keys().map(|k| kind_name(*k)).collect::<Vec<_>>().join(" + "))
    }
}

/// The kind's word; "unstated" when the source has none.
pub fn kind_name(kind: Option<Kind>) -> &'static str {
    kind.map_or("unstated", Kind::name)
}

/// The sort key of a level. Levels that the paper names come first, in its order; then numbers by value; then words
/// alphabetically.
pub fn level_key(level: &str) -> (usize, u64, String) {
    const KNOWN: [&str; 6] = ["sssr", "stereo", "path-traced", "traversal", "fade", "reprojection"];
    let known = KNOWN.iter().position(|k| *k == level).unwrap_or(KNOWN.len());
    let number = level.parse::<f64>().map_or(u64::MAX, |v| {
        let bits = v.to_bits();
        if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
    });
    (known, number, level.to_owned())
}

/// Collects responses one by one into a [`Dataset`].
#[derive(Debug, Default)]
pub struct Builder {
    data: Dataset,
    selection: Selection,
    people: HashMap<String, usize>,
    by_bytes: HashMap<Vec<u8>, usize>,
    by_levels: HashMap<(usize, Vec<Option<String>>), usize>,
    key: Vec<u8>,
    last: Option<(String, usize)>,
}

impl Builder {
    /// A builder that takes what the selection wants and passes over the rest.
    pub fn new(selection: &Selection) -> Self {
        Self { selection: selection.clone(), ..Self::default() }
    }

    /// Whether responses of this study, participant and kind are wanted.
    pub fn wants(&self, study: &str, participant: &str, kind: Option<Kind>) -> bool {
        let s = &self.selection;
        s.study.as_ref().is_none_or(|id| id == study)
            && (s.kind.is_none() || s.kind == kind)
            && (s.exclude.is_empty() || !s.exclude.contains(participant))
    }

    /// Adds a study, or adds to a known one what its first mention did not say; returns its index.
    pub fn study(&mut self, study: Study) -> usize {
        let studies = &mut self.data.studies;
        match studies.iter().position(|s| s.id == study.id) {
            Some(i) => {
                if studies[i].scale.is_empty() && studies[i].plan.is_none() {
                    studies[i] = study;
                }
                i
            }
            None => {
                studies.push(study);
                studies.len() - 1
            }
        }
    }

    /// A remark to hand on with the data.
    pub fn note(&mut self, note: String) {
        self.data.notes.push(note);
    }

    /// Adds one response.
    ///
    /// # Errors
    /// A sentence: the same showing answered twice, a sum beyond what 64 bits hold, or more participants and conditions
    /// than are kept.
    pub fn add(&mut self, r: &Response<'_>) -> Result<(), String> {
        if !self.wants(r.study, r.participant, r.kind) {
            return Ok(());
        }
        let cell = self.cell(r);
        let person = self.person(r.participant);
        let (cells, people, studies) = (self.data.cells.len(), self.data.participants.len(), self.data.studies.len());
        if studies > MOST_STUDIES || cells > MOST_CELLS || cells.saturating_mul(people) > MOST_TALLIES {
            return Err(format!(
                "{people} participants in {cells} conditions of {studies} studies are more than is analysed at once: \
                 at most {MOST_STUDIES} studies, {MOST_CELLS} conditions, and {MOST_TALLIES} for conditions times \
                 participants; is a column taken for a factor that is none?"
            ));
        }
        let who = &mut self.data.participants[person];
        who.kinds.insert(r.kind);
        if who.tallies.len() <= cell {
            who.tallies.resize(cell + 1, Tally::default());
        }
        let tally = &mut who.tallies[cell];
        if let Some(bit) = r.repetition.filter(|b| *b < 64) {
            if tally.seen >> bit & 1 == 1 {
                return Err(format!(
                    "participant {} answered {} (repetition {bit}) twice; keep one answer a showing, \
                     or number the showings in a column `repetition`",
                    r.participant,
                    self.data.describe(cell)
                ));
            }
            tally.seen |= 1 << bit;
        }
        tally.n += 1;
        tally.sum = tally.sum.checked_add(r.rating.0).ok_or_else(|| {
            format!("the ratings of participant {} are too large to be summed exactly", r.participant)
        })?;
        *self.data.cells[cell].counts.entry(r.rating).or_default() += 1;
        *self.data.kinds.entry(r.kind).or_default() += 1;
        Ok(())
    }

    fn person(&mut self, id: &str) -> usize {
        // Most rows of one participant follow each other.
        if let Some((last, i)) = &self.last
            && last == id
        {
            return *i;
        }
        let i = match self.people.get(id) {
            Some(i) => *i,
            None => {
                let i = self.data.participants.len();
                self.people.insert(id.to_owned(), i);
                self.data.participants.push(Participant {
                    id: id.to_owned(),
                    kinds: BTreeSet::new(),
                    tallies: Vec::new(),
                });
                i
            }
        };
        self.last = Some((id.to_owned(), i));
        i
    }

    fn cell(&mut self, r: &Response<'_>) -> usize {
        self.key.clear();
        self.key.extend_from_slice(r.study.as_bytes());
        for (name, level) in r.factors {
            // 0xff occurs in no UTF-8 text, so that no two lists of words make the same key.
            self.key.push(0xff);
            self.key.extend_from_slice(name.as_bytes());
            self.key.push(0xff);
            self.key.extend_from_slice(level.as_bytes());
        }
        if let Some(cell) = self.by_bytes.get(&self.key) {
            return *cell;
        }
        let study = match self.data.studies.iter().position(|s| s.id == r.study) {
            Some(i) => i,
            None => self.study(Study { id: r.study.to_owned(), ..Study::default() }),
        };
        for (name, _) in r.factors {
            if self.data.factor(name).is_none() {
                self.data.factors.push((*name).to_owned());
                self.data.cells.iter_mut().for_each(|c| c.levels.push(None));
                self.by_levels = self
                    .by_levels
                    .drain()
                    .map(|((s, mut l), i)| {
                        l.push(None);
                        ((s, l), i)
                    })
                    .collect();
            }
        }
        let mut levels = vec![None; self.data.factors.len()];
        for (name, level) in r.factors {
            if let Some(f) = self.data.factor(name) {
                levels[f] = Some((*level).to_owned());
            }
        }
        let next = self.data.cells.len();
        let cell = *self.by_levels.entry((study, levels.clone())).or_insert(next);
        if cell == next {
            self.data.cells.push(Cell { study, levels, counts: BTreeMap::new() });
        }
        self.by_bytes.insert(self.key.clone(), cell);
        cell
    }

    /// The data, cells and participants in an order that does not depend on the order of the input.
    pub fn finish(self) -> Dataset {
        let mut data = self.data;
        let mut order: Vec<usize> = (0..data.cells.len()).collect();
        let names: Vec<String> = data.studies.iter().map(|s| s.id.clone()).collect();
        order.sort_by_cached_key(|c| {
            let cell = &data.cells[*c];
            let levels: Vec<_> = cell.levels.iter().map(|l| l.as_deref().map(level_key)).collect();
            (names[cell.study].clone(), levels)
        });
        for p in &mut data.participants {
            p.tallies.resize(order.len(), Tally::default());
            p.tallies = order.iter().map(|c| p.tallies[*c]).collect();
        }
        let mut cells: Vec<Option<Cell>> = data.cells.into_iter().map(Some).collect();
        data.cells = order.iter().filter_map(|c| cells[*c].take()).collect();
        data.participants.sort_by_cached_key(|p| level_key(&p.id));
        data
    }
}
