//! The analysis that a study fixes before its first participant: the study file's `analysis` block.

use serde::{Deserialize, Serialize};

/// What will be computed from the votes, and by which conventions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct AnalysisPlan {
    /// The comparisons between two levels of a factor, in the order of their report.
    #[serde(default)]
    pub contrasts: Vec<Contrast>,
    /// Compare each participant's mean vote with this value (in a forced choice, the value of "same").
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub against: Option<i32>,
    /// The test of every contrast.
    #[serde(default)]
    pub test: Test,
    /// What happens to differences of zero.
    #[serde(default)]
    pub zeros: Zeros,
    /// The alternative hypothesis of every contrast.
    #[serde(default)]
    pub alternative: Alternative,
    /// The interval of every mean opinion score.
    #[serde(default)]
    pub interval: Interval,
    /// How p values of one family are adjusted.
    #[serde(default)]
    pub correction: Correction,
    /// Two one-sided tests of equivalence; without this, no equivalence is claimed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub equivalence: Option<Equivalence>,
    /// Whose data is left out of the second set of tables.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exclusion: Option<Exclusion>,
    /// When data collection ends, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stopping: Option<String>,
}

/// One comparison, a − b.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Contrast {
    /// A level of `factor`, such as `stereo`.
    pub a: String,
    /// Another level of `factor`, such as `sssr`.
    pub b: String,
    /// The factor whose levels are compared.
    #[serde(default = "method")]
    pub factor: String,
    /// The family of the comparison, within which p values are adjusted; `primary` by default.
    #[serde(default = "primary")]
    pub family: String,
    /// One test for each level of this factor (exploratory); none: one test over all levels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub per: Option<String>,
}

fn method() -> String {
    "method".to_owned()
}

fn primary() -> String {
    "primary".to_owned()
}

/// The test of a paired difference.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Test {
    /// Wilcoxon signed-rank, exact conditional null.
    #[default]
    SignedRankExact,
    /// Wilcoxon signed-rank, normal approximation with tie correction.
    SignedRankAsymptotic,
}

/// What happens to differences of zero. The names are those of the command line.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Zeros {
    /// Zeros are dropped.
    #[default]
    Wilcox,
    /// Zeros are ranked, then left out.
    Pratt,
    /// Zero ranks are split between the sides.
    Zsplit,
}

/// The alternative hypothesis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Alternative {
    /// a ≠ b
    #[default]
    TwoSided,
    /// a > b
    Greater,
    /// a < b
    Less,
}

/// The interval of a mean opinion score.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Interval {
    /// How the interval is made.
    #[serde(default)]
    pub kind: IntervalKind,
    /// Its confidence level, 0.5 ..= 0.999; the paper uses 0.9.
    #[serde(default = "ninety")]
    pub level: f64,
}

fn ninety() -> f64 {
    0.9
}

impl Default for Interval {
    fn default() -> Interval {
        Interval { kind: IntervalKind::T, level: ninety() }
    }
}

/// How an interval is made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum IntervalKind {
    /// Student t.
    #[default]
    T,
    /// Normal.
    Normal,
    /// Percentile bootstrap over participants.
    Percentile,
    /// BCa bootstrap over participants.
    Bca,
    /// Clopper–Pearson under a binomial model.
    ClopperPearson,
    /// Jeffreys under a binomial model.
    Jeffreys,
}

/// How p values of one family are adjusted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Correction {
    /// Holm: controls the family-wise error rate.
    #[default]
    Holm,
    /// Benjamini–Hochberg: controls the false discovery rate.
    BenjaminiHochberg,
    /// No adjustment.
    None,
}

/// A test of equivalence: no difference that matters between two levels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Equivalence {
    /// A level of the factor `method`.
    pub a: String,
    /// Another level of the factor `method`.
    pub b: String,
    /// Half width of the zone of equivalence, in scale steps, > 0.
    pub margin: f64,
}

/// Whose data is left out of the second set of tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub struct Exclusion {
    /// A participant who fails at least this many catch trials is left out (≥ 1).
    pub failed_catch_trials: u32,
}
