//! Intervals over random seeds by the delete-a-group jackknife, for figures that have no value for a single seed.
//! [`super::lasting`] and `compare` call it.
//!
//! The seeds are divided into G ≤ [`GROUPS`] groups. A figure θ of all n seeds is computed again without each group j,
//! which has m_j seeds; that gives θ₍ⱼ₎. With h_j = n / m_j, the pseudo-values are p_j = h_j·θ − (h_j − 1)·θ₍ⱼ₎, and
//! their centre is c = G·θ − Σ (1 − m_j/n)·θ₍ⱼ₎. The variance of θ is (1/G)·Σ (p_j − c)² / (h_j − 1): Busing, Meijer
//! and van der Leeden, *Delete-m Jackknife for Unequal m*, Statistics and Computing 9, 1999. With equal groups this is
//! the usual (G − 1)/G·Σ (θ₍ⱼ₎ − mean θ₍ⱼ₎)².

use cyclopean_analysis::special::student_quantile;

/// The number of groups. Seed i, in the order in which seeds are added, belongs to group i modulo this number. Fewer
/// seeds make fewer groups, of one seed each.
pub const GROUPS: usize = 8;

/// A figure over all seeds, and the same figure with each group left out in turn.
#[derive(Debug, Clone, Copy)]
pub struct Figure<'a> {
    pub all: f64,
    pub replicates: &'a [f64],
}

/// The 95 % interval θ ± t·√variance, with Student's t for G − 1 degrees of freedom. `sizes` has the number of seeds in
/// each group.
///
/// `None` where there are fewer than two groups, where not every group has a value, or where a value is not finite.
pub fn interval(figure: Figure<'_>, sizes: &[u32]) -> Option<[f64; 2]> {
    let groups = sizes.len();
    let Figure { all, replicates } = figure;
    if groups < 2 || replicates.len() != groups || !all.is_finite() || replicates.iter().any(|w| !w.is_finite()) {
        return None;
    }
    let count = groups as f64;
    let n: f64 = sizes.iter().map(|m| f64::from(*m)).sum();
    // All values are taken as distances from θ, so that the interval of equal values has exactly no width.
    let shifts = || replicates.iter().zip(sizes).map(|(w, m)| (w - all, n / f64::from(*m)));
    let centre = -shifts().map(|(shift, h)| (1.0 - 1.0 / h) * shift).sum::<f64>();
    let variance = shifts().map(|(shift, h)| (-(h - 1.0) * shift - centre).powi(2) / (h - 1.0)).sum::<f64>() / count;
    let reach = student_quantile(0.975, count - 1.0) * variance.sqrt();
    Some([all - reach, all + reach])
}

