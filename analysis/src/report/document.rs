//! The report as blocks, which every format writes in its own way.

use super::input::{ReportInput, Results, StudyReport, spearman};
use super::{svg, text};
use crate::contrast::ContrastResult;
use crate::data::outcome_name;
use crate::inspect::trust_name;
use crate::journal::plan::AnalysisPlan;
use crate::mos::{Row, Table};
use crate::special::p_text;
use crate::wilcoxon::percent;

/// A part of a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Block {
    /// A heading of level 1 or 2.
    Heading(u8, String),
    /// The headings of level 1, as links.
    Contents,
    /// A paragraph.
    Text(String),
    /// A list of remarks.
    Notes(Vec<String>),
    /// A table.
    Table {
        /// What it shows, with the stamp and the convention.
        caption: String,
        /// The header.
        head: Vec<String>,
        /// The rows.
        rows: Vec<Vec<String>>,
    },
    /// A drawing; formats without drawings leave it out.
    Plot {
        /// What it shows.
        caption: String,
        /// An SVG element.
        svg: String,
    },
    /// A drawing with colours of its own, whose styles must not affect the page.
    Drawing {
        /// What it shows.
        caption: String,
        /// A whole SVG file.
        svg: String,
    },
    /// A picture.
    Picture {
        /// What it shows.
        caption: String,
        /// PNG bytes.
        png: Vec<u8>,
    },
    /// Long text that is hidden until its summary line is opened.
    Details {
        /// The summary line.
        summary: String,
        /// The text, its line breaks kept.
        body: String,
    },
}

/// The whole report.
pub fn document(input: &ReportInput) -> Vec<Block> {
    let mut out = Vec::new();
    summary(input, &mut out);
    for study in &input.studies {
        one_study(input, study, &mut out);
    }
    if !input.figures.is_empty() {
        out.push(Block::Heading(1, "Stimuli".into()));
        out.extend(input.figures.iter().map(|f| Block::Picture { caption: f.caption.clone(), png: f.png.clone() }));
    }
    participants(input, &mut out);
    timing(input, &mut out);
    provenance(input, &mut out);
    out
}

/// One study's scores and tests of all its participants, as they appear in its part of the report.
pub fn scores(input: &ReportInput, study: &StudyReport) -> Vec<Block> {
    let mut out = Vec::new();
    results(input, study, &study.all, "", &mut out);
    out
}

fn stamp(input: &ReportInput, caption: &str) -> String {
    match &input.stamp {
        Some(s) => format!("{} data. {caption}", s.to_uppercase()),
        None => caption.to_owned(),
    }
}

fn summary(input: &ReportInput, out: &mut Vec<Block>) {
    let mut lines = Vec::new();
    for s in &input.studies {
        let name = if s.study.id.is_empty() { "The data".to_owned() } else { format!("Study {}", s.study.id) };
        lines.push(format!(
            "{name}: {} participants, {} votes.",
            s.participants,
            s.all.table.rows.iter().map(|r| r.votes).sum::<u64>()
        ));
        if let Some(c) = s.all.contrasts.iter().find(|c| c.at.is_none()) {
            lines.push(format!(
                "{}: mean paired difference {:.2} scale steps, {} CI [{}, {}]; p = {} ({}, n = {}).",
                text::name(c),
                c.difference.mean,
                percent(c.difference.level),
                text::number(c.difference.lo),
                text::number(c.difference.hi),
                p_text(c.p_adjusted),
                if c.test.p_exact.is_some() { "exact signed-rank" } else { "asymptotic signed-rank" },
                c.test.n
            ));
        }
        for e in &s.all.equivalences {
            lines.push(format!(
                "{} and {} are {}equivalent within ±{} steps (p = {}).",
                e.a,
                e.b,
                if e.result.equivalent { "" } else { "not shown to be " },
                e.result.margin,
                p_text(e.result.p)
            ));
        }
        if s.all.equivalences.is_empty() && !s.study.forced_choice {
            lines.push(
                "No margin of equivalence was fixed: a difference that is not significant is not shown to be absent."
                    .into(),
            );
        }
        if let Some(p) = &s.all.preference {
            lines.push(format!(
                "Forced choice, all conditions: p = {} (exact signed-rank of participants' sums, n = {}).",
                p.overall.p_exact.map_or_else(|| "-".into(), p_text),
                p.overall.n
            ));
        }
    }
    out.push(Block::Notes(lines));
}

