//! Methods as data: which parts of the pipeline are on.

use std::fmt;

/// A condition of a study, or a peer to compare with. `NAME@N` is NAME with N rays a pixel in one ratio.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Method {
    base: &'static Parts,
    /// Thousandths of a per cent of the method's [`Knob`]; `None`: the method's own default, or no knob.
    knob: Option<u32>,
    /// Rays (or paths) a pixel; `None`: the method's own default.
    samples: Option<u32>,
}

/// What the percentage at the end of a method's name sets (`stereo-hybrid-25`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Knob {
    /// Share of the rays that the views lose which may ask the scene's geometry; 100 by default. At 0 the method is the
    /// same without geometry.
    LostRays,
    /// Weber contrast between the eyes, relative to the pixel's composite luminance, below which no work is done in
    /// the other eye; 2 by default (seed 001: Walter et al. 2005).
    Weber,
}

impl Knob {
    /// Thousandths of a per cent.
    fn default_value(self) -> u32 {
        match self {
            Knob::LostRays => 100_000,
            Knob::Weber => 2_000,
        }
    }
}

/// How the taps of the spatial reuse are weighted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Reuse {
    /// Multiple-importance weights: the balance heuristic between the pixel's own density and each tap's (pairwise, as
    /// in Bitterli 2022), bright outliers bounded, and the eyes blended by their variances.
    #[default]
    Balance,
    /// The published ratio estimator (Stachowiak 2015): each tap over its own density, nothing bounded, and the eyes
    /// blended by fixed weights.
    Ratio,
}

/// How the light of a pair of pixels is blended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blend {
    /// By squared bias and both variances (seed 003, equation 4). Needs the moments that [`Reuse::Balance`] keeps.
    Variance,
    /// By fixed weights.
    Fixed,
}

/// How a new frame is weighed against the frames before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Temporal {
    /// By squared bias and both variances, pixel by pixel (seed 003, equation 4).
    #[default]
    Variance,
    /// A tenth of each new frame.
    Constant,
    /// A tenth of each new frame, and the history is clamped to what the pixel's neighbourhood shows (Salvi 2016).
    Clamp,
}

/// Where the reflection of a pixel is looked for in the last frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HistorySource {
    /// At both places below; the one that agrees better is taken.
    Better,
    /// Where the surface was.
    Surface,
    /// Where the last frame's eye saw the virtual image of what is reflected (seed 002).
    Image,
}

/// Accumulation of reflections over frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Accumulation {
    /// `None`: as the settings say.
    pub weights: Option<Temporal>,
    pub source: HistorySource,
}

/// How reflection rays are answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// From the depth of the views.
    ScreenSpace,
    /// From the scene's geometry.
    PathTraced,
}

/// How a screen-space ray uses the two views.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Traversal {
    /// It stays in its own eye's.
    OwnEye,
    /// Its own eye's first, then, where that loses it, the other one's: two compacted stages.
    TwoStages,
    /// Both eyes asked at every pixel on the way, without a hierarchy: the oracle.
    OneLoop,
}

/// Reuse between the eyes (paper §4.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reprojection {
    /// A pixel that knows nothing may take what the other eye knows.
    pub filling: bool,
    /// A pair must lead back to its pixel.
    pub back_check: bool,
    /// What the two reflect may differ by the lobe's footprint; otherwise by a thousandth of its distance.
    pub lobe_tolerance: bool,
    pub blend: Blend,
}

/// What a method is made of.
#[derive(Debug, PartialEq, Eq)]
pub struct Parts {
    name: &'static str,
    about: &'static str,
    pub answer: Answer,
    /// Closed meshes are as thick as their back faces say.
    pub back_faces: bool,
    /// Rays that come back towards the eye are marched too.
    pub camera_rays: bool,
    /// Rays that leave their eye's view go on in the other one's (paper §4.1).
    pub traversal: Traversal,
    /// Both eyes fade alike (paper §4.2).
    pub stereo_fade: bool,
    /// Samples are shared between the eyes (paper §4.3).
    pub reprojection: Option<Reprojection>,
    /// What the frames before knew is used.
    pub accumulation: Option<Accumulation>,
    /// Only the left eye traces; the right one has what is reprojected.
    pub one_eye: bool,
    /// The reference's rays go through the screen-space methods' filter.
    pub resolved: bool,
    /// Pixels beyond each border that are drawn and never shown, in thousandths of the view.
    pub guard_band: u32,
    /// Both eyes draw the same random numbers.
    pub shared_noise: bool,
    /// Squared radius of the spatial reuse, pixels; `None`: the settings'.
    pub reuse_radius_squared: Option<u32>,
    /// How taps are weighted; `None`: as the settings say.
    pub reuse: Option<Reuse>,
    /// What a percentage at the end of the name sets.
    pub knob: Option<Knob>,
    /// Stands for another method, which the device chooses: see [`Method::on`].
    pub chosen_by_device: bool,
    /// The right eye's reflections are exchanged left and right.
    pub unrelated: bool,
    samples: u32,
}

