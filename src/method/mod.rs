//! Methods as data: a name is parsed into a [`Method`], which says which parts of the pipeline are on. The commands,
//! the renderer, `compare` and `paper` call it. Nothing here needs a graphics device, so a build without one knows
//! every method as well.

mod ao;
mod table;
mod technique;

use std::fmt;

pub use ao::Ao;
use table::{METHODS, RECOMMENDED_WITH_RAY_QUERIES, RECOMMENDED_WITHOUT_RAY_QUERIES};
pub use technique::{
    Accumulation, Blend, HistorySource, HitSource, NamePercentage, Reprojection, Reuse, Technique, Temporal, Traversal,
};

/// A way to answer reflection rays, together with its number of rays. `NAME@N` is NAME with N rays a pixel, which are
/// mixed in one ratio estimator.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Method {
    base: &'static Technique,
    /// What the percentage in the name sets ([`NamePercentage`]), in thousandths of a per cent. `None`: the name has no
    /// percentage, so that the default holds where there is one.
    percentage: Option<u32>,
    /// Rays (of a path tracer: paths) a pixel. `None`: the method's default.
    samples: Option<u32>,
}

/// The name belongs to no method.
#[derive(Debug, thiserror::Error)]
#[error(
    "unknown method `{name}`; known: {known}. Each may be written NAME@N, with N rays a pixel (1 to 65536), and \
     {with_percentage} also NAME-P, with a percentage P from 0 to 100"
)]
pub struct UnknownMethod {
    pub name: String,
    pub known: String,
    /// The methods whose name may end in a percentage.
    pub with_percentage: String,
}

impl Method {
    /// Reads `NAME`, `NAME-P`, `NAME@N` or `NAME-P@N`.
    ///
    /// # Errors
    /// [`UnknownMethod`], which lists the known methods.
    pub fn parse(text: &str) -> Result<Method, UnknownMethod> {
        let unknown = || UnknownMethod {
            name: text.to_owned(),
            known: Method::names().join(", "),
            with_percentage: Method::names_with_percentage().join(", "),
        };
        // The count may also stand before this suffix: path-traced@2-resolved.
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
            return Ok(Method { base, percentage: None, samples: count });
        }
        let (stem, percent) = name.rsplit_once('-').ok_or_else(unknown)?;
        let base = METHODS.iter().find(|b| b.name == stem && b.percentage.is_some()).ok_or_else(unknown)?;
        // Only what `Display` would write is taken: digits and at most one point, and no `1e1`.
        let digits = percent.chars().all(|c| c.is_ascii_digit() || c == '.');
        let percent: f64 = percent.parse().ok().filter(|_| digits).ok_or_else(unknown)?;
        if !(0.0..=100.0).contains(&percent) {
            return Err(unknown());
        }
        Ok(Method { base, percentage: Some((percent * 1000.0).round() as u32), samples: count })
    }

    /// The method that this one stands for on a device; itself, except for `recommended`. Where ray queries are fast,
    /// `recommended` is the method with the lowest error of all. Elsewhere it is the one with the lowest error whose
    /// tracing and resolving take at most about 1.3 times as long as the baseline's. docs/compare.md has the
    /// measurements.
    pub fn on(&self, fast_ray_queries: bool) -> Method {
        if !self.base.chosen_by_device {
            return self.clone();
        }
        let name = if fast_ray_queries { RECOMMENDED_WITH_RAY_QUERIES } else { RECOMMENDED_WITHOUT_RAY_QUERIES };
        let base = Method::parse(name).expect("a known method");
        Method { samples: self.samples, ..base }
    }

    /// The share of the lost rays that may ask the scene's geometry, 0–1 in steps of 1/255. It is 0 for methods whose
    /// rays never ask it.
    pub fn lost_share(&self) -> f32 {
        match self.base.percentage {
            Some(NamePercentage::LostRays) => (self.percentage_value() as f32 / 100_000.0 * 255.0).round() / 255.0,
            _ => 0.0,
        }
    }

    /// The smallest Weber contrast between the eyes at which a pixel uses the other eye. `None`: the method has no such
    /// threshold.
    pub fn weber_share(&self) -> Option<f32> {
        (self.base.percentage == Some(NamePercentage::Weber)).then(|| self.percentage_value() as f32 / 100_000.0)
    }

    fn percentage_value(&self) -> u32 {
        self.percentage.or_else(|| self.base.percentage.map(NamePercentage::default_value)).unwrap_or(0)
    }

    /// The names of all methods, without `@N`.
    pub fn names() -> Vec<&'static str> {
        METHODS.iter().map(|b| b.name).collect()
    }

    /// The names that may end in a percentage.
    pub fn names_with_percentage() -> Vec<&'static str> {
        METHODS.iter().filter(|b| b.percentage.is_some()).map(|b| b.name).collect()
    }

    /// The name and the description of each method.
    pub fn described() -> impl Iterator<Item = (&'static str, &'static str)> {
        METHODS.iter().map(|b| (b.name, b.about))
    }

    /// The same method with so many rays a pixel (at least one). A count that the method already has wins.
    pub fn with_samples(self, samples: Option<u32>) -> Method {
        Method { samples: self.samples.or(samples.map(|n| n.max(1))), ..self }
    }

    /// The same method with so many rays a pixel (at least one), whatever count it has already.
    pub fn with_exactly(self, samples: u32) -> Method {
        Method { samples: Some(samples.max(1)), ..self }
    }

    /// The method that differs from this one only in whether it accumulates over frames. `None`: there is no such
    /// method.
    pub fn without_or_with_history(&self) -> Option<Method> {
        const SUFFIX: &str = "-temporal";
        let name = match self.base.name.strip_suffix(SUFFIX) {
            Some(without) => without.to_owned(),
            None => format!("{}{SUFFIX}", self.base.name),
        };
        let base = METHODS.iter().find(|b| b.name == name)?;
        Some(Method { base, ..self.clone() })
    }

    /// The choices that the method is made of.
    pub fn technique(&self) -> &'static Technique {
        self.base
    }

    /// Rays (of a path tracer: paths) a pixel.
    pub fn samples(&self) -> u32 {
        self.samples.unwrap_or(self.base.samples)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.base.name)?;
        if let Some(thousandths) = self.percentage {
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
            assert!(!taken.technique().chosen_by_device && taken.samples() == 2, "{taken}");
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
        const ROWS: &[Technique] = &[
            Technique {
                name: "sssr-narrow",
                about: "the baseline with 9 pixels of spatial reuse instead of 25",
                reuse_radius_squared: Some(2),
                ..SSSR
            },
        ];
        let method = Method { base: &ROWS[0], percentage: None, samples: Some(2) };
        assert_eq!((method.to_string().as_str(), method.technique().reuse_radius_squared), ("sssr-narrow@2", Some(2)));
        assert!(Method::names().iter().all(|name| *name != ROWS[0].name), "the page's example is a method by now");
        assert!(!method.technique().about.is_empty());
    }

    #[test]
    fn a_count_in_the_name_wins() {
        let method = Method::parse("sssr@4").expect("known").with_samples(Some(2));
        assert_eq!(method.samples(), 4);
        assert_eq!(Method::parse("sssr").expect("known").with_samples(Some(2)).to_string(), "sssr@2");
    }
}
