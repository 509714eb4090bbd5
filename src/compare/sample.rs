//! Made-up results, for tests of code that takes results.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::report::{EyeReport, PairsReport, Ratio, ReferenceReport, Rounds, Row, SceneReport};

/// A row with this median time for reflections, all of it for trace and resolve. The measures are the same in both eyes
/// and in both of its two rounds.
pub fn row(method: &str, spp: u32, ms: f64, measures: &[(&str, f64)]) -> Row {
    let eye = EyeReport {
        means: measures.iter().map(|(name, value)| ((*name).to_owned(), Some(*value))).collect(),
        bias2: None,
        variance: None,
        intervals: BTreeMap::new(),
    };
    let times: BTreeMap<String, f64> = ["total", "trace_resolve"].map(|g| (g.to_owned(), ms)).into();
    Row {
        rendered_method: method.to_owned(),
        method: method.to_owned(),
        spp,
        fallback: "black".to_owned(),
        seeds: 2,
        ms: times.clone(),
        ms_quartiles: BTreeMap::new(),
        passes: BTreeMap::new(),
        left: eye.clone(),
        right: eye,
        systematic_inconsistency: None,
        systematic_inconsistency_interval: None,
        systematic: None,
        systematic_unbiased: None,
        systematic_over: None,
        noise_variance: None,
        noise_variance_interval: None,
        noise_variance_relative: None,
        noise_over: None,
        jackknife: None,
        fireflies_total: 0,
        clamped: 0,
        rounds: Rounds {
            ms: vec![times; 2],
            measures: measures.iter().map(|(name, value)| ((*name).to_owned(), vec![*value; 2])).collect(),
        },
    }
}

/// A ratio of a row.
pub fn ratio(row: &Row, measure: &str, ratio: f64) -> Ratio {
    let interval = Some([ratio * 0.97, ratio * 1.03]);
    let (method, fallback, measure) = (row.method.clone(), row.fallback.clone(), measure.to_owned());
    Ratio { method, spp: row.spp, fallback, measure, ratio, interval }
}

/// A scene with these rows, with `sssr` as its baseline, and without ratios.
pub fn scene(name: &str, results: Vec<Row>) -> SceneReport {
    SceneReport {
        scene: name.to_owned(),
        scene_sha256: String::new(),
        view: "main".to_owned(),
        exposure: 1.0,
        reflective: 0.5,
        baseline: "sssr".to_owned(),
        reference: ReferenceReport { key: String::new(), files: PathBuf::new(), spp: 1024, variance: [1e-6; 2] },
        pairs: PairsReport { candidates: 0, used: 0, undecided: None, different: None, floor: None },
        results,
        equal_sample: Vec::new(),
        equal_time: Vec::new(),
        overhead: Vec::new(),
        left_out: Vec::new(),
    }
}
