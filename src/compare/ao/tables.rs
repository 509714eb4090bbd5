//! Writes `ao.md`: the report as tables for people.

use std::fmt::Write as _;

use cyclopean_analysis::escape::markdown as markdown_of;

use super::super::tables::{columns, row};
use super::report::{AoReport, AoRow, AoScene};
use crate::render::Ao;

/// The names of the passes, in the order of a frame.
const PASSES: [&str; 9] = [
    "ao_pairs",
    "ao_obscurance",
    "ao_reproject",
    "ao_filter",
    "ao_adaptive",
    "ao_obscurance_listed",
    "ao_filter_listed",
    "ao_blend_listed",
    "ao_blend",
];

/// The whole document. `docs/compare.md` has the definitions.
pub fn markdown(report: &AoReport) -> String {
    let mut out = String::from("# Ambient occlusion between the eyes\n\n");
    let _ = writeln!(
        out,
        "{} ({}, {}) · {}×{} per eye · {} seeds · radius {} m · threshold {} · oracle {} rays a pixel\n",
        report.device.name,
        report.device.kind,
        report.device.driver,
        report.width,
        report.height,
        report.seeds,
        report.radius_m,
        percent(Some(f64::from(report.threshold))),
        report.rays
    );
    for scene in &report.scenes {
        section(&mut out, scene);
    }
    if report.scenes.len() > 1 {
        summary(&mut out, &report.scenes);
    }
    for failure in &report.failed {
        let _ = writeln!(out, "**{} failed:** {}\n", markdown_of(&failure.scene), markdown_of(&failure.error));
    }
    out
}

fn section(out: &mut String, scene: &AoScene) {
    let rays = &scene.ray_traced;
    let _ = writeln!(
        out,
        "## {} ({})\n\n{} of the left eye's pixels have a partner in the right eye. The rays took {:.0} ms; their mean \
        visibility is {} and their inconsistency {}.\n",
        markdown_of(&scene.scene),
        markdown_of(&scene.view),
        percent(Some(scene.paired)),
        rays.ms,
        number(rays.mean_visibility),
        percent(rays.inconsistency)
    );
    let names = ["method", "ms", "over mono", "inconsistency", "MAE, fsa", "MAE, rays", "worked on again"];
    columns(out, &names, 1);
    for of in &scene.methods {
        let cells = [
            name(of.method),
            format!("{:.2}", of.ms),
            format!("{:.3}", of.ratio[1]),
            percent(of.inconsistency),
            number(of.mae_fsa),
            number(of.mae_ray_traced),
            percent(of.again),
        ];
        row(out, cells.into_iter());
    }
    passes(out, &scene.methods);
    columns(out, &["method", "threshold", "over mono", "inconsistency", "MAE, fsa", "worked on again"], 1);
    for of in &scene.thresholds {
        let cells = [
            name(of.method),
            percent(Some(f64::from(of.threshold))),
            format!("{:.3}", of.ratio[1]),
            percent(of.inconsistency),
            number(of.mae_fsa),
            percent(of.again),
        ];
        row(out, cells.into_iter());
    }
    out.push('\n');
    if let Some(path) = &scene.path {
        let _ = writeln!(out, "Means over {} poses of a path:\n", path.poses);
        columns(out, &["method", "inconsistency", "MAE, fsa"], 1);
        for along in &path.methods {
            let cells = [name(along.method), percent(along.mean_inconsistency), number(along.mean_mae_fsa)];
            row(out, cells.into_iter());
        }
        out.push('\n');
    }
}

/// The table of times by pass.
fn passes(out: &mut String, rows: &[AoRow]) {
    let ran: Vec<&str> = PASSES.into_iter().filter(|p| rows.iter().any(|r| r.passes.contains_key(*p))).collect();
    out.push_str("\nMilliseconds by pass, both eyes, medians:\n\n");
    let names: Vec<&str> = std::iter::once("method").chain(ran.iter().copied()).collect();
    columns(out, &names, 1);
    for of in rows {
        let ms = |pass: &&str| of.passes.get(*pass).map_or("–".to_owned(), |ms| format!("{ms:.2}"));
        row(out, std::iter::once(name(of.method)).chain(ran.iter().map(ms)));
    }
    out.push('\n');
}

fn name(method: Ao) -> String {
    format!("`{}`", method.name())
}

/// The table over all scenes: geometric means of the times, and means of the shares of pixels and of the errors.
fn summary(out: &mut String, scenes: &[AoScene]) {
    let _ = writeln!(out, "## Over {} scenes\n", scenes.len());
    let times = ["method", "over mono, geometric mean", "least", "most"];
    columns(out, &[&times[..], &["inconsistency", "of fsa's", "MAE, fsa", "MAE, rays"]].concat(), 1);
    let methods = scenes.first().map_or(&[][..], |s| &s.methods);
    let fsa = methods.iter().position(|r| r.method == Ao::Fsa);
    for (i, method) in methods.iter().enumerate() {
        let rows: Vec<&AoRow> = scenes.iter().filter_map(|s| s.methods.get(i)).collect();
        let ratios: Vec<f64> = rows.iter().map(|r| r.ratio[1]).collect();
        let mean = |of: &dyn Fn(&AoRow) -> Option<f64>| crate::metrics::mean(rows.iter().filter_map(|r| of(r)));
        let geometric = crate::metrics::mean(ratios.iter().map(|r| r.ln())).map_or(f64::NAN, f64::exp);
        let inconsistency = mean(&|r| r.inconsistency);
        let of_fsa = fsa
            .and_then(|f| crate::metrics::mean(scenes.iter().filter_map(|s| s.methods.get(f)?.inconsistency)))
            .zip(inconsistency)
            .map(|(fsa, own)| own / fsa);
        let cells = [
            name(method.method),
            format!("{geometric:.3}"),
            format!("{:.3}", ratios.iter().copied().fold(f64::INFINITY, f64::min)),
            format!("{:.3}", ratios.iter().copied().fold(0.0, f64::max)),
            percent(inconsistency),
            of_fsa.map_or("–".to_owned(), |r| format!("{r:.3}")),
            number(mean(&|r| r.mae_fsa)),
            number(mean(&|r| r.mae_ray_traced)),
        ];
        row(out, cells.into_iter());
    }
    out.push('\n');
}

fn percent(share: Option<f64>) -> String {
    share.map_or("–".to_owned(), |s| format!("{:.2} %", 100.0 * s))
}

fn number(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |v| format!("{v:.5}"))
}
