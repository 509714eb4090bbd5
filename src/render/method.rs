//! Methods as data: which parts of the pipeline are on.

use std::fmt;

/// A condition of a study, or a peer to compare with. `NAME@N` is NAME with N rays a pixel in one ratio.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Method {
    base: &'static Parts,
    /// Rays (or paths) a pixel; `None`: the method's own default.
    samples: Option<u32>,
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
    /// Only the left eye traces; the right one has what is reprojected.
    pub one_eye: bool,
    /// The reference's rays go through the screen-space methods' filter.
    pub resolved: bool,
    /// Pixels beyond each border that are drawn and never shown, in thousandths of the view.
    pub guard_band: u32,
    /// Both eyes draw the same random numbers.
    pub shared_noise: bool,
    /// Squared radius of the spatial reuse, pixels; `None`: the settings'.
    pub reuse: Option<u32>,
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
    one_eye: false,
    resolved: false,
    guard_band: 0,
    shared_noise: false,
    reuse: None,
    unrelated: false,
    samples: 1,
};

const OURS: Reprojection = Reprojection { filling: true, back_check: true, lobe_tolerance: true };
const PAPER: Reprojection = Reprojection { filling: false, back_check: false, lobe_tolerance: false };

/// All three parts of the paper's §4.
const STEREO: Parts = Parts {
    name: "stereo",
    about: "stereo-consistent: traversal, fade and reprojection know both eyes",
    traversal: Traversal::TwoStages,
    stereo_fade: true,
    reprojection: Some(OURS),
    ..SSSR
};

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
        reuse: Some(10),
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

/// A name that is no method.
#[derive(Debug, thiserror::Error)]
#[error("unknown method `{name}`; known: {known}, each also as NAME@N with N rays a pixel (1 to 65536)")]
pub struct UnknownMethod {
    pub name: String,
    pub known: String,
}

impl Method {
    /// Reads `NAME` or `NAME@N`.
    ///
    /// # Errors
    /// [`UnknownMethod`], which lists the known ones.
    pub fn parse(text: &str) -> Result<Method, UnknownMethod> {
        let unknown = || UnknownMethod { name: text.to_owned(), known: Method::names().join(", ") };
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
        let base = METHODS.iter().find(|b| b.name == name).ok_or_else(unknown)?;
        Ok(Method { base, samples: count })
    }

    /// Every name, without `@N`.
    pub fn names() -> Vec<&'static str> {
        METHODS.iter().map(|b| b.name).collect()
    }

    /// Name and description of each.
    pub fn described() -> impl Iterator<Item = (&'static str, &'static str)> {
        METHODS.iter().map(|b| (b.name, b.about))
    }

    /// The same with so many rays a pixel (at least one), unless its name says how many.
    pub fn with_samples(self, samples: Option<u32>) -> Method {
        Method { samples: self.samples.or(samples.map(|n| n.max(1))), ..self }
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
        match self.samples {
            Some(n) if n != self.base.samples => write!(f, "{}@{n}", self.base.name),
            _ => f.write_str(self.base.name),
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
    fn a_count_in_the_name_wins() {
        let method = Method::parse("sssr@4").expect("known").with_samples(Some(2));
        assert_eq!(method.samples(), 4);
        assert_eq!(Method::parse("sssr").expect("known").with_samples(Some(2)).to_string(), "sssr@2");
    }
}
