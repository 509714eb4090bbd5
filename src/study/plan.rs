//! One participant's plan: every presentation in order. It is drawn from (study seed, row) and nothing else.

use std::collections::BTreeMap;

use cyclopean_analysis::journal::record::{self, Condition, Planned, Purpose, Side};
use sha2::{Digest, Sha256};

use super::definition::{ConditionSpec, Definition, OrderKind, Task};
use super::order;
use super::random::Stream;
use super::stimulus::{StimulusRequest, split_method};

/// The procedure's name in the journal. It changes when the same (seed, row) would give another order.
pub const PROCEDURE: &str = "cyclopean-order 1 (chacha20, sha-256)";

/// A participant's whole session, before it begins.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub order: record::Order,
    /// The conditions of trials come first, then those of practice and catch trials.
    pub conditions: Vec<Condition>,
    /// Every stimulus once; `Planned::stimuli` holds indices into this list.
    pub stimuli: Vec<StimulusRequest>,
    pub presentations: Vec<Planned>,
}

impl Plan {
    /// Draws the plan of a row.
    pub fn draw(definition: &Definition, row: u64) -> Plan {
        let specs = definition.conditions();
        let mut plan = Builder::new(definition);
        let ids: Vec<u32> = specs.iter().map(|spec| plan.condition(spec)).collect();
        // Conditions are numbered in the file's order, so that an index means the same in every row.
        for spec in specs.iter().chain(&definition.practice).chain(definition.catch_trials.iter().map(|c| &c.show)) {
            plan.condition(spec);
            for method in [spec.reference.as_ref(), Some(&spec.method), spec.other.as_ref()].into_iter().flatten() {
                plan.stimulus(spec, method);
            }
        }
        for spec in &definition.practice {
            let condition = plan.condition(spec);
            let is_a =
                Stream::new(definition.seed, row, &format!("practice {}", plan.presentations.len())).below(2) == 0;
            plan.present(spec, condition, Purpose::Practice, 0, 0, is_a, &[]);
        }
        let rows = match definition.order.kind {
            OrderKind::LatinSquare => order::williams_rows(specs.len()),
            OrderKind::Fixed => 1,
            OrderKind::Random | OrderKind::Blocked => 0,
        };
        let is_a = order::assignments(specs.len(), definition.seed, row);
        let mut catches = place_catches(definition, row, specs.len() * definition.repetitions as usize);
        let mut shown = 0;
        let mut seen = vec![0u32; specs.len()];
        for (block, pass) in (1u32..).zip(passes(definition, &specs, row)) {
            for index in pass {
                while catches.last().is_some_and(|&(at, _)| at == shown) {
                    let Some((_, catch)) = catches.pop() else { break };
                    plan.catch(catch, block, row);
                }
                let repetition = seen[index];
                seen[index] += 1;
                // Repetitions alternate the side, so that an even number of them balances every condition.
                let method_is_a = is_a[index] ^ (repetition % 2 == 1);
                plan.present(&specs[index], ids[index], Purpose::Trial, repetition, block, method_is_a, &[]);
                shown += 1;
            }
        }
        let order = record::Order {
            ordering: definition.order.kind.name().to_owned(),
            procedure: PROCEDURE.to_owned(),
            rows,
            row,
            presentations: plan.presentations.len() as u32,
            sha256: digest(&plan.presentations),
        };
        Plan { order, conditions: plan.conditions, stimuli: plan.stimuli, presentations: plan.presentations }
    }

    /// Every stimulus of the study; it is the same for every row.
    pub fn all_stimuli(definition: &Definition) -> Vec<StimulusRequest> {
        Plan::draw(definition, 0).stimuli
    }
}

/// SHA-256 (hex) over the JSON text of the planned records, each followed by a line feed.
pub fn digest(presentations: &[Planned]) -> String {
    let mut hash = Sha256::new();
    for planned in presentations {
        // A struct of numbers and plain enums always has a JSON text.
        hash.update(serde_json::to_vec(planned).unwrap_or_default());
        hash.update(b"\n");
    }
    super::hex(&hash.finalize())
}

/// Blocks of condition indices, in order.
fn passes(definition: &Definition, specs: &[ConditionSpec], row: u64) -> Vec<Vec<usize>> {
    let (n, repetitions) = (specs.len(), definition.repetitions);
    let mut stream = Stream::new(definition.seed, row, "order");
    match definition.order.kind {
        OrderKind::LatinSquare => order::williams_passes(n, repetitions, row),
        OrderKind::Random => order::random_passes(n, repetitions, &mut stream),
        OrderKind::Fixed => vec![(0..n).collect(); repetitions as usize],
        OrderKind::Blocked => {
            let factor = definition.order.block_by.as_deref().unwrap_or("scene");
            let mut names: BTreeMap<String, usize> = BTreeMap::new();
            let group: Vec<usize> = specs
                .iter()
                .map(|spec| {
                    let next = names.len();
                    *names.entry(spec.factors().remove(factor).unwrap_or_default()).or_insert(next)
                })
                .collect();
            order::blocked(&group, repetitions, &mut stream).into_iter().map(|passes| passes.concat()).collect()
        }
    }
}

/// Pairs of a place and a catch trial: the catch trial comes before the trial of this number. The last place comes
/// first. No catch trial comes before the first trial, and no two have the same place.
fn place_catches(definition: &Definition, row: u64, trials: usize) -> Vec<(usize, usize)> {
    let mut places: Vec<usize> = (1..trials).collect();
    let mut stream = Stream::new(definition.seed, row, "catch");
    stream.shuffle(&mut places);
    let mut placed: Vec<(usize, usize)> = places.into_iter().zip(0..definition.catch_trials.len()).collect();
    placed.sort_unstable_by(|a, b| b.cmp(a));
    placed
}

