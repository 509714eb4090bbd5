//! The methods of ambient occlusion.

/// How the visibility of the surroundings is found, which dims ambient light (seed 001: Wu, adaptive stereo ambient
/// occlusion).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Ao {
    /// Not at all: ambient light is not occluded.
    #[default]
    None,
    /// Each eye for itself: obscurance in its own view, then a cross-bilateral filter.
    Mono,
    /// Fully stereo-aware (Shi et al. 2022): every sample looked at in both views, both eyes' filters blended.
    Fsa,
    /// `mono`, then the work of `fsa` on the pixels whose eyes differ visibly.
    Variant1,
    /// Samples in both views everywhere, then blended filters on the pixels whose eyes differ visibly.
    Variant2,
    /// Rays through the scene's geometry: the oracle of the others.
    RayTraced,
}

impl Ao {
    /// Every method.
    pub const ALL: [Ao; 6] = [Ao::None, Ao::Mono, Ao::Fsa, Ao::Variant1, Ao::Variant2, Ao::RayTraced];

    /// Every method of the views, in the order of their tables.
    pub const OF_VIEWS: [Ao; 4] = [Ao::Mono, Ao::Fsa, Ao::Variant1, Ao::Variant2];

    /// The word on the command line and in JSON.
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

    /// Estimated from the views.
    pub fn is_estimated(self) -> bool {
        Ao::OF_VIEWS.contains(&self)
    }

    /// The eyes are compared with each other.
    pub fn is_stereo(self) -> bool {
        self.is_estimated() && self != Ao::Mono
    }

    /// Every pixel's samples are looked at in both views.
    pub fn samples_both_views(self) -> bool {
        matches!(self, Ao::Fsa | Ao::Variant2)
    }

    /// Works on where the eyes differ visibly.
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
