//! `ao.md`: the report as tables for people.

use std::fmt::Write as _;

use super::report::{AoReport, AoRow, AoScene};

/// The passes in the order of a frame.
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

/// The whole document. Definitions stand in `docs/compare.md`.
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
        let _ = writeln!(out, "**{} failed:** {}\n", failure.scene, failure.error);
    }
    out
}

fn section(out: &mut String, scene: &AoScene) {
    let rays = &scene.ray_traced;
    let _ = writeln!(
        out,
        "## {} ({})\n\n{} of the left eye's pixels have a pair. Rays: {:.0} ms, mean visibility {}, inconsistency {}.\n",
        scene.scene,
        scene.view,
        percent(Some(scene.paired)),
        rays.ms,
        number(rays.mean_visibility),
        percent(rays.inconsistency)
    );
    out.push_str("| method | ms | over mono | inconsistency | MAE, fsa | MAE, rays | worked on again |\n");
    out.push_str("|---|---:|---:|---:|---:|---:|---:|\n");
    for row in &scene.methods {
        let _ = writeln!(
            out,
            "| `{}` | {:.2} | {:.3} | {} | {} | {} | {} |",
            row.method.name(),
            row.ms,
            row.ratio[1],
            percent(row.inconsistency),
            number(row.mae_fsa),
            number(row.mae_ray_traced),
            row.again.map_or("–".to_owned(), |share| percent(Some(share)))
        );
    }
    passes(out, &scene.methods);
    out.push_str("| method | threshold | over mono | inconsistency | MAE, fsa | worked on again |\n");
    out.push_str("|---|---:|---:|---:|---:|---:|\n");
    for row in &scene.thresholds {
        let _ = writeln!(
            out,
            "| `{}` | {} | {:.3} | {} | {} | {} |",
            row.method.name(),
            percent(Some(f64::from(row.threshold))),
            row.ratio[1],
            percent(row.inconsistency),
            number(row.mae_fsa),
            percent(row.again)
        );
    }
    out.push('\n');
    if let Some(path) = &scene.path {
        let _ = writeln!(
            out,
            "Means over {} poses of a path:\n\n| method | inconsistency | MAE, fsa |\n|---|---:|---:|",
            path.poses
        );
        for along in &path.methods {
            let (inconsistency, error) = (percent(along.mean_inconsistency), number(along.mean_mae_fsa));
            let _ = writeln!(out, "| `{}` | {inconsistency} | {error} |", along.method.name());
        }
        out.push('\n');
    }
}

/// Milliseconds by pass.
fn passes(out: &mut String, rows: &[AoRow]) {
    let ran: Vec<&str> = PASSES.into_iter().filter(|p| rows.iter().any(|r| r.passes.contains_key(*p))).collect();
    let _ = writeln!(out, "\nMilliseconds by pass, both eyes, medians:\n\n| method | {} |", ran.join(" | "));
    let _ = writeln!(out, "|---|{}", "---:|".repeat(ran.len()));
    for row in rows {
        let cells: Vec<String> =
            ran.iter().map(|p| row.passes.get(*p).map_or("–".to_owned(), |ms| format!("{ms:.2}"))).collect();
        let _ = writeln!(out, "| `{}` | {} |", row.method.name(), cells.join(" | "));
    }
    out.push('\n');
}

/// Over all scenes: geometric means of the times, the pixels' and errors' means.
fn summary(out: &mut String, scenes: &[AoScene]) {
    let _ = writeln!(
        out,
        "## Over {} scenes\n\n| method | over mono, geometric mean | least | most | inconsistency | of fsa's | MAE, fsa | MAE, rays |\n\
         |---|---:|---:|---:|---:|---:|---:|---:|",
        scenes.len()
    );
    let methods = scenes.first().map_or(&[][..], |s| &s.methods);
    let fsa = methods.iter().position(|r| r.method == crate::render::Ao::Fsa);
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
        let _ = writeln!(
            out,
            "| `{}` | {geometric:.3} | {:.3} | {:.3} | {} | {} | {} | {} |",
            method.method.name(),
            ratios.iter().copied().fold(f64::INFINITY, f64::min),
            ratios.iter().copied().fold(0.0, f64::max),
            percent(inconsistency),
            of_fsa.map_or("–".to_owned(), |r| format!("{r:.3}")),
            number(mean(&|r| r.mae_fsa)),
            number(mean(&|r| r.mae_ray_traced))
        );
    }
    out.push('\n');
}

fn percent(share: Option<f64>) -> String {
    share.map_or("–".to_owned(), |s| format!("{:.2} %", 100.0 * s))
}

fn number(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |v| format!("{v:.5}"))
}
