//! Methods as data: which parts of the pipeline are on.

use std::fmt;

/// A condition of a study, or a peer to compare with. `NAME@N` is NAME with N rays a pixel in one ratio.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Method {
    base: &'static Base,
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

#[derive(Debug, PartialEq, Eq)]
struct Base {
    name: &'static str,
    about: &'static str,
    answer: Answer,
    back_faces: bool,
    other_eye: bool,
    stereo_fade: bool,
    reprojection: bool,
    unrelated: bool,
    samples: u32,
}

/// The baseline; the others say where they differ.
const SSSR: Base = Base {
    name: "sssr",
    about: "stochastic screen-space reflections, each eye for itself (the baseline)",
    answer: Answer::ScreenSpace,
    back_faces: true,
    other_eye: false,
    stereo_fade: false,
    reprojection: false,
    unrelated: false,
    samples: 1,
};

/// All three parts of the paper's §4.
const STEREO: Base = Base {
    name: "stereo",
    about: "stereo-consistent: traversal, fade and reprojection know both eyes",
    other_eye: true,
    stereo_fade: true,
    reprojection: true,
    ..SSSR
};

const BASES: &[Base] = &[
    SSSR,
    STEREO,
    Base { name: "stereo-no-traversal", about: "stereo without the other eye's traversal", other_eye: false, ..STEREO },
    Base { name: "stereo-no-fade", about: "stereo with each eye's own fade", stereo_fade: false, ..STEREO },
    Base {
        name: "stereo-no-reprojection",
        about: "stereo without reuse between the eyes",
        reprojection: false,
        ..STEREO
    },
    Base {
        name: "sssr-thickness",
        about: "the baseline without back faces: every mesh is as thick as an open one",
        back_faces: false,
        ..SSSR
    },
    Base {
        name: "unrelated",
        about: "for catch trials: the right eye's reflections exchanged left and right, so that nothing fits",
        unrelated: true,
        ..SSSR
    },
    Base {
        name: "path-traced",
        about: "the reference: rays through the scene's geometry",
        answer: Answer::PathTraced,
        back_faces: false,
        samples: 1024,
        ..SSSR
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
        let base = BASES.iter().find(|b| b.name == name).ok_or_else(unknown)?;
        Ok(Method { base, samples: count })
    }

    /// Every name, without `@N`.
    pub fn names() -> Vec<&'static str> {
        BASES.iter().map(|b| b.name).collect()
    }

    /// Name and description of each.
    pub fn described() -> impl Iterator<Item = (&'static str, &'static str)> {
        BASES.iter().map(|b| (b.name, b.about))
    }

    /// The same with so many rays a pixel, unless its name says how many.
    pub fn with_samples(self, samples: Option<u32>) -> Method {
        Method { samples: self.samples.or(samples), ..self }
    }

    pub fn answer(&self) -> Answer {
        self.base.answer
    }

    /// Closed meshes are as thick as their back faces say.
    pub fn back_faces(&self) -> bool {
        self.base.back_faces
    }

    /// Rays that leave their eye's view go on in the other one's (paper §4.1).
    pub fn other_eye(&self) -> bool {
        self.base.other_eye
    }

    /// Both eyes fade alike (paper §4.2).
    pub fn stereo_fade(&self) -> bool {
        self.base.stereo_fade
    }

    /// Samples are shared between the eyes (paper §4.3).
    pub fn reprojection(&self) -> bool {
        self.base.reprojection
    }

    /// The right eye's reflections are exchanged left and right.
    pub fn unrelated(&self) -> bool {
        self.base.unrelated
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
