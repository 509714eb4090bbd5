//! Exports data for other programs: tidy CSV, a data dictionary, a Psych-DS folder, an R script. `mos export` calls it.

mod psych_ds;

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::data::{Selection, Source, expand, outcome_name, sessions};
use crate::error::{Error, Result};
use crate::escape;
use crate::files::write_whole;
use crate::journal::Kind;
use crate::journal::record::{Outcome, Purpose};

pub use psych_ds::{Column, columns as psych_ds_columns, name_part};

/// One answer, with all that may be published: no wall time, no host, no device.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportRow {
    /// Pseudonym.
    pub participant: String,
    /// Session id.
    pub session: String,
    /// Study id.
    pub study: String,
    /// Real, pilot or simulated.
    pub kind: Kind,
    /// Position in the order, from 0.
    pub presentation: u32,
    /// `trial` or `catch`.
    pub purpose: Purpose,
    /// Which showing of the condition.
    pub repetition: u32,
    /// Factor levels, in the order of the factor columns; empty where a study has no such factor.
    pub levels: Vec<String>,
    /// The rating.
    pub rating: i32,
    /// The attempt that was answered.
    pub attempt: u32,
    /// Milliseconds from the panel's opening to the confirmation.
    pub answer_ms: f64,
    /// Whether a catch trial was passed; `None` for trials.
    pub passed: Option<bool>,
    /// How the session ended.
    pub outcome: Option<Outcome>,
}

/// What an export wrote.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ExportedFiles {
    /// Answers.
    pub rows: u64,
    /// Files, relative to the folder.
    pub files: Vec<PathBuf>,
}

/// What the journals hold.
struct JournalData {
    factors: Vec<String>,
    lines: Vec<ExportRow>,
    /// Id and title.
    studies: Vec<(String, String)>,
}

/// Factor columns and lines of all journals. Kinds of session may be mixed here, because each line states its own.
fn gather(paths: &[PathBuf], selection: &Selection) -> Result<JournalData> {
    let mut files = Vec::new();
    for source in expand(paths)? {
        match source {
            Source::Journals(j) => files.extend(j),
            Source::Csv(path) => {
                return Err(Error::usage(format!(
                    "{}: export reads journals (.jsonl); this is tidy data already",
                    path.display()
                )));
            }
        }
    }
    let mut factors: BTreeSet<String> = BTreeSet::new();
    let mut studies: Vec<(String, String)> = Vec::new();
    let mut raw = Vec::new();
    sessions(&files, |s| {
        let h = &s.header;
        let wanted = selection.study.as_ref().is_none_or(|id| *id == h.study.id)
            && selection.kind.is_none_or(|k| k == s.kind)
            && !selection.exclude.contains(&h.participant)
            && s.outcome != Some(Outcome::Withdrawn);
        if !wanted {
            return Ok(());
        }
        if !studies.iter().any(|x| x.0 == h.study.id) {
            studies.push((h.study.id.clone(), h.study.title.clone()));
        }
        for vote in &s.votes {
            let Some(levels) = s.factors(vote) else { continue };
            factors.extend(levels.keys().cloned());
            let line = ExportRow {
                participant: h.participant.clone(),
                session: h.session.clone(),
                study: h.study.id.clone(),
                kind: s.kind,
                presentation: vote.presentation,
                purpose: vote.purpose,
                repetition: vote.repetition,
                levels: Vec::new(),
                rating: vote.rating,
                attempt: vote.attempt,
                answer_ms: vote.after_ns as f64 / 1e6,
                passed: vote.passed,
                outcome: s.outcome,
            };
            raw.push((line, levels.clone()));
        }
        Ok(())
    })?;
    if raw.is_empty() {
        return Err(Error::data("no answers to export"));
    }
    let factors: Vec<String> = factors.into_iter().collect();
    let lines = raw
        .into_iter()
        .map(|(mut line, levels)| {
            line.levels = factors.iter().map(|f| levels.get(f).cloned().unwrap_or_default()).collect();
            line
        })
        .collect();
    Ok(JournalData { factors, lines, studies })
}

/// The cells of one line, in the order of [`psych_ds_columns`].
fn cells(line: &ExportRow) -> Vec<String> {
    let purpose = match line.purpose {
        Purpose::Trial => "trial",
        Purpose::Catch => "catch",
        Purpose::Practice => "practice",
    };
    let text = |text: &String| escape::csv(text).into_owned();
    let mut out = vec![
        text(&line.participant),
        text(&line.session),
        text(&line.study),
        line.kind.name().to_owned(),
        line.presentation.to_string(),
        purpose.to_owned(),
        line.repetition.to_string(),
    ];
    out.extend(line.levels.iter().map(text));
    out.extend([
        line.rating.to_string(),
        line.attempt.to_string(),
        line.answer_ms.to_string(),
        line.passed.map(|p| p.to_string()).unwrap_or_default(),
        line.outcome.map_or("not ended", outcome_name).to_owned(),
    ]);
    out
}

