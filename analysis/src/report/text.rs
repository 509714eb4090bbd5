//! Tables as plain text, for terminals and logs.

use std::borrow::Cow;

use crate::contrast::ContrastResult;
use crate::equivalence::NamedEquivalence;
use crate::escape;
use crate::mos::{Row, Table};
use crate::preference::Preference;
use crate::special::p_text;
use crate::wilcoxon::{SignedRank, percent};

/// A sentence with names in it, as one line.
pub fn line(text: &str) -> String {
    format!("{}\n", escape::line(text))
}

/// A remark, as one line.
pub fn note(text: &str) -> String {
    line(&format!("note: {text}"))
}

/// Columns of text below a header, each as wide as its widest cell; numbers are flush right, words flush left.
pub fn align(rows: &[Vec<String>]) -> String {
    let rows: Vec<Vec<Cow<'_, str>>> = rows.iter().map(|r| r.iter().map(|c| escape::line(c)).collect()).collect();
    let numeric = |t: &Cow<'_, str>| t.starts_with(|c: char| c.is_ascii_digit() || "-[<".contains(c));
    let right: Vec<bool> = (0..rows.iter().map(Vec::len).max().unwrap_or(0))
        .map(|c| c > 0 && rows.iter().skip(1).filter_map(|r| r.get(c)).all(numeric))
        .collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|t| t.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut out = String::new();
    for row in &rows {
        let mut line = String::new();
        for (c, cell) in row.iter().enumerate() {
            let pad = " ".repeat(widths[c] - cell.chars().count());
            let gap = if c == 0 { "" } else { "  " };
            line += &if right[c] { format!("{gap}{pad}{cell}") } else { format!("{gap}{cell}{pad}") };
        }
        out += line.trim_end();
        out.push('\n');
    }
    out
}

/// Names and values, one pair on each line.
pub fn facts(rows: &[Vec<String>]) -> String {
    let width = rows.iter().map(|r| r[0].chars().count()).max().unwrap_or(0);
    rows.iter().map(|r| format!("{:width$}  {}\n", escape::line(&r[0]), escape::line(r[1].trim_end()))).collect()
}

/// A number with up to three decimals, or a dash.
pub fn number(x: Option<f64>) -> String {
    x.map_or_else(|| "-".into(), |x| format!("{x:.3}"))
}

/// `mean [lo, hi]`.
pub fn mean_and_interval(row: &Row) -> String {
    match (row.interval.lo, row.interval.hi) {
        (Some(lo), Some(hi)) => format!("{:.2} [{lo:.2}, {hi:.2}]", row.mean),
        _ => format!("{:.2} [no interval]", row.mean),
    }
}

/// The output of `mos table`: one line for each row, then the convention and every remark.
pub fn table(table: &Table) -> String {
    let factors: Vec<String> =
        table.rows.iter().flat_map(|r| r.factors.iter().map(|f| f.0.clone())).fold(Vec::new(), |mut names, name| {
            if !names.contains(&name) {
                names.push(name);
            }
            names
        });
    let studies = table.rows.iter().any(|r| !r.study.is_empty());
    let mut rows = vec![Vec::new()];
    if studies {
        rows[0].push("study".to_owned());
    }
    rows[0].extend(factors.clone());
    rows[0].extend(["n", "mean", "sd", "lo", "hi", "votes"].map(str::to_owned));
    for row in &table.rows {
        let mut line = Vec::new();
        if studies {
            line.push(row.study.clone());
        }
        line.extend(factors.iter().map(|f| row.level(f).unwrap_or("-").to_owned()));
        line.extend([
            row.n.to_string(),
            format!("{:.3}", row.mean),
            number(row.sd),
            number(row.interval.lo),
            number(row.interval.hi),
            votes(row),
        ]);
        rows.push(line);
    }
    let mut out = stamped(table.stamp.as_deref());
    out += &align(&rows);
    out += &format!("\n{}\n", table.convention);
    for row in &table.rows {
        let name = row.factors.iter().map(|f| f.1.as_str()).collect::<Vec<_>>().join(" ");
        out.extend(row.interval.notes.iter().map(|n| note(&format!("{name}: {n}"))));
    }
    out.extend(table.notes.iter().map(|n| note(n)));
    out
}

/// The votes as `1:0 2:3 …`; where there are many different ratings, only their number.
pub fn votes(row: &Row) -> String {
    if row.counts.len() > 12 {
        return format!("{} different ratings", row.counts.len());
    }
    row.counts.iter().map(|(s, n)| format!("{s}:{n}")).collect::<Vec<_>>().join(" ")
}

