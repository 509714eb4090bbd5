//! Writes `compare.md`: the report as tables for people. A [`Report`] goes in and Markdown comes out. `super::markdown`
//! calls it, and the other comparisons use its functions for tables.

mod summary;

use std::fmt::Write as _;

use cyclopean_analysis::escape::markdown as markdown_of;

use super::report::{Report, Row, SceneReport};

/// The groups of passes that are columns of the tables of times.
const GROUPS: [&str; 7] = ["total", "trace_resolve", "trace", "resolve", "backface", "depth_pyramid", "classify"];

/// The columns of the tables at equal samples: the title and the measure.
const EQUAL_SAMPLE: [(&str, &str); 11] = [
    ("MSE", "mse"),
    ("relMSE", "relmse"),
    ("tone-mapped MSE", "tonemapped_mse"),
    ("1 − SSIM", "one_minus_ssim"),
    ("1 − SSIM, reflection", "one_minus_reflection_ssim"),
    ("FLIP", "flip"),
    ("bias²", "bias2"),
    ("variance", "variance"),
    ("systematic", "systematic_inconsistency"),
    ("lasting contrast²", "systematic_unbiased"),
    ("noise", "noise_variance"),
];

/// Further such columns, for the measures by networks. They are shown where the network was named.
const EQUAL_SAMPLE_BY_NETWORKS: [(&str, &str); 4] = [
    ("LPIPS", "lpips"),
    ("DISTS", "dists"),
    ("LPIPS, reflection", "reflection_lpips"),
    ("DISTS, reflection", "reflection_dists"),
];

/// The columns of [`EQUAL_SAMPLE_BY_NETWORKS`] whose measure is there, as `has` says.
fn by_networks(has: impl Fn(&str) -> bool) -> impl Iterator<Item = (&'static str, &'static str)> {
    EQUAL_SAMPLE_BY_NETWORKS.into_iter().filter(move |(_, measure)| has(measure))
}

/// Whether a scene's results have a measure, even if it is undefined.
fn has(scene: &SceneReport) -> impl Fn(&str) -> bool {
    |measure| scene.results.iter().any(|r| r.left.means.contains_key(measure))
}

/// The whole document. `docs/compare.md` has the definitions.
pub fn markdown(report: &Report) -> String {
    let mut out = String::from("# Error against run time\n\n");
    let _ = writeln!(
        out,
        "{} ({}, {}) · {}×{} per eye · {} seeds · reference {} paths a pixel · FLIP at {} pixels per degree\n",
        report.device.name,
        report.device.kind,
        report.device.driver,
        report.width,
        report.height,
        report.seeds,
        report.reference_spp,
        report.pixels_per_degree
    );
    if report.networks.is_empty() {
        out.push_str("LPIPS and DISTS are absent: their networks were not named (`--lpips`, `--dists`).\n\n");
    }
    for (measure, sha256) in &report.networks {
        let _ = writeln!(out, "{} by the network with SHA-256 `{sha256}`.\n", measure.to_uppercase());
    }
    for scene in &report.scenes {
        scene_section(&mut out, scene);
    }
    if report.scenes.len() > 1 {
        summary::summary(&mut out, &report.summary, report.scenes.len());
    }
    for failure in &report.failed {
        let _ = writeln!(out, "**{} failed:** {}\n", markdown_of(&failure.scene), markdown_of(&failure.error));
    }
    out
}

fn scene_section(out: &mut String, scene: &SceneReport) {
    let _ = writeln!(out, "## {} ({})\n", markdown_of(&scene.scene), markdown_of(&scene.view));
    let p = &scene.pairs;
    let _ = writeln!(
        out,
        "{} of the pixels trace a reflection ray. The variance of the reference itself is {} (left) and {} (right). \
        Geometry gives {} pairs of pixels, and {} of them are used. For {} the reference is too noisy to tell whether \
        they match, and {} differ in it. In a reference with another seed, {} of the used pairs differ by more than \
        2 %.\n",
        percent(Some(scene.reflective)),
        short(Some(scene.reference.variance[0])),
        short(Some(scene.reference.variance[1])),
        p.candidates,
        p.used,
        percent(p.undecided),
        percent(p.different),
        percent(p.floor)
    );
    times(out, scene);
    errors(out, scene);
    inconsistency(out, scene);
    let others = scene.results.iter().any(|r| r.method != scene.baseline);
    if others {
        equal_sample(out, scene);
        equal_time(out, scene);
        overhead(out, scene);
    }
}

/// The heading of a table, and its first two lines.
fn head(out: &mut String, title: &str, names: &[&str], words: usize) {
    let _ = writeln!(out, "### {title}\n");
    columns(out, names, words);
}

