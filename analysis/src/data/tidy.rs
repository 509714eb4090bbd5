//! Reads tidy CSV: one row for each response, the columns `participant` and `rating`, and any others.

use std::cell::Cell;
use std::io::{self, Read};
use std::path::Path;

use super::{Builder, Response, Score};
use crate::error::{Error, Result};
use crate::journal::Kind;
use crate::{escape, files};

/// Columns that are factors wherever they occur; others become factors when a request names them.
pub const FACTORS: [&str; 9] = ["scene", "view", "path", "method", "other", "reference", "eye", "module", "condition"];

/// No row of answers has more bytes. A longer one is another kind of file, or has a quote mark that is never closed.
const LONGEST_ROW: u64 = 1 << 20;

/// A source that fails when a row is longer than a row may be. The CSV reader's buffer reads ahead of the rows: bytes
/// beyond the current row count for the next one.
struct Rows<'a, R> {
    source: R,
    left: &'a Cell<u64>,
}

impl<R: Read> Read for Rows<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.source.read(buffer)?;
        let left = self.left.get().checked_sub(read as u64).ok_or_else(|| {
            let what = format!("a row has more than {LONGEST_ROW} bytes; a quote mark may be open");
            io::Error::new(io::ErrorKind::FileTooLarge, what)
        })?;
        self.left.set(left);
        Ok(read)
    }
}

/// Which columns become factors of a cell.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// Factors beyond [`FACTORS`] that the request names.
    pub extra: Vec<String>,
    /// Make every repetition its own cell (screening looks at single stimuli).
    pub by_repetition: bool,
    /// Make every rating its own cell (forced choices need each participant's distribution).
    pub by_rating: bool,
}

/// Streams a tidy CSV file into `builder`, in bounded memory whatever the file's length.
///
/// Columns: `participant` and `rating` (finite numbers; empty or `NA`: no answer, counted and noted);
/// `study`, `kind` (real, pilot, simulated), `repetition` (a whole number) where present; factors as
/// [`Columns`] says. A column `purpose` keeps rows other than `trial` out of the analysis.
///
/// # Errors
/// [`Error::Read`] and [`Error::Line`]: a missing column, a row of another length, a rating that is no
/// finite number (participant and condition are named), a showing answered twice.
pub fn read(path: &Path, columns: &Columns, builder: &mut Builder) -> Result<()> {
    let file = files::open(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    read_from(path, file, columns, builder)
}

/// [`read`] from any source; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn read_from(path: &Path, source: impl Read, columns: &Columns, builder: &mut Builder) -> Result<()> {
    let left = Cell::new(LONGEST_ROW);
    let source = Rows { source, left: &left };
    let mut csv = csv::ReaderBuilder::new().buffer_capacity(1 << 18).trim(csv::Trim::All).from_reader(source);
    let wrong = |line: u64, what: String| Error::Line { path: path.to_owned(), line, what };
    let headers = csv.byte_headers().map_err(|e| csv_error(path, e))?.clone();
    let names: Vec<String> = headers
        .iter()
        .map(|h| escape::csv_read(String::from_utf8_lossy(h).trim_start_matches('\u{feff}')).to_lowercase())
        .collect();
    let column = |name: &str| names.iter().position(|n| n == name);
    let need = |name: &str| {
        column(name).ok_or_else(|| {
            wrong(
                1,
                format!(
                    "no column `{name}`; the header must name participant and rating, here it is `{}`",
                    names.join(",")
                ),
            )
        })
    };
    let (participant, rating) = (need("participant")?, need("rating")?);
    let (study, kind, repetition, purpose) = (column("study"), column("kind"), column("repetition"), column("purpose"));
    let factors: Vec<(usize, &str)> = names
        .iter()
        .enumerate()
        .filter(|(i, n)| {
            *i != participant
                && *i != rating
                && (FACTORS.contains(&n.as_str()) || (columns.extra.contains(n) && *n != "study"))
        })
        .map(|(i, n)| (i, n.as_str()))
        .collect();
    let mut row = csv::ByteRecord::new();
    let mut missing = 0u64;
    left.set(LONGEST_ROW);
    while csv.read_byte_record(&mut row).map_err(|e| csv_error(path, e))? {
        left.set(LONGEST_ROW);
        let line = row.position().map_or(0, csv::Position::line);
        let text = |i: usize| {
            std::str::from_utf8(&row[i])
                .map(escape::csv_read)
                .map_err(|_| wrong(line, format!("column `{}` is not UTF-8 text", names[i])))
        };
        if purpose.is_some_and(|p| !matches!(&row[p], b"trial" | b"")) {
            continue;
        }
        let who = text(participant)?;
        if who.is_empty() {
            return Err(wrong(line, "no participant: every row needs one".to_owned()));
        }
        let cells = factors.iter().map(|(i, name)| Ok((*name, text(*i)?))).collect::<Result<Vec<_>>>()?;
        let mut levels = Vec::with_capacity(factors.len() + 2);
        levels.extend(cells.iter().map(|(name, level)| (*name, level.as_ref())).filter(|(_, level)| !level.is_empty()));
        if matches!(&row[rating], b"" | b"NA" | b"na" | b"null") {
            missing += 1;
            continue;
        }
        let score = Score::parse(&row[rating]).map_err(|what| {
            let cell = levels.iter().map(|(n, l)| format!("{n} {l}")).collect::<Vec<_>>().join(", ");
            wrong(line, format!("the rating {what}; participant {who}, {cell}"))
        })?;
        let kind = match kind.map(&text).transpose()?.as_deref() {
            None | Some("") => None,
            Some("real") => Some(Kind::Real),
            Some("pilot") => Some(Kind::Pilot),
            Some("simulated") => Some(Kind::Simulated),
            Some(other) => {
                return Err(wrong(line, format!("unknown kind `{other}`; known: real, pilot, simulated")));
            }
        };
        let showing = match repetition.map(&text).transpose()?.as_deref() {
            None | Some("") => None,
            Some(t) => Some(
                t.parse::<u32>()
                    .map_err(|_| wrong(line, format!("repetition `{t}` is not a whole number from 0 up")))?,
            ),
        };
        let (showing_text, score_text);
        if columns.by_repetition {
            showing_text = showing.map(|s| s.to_string()).unwrap_or_default();
            if showing.is_some() {
                levels.push(("repetition", &showing_text));
            }
        }
        if columns.by_rating {
            score_text = score.to_string();
            levels.push(("rating", &score_text));
        }
        let response = Response {
            participant: &who,
            study: &study.map(&text).transpose()?.unwrap_or_default(),
            kind,
            factors: &levels,
            // Where the rating is part of the cell, a second answer to the same showing is refused only if it repeats
            // the rating.
            repetition: showing,
            rating: score,
        };
        builder.add(&response).map_err(|what| wrong(line, what))?;
    }
    if missing > 0 {
        builder.note(format!("{}: {missing} rows without a rating were left out", path.display()));
    }
    Ok(())
}

fn csv_error(path: &Path, error: csv::Error) -> Error {
    let line = error.position().map_or(1, csv::Position::line);
    match error.into_kind() {
        csv::ErrorKind::Io(source) => Error::Read { path: path.to_owned(), source },
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => Error::Line {
            path: path.to_owned(),
            line,
            what: format!("{len} fields where the header has {expected_len}"),
        },
        other => Error::Line { path: path.to_owned(), line, what: format!("not CSV: {other:?}") },
    }
}
