//! Writes `sequence.md`: the report as tables for people.

use std::fmt::Write as _;

use cyclopean_analysis::escape::markdown as markdown_of;

use super::report::{SequenceReport, SequenceScene};
use super::summary::{MEASURES, ratios};
use crate::compare::tables::{columns, row};

/// The titles of the columns, in the order of [`MEASURES`].
const TITLES: [&str; 9] = [
    "MSE",
    "bias²",
    "variance",
    "MSE, glossy",
    "MSE, uncovered",
    "flicker",
    "flicker, noise",
    "lasting contrast²",
    "noise",
];

/// The whole document. `docs/compare.md` has the definitions.
pub fn markdown(report: &SequenceReport) -> String {
    let mut out = String::from("# Reflections over time\n\n");
    let _ = writeln!(
        out,
        "{} ({}, {}) · {}×{} per eye · path `{}` · reference {} paths a pixel\n",
        report.device.name,
        report.device.kind,
        report.device.driver,
        report.width,
        report.height,
        markdown_of(&report.path),
        report.reference_spp
    );
    for scene in &report.scenes {
        section(&mut out, scene);
    }
    if report.scenes.len() > 1 {
        summary(&mut out, report);
    }
    for failure in &report.failed {
        let _ = writeln!(out, "**{} failed:** {}\n", markdown_of(&failure.scene), markdown_of(&failure.error));
    }
    out
}

fn section(out: &mut String, scene: &SequenceScene) {
    let _ = writeln!(
        out,
        "## {} ({})\n\n{} frames at {} a second.\n\n### Means over the frames\n",
        markdown_of(&scene.scene),
        markdown_of(&scene.view),
        scene.frames,
        scene.rate_hz
    );
    let names: Vec<&str> = ["method", "ms"].into_iter().chain(TITLES).chain(["lag, frames"]).collect();
    columns(out, &names, 1);
    for r in &scene.results {
        let ms = r.ms.get("total").map_or("–".to_owned(), |ms| format!("{ms:.1}"));
        let lag = r.lag_frames.map_or("–".to_owned(), |n| n.to_string());
        let means = MEASURES.map(|m| short(r.means.get(m).copied().flatten()));
        row(out, [format!("{}@{}", r.method, r.spp), ms].into_iter().chain(means).chain([lag]));
    }
    let others: Vec<_> = scene.results.iter().filter(|r| r.method != scene.baseline).collect();
    if !others.is_empty() {
        let _ = writeln!(out, "\n### Over `{}` with as many samples\n", scene.baseline);
        columns(out, &ratio_names(), 1);
    }
    for r in others {
        // If the baseline has no row with this number of samples, there is only the ratio at equal time.
        let mut cells = vec!["–".to_owned(); MEASURES.len() + 2];
        for (cell, (_, ratio)) in cells.iter_mut().zip(ratios(scene, r)) {
            *cell = short(ratio);
        }
        row(out, std::iter::once(format!("{}@{}", r.method, r.spp)).chain(cells));
    }
    out.push('\n');
}

fn ratio_names() -> Vec<&'static str> {
    ["method", "MSE at equal time", "ms"].into_iter().chain(TITLES).collect()
}

/// The table over all scenes: geometric means, and the worst scene.
fn summary(out: &mut String, report: &SequenceReport) {
    let _ = writeln!(out, "## Over {} scenes: geometric mean (worst)\n", report.scenes.len());
    columns(out, &ratio_names(), 1);
    let mut methods: Vec<(&str, u32)> = Vec::new();
    for s in &report.summary {
        if !methods.contains(&(&s.method, s.spp)) {
            methods.push((&s.method, s.spp));
        }
    }
    for (method, spp) in methods {
        let cell = |measure: &str| {
            let of = report.summary.iter().find(|s| s.method == method && s.spp == spp && s.measure == measure);
            of.map_or("–".to_owned(), |s| {
                let voters =
                    if s.scenes < report.scenes.len() { format!(", {} scenes", s.scenes) } else { String::new() };
                format!("{} ({}{voters})", short(Some(s.geomean)), short(Some(s.worst)))
            })
        };
        let cells = ["equal_time_mse", "ms_total"].into_iter().chain(MEASURES).map(cell);
        row(out, std::iter::once(format!("{method}@{spp}")).chain(cells));
    }
    out.push('\n');
}

/// A number with three decimals, or with an exponent where it is small or large.
fn short(value: Option<f64>) -> String {
    match value {
        None => "–".to_owned(),
        Some(v) if v != 0.0 && (v.abs() < 1e-3 || v.abs() >= 1e4) => format!("{v:.2e}"),
        Some(v) => format!("{v:.3}"),
    }
}