/// What distinguishes the requests of one study: scene, view, path, method and its samples.
type StimulusKey<'a> = (&'a str, Option<&'a str>, Option<&'a str>, &'a str, Option<u32>);

struct Builder<'a> {
    definition: &'a Definition,
    conditions: Vec<Condition>,
    condition_ids: BTreeMap<&'a ConditionSpec, u32>,
    stimuli: Vec<StimulusRequest>,
    stimulus_ids: BTreeMap<StimulusKey<'a>, u32>,
    presentations: Vec<Planned>,
}

impl<'a> Builder<'a> {
    fn new(definition: &'a Definition) -> Builder<'a> {
        Builder {
            definition,
            conditions: Vec::new(),
            condition_ids: BTreeMap::new(),
            stimuli: Vec::new(),
            stimulus_ids: BTreeMap::new(),
            presentations: Vec::new(),
        }
    }

    fn condition(&mut self, spec: &'a ConditionSpec) -> u32 {
        let next = self.conditions.len() as u32;
        let id = *self.condition_ids.entry(spec).or_insert(next);
        if id == next {
            self.conditions.push(Condition { id, factors: spec.factors() });
        }
        id
    }

    fn stimulus(&mut self, spec: &'a ConditionSpec, method: &'a str) -> u32 {
        let samples = StimulusRequest::samples(self.definition, method);
        let key = (spec.scene.as_str(), spec.view.as_deref(), spec.path.as_deref(), split_method(method).0, samples);
        let next = self.stimuli.len() as u32;
        let id = *self.stimulus_ids.entry(key).or_insert(next);
        if id == next {
            self.stimuli.push(StimulusRequest::new(self.definition, spec, method));
        }
        id
    }

    fn catch(&mut self, index: usize, block: u32, row: u64) {
        let definition = self.definition;
        let catch = &definition.catch_trials[index];
        let condition = self.condition(&catch.show);
        let is_a = Stream::new(definition.seed, row, &format!("catch {index}")).below(2) == 0;
        self.present(&catch.show, condition, Purpose::Catch, index as u32, block, is_a, &catch.passes);
    }

    #[allow(clippy::too_many_arguments)]
    fn present(
        &mut self,
        spec: &'a ConditionSpec,
        condition: u32,
        purpose: Purpose,
        repetition: u32,
        block: u32,
        method_is_a: bool,
        passes: &[i32],
    ) {
        let method = self.stimulus(spec, &spec.method);
        let (a_is, stimuli) = match (self.definition.task, &spec.other) {
            (Task::Compare, Some(other)) => {
                let other = self.stimulus(spec, other);
                let reference = spec.reference.as_ref().map(|r| self.stimulus(spec, r));
                let pair = if method_is_a { [method, other] } else { [other, method] };
                let side = if method_is_a { Side::Method } else { Side::Other };
                (Some(side), reference.into_iter().chain(pair).collect())
            }
            _ => (None, vec![method]),
        };
        let presentation = self.presentations.len() as u32;
        let passes = passes.to_vec();
        let planned = Planned { presentation, purpose, condition, repetition, block, a_is, stimuli, passes };
        self.presentations.push(planned);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::testing;

    #[test]
    fn a_plan_depends_on_seed_and_row_alone() {
        let definition = testing::compare(4, 2);
        assert_eq!(Plan::draw(&definition, 3), Plan::draw(&definition, 3));
        assert_ne!(Plan::draw(&definition, 3).order.sha256, Plan::draw(&definition, 4).order.sha256);
        let other = Definition { seed: definition.seed + 1, ..definition.clone() };
        assert_ne!(Plan::draw(&definition, 3).order.sha256, Plan::draw(&other, 3).order.sha256);
    }

    #[test]
    fn the_method_is_a_in_exactly_half_of_the_trials() {
        for row in 0..40 {
            let plan = Plan::draw(&testing::compare(6, 1), row);
            let trials = plan.presentations.iter().filter(|p| p.purpose == Purpose::Trial);
            assert_eq!(trials.filter(|p| p.a_is == Some(Side::Method)).count(), 3, "row {row}");
        }
    }

    #[test]
    fn stimuli_stand_in_the_order_of_a_and_b() {
        let definition = testing::compare(4, 1);
        let plan = Plan::draw(&definition, 1);
        for planned in &plan.presentations {
            let methods: Vec<&str> =
                planned.stimuli.iter().map(|&s| plan.stimuli[s as usize].method.as_str()).collect();
            let expected =
                if planned.a_is == Some(Side::Method) { ["sssr", "path-traced"] } else { ["path-traced", "sssr"] };
            assert_eq!(methods, expected);
        }
    }

    #[test]
    fn catch_trials_are_placed_among_the_trials() {
        let mut definition = testing::rate(3, 2);
        let show = definition.conditions()[0].clone();
        definition.catch_trials =
            (0..3).map(|_| crate::study::definition::CatchTrial { show: show.clone(), passes: vec![1] }).collect();
        for row in 0..50 {
            let plan = Plan::draw(&definition, row);
            let purposes: Vec<Purpose> = plan.presentations.iter().map(|p| p.purpose).collect();
            assert_eq!(purposes.iter().filter(|p| **p == Purpose::Catch).count(), 3);
            assert!(purposes.windows(2).all(|w| w != [Purpose::Catch; 2]));
            assert_eq!(purposes.iter().find(|p| **p != Purpose::Practice), Some(&Purpose::Trial));
        }
    }
}