fn one_study(input: &ReportInput, s: &StudyReport, out: &mut Vec<Block>) {
    let title = s
        .study
        .title
        .clone()
        .unwrap_or_else(|| if s.study.id.is_empty() { "Ratings".into() } else { s.study.id.clone() });
    out.push(Block::Heading(1, title));
    definition(s, out);
    results(input, s, &s.all, "", out);
    if let Some(kept) = &s.kept {
        out.push(Block::Heading(2, "The same without excluded participants".into()));
        results(input, s, kept, "without excluded participants", out);
    }
    metrics(input, s, out);
    screening(input, s, out);
}

fn definition(s: &StudyReport, out: &mut Vec<Block>) {
    out.push(Block::Heading(2, "Definition".into()));
    let study = &s.study;
    let mut lines = Vec::new();
    if !study.id.is_empty() {
        lines.push(format!("study id {}", study.id));
    }
    if let Some(sha) = &study.sha256 {
        lines.push(format!("study file SHA-256 {sha}"));
    }
    if !study.scale.is_empty() {
        let kind = if study.forced_choice { "forced choice" } else { "scale" };
        lines.push(format!(
            "{kind}: {}",
            study.scale.iter().map(|(v, w)| format!("{v} {w}")).collect::<Vec<_>>().join(", ")
        ));
    }
    if let Some(plan) = &study.plan {
        lines.extend(plan_lines(plan));
    }
    if lines.is_empty() {
        lines.push("the source holds ratings only; nothing in it says how the study was defined".into());
    }
    out.push(Block::Notes(lines));
    if let Some(text) = &study.text {
        out.push(Block::Details {
            summary: "The study file, as the sessions ran it".into(),
            body: text.replace("\r\n", "\n"),
        });
    }
}

fn plan_lines(plan: &AnalysisPlan) -> Vec<String> {
    let mut lines: Vec<String> = plan
        .contrasts
        .iter()
        .map(|c| {
            let per = c.per.as_ref().map(|p| format!(", per {p}")).unwrap_or_default();
            format!("contrast fixed beforehand: {} - {} ({}, family {}{per})", c.a, c.b, c.factor, c.family)
        })
        .collect();
    if let Some(e) = &plan.equivalence {
        lines.push(format!("equivalence margin fixed beforehand: {} - {} within ±{} steps", e.a, e.b, e.margin));
    }
    if let Some(e) = plan.exclusion {
        lines.push(format!("exclusion fixed beforehand: {} or more failed catch trials", e.failed_catch_trials));
    }
    lines.extend(plan.stopping.iter().map(|s| format!("data collection ends: {s}")));
    lines
}

/// The factor for the groups of a plot and the factor for its series: `scene`, and the factor that varies besides it.
fn axes(table: &Table) -> (Option<String>, Option<String>) {
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in table.rows.iter().flat_map(|r| &r.factors) {
        let levels = |r: &Row| r.level(name).map(str::to_owned);
        if !names.contains(&name.as_str()) && table.rows.iter().any(|r| levels(r) != levels(&table.rows[0])) {
            names.push(name);
        }
    }
    match names[..] {
        [] => (None, None),
        [one] => (None, Some(one.to_owned())),
        [a, b, ..] => (Some(a.to_owned()), Some(b.to_owned())),
    }
}

fn results(input: &ReportInput, s: &StudyReport, r: &Results, which: &str, out: &mut Vec<Block>) {
    let suffix = if which.is_empty() { String::new() } else { format!(" ({which})") };
    let table = &r.table;
    let rows: Vec<&Row> = table.rows.iter().collect();
    let (group, series) = axes(table);
    out.push(Block::Heading(2, format!("Mean opinion scores{suffix}")));
    let stamp_word = input.stamp.as_deref();
    if !s.study.forced_choice {
        out.push(Block::Plot {
            caption: stamp(
                input,
                &format!(
                    "Mean opinion scores with {} intervals ({}).",
                    percent(table.options.level),
                    table.options.method.words()
                ),
            ),
            svg: svg::means(
                &rows,
                group.as_deref(),
                series.as_deref(),
                "mean opinion scores with intervals",
                stamp_word,
            ),
        });
    }
    let varying: Vec<&str> = [group.as_deref(), series.as_deref()].into_iter().flatten().collect();
    let name = |row: &Row| {
        let words: Vec<&str> = if varying.is_empty() {
            row.factors.iter().map(|f| f.1.as_str()).collect()
        } else {
            row.factors.iter().filter(|f| varying.contains(&f.0.as_str())).map(|f| f.1.as_str()).collect()
        };
        words.join(" · ")
    };
    let names: Vec<String> = rows.iter().map(|row| name(row)).collect();
    let words = scale_words(s, &rows);
    out.push(Block::Plot {
        caption: stamp(input, "Distribution of the votes, with the MOS and its interval at the right."),
        svg: svg::distributions(&rows, &names, &words, "distribution of votes", stamp_word),
    });
    out.push(mos_table(input, table));
    let mut notes: Vec<String> = rows
        .iter()
        .zip(&names)
        .flat_map(|(r, n)| r.interval.notes.iter().map(move |note| format!("{n}: {note}")))
        .collect();
    if !s.study.forced_choice {
        notes.push("Differences are judged by the interval of the paired difference below, never by whether these intervals overlap.".into());
    }
    out.push(Block::Notes(notes));
    tests(input, r, &suffix, out);
    choices(input, r, &suffix, out);
    if !r.notes.is_empty() {
        out.push(Block::Notes(r.notes.clone()));
    }
}