/// The baseline; the others say where they differ.
const SSSR: Parts = Parts {
    name: "sssr",
    about: "stochastic screen-space reflections, each eye for itself (the baseline)",
    answer: Answer::ScreenSpace,
    back_faces: true,
    camera_rays: true,
    traversal: Traversal::OwnEye,
    stereo_fade: false,
    reprojection: None,
    accumulation: None,
    one_eye: false,
    resolved: false,
    guard_band: 0,
    shared_noise: false,
    reuse_radius_squared: None,
    reuse: None,
    knob: None,
    chosen_by_device: false,
    unrelated: false,
    samples: 1,
};

const OURS: Reprojection =
    Reprojection { filling: true, back_check: true, lobe_tolerance: true, blend: Blend::Variance };
const PAPER: Reprojection =
    Reprojection { filling: false, back_check: false, lobe_tolerance: false, blend: Blend::Fixed };

/// All three parts of the paper's §4.
const STEREO: Parts = Parts {
    name: "stereo",
    about: "stereo-consistent: traversal, fade and reprojection know both eyes",
    traversal: Traversal::TwoStages,
    stereo_fade: true,
    reprojection: Some(OURS),
    ..SSSR
};

const OVER_TIME: Accumulation = Accumulation { weights: None, source: HistorySource::Better };

/// The reference; also the tracer of its real-time relative.
const PATH_TRACED: Parts = Parts {
    name: "path-traced",
    about: "the reference: rays through the scene's geometry",
    answer: Answer::PathTraced,
    back_faces: false,
    samples: 1024,
    ..SSSR
};

