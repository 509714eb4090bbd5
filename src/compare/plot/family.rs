//! Finds families: methods that differ only in the percentage at the end of their names, such as `stereo-adaptive-0.5`
//! and `stereo-adaptive-2`. The drawings of `plot` call it with a scene's rows.

use crate::compare::report::Row;

/// The rows of one family that have the same number of samples and the same fallback.
pub struct Family<'a> {
    /// The part of the methods' names before the last hyphen, which they share.
    pub stem: &'a str,
    pub spp: u32,
    /// The rows with their percentages, in rising order.
    pub rows: Vec<(f64, &'a Row)>,
}

/// Splits a name into its stem and its percentage: `stereo-adaptive-0.5` into `stereo-adaptive` and 0.5. `None` for a
/// name without a percentage.
pub fn parse(method: &str) -> Option<(&str, f64)> {
    let (stem, number) = method.rsplit_once('-')?;
    let plain =
        number.starts_with(|c: char| c.is_ascii_digit()) && number.chars().all(|c| c.is_ascii_digit() || c == '.');
    let percent = number.parse().ok().filter(|_| plain)?;
    (!stem.is_empty()).then_some((stem, percent))
}

/// The families among the rows with this fallback. A family has at least two percentages with the same number of
/// samples.
pub fn families<'a>(rows: &'a [Row], fallback: &str) -> Vec<Family<'a>> {
    let mut found: Vec<Family<'a>> = Vec::new();
    for row in rows.iter().filter(|r| r.fallback == fallback) {
        let Some((stem, percent)) = parse(&row.method) else { continue };
        match found.iter_mut().find(|f| f.stem == stem && f.spp == row.spp) {
            Some(family) => family.rows.push((percent, row)),
            None => found.push(Family { stem, spp: row.spp, rows: vec![(percent, row)] }),
        }
    }
    for family in &mut found {
        family.rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        family.rows.dedup_by(|a, b| a.0 == b.0);
    }
    found.retain(|f| f.rows.len() > 1);
    found
}

impl Family<'_> {
    /// The stem, with the number of samples behind it where `all` has the family with several numbers.
    pub fn name(&self, all: &[Family<'_>]) -> String {
        let several = all.iter().any(|f| f.stem == self.stem && f.spp != self.spp);
        if several { format!("{}@{}", self.stem, self.spp) } else { self.stem.to_owned() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::sample::row;

    #[test]
    fn names_that_end_in_a_number_belong_together() {
        assert_eq!(parse("stereo-adaptive-0.5"), Some(("stereo-adaptive", 0.5)));
        assert_eq!(parse("stereo-hybrid-25"), Some(("stereo-hybrid", 25.0)));
        for none in ["stereo", "stereo-adaptive", "path-traced", "stereo-", "-5", "stereo-1.2.3", "stereo-1e3", "a-inf"]
        {
            assert_eq!(parse(none), None, "{none}");
        }
        let names = [("s-2", 1), ("s-0.5", 1), ("s", 1), ("s-2", 2), ("t-1", 1), ("s-8", 2)];
        let rows: Vec<Row> = names.iter().map(|(name, spp)| row(name, *spp, 1.0, &[])).collect();
        let found = families(&rows, "black");
        let seen: Vec<(String, Vec<f64>)> =
            found.iter().map(|f| (f.name(&found), f.rows.iter().map(|r| r.0).collect())).collect();
        assert_eq!(seen, [("s@1".to_owned(), vec![0.5, 2.0]), ("s@2".to_owned(), vec![2.0, 8.0])]);
        assert!(families(&rows, "probe").is_empty());
    }
}