/// The words for the steps of the scale: numbers for ratings, the names of the two methods for a forced choice.
fn scale_words(s: &StudyReport, rows: &[&Row]) -> Vec<String> {
    if s.study.scale.is_empty() {
        return rows.first().map(|r| r.counts.keys().map(ToString::to_string).collect()).unwrap_or_default();
    }
    if !s.study.forced_choice {
        return s.study.scale.iter().map(|(v, _)| v.to_string()).collect();
    }
    let conditions = s.all.preference.iter().flat_map(|p| &p.conditions);
    let side = |factor: &str| {
        let mut names: Vec<&str> =
            conditions.clone().flat_map(|c| &c.factors).filter(|f| f.0 == factor).map(|f| f.1.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        match names[..] {
            [one] => one.to_owned(),
            _ => factor.to_owned(),
        }
    };
    let named = |w: &str| match w.split_once(' ') {
        Some((factor @ ("method" | "other"), rest)) => format!("{} {rest}", side(factor)),
        _ => w.to_owned(),
    };
    s.study.scale.iter().map(|(_, w)| named(w)).collect()
}

fn mos_table(input: &ReportInput, table: &Table) -> Block {
    let factors: Vec<String> =
        table.rows.first().map(|r| r.factors.iter().map(|f| f.0.clone()).collect()).unwrap_or_default();
    let mut head = factors.clone();
    head.extend(["n", "MOS", "s", "lower", "upper", "votes"].map(str::to_owned));
    let rows = table
        .rows
        .iter()
        .map(|r| {
            let mut row: Vec<String> = factors.iter().map(|f| r.level(f).unwrap_or("-").to_owned()).collect();
            row.extend([
                r.n.to_string(),
                format!("{:.2}", r.mean),
                r.sd.map_or_else(|| "-".into(), |s| format!("{s:.2}")),
                r.interval.lo.map_or_else(|| "-".into(), |s| format!("{s:.2}")),
                r.interval.hi.map_or_else(|| "-".into(), |s| format!("{s:.2}")),
                text::votes(r),
            ]);
            row
        })
        .collect();
    Block::Table { caption: stamp(input, &format!("{}.", table.convention)), head, rows }
}

fn tests(input: &ReportInput, r: &Results, suffix: &str, out: &mut Vec<Block>) {
    let Some(first) = r.contrasts.first() else { return };
    out.push(Block::Heading(2, format!("Paired tests{suffix}")));
    let optional = |p: Option<f64>| p.map_or_else(|| "-".into(), p_text);
    let interval = |lo: Option<f64>, hi: Option<f64>| match (lo, hi) {
        (Some(lo), Some(hi)) => format!("[{lo:.2}, {hi:.2}]"),
        _ => "-".into(),
    };
    let name = |c: &ContrastResult| {
        let at = c.at.as_ref().map(|at| format!(" ({at})")).unwrap_or_default();
        format!("{} - {}{at}", c.contrast.a, c.contrast.b)
    };
    let lines: Vec<_> =
        r.contrasts.iter().map(|c| (name(c), c.difference.mean, c.difference.lo, c.difference.hi)).collect();
    let margin = r.equivalences.first().map(|e| e.result.margin);
    out.push(Block::Plot {
        caption: stamp(
            input,
            &format!("Mean paired differences in scale steps with {} t intervals.", percent(first.difference.level)),
        ),
        svg: svg::differences(&lines, margin, "paired differences", input.stamp.as_deref()),
    });
    let rows = r.contrasts.iter().map(|c| {
        let t = &c.test;
        let sums = [t.r_plus.to_string(), t.r_minus.to_string(), text::number(t.z)];
        let p = [optional(t.p_exact), optional(t.p_mid), optional(t.p_asymptotic), p_text(c.p_adjusted)];
        let head = [name(c), c.contrast.family.clone(), t.n.to_string(), t.n_zero.to_string()];
        head.into_iter().chain(sums).chain(p).collect()
    });
    out.push(Block::Table {
        caption: stamp(
            input,
            &format!(
                "Wilcoxon signed-rank tests. Unit: the participant (sums over cells and repetitions). Convention: {}. p adjusted \
                 within each family: {}.",
                first.test.convention,
                first.correction.name()
            ),
        ),
        head: ["contrast", "family", "n", "zeros", "R+", "R-", "z", "p exact", "p mid", "p asympt.", "p adjusted"]
            .map(str::to_owned)
            .to_vec(),
        rows: rows.collect(),
    });
    let rows = r.contrasts.iter().map(|c| {
        let t = &c.test;
        vec![
            name(c),
            format!("{:.2} {}", c.difference.mean, interval(c.difference.lo, c.difference.hi)),
            format!("{} {}", text::number(t.hodges_lehmann), interval(t.hodges_lehmann_lo, t.hodges_lehmann_hi)),
            t.hodges_lehmann_level.map_or_else(|| "-".into(), |l| format!("{:.1} %", 100.0 * l)),
            format!("{} {}", text::number(t.rank_biserial), interval(t.rank_biserial_lo, t.rank_biserial_hi)),
            format!("{} (N = {})", text::number(t.effect_r), t.effect_r_n),
        ]
    });
    out.push(Block::Table {
        caption: stamp(
            input,
            &format!(
                "Effect sizes. Differences in scale steps: mean with its {} t interval, Hodges-Lehmann shift with its {} interval and \
                 the level achieved; matched-pairs rank-biserial on wilcox ranks with its interval by Fisher's z (none at ±1).",
                percent(first.difference.level),
                percent(first.test.level)
            ),
        ),
        head: ["contrast", "mean difference", "Hodges-Lehmann", "achieved", "rank-biserial", "r = z/sqrt(N)"]
            .map(str::to_owned)
            .to_vec(),
        rows: rows.collect(),
    });
    let mut notes: Vec<String> = Vec::new();
    for note in r.contrasts.iter().flat_map(|c| &c.test.notes) {
        if !notes.contains(note) {
            notes.push(note.clone());
        }
    }
    for e in &r.equivalences {
        let x = &e.result;
        notes.push(format!(
            "Equivalence {} - {} within ±{} steps: {} (p = {}; {}; mean difference {:.2} {} at {}).",
            e.a,
            e.b,
            x.margin,
            if x.equivalent { "shown" } else { "not shown" },
            p_text(x.p),
            x.convention,
            x.difference.mean,
            interval(x.difference.lo, x.difference.hi),
            percent(x.difference.level)
        ));
        notes.extend(x.notes.iter().cloned());
    }
    if let Some((levels, f)) = &r.friedman {
        let ranks: Vec<String> = levels.iter().zip(&f.mean_ranks).map(|(l, r)| format!("{l} {r:.2}")).collect();
        notes.push(format!(
            "Friedman over {}: chi-squared = {}, df = {}, p = {}, Kendall's W = {}, n = {} (tie correction; chi-squared approximation).",
            ranks.join(", "),
            text::number(f.chi_squared),
            f.df,
            p_text(f.p),
            text::number(f.kendall_w),
            f.n
        ));
        notes.extend(f.notes.iter().cloned());
    }
    out.push(Block::Notes(notes));
}

fn choices(input: &ReportInput, r: &Results, suffix: &str, out: &mut Vec<Block>) {
    let Some(p) = &r.preference else { return };
    out.push(Block::Heading(2, format!("Forced choices{suffix}")));
    let varying: Vec<&String> = p
        .conditions
        .iter()
        .flat_map(|c| &c.factors)
        .filter(|f| p.conditions.iter().any(|c| !c.factors.contains(f)))
        .map(|f| &f.0)
        .collect();
    let optional = |p: Option<f64>| p.map_or_else(|| "-".into(), p_text);
    let rows = p
        .conditions
        .iter()
        .map(|c| {
            let name: Vec<&str> = c.factors.iter().filter(|f| varying.contains(&&f.0)).map(|f| f.1.as_str()).collect();
            vec![
                if name.is_empty() { "all".into() } else { name.join(" · ") },
                c.votes.wins.to_string(),
                c.votes.ties.to_string(),
                c.votes.losses.to_string(),
                format!("{:.2}", c.mos),
                format!("{} of {}", c.decided.k, c.decided.n),
                match (c.decided.lo, c.decided.hi) {
                    (Some(lo), Some(hi)) => format!("{} [{lo:.2}, {hi:.2}]", text::number(c.decided.share)),
                    _ => "-".into(),
                },
                optional(c.decided.p),
                optional(c.p_adjusted),
                optional(c.split.p),
            ]
        })
        .collect();
    out.push(Block::Table {
        caption: stamp(input, &format!("{}.", p.convention)),
        head: [
            "condition",
            "method",
            "same",
            "other",
            "MOS",
            "decided",
            "share",
            "p decided",
            "p adjusted",
            "p ties split",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows,
    });
    let t = &p.overall;
    let mut notes = vec![format!(
        "All conditions, participant level: n = {}, zeros {}, z = {}, p exact = {}, p mid = {}, p asymptotic = {}.",
        t.n,
        t.n_zero,
        text::number(t.z),
        optional(t.p_exact),
        optional(t.p_mid),
        optional(t.p_asymptotic)
    )];
    let strengths: Vec<String> = p
        .davidson
        .strengths
        .iter()
        .map(|s| format!("{} {:.2} [{}, {}]", s.name, s.log_strength, text::number(s.lo), text::number(s.hi)))
        .collect();
    notes.push(format!(
        "Log-strengths: {}; tie parameter {:.3}. {}.",
        strengths.join("; "),
        p.davidson.nu,
        p.davidson.convention
    ));
    if !p.incomplete.is_empty() {
        notes.push(format!("Left out of the overall test, without every vote: {}.", p.incomplete.join(", ")));
    }
    out.push(Block::Notes(notes));
}

fn metrics(input: &ReportInput, s: &StudyReport, out: &mut Vec<Block>) {
    if s.study.forced_choice || input.metrics.is_empty() {
        return;
    }
    let points: Vec<svg::Point> = s
        .all
        .table
        .rows
        .iter()
        .filter_map(|r| {
            let (scene, method) = (r.level("scene")?, r.level("method")?);
            let m = input.metrics.iter().find(|m| m.scene == scene && m.method == method)?;
            Some(svg::Point { scene: scene.to_owned(), method: method.to_owned(), x: m.value, y: r.mean })
        })
        .collect();
    if points.len() < 3 {
        return;
    }
    let rho = spearman(&points.iter().map(|p| (p.x, p.y)).collect::<Vec<_>>());
    out.push(Block::Heading(2, "MOS against measured inconsistency".into()));
    out.push(Block::Plot {
        caption: stamp(
            input,
            &format!(
                "Spearman's rank correlation {} over {} conditions. It describes these stimuli; conditions are no sample, so no test is made.",
                text::number(rho),
                points.len()
            ),
        ),
        svg: svg::scatter(&points, "MOS against measured inconsistency", input.stamp.as_deref()),
    });
}

fn screening(input: &ReportInput, s: &StudyReport, out: &mut Vec<Block>) {
    let Some(x) = &s.screening else { return };
    out.push(Block::Heading(2, "Screening of observers (shown, not applied)".into()));
    let rows = x
        .participants
        .iter()
        .enumerate()
        .map(|(i, who)| {
            let o = &x.bt500.observers[i];
            vec![
                who.clone(),
                o.votes.to_string(),
                o.high.to_string(),
                o.low.to_string(),
                if o.rejected { "flagged" } else { "kept" }.to_owned(),
                format!("{:.2}", x.p910.bias[i]),
                format!("{:.2}", x.p910.inconsistency[i]),
            ]
        })
        .collect();
    out.push(Block::Table {
        caption: stamp(
            input,
            "BT.500 (sigma divided by n, unanimous stimuli skipped) and P.910 bias and inconsistency, scale steps.",
        ),
        head: ["participant", "votes", "high", "low", "BT.500", "bias", "inconsistency"].map(str::to_owned).to_vec(),
        rows,
    });
    let mut notes = vec![format!(
        "Krippendorff's alpha (ordinal) {} over {} stimuli; largest P.910 weight {:.2} ({}).",
        text::number(x.krippendorff.alpha),
        x.krippendorff.units,
        x.p910.largest_weight,
        x.participants[x.p910.heaviest]
    )];
    notes.extend(x.bt500.notes.iter().chain(&x.p910.notes).cloned());
    out.push(Block::Notes(notes));
}

fn participants(input: &ReportInput, out: &mut Vec<Block>) {
    out.push(Block::Heading(1, "Participants and exclusions".into()));
    let mut notes: Vec<String> = input.excluded.iter().map(|(who, why)| format!("{who}: {why}")).collect();
    if notes.is_empty() {
        notes.push("No rule of the study file excludes anybody.".into());
    }
    notes.extend(input.notes.iter().cloned());
    if !input.sessions.is_empty() {
        let rows = input
            .sessions
            .iter()
            .map(|s| {
                vec![
                    s.participant.clone(),
                    s.study.clone(),
                    s.kind.name().to_owned(),
                    s.outcome.map_or("not ended", outcome_name).to_owned(),
                    s.answers.to_string(),
                    s.missing.to_string(),
                    if s.catch.0 == 0 { "-".into() } else { format!("{} of {}", s.catch.1, s.catch.0) },
                ]
            })
            .collect();
        out.push(Block::Table {
            caption: stamp(input, "Sessions."),
            head: ["participant", "study", "kind", "ended", "answers", "missing", "catch trials failed"]
                .map(str::to_owned)
                .to_vec(),
            rows,
        });
    }
    out.push(Block::Notes(notes));
}

fn timing(input: &ReportInput, out: &mut Vec<Block>) {
    if input.inspections.is_empty() {
        return;
    }
    out.push(Block::Heading(1, "Timing quality".into()));
    let rows = input
        .inspections
        .iter()
        .map(|i| {
            let t = &i.timing;
            vec![
                i.participant.clone(),
                i.study.clone(),
                t.trust.map_or("none", trust_name).to_owned(),
                t.shown.to_string(),
                t.invalid.to_string(),
                format!("{} of {}", t.missed, t.frames_asked),
                format!("{:.1}", t.longest_gap_ms),
                format!("{:.1}", t.longest_lost_ms),
                i.resumes_ms.len().to_string(),
                i.median_answer_ms.map_or_else(|| "-".into(), |m| format!("{:.1}", m / 1000.0)),
            ]
        })
        .collect();
    out.push(Block::Table {
        caption: stamp(
            input,
            "How far display times can be trusted, in the display's own word (virtual: nothing was shown; predicted and reported: the \
             runtime says so; measured: a photodiode saw it), and what went wrong.",
        ),
        head: ["participant", "study", "trust", "shown", "invalid", "missed frames", "longest gap, ms", "longest loss, ms", "resumed", "median answer, s"]
            .map(str::to_owned)
            .to_vec(),
        rows,
    });
    let damaged: Vec<String> = input.inspections.iter().filter_map(|i| i.error.clone()).collect();
    if !damaged.is_empty() {
        out.push(Block::Notes(damaged));
    }
}

fn provenance(input: &ReportInput, out: &mut Vec<Block>) {
    out.push(Block::Heading(1, "Provenance".into()));
    let mut notes = vec![format!("analysed by {} {}", env!("CARGO_PKG_NAME"), env!("CARGO_PKG_VERSION"))];
    let mut add = |what: &str, values: Vec<String>| {
        let mut seen: Vec<(String, usize)> = Vec::new();
        for v in values.into_iter().filter(|v| !v.is_empty()) {
            match seen.iter_mut().find(|s| s.0 == v) {
                Some(s) => s.1 += 1,
                None => seen.push((v, 1)),
            }
        }
        notes.extend(seen.into_iter().map(|(v, n)| format!("{what}: {v} ({n} sessions)")));
    };
    add("program", input.sessions.iter().map(|s| s.program.clone()).collect());
    add("display", input.sessions.iter().map(|s| s.display.clone()).collect());
    add("device", input.sessions.iter().map(|s| s.device.clone()).collect());
    if input.sessions.is_empty() {
        notes.extend(input.sources.iter().map(|s| format!("read: {}", s.display())));
    } else {
        notes.push(format!("{} journals read, every line's check sum verified", input.sessions.len()));
    }
    out.push(Block::Notes(notes));
}