const METHODS: &[Parts] = &[
    SSSR,
    STEREO,
    Parts {
        name: "stereo-no-traversal",
        about: "stereo without the other eye's traversal",
        traversal: Traversal::OwnEye,
        ..STEREO
    },
    Parts { name: "stereo-no-fade", about: "stereo with each eye's own fade", stereo_fade: false, ..STEREO },
    Parts {
        name: "stereo-no-reprojection",
        about: "stereo without reuse between the eyes",
        reprojection: None,
        ..STEREO
    },
    Parts {
        name: "stereo-one-loop",
        about: "stereo whose rays ask both eyes at every pixel: the oracle of its traversal, slow",
        traversal: Traversal::OneLoop,
        ..STEREO
    },
    Parts {
        name: "stereo-paper",
        about: "stereo with the publication's settings: the four below together",
        camera_rays: false,
        reprojection: Some(PAPER),
        ..STEREO
    },
    Parts {
        name: "stereo-fixed-tolerance",
        about: "stereo whose pairs agree to a thousandth, whatever the roughness",
        reprojection: Some(Reprojection { lobe_tolerance: false, ..OURS }),
        ..STEREO
    },
    Parts {
        name: "stereo-no-filling",
        about: "stereo whose pixels that know nothing take nothing from the other eye",
        reprojection: Some(Reprojection { filling: false, ..OURS }),
        ..STEREO
    },
    Parts {
        name: "stereo-no-back-check",
        about: "stereo whose pairs need not lead back",
        reprojection: Some(Reprojection { back_check: false, ..OURS }),
        ..STEREO
    },
    Parts {
        name: "stereo-no-camera-rays",
        about: "stereo without rays that come back towards the eye",
        camera_rays: false,
        ..STEREO
    },
    Parts {
        name: "stereo-fixed-blend",
        about: "stereo whose eyes are blended by fixed weights instead of their variances",
        reprojection: Some(Reprojection { blend: Blend::Fixed, ..OURS }),
        ..STEREO
    },
    Parts {
        name: "stereo-ratio",
        about: "stereo with the published ratio estimator, whatever --reuse says",
        reuse: Some(Reuse::Ratio),
        ..STEREO
    },
    Parts {
        name: "sssr-ratio",
        about: "the baseline with the published ratio estimator, whatever --reuse says",
        reuse: Some(Reuse::Ratio),
        ..SSSR
    },
    Parts {
        name: "stereo-hybrid",
        about: "stereo whose lost rays ask the scene's geometry; stereo-hybrid-25 lets 25 % of them ask",
        knob: Some(Knob::LostRays),
        ..STEREO
    },
    Parts {
        name: "sssr-hybrid",
        about: "the baseline whose lost rays ask the scene's geometry; sssr-hybrid-25 lets 25 % of them ask",
        knob: Some(Knob::LostRays),
        ..SSSR
    },
    Parts {
        name: "stereo-adaptive",
        about: "each eye for itself, then stereo work only where the eyes may differ visibly; stereo-adaptive-5: by 5 %",
        traversal: Traversal::OwnEye,
        knob: Some(Knob::Weber),
        ..STEREO
    },
    Parts {
        name: "sssr-temporal",
        about: "the baseline, accumulated over frames",
        accumulation: Some(OVER_TIME),
        ..SSSR
    },
    Parts {
        name: "stereo-temporal",
        about: "stereo, each eye accumulated over frames before the eyes are blended",
        accumulation: Some(OVER_TIME),
        ..STEREO
    },
    Parts {
        name: "stereo-hybrid-temporal",
        about: "stereo-hybrid, accumulated likewise; stereo-hybrid-temporal-25 lets 25 % of the lost rays ask",
        accumulation: Some(OVER_TIME),
        knob: Some(Knob::LostRays),
        ..STEREO
    },
    Parts {
        name: "stereo-temporal-surface",
        about: "stereo-temporal whose history follows the surfaces alone",
        accumulation: Some(Accumulation { source: HistorySource::Surface, ..OVER_TIME }),
        ..STEREO
    },
    Parts {
        name: "stereo-temporal-image",
        about: "stereo-temporal whose history follows the virtual images alone",
        accumulation: Some(Accumulation { source: HistorySource::Image, ..OVER_TIME }),
        ..STEREO
    },
    Parts {
        name: "stereo-temporal-constant",
        about: "stereo-temporal that takes a tenth of each new frame, whatever --temporal says",
        accumulation: Some(Accumulation { weights: Some(Temporal::Constant), ..OVER_TIME }),
        ..STEREO
    },
    Parts {
        name: "stereo-temporal-clamp",
        about: "the same with the history clamped to the neighbourhood",
        accumulation: Some(Accumulation { weights: Some(Temporal::Clamp), ..OVER_TIME }),
        ..STEREO
    },
    Parts {
        name: "recommended",
        about: "what measurement says is best on this kind of device; --explain says what it took",
        chosen_by_device: true,
        ..STEREO
    },
    Parts {
        name: "sssr-thickness",
        about: "the baseline without back faces: every mesh is as thick as an open one",
        back_faces: false,
        ..SSSR
    },
    Parts {
        name: "sssr-guardband",
        about: "the baseline with a tenth of the view drawn beyond each border",
        guard_band: 100,
        ..SSSR
    },
    Parts {
        name: "stereo-guardband",
        about: "stereo with a tenth of the view drawn beyond each border",
        guard_band: 100,
        ..STEREO
    },
    Parts {
        name: "sssr-shared-noise",
        about: "the baseline with one random stream for both eyes",
        shared_noise: true,
        ..SSSR
    },
    Parts {
        name: "sssr-wide",
        about: "the baseline with 37 pixels of spatial reuse instead of 25",
        reuse_radius_squared: Some(10),
        ..SSSR
    },
    Parts {
        name: "one-eye",
        about: "the left eye as in the baseline, the right one reprojected from it",
        reprojection: Some(OURS),
        one_eye: true,
        ..SSSR
    },
    Parts {
        name: "unrelated",
        about: "for catch trials: the right eye's reflections exchanged left and right, so that nothing fits",
        unrelated: true,
        ..SSSR
    },
    PATH_TRACED,
    Parts {
        name: "path-traced-resolved",
        about: "a few of the reference's rays through the baseline's filter (also path-traced@N-resolved)",
        resolved: true,
        samples: 2,
        ..PATH_TRACED
    },
];

