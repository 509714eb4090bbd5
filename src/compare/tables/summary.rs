//! The tables over all scenes: geometric means, and which scenes they leave out. The report's summary goes in.

use std::fmt::Write as _;

use cyclopean_analysis::escape::markdown as markdown_of;

use super::{EQUAL_SAMPLE, by_networks, head, ratio, row};
use crate::compare::report::Summary;

/// The title and the measure of each column.
type Columns<'a> = &'a [(&'a str, &'a str)];

const TIMES: [(&str, &str); 7] = [
    ("total", "ms_total"),
    ("trace + resolve", "ms_trace_resolve"),
    ("trace", "ms_trace"),
    ("resolve", "ms_resolve"),
    ("MSE at equal time", "equal_time_mse"),
    ("relMSE at equal time", "equal_time_relmse"),
    ("tone-mapped MSE at equal time", "equal_time_tonemapped_mse"),
];

/// Writes two tables and, below each, the scenes that are left out.
pub fn summary(out: &mut String, summary: &[Summary], scenes: usize) {
    let _ = writeln!(out, "## All {scenes} scenes\n");
    table(out, summary, "Times, and errors at equal time", &TIMES);
    let has = |measure: &str| summary.iter().any(|s| s.measure == measure);
    let columns: Vec<(&str, &str)> = EQUAL_SAMPLE.into_iter().chain(by_networks(has)).collect();
    table(out, summary, "Equal samples", &columns);
}

/// Writes a table with a row for each configuration and a column for each measure.
fn table(out: &mut String, summary: &[Summary], title: &str, columns: Columns<'_>) {
    let title = format!("{title}: geometric means of the ratios, 95 % intervals over scenes, ≤ the worst scene");
    let names: Vec<&str> = ["method"].into_iter().chain(columns.iter().map(|m| m.0)).collect();
    head(out, &title, &names, 1);
    let mut seen: Vec<(&str, u32, &str)> = Vec::new();
    for s in summary {
        let which = configuration(s);
        if seen.contains(&which) {
            continue;
        }
        seen.push(which);
        let cell = |(_, measure): &(&str, &str)| {
            let found = summary.iter().find(|o| configuration(o) == which && o.measure == *measure);
            found.map_or_else(|| "–".to_owned(), text)
        };
        row(out, std::iter::once(name(s, summary)).chain(columns.iter().map(cell)));
    }
    out.push('\n');
    left_out(out, summary, columns);
}

fn configuration(s: &Summary) -> (&str, u32, &str) {
    (s.method.as_str(), s.spp, s.fallback.as_str())
}

/// The name of a configuration, with the fallback where there are several.
fn name(s: &Summary, all: &[Summary]) -> String {
    let two = all.iter().any(|o| o.fallback != all[0].fallback);
    let name = format!("{}@{}", s.method, s.spp);
    if two { format!("{name}, {}", s.fallback) } else { name }
}

/// The text of a cell. It says so where a mean leaves scenes out.
fn text(s: &Summary) -> String {
    let mean = match (s.geomean, s.worst) {
        (Some(mean), Some(worst)) => format!("{}, ≤ {worst:.3}", ratio(mean, s.interval)),
        _ => "–".to_owned(),
    };
    if s.left_out.is_empty() { mean } else { format!("{mean}, **{}**", votes(s)) }
}

fn votes(s: &Summary) -> String {
    format!("{} of {} scenes", s.scenes, s.scenes + s.left_out.len())
}

/// Writes below the table which scenes are left out, and why.
fn left_out(out: &mut String, summary: &[Summary], columns: Columns<'_>) {
    let mut lines = Vec::new();
    for s in summary.iter().filter(|s| !s.left_out.is_empty()) {
        let Some((title, _)) = columns.iter().find(|(_, measure)| *measure == s.measure) else { continue };
        let scenes: Vec<String> =
            s.left_out.iter().map(|l| format!("{} left out: {}", markdown_of(&l.scene), markdown_of(&l.why))).collect();
        lines.push(format!("- `{}`, {title}: {}; {}.", name(s, summary), votes(s), scenes.join("; ")));
    }
    if !lines.is_empty() {
        let _ = writeln!(out, "**Not every scene has a vote in these means:**\n\n{}\n", lines.join("\n"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::report::SceneWithoutRatio;

    #[test]
    fn a_reader_sees_who_has_no_vote() {
        let summary_of =
            |measure: &str, scenes: usize, geomean: Option<f64>, left_out: Vec<SceneWithoutRatio>| Summary {
                method: "stereo".to_owned(),
                spp: 1,
                fallback: "black".to_owned(),
                measure: measure.to_owned(),
                geomean,
                interval: None,
                worst: geomean,
                scenes,
                left_out,
            };
        let wine = || SceneWithoutRatio {
            scene: "wine".to_owned(),
            why: "the baseline's is 0, so there is nothing to divide by".to_owned(),
        };
        let all = [
            summary_of("mse", 5, Some(0.5), Vec::new()),
            summary_of("noise_variance", 4, Some(0.25), vec![wine()]),
            summary_of("bias2", 0, None, vec![wine()]),
        ];
        let mut out = String::new();
        summary(&mut out, &all, 5);
        assert!(out.contains("| 0.500, ≤ 0.500 |"), "{out}");
        assert!(out.contains("| 0.250, ≤ 0.250, **4 of 5 scenes** |"), "{out}");
        assert!(out.contains("| –, **0 of 1 scenes** |"), "{out}");
        let line =
            "- `stereo@1`, noise: 4 of 5 scenes; wine left out: the baseline's is 0, so there is nothing to divide by.";
        assert!(out.contains(line), "{out}");
    }
}
