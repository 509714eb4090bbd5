//! Small studies for unit tests.

use super::definition::Definition;

/// A study of `n` scenes by one method, rated on five steps, with short timings.
pub fn rate(n: usize, repetitions: u32) -> Definition {
    let scenes: Vec<String> = (0..n).map(|i| format!("scene-{i}")).collect();
    let text = serde_json::json!({
        "format": 1, "id": "rate", "title": "Rate", "seed": 11, "participants": 4, "task": "rate",
        "instructions": "Look.", "question": "How much?",
        "labels": ["very strong", "strong", "moderate", "slight", "none"], "scale": [1, 2, 3, 4, 5],
        "protocol": [{"show": "stimulus", "seconds": 2.0}],
        "blank": {"seconds": 0.5},
        "conditions": {"cross": {"scene": scenes, "method": ["sssr"]}},
        "repetitions": repetitions,
        "practice": [{"scene": "pink", "method": "sssr"}],
        "simulation": {"latent": {"sssr": 3.0}, "noise_sd": 1.0, "response_seconds": 1.0}
    });
    serde_json::from_value(text).expect("a study for tests")
}

/// A study of `n` scenes in which two methods are compared, toggled four times in ten seconds.
pub fn compare(n: usize, repetitions: u32) -> Definition {
    let scenes: Vec<String> = (0..n).map(|i| format!("scene-{i}")).collect();
    let text = serde_json::json!({
        "format": 1, "id": "compare", "title": "Compare", "seed": 11, "participants": 4, "task": "compare",
        "instructions": "Look.", "question": "Which?", "labels": ["A", "no difference", "B"],
        "preference": {"other": 1, "same": 2, "method": 3},
        "protocol": [
            {"show": "a", "seconds": 1.25}, {"show": "b", "seconds": 2.5}, {"show": "a", "seconds": 2.5},
            {"show": "b", "seconds": 2.5}, {"show": "a", "seconds": 1.25}
        ],
        "conditions": {"cross": {"scene": scenes, "method": ["sssr"], "other": ["path-traced"]}},
        "repetitions": repetitions,
        "simulation": {"latent": {"sssr": 3.0, "path-traced": 4.0}, "noise_sd": 0.7}
    });
    serde_json::from_value(text).expect("a study for tests")
}

/// Every record that a journal holds before trial 1.
pub fn preamble(definition: &Definition, plan: &super::plan::Plan) -> Vec<cyclopean_analysis::journal::Record> {
    use cyclopean_analysis::journal::record::{self, Record};
    let info = crate::display::headless::Headless::information(90.0);
    let header = record::Header {
        format: 1,
        study: record::Study {
            id: definition.id.clone(),
            title: definition.title.clone(),
            sha256: String::new(),
            text: String::new(),
            seed: definition.seed,
        },
        participant: "p01".to_owned(),
        session: "001".to_owned(),
        row: plan.order.row,
        question: definition.journal_question(),
        analysis: definition.analysis.clone(),
        program: super::session::program(),
        display: record::Display {
            kind: info.kind,
            system: info.system,
            runtime: info.runtime,
            trust: info.trust,
            nominal_hz: info.nominal_hz,
            measured_hz: None,
            interval_sd_ms: None,
            width_px: 1,
            height_px: 1,
            fov_deg: None,
            ipd_m: None,
            rendered_ipd_m: 0.063,
        },
        device: None,
        os: "test".to_owned(),
        consent: None,
        frozen_sha256: None,
        poses: None,
    };
    let stimulus = |id: usize| record::Stimulus {
        id: id as u32,
        key: String::new(),
        scene: String::new(),
        view: String::new(),
        method: String::new(),
        files: Default::default(),
        scene_sha256: None,
        shaders_sha256: None,
        renderer: None,
        film: None,
    };
    let mut out = vec![Record::Header(Box::new(header))];
    out.extend((0..plan.stimuli.len()).map(|id| Record::Stimulus(stimulus(id))));
    out.extend(plan.conditions.iter().cloned().map(Record::Condition));
    out.push(Record::Order(plan.order.clone()));
    out.extend(plan.presentations.iter().cloned().map(Record::Planned));
    out.push(Record::Ready(record::Ready { lines: out.len() as u64 }));
    out
}