/// Best at no more than 1.25 times the baseline's trace and resolve on a device that walks the geometry slowly.
const RECOMMENDED_WITHOUT_RAY_QUERIES: &str = "stereo-guardband";
/// Best where a ray through the geometry costs about what a march through a view does.
const RECOMMENDED_WITH_RAY_QUERIES: &str = "stereo-hybrid";

/// A name that is no method.
#[derive(Debug, thiserror::Error)]
#[error(
    "unknown method `{name}`; known: {known}, each also as NAME@N with N rays a pixel (1 to 65536); {knobs} also as \
     NAME-P with a percentage P from 0 to 100"
)]
pub struct UnknownMethod {
    pub name: String,
    pub known: String,
    /// Those with a percentage.
    pub knobs: String,
}

impl Method {
    /// Reads `NAME`, `NAME-P`, `NAME@N` or `NAME-P@N`.
    ///
    /// # Errors
    /// [`UnknownMethod`], which lists the known ones.
    pub fn parse(text: &str) -> Result<Method, UnknownMethod> {
        let unknown = || UnknownMethod {
            name: text.to_owned(),
            known: Method::names().join(", "),
            knobs: Method::names_with_percentage().join(", "),
        };
        // The count may stand before the suffix: path-traced@2-resolved.
        let suffix = "-resolved";
        let moved = text.strip_suffix(suffix).and_then(|t| t.split_once('@')).map(|(n, c)| format!("{n}{suffix}@{c}"));
        let text = moved.as_deref().unwrap_or(text);
        let (name, count) = match text.split_once('@') {
            None => (text, None),
            Some((name, count)) => {
                let count: u32 = count.parse().map_err(|_| unknown())?;
                if !(1..=65536).contains(&count) {
                    return Err(unknown());
                }
                (name, Some(count))
            }
        };
        if let Some(base) = METHODS.iter().find(|b| b.name == name) {
            return Ok(Method { base, knob: None, samples: count });
        }
        let (stem, percent) = name.rsplit_once('-').ok_or_else(unknown)?;
        let base = METHODS.iter().find(|b| b.name == stem && b.knob.is_some()).ok_or_else(unknown)?;
        // Only what `Display` writes again: digits with at most one point.
        let digits = percent.chars().all(|c| c.is_ascii_digit() || c == '.');
        let percent: f64 = percent.parse().ok().filter(|_| digits).ok_or_else(unknown)?;
        if !(0.0..=100.0).contains(&percent) {
            return Err(unknown());
        }
        Ok(Method { base, knob: Some((percent * 1000.0).round() as u32), samples: count })
    }

    /// The method that this one stands for on a device: `recommended` is the best one that was measured at 1.25 times
    /// the baseline's trace and resolve, or, where ray queries are fast, the best one of all. Figures: docs/compare.md.
    pub fn on(&self, fast_ray_queries: bool) -> Method {
        if !self.base.chosen_by_device {
            return self.clone();
        }
        let name = if fast_ray_queries { RECOMMENDED_WITH_RAY_QUERIES } else { RECOMMENDED_WITHOUT_RAY_QUERIES };
        let base = Method::parse(name).expect("a known method");
        Method { samples: self.samples, ..base }
    }

    /// The share of the rays lost by the views that may ask the scene's geometry, 0–1 in steps of 1/255; 0 where the
    /// method has no such rays.
    pub fn lost_share(&self) -> f32 {
        match self.base.knob {
            Some(Knob::LostRays) => (self.knob_value() as f32 / 100_000.0 * 255.0).round() / 255.0,
            _ => 0.0,
        }
    }

    /// The contrast between the eyes from which on the other eye is asked; `None`: everywhere.
    pub fn weber_share(&self) -> Option<f32> {
        (self.base.knob == Some(Knob::Weber)).then(|| self.knob_value() as f32 / 100_000.0)
    }

    fn knob_value(&self) -> u32 {
        self.knob.or_else(|| self.base.knob.map(Knob::default_value)).unwrap_or(0)
    }

