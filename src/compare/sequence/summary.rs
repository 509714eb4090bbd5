//! Ratios of each method to the baseline with the same number of samples, and their geometric means over the scenes.
//! [`super::compare`] calls it.

use super::report::{SequenceRow, SequenceScene, SequenceSummary};
use crate::compare::ratios::geometric;

/// The measures that are compared, in the order of the tables.
pub const MEASURES: [&str; 9] = [
    "mse",
    "bias2",
    "variance",
    "glossy_mse",
    "uncovered_mse",
    "flicker",
    "noise_flicker",
    "lasting_contrast2",
    "noise",
];

/// The geometric means over the scenes. A scene whose ratio is not a positive number is left out.
pub fn over_scenes(scenes: &[SequenceScene]) -> Vec<SequenceSummary> {
    let mut groups: Vec<(String, u32, String, Vec<f64>)> = Vec::new();
    for scene in scenes {
        for row in &scene.results {
            for (measure, ratio) in ratios(scene, row) {
                let Some(ratio) = ratio.filter(|r| r.is_finite() && *r > 0.0) else { continue };
                let same =
                    |g: &&mut (String, u32, String, Vec<f64>)| g.0 == row.method && g.1 == row.spp && g.2 == measure;
                match groups.iter_mut().find(same) {
                    Some(group) => group.3.push(ratio),
                    None => groups.push((row.method.clone(), row.spp, measure, vec![ratio])),
                }
            }
        }
    }
    let summary = |(method, spp, measure, found): (String, u32, String, Vec<f64>)| {
        let (geomean, interval) = geometric(&found.iter().map(|r| r.ln()).collect::<Vec<_>>());
        let worst = found.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Some(SequenceSummary { method, spp, measure, geomean: geomean?, interval, worst, scenes: found.len() })
    };
    groups.into_iter().filter_map(summary).collect()
}

/// The ratios of a row to the baseline's row with the same number of samples. The baseline's own rows have none.
pub fn ratios(scene: &SequenceScene, row: &SequenceRow) -> Vec<(String, Option<f64>)> {
    if row.method == scene.baseline {
        return Vec::new();
    }
    let mut found = vec![("equal_time_mse".to_owned(), row.equal_time.map(|e| e.ratio))];
    if let Some(peer) = scene.results.iter().find(|r| r.method == scene.baseline && r.spp == row.spp) {
        let total = |r: &SequenceRow| r.ms.get("total").copied();
        found.push(("ms_total".to_owned(), total(row).zip(total(peer)).map(|(a, b)| a / b)));
        // A product of two runs may be negative by chance. Then there is no ratio.
        let value = |r: &SequenceRow, m| r.means.get(m).copied().flatten().filter(|v| *v > 0.0);
        found.extend(MEASURES.map(|m| (m.to_owned(), value(row, m).zip(value(peer, m)).map(|(a, b)| a / b))));
    }
    found
}