/// The table in the form of the paper's figures: one line for each method, one column for each scene, a block for each
/// study.
///
/// Works for rows of one or two factors; the last factor makes the lines.
pub fn grid(table: &Table) -> String {
    let mut out = stamped(table.stamp.as_deref());
    let mut studies: Vec<&str> = table.rows.iter().map(|r| r.study.as_str()).collect();
    studies.dedup();
    for study in studies {
        let rows: Vec<&Row> = table.rows.iter().filter(|r| r.study == study).collect();
        if !study.is_empty() {
            out += &format!("{}\n", escape::line(study));
        }
        // A factor with only one level would repeat its name in every line.
        let varies =
            |i: usize| rows.iter().any(|r| r.factors.get(i).map(|f| &f.1) != rows[0].factors.get(i).map(|f| &f.1));
        let width = rows.iter().map(|r| r.factors.len()).max().unwrap_or(0);
        let mut shown: Vec<usize> = (0..width).filter(|i| varies(*i)).collect();
        if shown.is_empty() {
            shown = (0..width).collect();
        }
        let words = |r: &Row, which: &[usize]| {
            which.iter().filter_map(|i| r.factors.get(*i)).map(|f| f.1.clone()).collect::<Vec<_>>().join(" ")
        };
        let (line, column) = shown.split_last().map_or((vec![], vec![]), |(l, c)| (vec![*l], c.to_vec()));
        let last = |r: &Row| words(r, &line);
        let first = |r: &Row| words(r, &column);
        let distinct = |of: &dyn Fn(&Row) -> String| {
            rows.iter().map(|r| of(r)).fold(Vec::new(), |mut all, l| {
                if !all.contains(&l) {
                    all.push(l);
                }
                all
            })
        };
        let (lines, columns) = (distinct(&last), distinct(&first));
        let mut cells = vec![vec![String::new()]];
        cells[0].extend(columns.iter().cloned());
        for line in &lines {
            let mut out = vec![line.clone()];
            for column in &columns {
                let found = rows.iter().find(|r| last(r) == *line && first(r) == *column);
                out.push(found.map_or("-".into(), |r| format!("{} n={}", mean_and_interval(r), r.n)));
            }
            cells.push(out);
        }
        out += &align(&cells);
        out.push('\n');
    }
    out += &format!("mean opinion scores with {} intervals: {}\n", percent(table.options.level), table.convention);
    out
}

/// The stamp's line; empty for real sessions.
pub fn stamped(stamp: Option<&str>) -> String {
    stamp.map(|s| format!("*** {} data ***\n", s.to_uppercase())).unwrap_or_default()
}

/// Everything about one signed-rank test, one fact on each line.
pub fn signed_rank(t: &SignedRank) -> String {
    let p = |p: Option<f64>| p.map_or_else(|| "-".into(), p_text);
    let interval = |lo: Option<f64>, hi: Option<f64>| match (lo, hi) {
        (Some(lo), Some(hi)) => format!("[{lo:.4}, {hi:.4}]"),
        _ => "no interval".into(),
    };
    let mut out = facts(&[
        vec!["pairs".into(), format!("{} (zeros {}, ranks used {})", t.n, t.n_zero, t.n_used)],
        vec!["R+, R-".into(), format!("{}, {}", t.r_plus, t.r_minus)],
        vec!["statistic".into(), t.statistic.to_string()],
        vec!["z".into(), t.z.map_or_else(|| "undefined".into(), |z| format!("{z:.4}"))],
        vec!["p exact".into(), p(t.p_exact)],
        vec!["p mid".into(), p(t.p_mid)],
        vec!["p asymptotic".into(), p(t.p_asymptotic)],
        vec![
            "rank-biserial".into(),
            format!("{} {}", number(t.rank_biserial), interval(t.rank_biserial_lo, t.rank_biserial_hi)),
        ],
        vec!["r = z/sqrt(N)".into(), format!("{} (N = {})", number(t.effect_r), t.effect_r_n)],
        vec![
            "Hodges-Lehmann".into(),
            format!(
                "{} {}{}",
                number(t.hodges_lehmann),
                interval(t.hodges_lehmann_lo, t.hodges_lehmann_hi),
                t.hodges_lehmann_level.map(|l| format!(" at {:.2} %", 100.0 * l)).unwrap_or_default()
            ),
        ],
    ]);
    out += &format!("convention: {}\n", t.convention);
    out.extend(t.notes.iter().map(|n| note(n)));
    out
}

