//! The target for orders. Whatever a study asks for, each participant must be shown the planned conditions as often as
//! planned.
//!
//! The bytes are numbers that choose a study, so that most inputs give a valid study with an order.

use std::collections::{BTreeMap, BTreeSet};

use cyclopean::study::definition::{Definition, OrderKind, Task};
use cyclopean::study::{Plan, validate};
use cyclopean_analysis::journal::record::{Planned, Purpose, Side};
use serde_json::{Value, json};

pub fn run(bytes: &[u8]) {
    let mut bytes = bytes.iter().copied();
    let mut next = || bytes.next().unwrap_or(0);
    let row = u64::from_le_bytes(std::array::from_fn(|_| next()));
    let seed = u64::from_le_bytes([next(), next(), next(), next(), next(), next(), 0, 0]);
    let mut names = |prefix: &str, most: u8, least: u8| -> Vec<String> {
        (0..(next() % (most + 1)).max(least)).map(|i| format!("{prefix}{i}")).collect()
    };
    let (scenes, methods) = (names("s", 3, 1), names("m", 4, 1));
    let (views, paths, others, eyes) = (names("v", 2, 0), names("p", 2, 0), names("o", 2, 1), names("e", 2, 0));
    let [task, kind, factor, repetitions, practice, catches] = std::array::from_fn(|_| next());
    let compares = task % 2 == 1;
    let mirrored = compares && task % 4 == 3;
    let mut cross = json!({ "scene": scenes, "method": methods, "view": views, "path": paths });
    let mut one = json!({ "scene": "s0", "method": "m0" });
    if compares {
        cross["other"] = others.into();
        one["other"] = "o0".into();
    }
    if mirrored {
        cross["eye"] = ["left", "right"][..eyes.len().max(1)].into();
        cross["reference"] = "reference".into();
        (one["eye"], one["reference"]) = ("left".into(), "reference".into());
    }
    let kind = ["random", "fixed", "blocked", "latin-square"][usize::from(kind % 4)];
    let mut order = json!({ "kind": kind });
    if kind == "blocked" {
        order["block_by"] = ["scene", "method", "view", "path", "other", "eye"][usize::from(factor % 6)].into();
    }
    let catch = json!({ "show": one, "passes": [2] });
    let mut study = json!({
        "format": 1, "id": "orders", "title": "Orders", "seed": seed, "participants": 1,
        "instructions": "Look.", "question": "How much?",
        "conditions": { "cross": cross }, "order": order, "repetitions": u32::from(repetitions % 5).max(1),
        "practice": vec![one; usize::from(practice % 4)], "catch_trials": vec![catch; usize::from(catches % 9)],
    });
    let of_task: Value = if compares {
        json!({
            "task": "compare", "labels": ["A", "same", "B"], "preference": { "other": 1, "same": 2, "method": 3 },
            "protocol": [{ "show": "a", "seconds": 1 }, { "show": "b", "seconds": 1 }],
            "layout": if mirrored { "mirrored-pair" } else { "stereo" },
        })
    } else {
        json!({
            "task": "rate", "labels": ["no", "yes"], "scale": [1, 2],
            "protocol": [{ "show": "stimulus", "seconds": 1 }],
        })
    };
    for (key, value) in of_task.as_object().into_iter().flatten() {
        study[key] = value.clone();
    }
    match validate::parse("orders.json".as_ref(), study.to_string()) {
        Ok(study) => check(&study.definition, row),
        Err(error) => super::said(&error),
    }
}

/// Sessions with more presentations are also drawn, but only the fast checks are done.
const MOST_CHECKED: usize = 20_000;

/// Checks the promises of a plan, for a definition that was accepted.
pub fn check(definition: &Definition, row: u64) {
    let plan = Plan::draw(definition, row);
    let (specs, repetitions) = (definition.conditions(), definition.repetitions as usize);
    let (practice, catches) = (definition.practice.len(), definition.catch_trials.len());
    let trials = specs.len() * repetitions;
    assert_eq!(plan.presentations.len(), practice + trials + catches, "the plan has another number of presentations");
    assert_eq!(plan.order.presentations as usize, plan.presentations.len());
    for (at, planned) in plan.presentations.iter().enumerate() {
        assert_eq!(planned.presentation as usize, at, "presentations are not numbered in their order");
        assert!((planned.condition as usize) < plan.conditions.len(), "a condition does not exist");
        assert!(!planned.stimuli.is_empty(), "a presentation shows nothing");
        assert!(planned.stimuli.iter().all(|s| (*s as usize) < plan.stimuli.len()), "a stimulus does not exist");
    }
    if plan.presentations.len() > MOST_CHECKED {
        return;
    }
    assert_eq!(Plan::draw(definition, row), plan, "the same study and row gave another order");
    let of = |purpose: Purpose| plan.presentations.iter().filter(move |p| p.purpose == purpose);
    assert!(
        plan.presentations[..practice].iter().all(|p| p.purpose == Purpose::Practice),
        "practice does not come first"
    );
    let caught: BTreeSet<u32> = of(Purpose::Catch).map(|p| p.repetition).collect();
    assert!(of(Purpose::Catch).count() == catches && caught.len() == catches, "a catch trial is missing or repeated");
    assert!(plan.presentations.get(practice).is_none_or(|p| p.purpose == Purpose::Trial), "a catch trial comes first");
    let shown: Vec<&Planned> = of(Purpose::Trial).collect();
    let all: BTreeSet<u32> = shown.iter().map(|p| p.condition).collect();
    assert_eq!(all.len(), specs.len(), "a condition is missing");
    let mut seen: BTreeMap<u32, u32> = BTreeMap::new();
    for planned in &shown {
        let showing = seen.entry(planned.condition).or_default();
        assert_eq!(planned.repetition, *showing, "the repetitions of a condition are not counted in order");
        *showing += 1;
    }
    assert!(seen.values().all(|n| *n as usize == repetitions), "a condition is not shown as often as planned");
    if definition.order.kind != OrderKind::Blocked {
        for (number, pass) in shown.chunks(specs.len()).enumerate() {
            let each: BTreeSet<u32> = pass.iter().map(|p| p.condition).collect();
            assert_eq!(each.len(), specs.len(), "pass {number} is not a permutation of the conditions");
            assert!(
                pass.iter().all(|p| p.block as usize == number + 1),
                "a pass does not have the block of its number"
            );
        }
        let again = shown.windows(2).any(|pair| pair[0].condition == pair[1].condition);
        assert!(!again || specs.len() < 2, "a condition is shown twice in succession");
    }
    if definition.task == Task::Compare {
        for condition in all.iter().filter(|_| repetitions.is_multiple_of(2)) {
            let as_a = shown.iter().filter(|p| p.condition == *condition && p.a_is == Some(Side::Method)).count();
            assert_eq!(as_a * 2, repetitions, "the method is not A in half of the presentations");
        }
    }
}
