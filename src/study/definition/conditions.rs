//! What is compared, and in which order it is shown.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is compared: factors crossed, or conditions listed; one of the two.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// Every combination of these levels, the first factor slowest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross: Option<Cross>,
    /// These and no other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub list: Option<Vec<ConditionSpec>>,
}

/// Levels to cross, in this order of factors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cross {
    /// Scenes.
    pub scene: Vec<String>,
    /// Views; none: each scene's first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub view: Vec<String>,
    /// Paths of the head, which make the stimuli move; none: stills.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub path: Vec<String>,
    /// Eyes (`mirrored-pair` only).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub eye: Vec<EyeName>,
    /// Methods.
    pub method: Vec<String>,
    /// What each is compared with (`compare` only).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other: Vec<String>,
    /// What both are compared to (`mirrored-pair` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
}

/// One of the two eyes' images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum EyeName {
    /// The left.
    Left,
    /// The right.
    Right,
}

impl EyeName {
    pub fn name(self) -> &'static str {
        match self {
            EyeName::Left => "left",
            EyeName::Right => "right",
        }
    }
}

/// One condition.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConditionSpec {
    /// Scene name.
    pub scene: String,
    /// View name; none: the scene's first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
    /// The path that the head follows, one of the scene's or of those that every scene has (`still`, `sway`, `cut`); the
    /// stimulus moves at the path's own rate. None: a still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// Which eye's image (`mirrored-pair` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<EyeName>,
    /// Method name, `NAME` or `NAME@samples`.
    pub method: String,
    /// The method it is compared with (`compare` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other: Option<String>,
    /// The method both are compared to (`mirrored-pair` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
}

impl ConditionSpec {
    /// Factor → level, as the journal and the analysis name them.
    pub fn factors(&self) -> BTreeMap<String, String> {
        let eye = self.eye.map(|e| e.name().to_owned());
        let optional = [
            ("view", &self.view),
            ("path", &self.path),
            ("eye", &eye),
            ("other", &self.other),
            ("reference", &self.reference),
        ];
        [("scene", self.scene.clone()), ("method", self.method.clone())]
            .into_iter()
            .chain(optional.into_iter().filter_map(|(name, level)| Some((name, level.clone()?))))
            .map(|(name, level)| (name.to_owned(), level))
            .collect()
    }
}

/// A presentation whose right answer is known.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CatchTrial {
    /// What is shown; `compare`: `other` equal to `method` shows one image twice.
    pub show: ConditionSpec,
    /// Ratings that pass.
    pub passes: Vec<i32>,
}

/// In which order the conditions are shown.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OrderSpec {
    /// The design.
    pub kind: OrderKind,
    /// `blocked`: conditions that agree in this factor stay together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub block_by: Option<String>,
}

impl Default for OrderSpec {
    fn default() -> OrderSpec {
        OrderSpec { kind: OrderKind::LatinSquare, block_by: None }
    }
}

/// The design of the order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OrderKind {
    /// A random order for each participant.
    Random,
    /// Williams: balanced for first-order carry-over; n rows for even n, 2n for odd.
    LatinSquare,
    /// As in the file, for all.
    Fixed,
    /// Blocks in random order, conditions in random order within a block.
    Blocked,
}

impl OrderKind {
    pub fn name(self) -> &'static str {
        match self {
            OrderKind::Random => "random",
            OrderKind::LatinSquare => "latin-square",
            OrderKind::Fixed => "fixed",
            OrderKind::Blocked => "blocked",
        }
    }
}
