//! Screening of observers. The results are shown; no table leaves anybody out because of them.

mod bt500;
mod krippendorff;
mod p910;

use crate::data::Dataset;

pub use bt500::{Bt500, Observer, Sigma, bt500};
pub use krippendorff::{Alpha, krippendorff_ordinal};
pub use p910::{P910, P910Options, p910, remove_bias};

/// Votes by stimulus and observer; `None` where there is none.
pub type Votes = Vec<Vec<Option<f64>>>;

/// A matrix with one row for each stimulus (a cell with its repetition) and one column for each participant, and the
/// names of both.
///
/// The data must have been read with repetitions as cells ([`crate::data::Columns::by_repetition`]);
/// several votes in one cell are averaged.
pub fn matrix(data: &Dataset, study: usize) -> (Vec<String>, Vec<String>, Votes) {
    let cells = data.cells_of(study);
    let people: Vec<usize> =
        (0..data.participants.len()).filter(|p| cells.iter().any(|c| data.participants[*p].tally(*c).n > 0)).collect();
    let votes = cells
        .iter()
        .map(|c| people.iter().map(|p| data.participants[*p].tally(*c)).map(|t| (t.n > 0).then(|| t.mean())).collect())
        .collect();
    (
        cells.iter().map(|c| data.describe(*c)).collect(),
        people.iter().map(|p| data.participants[*p].id.clone()).collect(),
        votes,
    )
}
