//! `mos check`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use cyclopean_analysis::Error;
use cyclopean_analysis::data::{Builder, Columns, Selection, Source, expand, tidy};
use cyclopean_analysis::inspect::{Inspection, inspect_all, trust_name};
use cyclopean_analysis::report::text;
use serde_json::{Value, json};

use super::input::{print, print_json};

/// `mos check PATH…`
#[derive(Args)]
pub struct Check {
    /// Journals (.jsonl), folders of journals, patterns with * and ?, or tidy CSV files
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl Check {
    /// Prints one line for each source; ends with an error if any source is damaged.
    pub fn run(self) -> Result<()> {
        let (mut lines, mut objects) = (String::new(), Vec::new());
        let mut damaged = 0;
        let mut kinds: BTreeMap<&str, u64> = BTreeMap::new();
        let mut people: BTreeMap<(String, String), u64> = BTreeMap::new();
        for source in expand(&self.paths)? {
            match source {
                Source::Csv(path) => {
                    let (ok, line, object) = csv(&path);
                    damaged += u64::from(!ok);
                    lines += &text::line(&line);
                    objects.push(object);
                }
                Source::Journals(files) => inspect_all(&files, |i| {
                    damaged += u64::from(i.error.is_some());
                    if let Some(kind) = i.kind {
                        *kinds.entry(kind.name()).or_default() += 1;
                        *people.entry((i.study.clone(), i.participant.clone())).or_default() += 1;
                    }
                    lines += &text::line(&line(&i));
                    objects.push(serde_json::to_value(&i).unwrap_or_default());
                }),
            }
        }
        let mut notes = Vec::new();
        if kinds.len() > 1 {
            let found = kinds.iter().map(|(k, n)| format!("{n} {k}")).collect::<Vec<_>>().join(", ");
            notes.push(format!(
                "mixed kinds of session: {found}; they are never analysed together unless --allow-kind names them"
            ));
        }
        for ((study, who), n) in people.iter().filter(|p| *p.1 > 1) {
            notes.push(format!("participant {who} has {n} sessions of study {study}"));
        }
        let total = objects.len();
        if self.json {
            print_json(
                &json!({ "ok": damaged == 0, "damaged": damaged, "sources": objects, "kinds": kinds, "notes": notes }),
            )?;
        } else {
            lines.extend(notes.iter().map(|n| text::note(n)));
            lines += &format!("{total} checked, {damaged} damaged\n");
            print(&lines)?;
        }
        if damaged > 0 {
            return Err(Error::data(format!(
                "{damaged} of {total} sources are damaged; their lines above say what to do"
            ))
            .into());
        }
        Ok(())
    }
}

fn line(i: &Inspection) -> String {
    if let Some(error) = &i.error {
        return format!("DAMAGED  {error}");
    }
    let mut out = format!(
        "ok  {}: {} lines, {}, participant {}, {} of {} trials answered",
        i.path.display(),
        i.lines,
        i.kind.map_or("no kind", |k| k.name()),
        i.participant,
        i.answered,
        i.planned
    );
    if i.missing > 0 {
        out += &format!(", {} missing", i.missing);
    }
    out += match i.outcome {
        Some(_) => ", ended",
        None => ", NOT ENDED",
    };
    if !i.resumes_ms.is_empty() {
        let gap: i64 = i.resumes_ms.iter().sum();
        out += &format!(", resumed {} times after {:.0} s in all", i.resumes_ms.len(), gap as f64 / 1000.0);
    }
    let t = &i.timing;
    out += &format!(
        ", timing {}: {} shown, {} invalid, {} frames missed, longest gap {:.1} ms",
        t.trust.map_or("none", trust_name),
        t.shown,
        t.invalid,
        t.missed,
        t.longest_gap_ms
    );
    out
}

fn csv(path: &Path) -> (bool, String, Value) {
    let mut builder = Builder::new(&Selection::default());
    match tidy::read(path, &Columns::default(), &mut builder) {
        Ok(()) => {
            let data = builder.finish();
            let (n, people, cells) = (data.responses(), data.participants.len(), data.cells.len());
            let line = format!("ok  {}: {n} answers, {people} participants, {cells} cells", path.display());
            let object = json!({ "path": path, "error": null, "answers": n, "participants": people, "cells": cells });
            (true, line, object)
        }
        Err(e) => (false, format!("DAMAGED  {e}"), json!({ "path": path, "error": e.to_string() })),
    }
}
