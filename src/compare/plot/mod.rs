//! Drawings of a scene's results as SVG: error over time, and what a family of methods pays and gains with its percentage.

pub(super) mod axis;
pub(super) mod draw;
mod family;
mod knob;
pub(super) mod panels;
mod time;

use super::report::SceneReport;

/// Error over time, a drawing for each fallback of the scene; none where there is nothing to draw.
pub fn plots(scene: &SceneReport) -> Vec<(String, String)> {
    fallbacks(scene).into_iter().filter_map(|f| time::plot(scene, &f).map(|svg| (f, svg))).collect()
}

/// A family of methods against its percentage.
pub struct Knob {
    pub fallback: String,
    /// The methods' common name, with `@N` where the family has drawings at several sample counts.
    pub family: String,
    pub svg: String,
}

/// A drawing for every family of methods that differ in a percentage.
pub fn knobs(scene: &SceneReport) -> Vec<Knob> {
    let mut found = Vec::new();
    for fallback in fallbacks(scene) {
        let families = family::families(&scene.results, &fallback);
        for family in &families {
            if let Some(svg) = knob::plot(scene, family) {
                found.push(Knob { fallback: fallback.clone(), family: family.name(&families), svg });
            }
        }
    }
    found
}

/// In the order of the results.
fn fallbacks(scene: &SceneReport) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for row in &scene.results {
        if !found.contains(&row.fallback) {
            found.push(row.fallback.clone());
        }
    }
    found
}
