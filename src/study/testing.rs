//! Small studies for unit tests.

use super::definition::Definition;

/// `n` scenes rated on five steps by one method, timings short.
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

/// `n` scenes, two methods compared, toggled four times in ten seconds.
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