/// The first two lines of a table: the names of the columns, and how they are aligned. The first `words` columns are
/// aligned to the left and the others to the right.
pub(super) fn columns(out: &mut String, names: &[&str], words: usize) {
    row(out, names.iter().map(|n| (*n).to_owned()));
    row(out, (0..names.len()).map(|i| if i < words { "---" } else { "---:" }.to_owned()));
}

/// A line of a table.
pub(super) fn row(out: &mut String, cells: impl Iterator<Item = String>) {
    let _ = writeln!(out, "| {} |", cells.map(|c| markdown_of(&c)).collect::<Vec<_>>().join(" | "));
}

/// The name of a row, such as `stereo@2`, with the fallback where the scene has several.
fn label(scene: &SceneReport, method: &str, spp: u32, fallback: &str) -> String {
    let two = scene.results.iter().any(|r| r.fallback != fallback);
    if two { format!("{method}@{spp}, {fallback}") } else { format!("{method}@{spp}") }
}

fn row_label(scene: &SceneReport, r: &Row) -> String {
    label(scene, &r.method, r.spp, &r.fallback)
}

fn times(out: &mut String, scene: &SceneReport) {
    let names = ["method", "total", "trace + resolve", "trace", "resolve", "backface", "depth_pyramid", "classify"];
    head(out, "Time of the reflections, ms: median over rounds, first to third quartile of the total", &names, 1);
    for r in &scene.results {
        let cell = |group: &&str| r.ms.get(*group).map_or_else(|| "–".to_owned(), |ms| format!("{ms:.2}"));
        let quartiles = r.ms_quartiles.get("total").map(|q| format!(" ({:.2}–{:.2})", q[0], q[1])).unwrap_or_default();
        let cells = GROUPS.iter().map(cell).enumerate();
        let cells = cells.map(|(i, c)| if i == 0 { format!("{c}{quartiles}") } else { c });
        row(out, std::iter::once(row_label(scene, r)).chain(cells));
    }
    out.push('\n');
}

fn errors(out: &mut String, scene: &SceneReport) {
    let title = "Error against the reference, left / right eye; ± half the 95 % interval over seeds";
    let names = [
        "method",
        "MSE",
        "RSE",
        "relMSE",
        "tone-mapped MSE",
        "bias²",
        "variance",
        "SSIM",
        "SSIM, reflection",
        "FLIP",
        "fireflies a megapixel",
        "fireflies, all seeds and eyes",
    ];
    let distances: Vec<(&str, &str)> = by_networks(has(scene)).collect();
    let names: Vec<&str> = names.into_iter().chain(distances.iter().map(|(title, _)| *title)).collect();
    head(out, title, &names, 1);
    for r in &scene.results {
        let eyes = [&r.left, &r.right];
        let both = |f: &dyn Fn(usize) -> String| format!("{} / {}", f(0), f(1));
        let measured = |name: &str, print: &dyn Fn(Option<f64>) -> String| {
            both(&|eye| {
                let mean = print(eyes[eye].means.get(name).copied().flatten());
                let half = eyes[eye].intervals.get(name).map(|i| (i[1] - i[0]) / 2.0);
                half.map_or_else(|| mean.clone(), |h| format!("{mean} ± {}", print(Some(h))))
            })
        };
        let cells = [
            row_label(scene, r),
            measured("mse", &short),
            measured("rse", &short),
            measured("relmse", &short),
            measured("tonemapped_mse", &short),
            both(&|eye| short(eyes[eye].bias2)),
            both(&|eye| short(eyes[eye].variance)),
            measured("ssim", &fixed),
            measured("reflection_ssim", &fixed),
            measured("flip", &fixed),
            measured("fireflies", &|v| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.1}"))),
            r.fireflies_total.to_string(),
        ];
        let distances = distances.iter().map(|(_, measure)| measured(measure, &fixed));
        row(out, cells.into_iter().chain(distances));
    }
    out.push('\n');
}

fn inconsistency(out: &mut String, scene: &SceneReport) {
    let names = [
        "method",
        "systematic",
        "raw > 2 %",
        "by chance",
        "systematic > 10 %",
        "RMS contrast",
        "lasting contrast², unbiased",
        "variance of L − R",
        "relative",
        "> 2 %",
        "> 5 %",
        "> 10 %",
        "> 20 %",
    ];
    let title = "Inconsistency between the eyes as shares of the pairs, from `> 2 %` on in single frames; \
    in brackets 95 % intervals over seeds";
    head(out, title, &names, 1);
    for r in &scene.results {
        let over = |percents: u32| percent(r.noise_over.as_ref().and_then(|n| n.get(&percents).copied()));
        let s = r.systematic;
        let within = |value: String, ends: Option<[f64; 2]>, print: &dyn Fn(Option<f64>) -> String| {
            ends.map_or_else(
                || value.clone(),
                |[lo, hi]| format!("{value} ({} to {})", print(Some(lo)), print(Some(hi))),
            )
        };
        let unbiased = r.systematic_unbiased;
        let cells = [
            row_label(scene, r),
            within(percent(r.systematic_inconsistency), r.systematic_inconsistency_interval, &percent),
            percent(s.map(|s| s.raw)),
            percent(s.map(|s| s.by_chance)),
            percent(r.systematic_over.as_ref().and_then(|o| o.get(&10).copied())),
            percent(s.map(|s| s.rms)),
            within(short(unbiased.map(|u| u.squared)), unbiased.and_then(|u| u.interval), &short),
            within(short(r.noise_variance), r.noise_variance_interval, &short),
            short(r.noise_variance_relative),
            over(2),
            over(5),
            over(10),
            over(20),
        ];
        row(out, cells.into_iter());
    }
    out.push('\n');
}

