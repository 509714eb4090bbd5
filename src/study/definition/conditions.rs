//! The conditions of a study file, and the order in which they are shown.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The conditions that are compared: either factors to cross, or a list of conditions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// Every combination of these levels; the first factor varies slowest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross: Option<Cross>,
    /// Exactly these conditions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub list: Option<Vec<ConditionSpec>>,
}

/// Levels to cross, in this order of factors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cross {
    /// Scenes.
    pub scene: Vec<String>,
    /// Views; none: the first view of each scene.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub view: Vec<String>,
    /// Paths of the head, which make the stimuli move; none: the stimuli are stills.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub path: Vec<String>,
    /// Eyes whose images are shown (`mirrored-pair` only).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub eye: Vec<EyeName>,
    /// Methods.
    pub method: Vec<String>,
    /// Methods that each method is compared with (`compare` only).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub other: Vec<String>,
    /// The method of the reference that is shown beside both (`mirrored-pair` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<String>,
}

/// One of the two eyes' images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum EyeName {
    /// The left eye's image.
    Left,
    /// The right eye's image.
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
    /// The path that the head follows: one of the scene's, or one that every scene has (`still`, `sway`, `cut`). The
    /// stimulus moves at the path's own rate. None: a still.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// The eye whose image is shown (`mirrored-pair` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<EyeName>,
    /// Method name, `NAME` or `NAME@samples`.
    pub method: String,
    /// The method that it is compared with (`compare` only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub other: Option<String>,
    /// The method of the reference that is shown beside both (`mirrored-pair` only).
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
    /// What is shown. With `compare`, an `other` that equals `method` shows one image twice.
    pub show: ConditionSpec,
    /// Ratings with which the catch trial is passed.
    pub passes: Vec<i32>,
}

/// The order in which the conditions are shown.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OrderSpec {
    /// The design of the order.
    pub kind: OrderKind,
    /// For `blocked`: conditions with the same level of this factor stay together.
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
    /// Williams' design, balanced for first-order carry-over; it has n rows for even n, 2n for odd n.
    LatinSquare,
    /// The order of the file, for every participant.
    Fixed,
    /// Blocks in random order, and conditions in random order within each block.
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
