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
    samples: u32,
}

const BASES: &[Base] = &[
    Base {
        name: "sssr",
        about: "stochastic screen-space reflections, each eye for itself (the baseline)",
        answer: Answer::ScreenSpace,
        back_faces: true,
        samples: 1,
    },
    Base {
        name: "sssr-thickness",
        about: "the baseline without back faces: every mesh is as thick as an open one",
        answer: Answer::ScreenSpace,
        back_faces: false,
        samples: 1,
    },
    Base {
        name: "path-traced",
        about: "the reference: rays through the scene's geometry",
        answer: Answer::PathTraced,
        back_faces: false,
        samples: 1024,
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
