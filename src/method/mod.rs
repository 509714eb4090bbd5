//! Methods as data: which parts of the pipeline are on. No device: a build without one knows every method by name.

mod ao;
mod parts;
mod table;

use std::fmt;

pub use ao::Ao;
pub use parts::{Accumulation, Blend, HistorySource, HitSource, Knob, Parts, Reprojection, Reuse, Temporal, Traversal};
use table::{METHODS, RECOMMENDED_WITH_RAY_QUERIES, RECOMMENDED_WITHOUT_RAY_QUERIES};

/// A condition of a study, or a peer to compare with. `NAME@N` is NAME with N rays a pixel in one ratio.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Method {
    base: &'static Parts,
    /// Thousandths of a per cent of the method's [`Knob`]; `None`: the method's own default, or no knob.
    knob: Option<u32>,
    /// Rays (or paths) a pixel; `None`: the method's own default.
    samples: Option<u32>,
}

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

    /// The smallest contrast between the eyes at which the other eye is used; `None`: it is used everywhere.
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
    fn the_worked_example_of_the_page_is_a_method() {
        use super::table::SSSR;
        #[rustfmt::skip]
        const ROWS: &[Parts] = &[
            Parts {
                name: "sssr-narrow",
                about: "the baseline with 9 pixels of spatial reuse instead of 25",
                reuse_radius_squared: Some(2),
                ..SSSR
            },
        ];
        let method = Method { base: &ROWS[0], knob: None, samples: Some(2) };
        assert_eq!((method.to_string().as_str(), method.parts().reuse_radius_squared), ("sssr-narrow@2", Some(2)));
        assert!(Method::names().iter().all(|name| *name != ROWS[0].name), "the page's example is a method by now");
        assert!(!method.parts().about.is_empty());
    }

    #[test]
    fn a_count_in_the_name_wins() {
        let method = Method::parse("sssr@4").expect("known").with_samples(Some(2));
        assert_eq!(method.samples(), 4);
        assert_eq!(Method::parse("sssr").expect("known").with_samples(Some(2)).to_string(), "sssr@2");
    }
}