/// The output of `mos test`: one line for each contrast, then conventions and remarks.
pub fn contrasts(results: &[ContrastResult], stamp: Option<&str>) -> String {
    let mut rows = vec![
        [
            "contrast",
            "family",
            "n",
            "zeros",
            "R+",
            "R-",
            "z",
            "p exact",
            "p mid",
            "p asympt.",
            "p adjusted",
            "mean diff.",
            "interval",
            "rank-bis.",
        ]
        .map(str::to_owned)
        .to_vec(),
    ];
    let p = |p: Option<f64>| p.map_or_else(|| "-".into(), p_text);
    for r in results {
        let t = &r.test;
        rows.push(vec![
            name(r),
            r.contrast.family.clone(),
            t.n.to_string(),
            t.n_zero.to_string(),
            t.r_plus.to_string(),
            t.r_minus.to_string(),
            number(t.z),
            p(t.p_exact),
            p(t.p_mid),
            p(t.p_asymptotic),
            p_text(r.p_adjusted),
            number(Some(r.difference.mean)),
            match (r.difference.lo, r.difference.hi) {
                (Some(lo), Some(hi)) => format!("[{lo:.3}, {hi:.3}]"),
                _ => "-".into(),
            },
            number(t.rank_biserial),
        ]);
    }
    let mut out = stamped(stamp);
    out += &align(&rows);
    if let Some(r) = results.first() {
        out += &format!(
            "\nunit: the participant (sums over cells and repetitions); {}\np adjusted within each family: {}; \
             mean difference in scale steps with its {} t interval: judge differences by it, not by whether MOS bars overlap\n",
            r.test.convention,
            r.correction.name(),
            percent(r.difference.level)
        );
    }
    let mut remarks: Vec<(&str, Vec<String>)> = Vec::new();
    for r in results {
        for note in &r.test.notes {
            match remarks.iter_mut().find(|m| m.0 == note) {
                Some(m) => m.1.push(name(r)),
                None => remarks.push((note, vec![name(r)])),
            }
        }
    }
    for (note, of) in remarks {
        let of = if of.len() == results.len() && of.len() > 1 { "every contrast".into() } else { of.join(", ") };
        out += &self::note(&format!("{of}: {note}"));
    }
    for r in results {
        if let Some(pooled) = &r.pooled {
            out += &format!(
                "{}: {}: n = {}, z = {}, p asymptotic = {}, p exact = {}\n",
                escape::line(&name(r)),
                pooled.label,
                pooled.test.n,
                number(pooled.test.z),
                p(pooled.test.p_asymptotic),
                p(pooled.test.p_exact)
            );
        }
    }
    out
}

/// `stereo - sssr`, with the study and the stratum where there are some.
pub fn name(r: &ContrastResult) -> String {
    let mut name = format!("{} - {}", r.contrast.a, r.contrast.b);
    if let Some(at) = &r.at {
        name += &format!(" ({at})");
    }
    if r.study.is_empty() { name } else { format!("{}: {name}", r.study) }
}

/// Which method was preferred, one line for each condition. This is what a comparison measures; a mean of votes coded 1
/// to 3 only stands for it.
pub fn winners(p: &Preference) -> String {
    let header = ["condition", "preferred", "by", "share", "interval", "over", "no difference", "p", "p adjusted"];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    let optional = |p: Option<f64>| p.map_or_else(|| "-".into(), p_text);
    for c in &p.conditions {
        let level = |name: &str| c.factors.iter().find(|f| f.0 == name).map_or("?", |f| f.1.as_str());
        let (method, other) = (level("method"), level("other"));
        let among: Vec<&str> = c
            .factors
            .iter()
            .filter(|f| !["method", "other", "reference"].contains(&f.0.as_str()))
            .map(|f| f.1.as_str())
            .collect();
        let v = c.votes;
        let (winner, loser, by, is_method) = match v.wins.cmp(&v.losses) {
            std::cmp::Ordering::Less => (other, method, v.losses, false),
            _ => (method, other, v.wins, true),
        };
        // The shares are the method's. Where the other one won, 1 − share is its share.
        let of = |share: Option<f64>| share.map(|s| 100.0 * if is_method { s } else { 1.0 - s });
        let (lo, hi) = if is_method { (c.decided.lo, c.decided.hi) } else { (c.decided.hi, c.decided.lo) };
        rows.push(vec![
            if among.is_empty() { "all".to_owned() } else { among.join(" ") },
            if v.wins == v.losses { "neither".to_owned() } else { winner.to_owned() },
            format!("{by} of {}", v.wins + v.losses),
            of(c.decided.share).map_or_else(|| "-".into(), |s| format!("{s:.0} %")),
            match (of(lo), of(hi)) {
                (Some(lo), Some(hi)) => format!("[{lo:.0}, {hi:.0}]"),
                _ => "-".into(),
            },
            if v.wins == v.losses { format!("{method}, {other}") } else { loser.to_owned() },
            format!("{} of {}", v.ties, v.total()),
            optional(c.decided.p),
            optional(c.p_adjusted),
        ]);
    }
    let of_study = if p.study.is_empty() { String::new() } else { format!(" in {}", escape::line(&p.study)) };
    let mut out = format!("who was preferred{of_study}\n");
    out += &align(&rows);
    out += "by: votes for it among those that decided, with their share and its exact interval (Clopper and Pearson); p: exact \
            binomial test of the decided votes against one half, adjusted over the conditions by Holm\n";
    out
}

