//! The target for tidy CSV. A table that can be read must have the same answers after it is written and read again, and
//! it must be possible to make its report.

use std::collections::BTreeMap;
use std::path::Path;

use cyclopean_analysis::data::{self, Cell, Columns, Dataset, Score, Selection};
use cyclopean_analysis::escape;
use cyclopean_analysis::journal::Kind;
use cyclopean_analysis::mos::{TableOptions, table};
use cyclopean_analysis::report::{self, ReportInput, ReportOptions};

/// Tables with more answers are only read.
const MOST_REPORTED: u64 = 64;
/// A report takes a millisecond, so that it is made for only one in this many tables.
const REPORTED_OF: u64 = 16;

pub fn run(bytes: &[u8]) {
    let path = super::file("t.csv", bytes);
    let plain = selection(Columns::default());
    let loaded = match data::load(std::slice::from_ref(&path), &plain) {
        Ok(loaded) => loaded.data,
        Err(error) => return super::said(&error),
    };
    let whole = data::load(std::slice::from_ref(&path), &selection(Columns { by_rating: true, ..Columns::default() }));
    let whole = whole.expect("the same rows can be read with one cell for each rating").data;
    assert_eq!(whole.responses(), loaded.responses(), "answers were lost");
    assert_eq!(whole.kinds, loaded.kinds);
    if loaded.responses() > MOST_REPORTED {
        return;
    }
    let again = super::file("again.csv", &write(&whole));
    let again = data::load(&[again], &plain).expect("a written table can be read").data;
    assert_eq!(told(&again), told(&loaded), "the answers changed when they were written and read again");
    match table(&loaded, &TableOptions::default()) {
        Ok(table) => drop(table.to_json()),
        Err(error) => super::said(&error),
    }
    if super::one_of(REPORTED_OF, bytes) {
        reported(&path);
    }
}

fn selection(columns: Columns) -> Selection {
    let allow_kinds = [Kind::Real, Kind::Pilot, Kind::Simulated].into();
    Selection { columns, allow_kinds, ..Selection::default() }
}

/// The study, and its factors with their levels.
type Condition<'a> = (&'a str, BTreeMap<&'a str, &'a str>);

/// How often each rating was given, and for each participant the number and the sum of the ratings.
type Answers<'a> = (Vec<(Score, u64)>, BTreeMap<&'a str, (u32, i64)>);

/// The answers by condition, which do not depend on the order of the rows.
fn told(data: &Dataset) -> BTreeMap<Condition<'_>, Answers<'_>> {
    let of = |at: usize| {
        let cell: &Cell = &data.cells[at];
        let levels = data.factors.iter().zip(&cell.levels);
        let levels = levels.filter_map(|(name, level)| Some((name.as_str(), level.as_deref()?))).collect();
        let counts = cell.counts.iter().map(|(rating, n)| (*rating, *n)).collect();
        let people = data.participants.iter().map(|p| (p.id.as_str(), p.tally(at)));
        let people = people.filter(|(_, tally)| tally.n > 0).map(|(id, tally)| (id, (tally.n, tally.sum))).collect();
        ((data.studies[cell.study].id.as_str(), levels), (counts, people))
    };
    (0..data.cells.len()).filter(|at| !data.cells[*at].counts.is_empty()).map(of).collect()
}

/// Writes one row for each answer, from cells that have one rating each.
fn write(data: &Dataset) -> Vec<u8> {
    let mut out = String::new();
    let mut line = |cells: &mut dyn Iterator<Item = &str>| {
        // Numbers are not escaped, as in an export.
        let text =
            |cell: &str| if cell.parse::<f64>().is_ok() { cell.to_owned() } else { escape::csv(cell).into_owned() };
        let quoted = |cell: &str| format!("\"{}\"", text(cell).replace('"', "\"\""));
        out += &(cells.map(quoted).collect::<Vec<_>>().join(",") + "\n");
    };
    line(&mut ["participant", "study"].into_iter().chain(data.factors.iter().map(String::as_str)));
    for participant in &data.participants {
        for (at, cell) in data.cells.iter().enumerate() {
            for _ in 0..participant.tally(at).n {
                let levels = cell.levels.iter().map(|level| level.as_deref().unwrap_or_default());
                line(&mut [participant.id.as_str(), &data.studies[cell.study].id].into_iter().chain(levels));
            }
        }
    }
    out.into_bytes()
}

/// Makes the report of a table in every form.
fn reported(path: &Path) {
    let options = ReportOptions { title: "Fuzz".to_owned(), ..ReportOptions::default() };
    match ReportInput::gather(&[path.to_owned()], &selection(Columns::default()), &options) {
        Ok(gathered) => {
            assert!(report::html(&gathered).trim_end().ends_with("</html>"));
            for text in [report::markdown(&gathered), report::latex(&gathered), report::csv(&gathered)] {
                assert!(!text.is_empty());
            }
            report::json(&gathered);
        }
        Err(error) => super::said(&error),
    }
}
