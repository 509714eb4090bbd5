//! One answer that counts, wherever it comes from.

use super::Score;
use crate::journal::Kind;

/// One rating of one participant under one condition.
#[derive(Clone, Copy, Debug)]
pub struct Response<'a> {
    /// Pseudonym.
    pub participant: &'a str,
    /// Study id; empty when the source does not say.
    pub study: &'a str,
    /// Real, pilot or simulated; `None` when the source does not say.
    pub kind: Option<Kind>,
    /// What was varied: factor and level, such as (`scene`, `pica`).
    pub factors: &'a [(&'a str, &'a str)],
    /// Which showing of the condition, from 0; `None` when the source does not say.
    pub repetition: Option<u32>,
    /// The rating.
    pub rating: Score,
}
