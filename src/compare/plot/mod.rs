//! Draws a scene's results as SVG: error over time, and the time and errors of a family of methods against its
//! percentage. A scene's part of the report goes in. `compare` writes what comes out.

pub(super) mod axis;
pub(super) mod draw;
mod family;
pub(super) mod panels;
mod percentage;
mod time;

use super::report::SceneReport;

/// The drawings of error over time, one for each fallback of the scene that has something to draw, with the fallback's
/// name.
pub fn plots(scene: &SceneReport) -> Vec<(String, String)> {
    fallbacks(scene).into_iter().filter_map(|f| time::plot(scene, &f).map(|svg| (f, svg))).collect()
}

/// The drawing of a family of methods against its percentage.
pub struct FamilyPlot {
    pub fallback: String,
    /// The name that the methods share, with `@N` where the family has several sample counts.
    pub family: String,
    pub svg: String,
}

/// The drawings of all families of methods that differ in a percentage.
pub fn family_plots(scene: &SceneReport) -> Vec<FamilyPlot> {
    let mut found = Vec::new();
    for fallback in fallbacks(scene) {
        let families = family::families(&scene.results, &fallback);
        for family in &families {
            if let Some(svg) = percentage::plot(scene, family) {
                found.push(FamilyPlot { fallback: fallback.clone(), family: family.name(&families), svg });
            }
        }
    }
    found
}

/// The fallbacks of a scene's results, in their order.
fn fallbacks(scene: &SceneReport) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for row in &scene.results {
        if !found.contains(&row.fallback) {
            found.push(row.fallback.clone());
        }
    }
    found
}