fn equal_sample(out: &mut String, scene: &SceneReport) {
    let title = format!("Equal samples: ratios to `{}` and 95 % intervals over seeds", scene.baseline);
    let columns: Vec<(&str, &str)> = EQUAL_SAMPLE.into_iter().chain(by_networks(has(scene))).collect();
    let names: Vec<&str> = ["method"].into_iter().chain(columns.iter().map(|(title, _)| *title)).collect();
    head(out, &title, &names, 1);
    for r in scene.results.iter().filter(|r| r.method != scene.baseline) {
        let cell = |(_, measure): &(&str, &str)| {
            let same = |q: &&super::report::Ratio| {
                (&q.method, q.spp, &q.fallback, q.measure.as_str()) == (&r.method, r.spp, &r.fallback, *measure)
            };
            scene.equal_sample.iter().find(same).map_or_else(|| "–".to_owned(), |q| ratio(q.ratio, q.interval))
        };
        row(out, std::iter::once(row_label(scene, r)).chain(columns.iter().map(cell)));
    }
    out.push('\n');
    let missing = scene.left_out.iter().filter_map(|l| {
        let title = columns.iter().find(|(_, measure)| *measure == l.measure)?.0;
        Some(format!("`{}`, {title}: {}", label(scene, &l.method, l.spp, &l.fallback), l.why))
    });
    let missing: Vec<String> = missing.collect();
    if !missing.is_empty() {
        let _ = writeln!(out, "Without a ratio: {}.\n", missing.join("; "));
    }
}

fn equal_time(out: &mut String, scene: &SceneReport) {
    if scene.equal_time.is_empty() {
        let _ = writeln!(
            out,
            "No equal-time table: `{}` was measured with fewer than two sample counts (`--spp 1,2,4`).\n",
            scene.baseline
        );
        return;
    }
    let title = format!("Equal time: errors over those of `{}` at the same reflection time", scene.baseline);
    let names = ["method", "ms", "MSE", "baseline's MSE", "MSE ratio", "relMSE ratio", "tone-mapped MSE ratio"];
    head(out, &title, &names, 1);
    for e in &scene.equal_time {
        let mark = if e.extrapolated { " (extrapolated)" } else { "" };
        let other = |ratio: Option<f64>| ratio.map_or_else(|| "–".to_owned(), |r| format!("{r:.3}{mark}"));
        let cells = [
            label(scene, &e.method, e.spp, &e.fallback),
            format!("{:.2}", e.ms),
            short(Some(e.mse)),
            short(Some(e.baseline_mse)),
            format!("{:.3}{mark}", e.ratio),
            other(e.relmse_ratio),
            other(e.tonemapped_mse_ratio),
        ];
        row(out, cells.into_iter());
    }
    out.push('\n');
}

fn overhead(out: &mut String, scene: &SceneReport) {
    let title =
        format!("Time over `{}` with as many samples: median of the rounds' ratios and quartiles", scene.baseline);
    let names = ["method", "total", "trace + resolve", "trace", "resolve", "backface", "depth_pyramid", "classify"];
    head(out, &title, &names, 1);
    for r in scene.results.iter().filter(|r| r.method != scene.baseline) {
        let cell = |group: &&str| {
            let same = |o: &&super::report::Overhead| {
                (&o.method, o.spp, &o.fallback, o.group.as_str()) == (&r.method, r.spp, &r.fallback, *group)
            };
            scene.overhead.iter().find(same).map_or_else(|| "–".to_owned(), |o| ratio(o.median, Some(o.quartiles)))
        };
        row(out, std::iter::once(row_label(scene, r)).chain(GROUPS.iter().map(cell)));
    }
    out.push('\n');
}

fn ratio(value: f64, interval: Option<[f64; 2]>) -> String {
    interval.map_or_else(|| format!("{value:.3}"), |i| format!("{value:.3} ({:.3}–{:.3})", i[0], i[1]))
}

fn short(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |v| format!("{v:.3e}"))
}

fn fixed(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |v| format!("{v:.4}"))
}

fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| "–".to_owned(), |s| format!("{:.1} %", 100.0 * s))
}
