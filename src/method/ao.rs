//! The names and properties of the methods of ambient occlusion. The command line and JSON name an [`Ao`]; the renderer
//! and `compare` read its properties.

/// How ambient occlusion is found: the share of a point's surroundings that nearby surfaces hide, by which its ambient
/// light is reduced. All methods but the rays are those of seed 001 (Wu, adaptive stereo ambient occlusion).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Ao {
    /// Ambient light is not occluded.
    #[default]
    None,
    /// Each eye for itself: obscurance is estimated in its own view, then smoothed by a cross-bilateral filter.
    Mono,
    /// Fully stereo-aware (Shi et al. 2022): every sample is looked up in both views, and both eyes' filtered values
    /// are blended.
    Fsa,
    /// `mono` first, then the work of `fsa` on the pixels that differ visibly between the eyes.
    Variant1,
    /// Every sample is looked up in both views. Only pixels that differ visibly between the eyes are blended.
    Variant2,
    /// Rays through the scene's geometry, with which the other methods are compared.
    RayTraced,
}

impl Ao {
    /// Every method.
    pub const ALL: [Ao; 6] = [Ao::None, Ao::Mono, Ao::Fsa, Ao::Variant1, Ao::Variant2, Ao::RayTraced];

    /// The methods that estimate occlusion from the views, in the order of the tables.
    pub const OF_VIEWS: [Ao; 4] = [Ao::Mono, Ao::Fsa, Ao::Variant1, Ao::Variant2];

    /// The name on the command line and in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Ao::None => "none",
            Ao::Mono => "mono",
            Ao::Fsa => "fsa",
            Ao::Variant1 => "variant1",
            Ao::Variant2 => "variant2",
            Ao::RayTraced => "ray-traced",
        }
    }

    /// Whether occlusion is estimated from the views.
    pub fn is_estimated(self) -> bool {
        Ao::OF_VIEWS.contains(&self)
    }

    /// Whether the method uses both views together.
    pub fn is_stereo(self) -> bool {
        self.is_estimated() && self != Ao::Mono
    }

    /// Whether the samples of every pixel are looked up in both views.
    pub fn samples_both_views(self) -> bool {
        matches!(self, Ao::Fsa | Ao::Variant2)
    }

    /// Whether the method does further work only on the pixels that differ visibly between the eyes.
    pub fn is_adaptive(self) -> bool {
        matches!(self, Ao::Variant1 | Ao::Variant2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum as _;

    #[test]
    fn every_method_has_one_name() {
        for ao in Ao::value_variants() {
            let shown = ao.to_possible_value().expect("none is hidden");
            assert_eq!(shown.get_name(), ao.name());
            assert_eq!(serde_json::to_value(ao).expect("JSON"), ao.name());
        }
    }
}