/// Lines as CSV with a header.
fn csv<'a>(columns: &[Column], lines: impl Iterator<Item = &'a ExportRow>) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let failed = |e: &dyn std::fmt::Display| Error::data(format!("cannot write CSV: {e}"));
    writer.write_record(columns.iter().map(|c| escape::csv(&c.name).into_owned())).map_err(|e| failed(&e))?;
    for line in lines {
        writer.write_record(cells(line)).map_err(|e| failed(&e))?;
    }
    writer.into_inner().map_err(|e| failed(&e))
}

/// Writes everything into `folder`: `responses.csv`, `dictionary.csv`, `analysis.R`, `psych-ds/…`.
///
/// The same journals give the same bytes. Nothing outside `folder` is touched; files of an earlier export
/// with the same names are replaced.
///
/// # Errors
/// As [`crate::data::load`]; [`Error::Write`] with the file that could not be written.
pub fn export(paths: &[PathBuf], selection: &Selection, folder: &Path) -> Result<ExportedFiles> {
    let JournalData { factors, lines, studies } = gather(paths, selection)?;
    let columns = psych_ds::columns(&factors);
    let mut written = ExportedFiles { rows: lines.len() as u64, files: Vec::new() };
    let mut put = |name: &Path, bytes: &[u8]| -> Result<()> {
        let path = folder.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)
                .map_err(|source| crate::files::WriteError { path: parent.to_owned(), source })?;
        }
        write_whole(&path, |out| out.write_all(bytes))?;
        written.files.push(name.to_owned());
        Ok(())
    };
    put(Path::new("responses.csv"), &csv(&columns, lines.iter())?)?;
    put(Path::new("dictionary.csv"), &dictionary(&columns)?)?;
    put(Path::new("analysis.R"), r_script(&factors).as_bytes())?;
    let root = Path::new("psych-ds");
    put(&root.join("dataset_description.json"), psych_ds::description(&columns, &studies, &lines).as_bytes())?;
    put(&root.join("README.md"), psych_ds::readme(&studies).as_bytes())?;
    for (name, of) in psych_ds::files(&lines) {
        put(&root.join("data").join(name), &csv(&columns, of.into_iter())?)?;
    }
    Ok(written)
}

fn dictionary(columns: &[Column]) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let failed = |e: &dyn std::fmt::Display| Error::data(format!("cannot write CSV: {e}"));
    writer.write_record(["column", "type", "unit", "description"]).map_err(|e| failed(&e))?;
    for c in columns {
        let row = [&escape::csv(&c.name), c.kind, c.unit, &escape::csv(&c.description)];
        writer.write_record(row).map_err(|e| failed(&e))?;
    }
    writer.into_inner().map_err(|e| failed(&e))
}

/// An R script that fits a mixed ordinal model to the ratings, so that an independent program checks the result.
fn r_script(factors: &[String]) -> String {
    let mut out = String::from(
        "# Cumulative link mixed model of the ratings, study by study.\n\
         # install.packages(\"ordinal\") once; then: Rscript analysis.R\n\
         library(ordinal)\n\
         d <- read.csv(\"responses.csv\", stringsAsFactors = TRUE)\n\
         d <- subset(d, purpose == \"trial\")\n\
         stopifnot(length(unique(d$kind)) == 1)  # kinds of session are never analysed together\n\
         d$rating <- factor(d$rating, ordered = TRUE)\n\
         d$participant <- factor(d$participant)\n\
         for (s in levels(d$study)) {\n\
         \x20 x <- droplevels(subset(d, study == s))\n\
         \x20 cat(\"\\nstudy\", s, \"\\n\")\n",
    );
    let has = |f: &str| factors.iter().any(|x| x == f);
    if has("method") && has("scene") {
        out += "  if (nlevels(x$method) > 1 && nlevels(x$scene) > 1) {\n\
                \x20   print(summary(clmm(rating ~ method * scene + (1 + method | participant), data = x)))\n\
                \x20 } else ";
    } else {
        out += "  ";
    }
    let _ = writeln!(out, "print(summary(clmm(rating ~ 1 + (1 | participant), data = x)))\n}}");
    out
}