    /// Every name, without `@N`.
    pub fn names() -> Vec<&'static str> {
        METHODS.iter().map(|b| b.name).collect()
    }

    /// Those that may end in a percentage.
    pub fn names_with_percentage() -> Vec<&'static str> {
        METHODS.iter().filter(|b| b.knob.is_some()).map(|b| b.name).collect()
    }

    /// Name and description of each.
    pub fn described() -> impl Iterator<Item = (&'static str, &'static str)> {
        METHODS.iter().map(|b| (b.name, b.about))
    }

    /// The same with so many rays a pixel (at least one), unless its name says how many.
    pub fn with_samples(self, samples: Option<u32>) -> Method {
        Method { samples: self.samples.or(samples.map(|n| n.max(1))), ..self }
    }

    /// The same with so many rays a pixel (at least one), whatever its name says.
    pub fn with_exactly(self, samples: u32) -> Method {
        Method { samples: Some(samples.max(1)), ..self }
    }

    /// The method that differs from this one in its accumulation over frames alone; `None`: there is none of that name.
    pub fn without_or_with_history(&self) -> Option<Method> {
        const SUFFIX: &str = "-temporal";
        let name = match self.base.name.strip_suffix(SUFFIX) {
            Some(without) => without.to_owned(),
            None => format!("{}{SUFFIX}", self.base.name),
        };
        let base = METHODS.iter().find(|b| b.name == name)?;
        Some(Method { base, ..self.clone() })
    }

    /// What it is made of.
    pub fn parts(&self) -> &'static Parts {
        self.base
    }

    /// Rays (or paths) a pixel.
    pub fn samples(&self) -> u32 {
        self.samples.unwrap_or(self.base.samples)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.base.name)?;
        if let Some(thousandths) = self.knob {
            write!(f, "-{}", f64::from(thousandths) / 1000.0)?;
        }
        match self.samples {
            Some(n) if n != self.base.samples => write!(f, "@{n}"),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_counts_are_read() {
        let method = Method::parse("sssr@4").expect("known");
        assert_eq!((method.samples(), method.to_string().as_str()), (4, "sssr@4"));
        assert_eq!(Method::parse("path-traced").expect("known").samples(), 1024);
        let resolved = Method::parse("path-traced@4-resolved").expect("known");
        assert_eq!((resolved.samples(), resolved.to_string().as_str()), (4, "path-traced-resolved@4"));
        for wrong in ["", "sssr@", "sssr@0", "sssr@-1", "sssr@99999999999", "SSSR", "nothing"] {
            let error = Method::parse(wrong).expect_err("unknown").to_string();
            assert!(error.contains("known: sssr"), "{error}");
        }
    }

    #[test]
    fn a_percentage_in_the_name_is_read_and_written() {
        for (name, share) in [("stereo-hybrid", 1.0), ("stereo-hybrid-0", 0.0), ("sssr-hybrid-20", 0.2)] {
            let method = Method::parse(name).expect("known");
            assert_eq!((method.to_string().as_str(), method.lost_share()), (name, share));
        }
        let method = Method::parse("stereo-adaptive-0.5@2").expect("known");
        assert_eq!((method.weber_share(), method.samples()), (Some(0.005), 2));
        assert_eq!(method.to_string(), "stereo-adaptive-0.5@2");
        assert_eq!(Method::parse("stereo-adaptive").expect("known").weber_share(), Some(0.02));
        assert_eq!(Method::parse("stereo").expect("known").weber_share(), None);
        for wrong in ["stereo-5", "stereo-hybrid-101", "stereo-hybrid--1", "stereo-hybrid-", "stereo-hybrid-1e1"] {
            let error = Method::parse(wrong).expect_err("unknown").to_string();
            assert!(error.contains("percentage"), "{error}");
        }
    }

    #[test]
    fn the_recommended_method_is_one_of_the_others() {
        let recommended = Method::parse("recommended@2").expect("known");
        for fast in [false, true] {
            let taken = recommended.on(fast);
            assert!(!taken.parts().chosen_by_device && taken.samples() == 2, "{taken}");
        }
        let other = Method::parse("sssr@4").expect("known");
        assert_eq!(other.on(true), other);
    }

    #[test]
    fn a_method_knows_its_twin_over_time() {
        let twin = |name: &str| Method::parse(name).expect("known").without_or_with_history().map(|m| m.to_string());
        assert_eq!(twin("stereo-temporal@2").as_deref(), Some("stereo@2"));
        assert_eq!(twin("stereo-hybrid-25").as_deref(), Some("stereo-hybrid-temporal-25"));
        assert_eq!(twin("path-traced"), None);
    }

    #[test]
    fn a_count_in_the_name_wins() {
        let method = Method::parse("sssr@4").expect("known").with_samples(Some(2));
        assert_eq!(method.samples(), 4);
        assert_eq!(Method::parse("sssr").expect("known").with_samples(Some(2)).to_string(), "sssr@2");
    }
}