/// The 95 % interval of a / b, from the [`interval`] of its logarithm. Both figures must come from the same seeds in
/// the same groups, so that the luck of a seed that both share cancels. `None` where any value is not above 0.
pub fn ratio(a: Figure<'_>, b: Figure<'_>, sizes: &[u32]) -> Option<[f64; 2]> {
    if a.replicates.len() != b.replicates.len() {
        return None;
    }
    let log = |a: f64, b: f64| (a > 0.0 && b > 0.0).then(|| (a / b).ln());
    let replicates: Option<Vec<f64>> = a.replicates.iter().zip(b.replicates).map(|(a, b)| log(*a, *b)).collect();
    let ends = interval(Figure { all: log(a.all, b.all)?, replicates: &replicates? }, sizes)?;
    Some(ends.map(f64::exp))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cyclopean_analysis::chance::Stream;
    use cyclopean_analysis::interval::student_t;

    fn mean(values: &[f64]) -> f64 {
        values.iter().sum::<f64>() / values.len() as f64
    }

    /// The means without each of the groups.
    fn replicates(values: &[f64], groups: usize) -> Vec<f64> {
        let kept = |g: usize| -> Vec<f64> {
            values.iter().enumerate().filter(|(i, _)| i % groups != g).map(|(_, v)| *v).collect()
        };
        (0..groups).map(|g| mean(&kept(g))).collect()
    }

    #[test]
    fn without_one_at_a_time_the_mean_has_students_interval() {
        let values = [3.0, 1.0, 4.0, 1.0, 5.0, 9.0];
        let all = mean(&values);
        let found = interval(Figure { all, replicates: &replicates(&values, 6) }, &[1; 6]).expect("six groups");
        let expected = student_t(&values, 0.95);
        assert!((found[0] - expected.lo.expect("six")).abs() < 1e-12);
        assert!((found[1] - expected.hi.expect("six")).abs() < 1e-12);
    }

    #[test]
    fn unequal_groups_have_the_formulas_interval() {
        // Computed by hand. The groups are {1, 4}, {2} and {6}. θ is 13/4, without each group it is 4, 11/3 and 7/3,
        // and h is 2, 4 and 4. The pseudo-values are 2.5, 2 and 6, c = 39/4 − (2 + 11/4 + 7/4) = 3.25, and the variance
        // is (0.5625 + 1.5625/3 + 7.5625/3)/3.
        let figure = Figure { all: 3.25, replicates: &[4.0, 11.0 / 3.0, 7.0 / 3.0] };
        let [lo, hi] = interval(figure, &[2, 1, 1]).expect("three groups");
        // scipy.stats.t.ppf(0.975, 2)
        let reach = 4.302652729911275 * (3.604_166_666_666_667f64 / 3.0).sqrt();
        assert!((lo - (3.25 - reach)).abs() < 1e-9 && (hi - (3.25 + reach)).abs() < 1e-9, "{lo} {hi}");
    }

    #[test]
    fn intervals_of_a_mean_hold_it_95_times_in_100() {
        for n in [16, 19] {
            let mut stream = Stream::new(3, n);
            let sizes: Vec<u32> = (0..8).map(|g| (0..n).filter(|i| i % 8 == g).count() as u32).collect();
            let holds = |_: &u32| {
                let values: Vec<f64> = (0..n).map(|_| stream.normal()).collect();
                let figure = Figure { all: mean(&values), replicates: &replicates(&values, 8) };
                let [lo, hi] = interval(figure, &sizes).expect("eight groups");
                lo <= 0.0 && 0.0 <= hi
            };
            let share = (0..4000).filter(holds).count() as f64 / 4000.0;
            // With 4,000 tries, three standard errors are 1 %.
            assert!((share - 0.95).abs() < 0.015, "{n} seeds: {share}");
        }
    }

    #[test]
    fn what_both_share_cancels_in_a_ratio() {
        let theirs = [1.0, 2.0, 9.0, 4.0, 3.0];
        let ours = theirs.map(|v| v / 2.0);
        let (a, b) = (replicates(&ours, 5), replicates(&theirs, 5));
        let figure = |values: &[f64], replicates| Figure { all: mean(values), replicates };
        let [lo, hi] = ratio(figure(&ours, &a), figure(&theirs, &b), &[1; 5]).expect("five groups");
        assert!((lo - 0.5).abs() < 1e-9 && (hi - 0.5).abs() < 1e-9, "{lo} {hi}");
        assert_eq!(ratio(Figure { all: -1.0, replicates: &a }, figure(&theirs, &b), &[1; 5]), None);
    }

    #[test]
    fn too_few_groups_have_none() {
        assert_eq!(interval(Figure { all: 1.0, replicates: &[1.0] }, &[1]), None);
        assert_eq!(interval(Figure { all: 1.0, replicates: &[] }, &[1, 1]), None);
        assert_eq!(interval(Figure { all: 1.0, replicates: &[f64::NAN, 1.0] }, &[1, 1]), None);
        assert_eq!(interval(Figure { all: 1.0, replicates: &[1.0, 1.0] }, &[1, 1]), Some([1.0, 1.0]));
    }
}
