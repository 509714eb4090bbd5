//! The report as Markdown and LaTeX, and its numbers as CSV and JSON.

use serde_json::{Value, json};

use super::document::{Block, document};
use super::input::{ReportInput, Results};
use crate::escape::{self, latex as tex, markdown as md};

/// GitHub-flavoured Markdown; drawings and pictures are named, not shown.
pub fn markdown(input: &ReportInput) -> String {
    let mut out = format!("# {}\n\n", md(&input.title));
    if let Some(stamp) = &input.stamp {
        out += &format!("**{} data**\n\n", stamp.to_uppercase());
    }
    for block in document(input) {
        out += &match block {
            Block::Heading(level, text) => format!("{} {}\n\n", "#".repeat(usize::from(level) + 1), md(&text)),
            Block::Text(text) => format!("{}\n\n", md(&text)),
            Block::Notes(notes) => notes.iter().map(|n| format!("- {}\n", md(n))).collect::<String>() + "\n",
            Block::Table { caption, head, rows } => {
                let line = |r: &[String]| format!("| {} |\n", r.iter().map(|c| md(c)).collect::<Vec<_>>().join(" | "));
                let rule = format!("|{}\n", " --- |".repeat(head.len()));
                let rows: String = rows.iter().map(|r| line(r)).collect();
                format!("{}{rule}{rows}\n{}\n\n", line(&head), md(&caption))
            }
            Block::Plot { .. } | Block::Contents => String::new(),
            Block::Drawing { caption, .. } | Block::Picture { caption, .. } => {
                format!("(picture: {})\n\n", md(&caption))
            }
            Block::Details { summary, body } => {
                // The fence is longer than any in the text, so that the text cannot end it.
                let longest = body.split(|c| c != '`').map(str::len).max().unwrap_or(0);
                let fence = "`".repeat(longest.max(2) + 1);
                format!("{}:\n\n{fence}\n{}\n{fence}\n\n", md(&summary), escape::terminal(body.trim_end()))
            }
        };
    }
    out
}

/// A standalone LaTeX document with `booktabs` tables.
pub fn latex(input: &ReportInput) -> String {
    let mut out = String::from(
        "\\documentclass{article}\n\\usepackage[utf8]{inputenc}\n\\usepackage[T1]{fontenc}\n\\usepackage{booktabs}\n\
         \\usepackage{graphicx}\n\\usepackage[a4paper,margin=2cm]{geometry}\n\\begin{document}\n",
    );
    out += &format!("\\section*{{{}}}\n", tex(&input.title));
    if let Some(stamp) = &input.stamp {
        out += &format!("\\textbf{{{} data}}\n\n", tex(&stamp.to_uppercase()));
    }
    for block in document(input) {
        out += &match block {
            Block::Heading(1, text) => format!("\\section{{{}}}\n", tex(&text)),
            Block::Heading(_, text) => format!("\\subsection{{{}}}\n", tex(&text)),
            Block::Text(text) => format!("{}\n\n", tex(&text)),
            Block::Notes(notes) if notes.is_empty() => String::new(),
            Block::Notes(notes) => {
                let items: String = notes.iter().map(|n| format!("\\item {}\n", tex(n))).collect();
                format!("\\begin{{itemize}}\n{items}\\end{{itemize}}\n")
            }
            Block::Table { caption, head, rows } => {
                let line =
                    |r: &[String]| format!("{} \\\\\n", r.iter().map(|c| tex(c)).collect::<Vec<_>>().join(" & "));
                format!(
                    "\\begin{{table}}[ht]\\centering\\small\n\\resizebox{{\\ifdim\\width>\\linewidth\\linewidth\\else\\width\\fi}}{{!}}{{%\n\
                     \\begin{{tabular}}{{{}}}\n\\toprule\n{}\\midrule\n{}\\bottomrule\n\\end{{tabular}}}}\n\\caption{{{}}}\n\\end{{table}}\n",
                    "l".repeat(head.len()),
                    line(&head),
                    rows.iter().map(|r| line(r)).collect::<String>(),
                    tex(&caption)
                )
            }
            Block::Plot { .. }
            | Block::Contents
            | Block::Drawing { .. }
            | Block::Picture { .. }
            | Block::Details { .. } => String::new(),
        };
    }
    out + "\\end{document}\n"
}

/// The MOS table as CSV: one line a study and condition.
pub fn csv(input: &ReportInput) -> String {
    let field = |t: &str| {
        let t = escape::csv(t);
        if t.contains([',', '"']) { format!("\"{}\"", t.replace('"', "\"\"")) } else { t.into_owned() }
    };
    let mut factors: Vec<&str> = Vec::new();
    for (name, _) in input.studies.iter().flat_map(|s| &s.all.table.rows).flat_map(|r| &r.factors) {
        if !factors.contains(&name.as_str()) {
            factors.push(name);
        }
    }
    let mut out = format!(
        "study,{}n,votes,mean,sd,lo,hi,level,ci,kind\n",
        factors.iter().map(|f| format!("{},", field(f))).collect::<String>()
    );
    let number = |x: Option<f64>| x.map(|x| x.to_string()).unwrap_or_default();
    for table in input.studies.iter().map(|s| &s.all.table) {
        for r in &table.rows {
            let levels: String = factors.iter().map(|f| format!("{},", field(r.level(f).unwrap_or("")))).collect();
            out += &format!(
                "{},{levels}{},{},{},{},{},{},{},{},{}\n",
                field(&r.study),
                r.n,
                r.votes,
                r.mean,
                number(r.sd),
                number(r.interval.lo),
                number(r.interval.hi),
                table.options.level,
                field(table.options.method.words()),
                field(input.stamp.as_deref().unwrap_or(""))
            );
        }
    }
    out
}

/// Everything as one object.
pub fn json(input: &ReportInput) -> Value {
    let results = |r: &Results| {
        json!({
            "table": r.table.to_json(), "contrasts": r.contrasts, "equivalence": r.equivalences,
            "friedman": r.friedman.as_ref().map(|(levels, f)| json!({ "levels": levels, "test": f })),
            "preference": r.preference, "notes": r.notes,
        })
    };
    let studies: Vec<Value> = input
        .studies
        .iter()
        .map(|s| {
            json!({
                "id": s.study.id, "title": s.study.title, "sha256": s.study.sha256, "participants": s.participants,
                "all": results(&s.all), "without_excluded": s.kept.as_ref().map(results), "screening": s.screening,
            })
        })
        .collect();
    let excluded: Vec<Value> =
        input.excluded.iter().map(|(p, why)| json!({ "participant": p, "reason": why })).collect();
    json!({
        "title": input.title, "stamp": input.stamp, "studies": studies, "sessions": input.sessions,
        "journals": input.inspections, "excluded": excluded, "notes": input.notes, "metrics": input.metrics,
    })
}