/// The output of `mos preference`: one line for each condition, the overall test, and the model.
pub fn preference(p: &Preference) -> String {
    let mut rows = vec![
        [
            "condition",
            "method",
            "same",
            "other",
            "MOS",
            "decided",
            "p",
            "p adjusted",
            "share",
            "interval",
            "p ties split",
        ]
        .map(str::to_owned)
        .to_vec(),
    ];
    let optional = |p: Option<f64>| p.map_or_else(|| "-".into(), p_text);
    for c in &p.conditions {
        let v = c.votes;
        rows.push(vec![
            c.factors.iter().map(|f| f.1.as_str()).collect::<Vec<_>>().join(" "),
            format!("{} ({:.0} %)", v.wins, 100.0 * c.shares[0]),
            format!("{} ({:.0} %)", v.ties, 100.0 * c.shares[1]),
            format!("{} ({:.0} %)", v.losses, 100.0 * c.shares[2]),
            format!("{:.3}", c.mos),
            format!("{} of {}", c.decided.k, c.decided.n),
            optional(c.decided.p),
            optional(c.p_adjusted),
            number(c.decided.share),
            match (c.decided.lo, c.decided.hi) {
                (Some(lo), Some(hi)) => format!("[{lo:.3}, {hi:.3}]"),
                _ => "-".into(),
            },
            optional(c.split.p),
        ]);
    }
    let mut out = if p.study.is_empty() { String::new() } else { format!("{}\n", escape::line(&p.study)) };
    out += &align(&rows);
    let t = &p.overall;
    out += &format!(
        "overall, participant level: n = {}, zeros {}, R+ = {}, R- = {}, z = {}, p exact = {}, p mid = {}, p asymptotic = {}\n",
        t.n,
        t.n_zero,
        t.r_plus,
        t.r_minus,
        number(t.z),
        optional(t.p_exact),
        optional(t.p_mid),
        optional(t.p_asymptotic)
    );
    for s in &p.davidson.strengths {
        let name = escape::line(&s.name);
        out += &format!("log-strength {name}: {:.3} [{}, {}]\n", s.log_strength, number(s.lo), number(s.hi));
    }
    out += &format!("tie parameter nu = {:.4}; {}\n", p.davidson.nu, p.davidson.convention);
    if let Some((ratio, nu)) = p.davidson.two_methods {
        out += &format!("two methods, without a prior: ratio {}, nu {}\n", number(ratio), number(nu));
    }
    out += &format!("convention: {}\n", p.convention);
    if !p.incomplete.is_empty() {
        out += &note(&format!("left out of the overall test, without every vote: {}", p.incomplete.join(", ")));
    }
    out
}

/// Equivalence tests, one line for each, with the conclusion that each allows.
pub fn equivalences(all: &[NamedEquivalence]) -> String {
    let mut out = String::new();
    for e in all {
        let r = &e.result;
        out += &format!(
            "equivalence {} - {} within ±{} steps: {} (p = {}, one-sided {} and {}, n = {}; mean difference {:.3} [{}, {}] at {})\n",
            escape::line(&e.a),
            escape::line(&e.b),
            r.margin,
            if r.equivalent { "shown" } else { "NOT shown" },
            p_text(r.p),
            p_text(r.p_lower),
            p_text(r.p_upper),
            r.n,
            r.difference.mean,
            number(r.difference.lo),
            number(r.difference.hi),
            percent(r.difference.level)
        );
        out.extend(r.notes.iter().map(|n| note(&format!("equivalence: {n}"))));
    }
    out
}
