//! Estimates the difference between the eyes that stays whatever the seed is, free of the noise that is left in a mean
//! over a few seeds. It also gives intervals for the measures of consistency, over the seeds. [`super::stereo`] calls
//! it.
//!
//! Let D_i be L − R of a pair with seed i, and let R₁ and R₂ be L − R of two references with different seeds. The
//! product of two independent errors is 0 on average. So (D_i − R₁)·(D_j − R₂) with i ≠ j has the right mean, however
//! noisy the method and the references are.
//!
//! Let m = (R₁ + R₂)/2, h = (R₁ − R₂)/2, C_i = D_i − m, S = Σ C_i and Q = Σ C_i². The average of the product over all
//! i ≠ j and over both ways to assign the references is then (S² − Q)/(n(n − 1)) − h².

use cyclopean_analysis::special::student_upper;
use serde::{Deserialize, Serialize};

use super::jackknife::{self, Figure, GROUPS};
use super::pairs::{MATCH, Pairs, pair_luminances};

/// What two references with different seeds show at each pair.
#[derive(Debug, Clone)]
pub struct ReferenceAgreement {
    /// m: the mean of L − R over both references, luminance.
    mean_difference: Vec<f64>,
    /// h²: the square of half the difference between the two references' L − R.
    half_difference2: Vec<f64>,
    /// The mean luminance of both eyes in both references, at least ε.
    luminance: Vec<f64>,
}

impl ReferenceAgreement {
    /// Compares two references, each given as the linear composites of both eyes.
    pub fn new(pairs: &Pairs, first: [&[[f32; 3]]; 2], second: [&[[f32; 3]]; 2]) -> ReferenceAgreement {
        let mut found =
            ReferenceAgreement { mean_difference: Vec::new(), half_difference2: Vec::new(), luminance: Vec::new() };
        for pair in &pairs.pairs {
            let (a, b) = (pair_luminances(pair, first), pair_luminances(pair, second));
            let (r1, r2) = (a[0] - a[1], b[0] - b[1]);
            found.mean_difference.push((r1 + r2) / 2.0);
            found.half_difference2.push(((r1 - r2) / 2.0).powi(2));
            found.luminance.push(((a[0] + a[1] + b[0] + b[1]) / 4.0).max(pairs.epsilon));
        }
        found
    }
}

/// Sums over the seeds of each group. Only these are kept, so that a thousand seeds take no more memory than eight.
#[derive(Debug, Clone)]
pub struct LastingContrast<'a> {
    agreement: &'a ReferenceAgreement,
    /// The number of seeds added so far, by group.
    sizes: [u32; GROUPS],
    /// ΣC and ΣC², by pair and group.
    sums: Vec<[[f64; 2]; GROUPS]>,
}

/// The squared lasting contrast of the pairs, less what the reference itself has of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Unbiased {
    /// For each pair, the average of (D_i − R₁)(D_j − R₂) over i ≠ j is divided by the square of the pair's mean
    /// luminance. That luminance is the references' or the method's over all seeds, whichever is larger. This is the
    /// mean over the pairs. Where there is only noise it is 0 on average, so it may be negative.
    pub squared: f64,
    /// The root of `squared`, or 0 where that is negative. A Weber contrast.
    pub rms: f64,
    /// The 95 % interval of `squared` over the seeds, with the references taken as given. `None` (in JSON null) with
    /// fewer than three seeds.
    pub interval: Option<[f64; 2]>,
}

/// The figures computed again with each group of seeds left out in turn. Intervals are made from them. The lists of
/// figures are empty where there are too few seeds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JackknifeReplicates {
    /// The number of seeds in each group. Round r, counted from 1, belongs to group (r − 1) modulo 8.
    pub seeds: Vec<u32>,
    pub systematic_unbiased: Vec<f64>,
    pub systematic_inconsistency: Vec<f64>,
    pub noise_variance: Vec<f64>,
}

/// What all seeds together show.
#[derive(Debug, Clone, PartialEq)]
pub struct SeedEstimates {
    pub unbiased: Unbiased,
    /// The 95 % interval of [`super::stereo::Systematic::share`], cut to 0 to 1. It is approximate, because the share
    /// counts the means that lie beyond a threshold.
    pub share: Option<[f64; 2]>,
    /// The 95 % interval of the mean variance of L − R, cut at 0; luminance².
    pub noise_variance: Option<[f64; 2]>,
    pub replicates: JackknifeReplicates,
}

/// The sums of one pair over some of the seeds.
#[derive(Debug, Clone, Copy)]
struct Part {
    n: f64,
    sum: f64,
    squares: f64,
}

impl Part {
    /// The average of C_i·C_j over i ≠ j.
    fn product(self) -> f64 {
        (self.sum * self.sum - self.squares) / (self.n * (self.n - 1.0))
    }

    /// The sample variance, with n − 1. Rounding could make it negative, so it is cut at 0.
    fn variance(self) -> f64 {
        ((self.squares - self.sum * self.sum / self.n) / (self.n - 1.0)).max(0.0)
    }
}

/// The figures over some of the seeds.
#[derive(Debug, Clone, Copy, Default)]
struct Figures {
    unbiased: f64,
    share: f64,
    noise_variance: f64,
}

impl<'a> LastingContrast<'a> {
    pub fn new(agreement: &'a ReferenceAgreement) -> LastingContrast<'a> {
        LastingContrast { agreement, sizes: [0; GROUPS], sums: vec![[[0.0; 2]; GROUPS]; agreement.luminance.len()] }
    }

    /// Adds L − R (luminance) of the next seed, in the order of the pairs.
    pub fn add(&mut self, differences: impl IntoIterator<Item = f64>) {
        let group = self.sizes.iter().sum::<u32>() as usize % GROUPS;
        self.sizes[group] += 1;
        for ((sums, middle), d) in self.sums.iter_mut().zip(&self.agreement.mean_difference).zip(differences) {
            let c = d - middle;
            sums[group][0] += c;
            sums[group][1] += c * c;
        }
    }

    /// What the seeds so far show. `None` with fewer than two seeds or without pairs. `bases` holds each pair's mean
    /// luminance over all of the method's seeds, at least ε. The systematic share is relative to it, also where a group
    /// is left out.
    pub fn found(&self, bases: &[f64]) -> Option<SeedEstimates> {
        let n: u32 = self.sizes.iter().sum();
        if n < 2 || self.sums.is_empty() {
            return None;
        }
        let sizes: Vec<u32> = self.sizes.iter().copied().filter(|m| *m > 0).collect();
        // Whichever group is left out, at least two seeds must stay, because one has no variance. The first group is
        // the largest.
        let groups = if n - sizes[0] >= 2 { 0..sizes.len() } else { 0..0 };
        let (all, without) = std::thread::scope(|scope| {
            let parts: Vec<_> = groups.map(|g| scope.spawn(move || self.figures(Some(g), bases))).collect();
            let all = self.figures(None, bases);
            let join = |t: std::thread::ScopedJoinHandle<'_, Figures>| t.join().expect("sums do not panic");
            (all, parts.into_iter().map(join).collect::<Vec<_>>())
        });
        let list = |of: fn(&Figures) -> f64| without.iter().map(of).collect::<Vec<_>>();
        let replicates = JackknifeReplicates {
            seeds: sizes,
            systematic_unbiased: list(|f| f.unbiased),
            systematic_inconsistency: list(|f| f.share),
            noise_variance: list(|f| f.noise_variance),
        };
        let interval =
            |all: f64, left: &[f64]| jackknife::interval(Figure { all, replicates: left }, &replicates.seeds);
        let clamped = |ends: Option<[f64; 2]>, most: f64| ends.map(|e| e.map(|v| v.clamp(0.0, most)));
        Some(SeedEstimates {
            unbiased: Unbiased {
                squared: all.unbiased,
                rms: all.unbiased.max(0.0).sqrt(),
                interval: interval(all.unbiased, &replicates.systematic_unbiased),
            },
            share: clamped(interval(all.share, &replicates.systematic_inconsistency), 1.0),
            noise_variance: clamped(interval(all.noise_variance, &replicates.noise_variance), f64::INFINITY),
            replicates,
        })
    }

    /// The figures over all seeds, or over all but those of one group.
    fn figures(&self, without: Option<usize>, bases: &[f64]) -> Figures {
        let kept = |group: usize| Some(group) != without;
        let n: u32 = (0..GROUPS).filter(|g| kept(*g)).map(|g| self.sizes[g]).sum();
        let (mut sum, mut raw, mut by_chance) = (Figures::default(), 0.0, 0.0);
        for (pair, (sums, own_base)) in self.sums.iter().zip(bases).enumerate() {
            let mut part = Part { n: f64::from(n), sum: 0.0, squares: 0.0 };
            for (_, [c, squares]) in sums.iter().enumerate().filter(|(g, _)| kept(*g)) {
                part.sum += c;
                part.squares += squares;
            }
            // The larger base is taken, because neither alone bounds the contrast. Where one base is nearly black and
            // the other is not, a single pair would outweigh all others.
            let base = self.agreement.luminance[pair].max(*own_base);
            sum.unbiased += (part.product() - self.agreement.half_difference2[pair]) / (base * base);
            let variance = part.variance();
            sum.noise_variance += variance;
            let contrast = (part.sum / part.n + self.agreement.mean_difference[pair]) / own_base;
            raw += f64::from(u8::from(contrast.abs() > MATCH));
            by_chance += chance(MATCH, (variance / part.n).sqrt() / own_base, part.n);
        }
        let pairs = self.sums.len() as f64;
        Figures {
            unbiased: sum.unbiased / pairs,
            share: share(raw / pairs, by_chance / pairs),
            noise_variance: sum.noise_variance / pairs,
        }
    }
}

/// The probability that noise alone brings a mean contrast over n seeds beyond the threshold. `error` is the standard
/// error of that contrast. Without any noise the probability is 0.
pub(super) fn chance(threshold: f64, error: f64, n: f64) -> f64 {
    if error > 0.0 { 2.0 * student_upper(threshold / error, n - 1.0) } else { 0.0 }
}

/// Storey's estimate of the share that truly lies beyond a threshold. `raw` is the share that is found there, and
/// `by_chance` the share that noise alone would bring there.
pub(super) fn share(raw: f64, by_chance: f64) -> f64 {
    if by_chance < 1.0 { ((raw - by_chance) / (1.0 - by_chance)).max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cyclopean_analysis::chance::Stream;

    /// Pairs of mean luminance 2. L − R is `lasting` in a method and `from_reference` in the references, both without their
    /// noise.
    struct World {
        pairs: u32,
        seeds: u32,
        lasting: f64,
        from_reference: f64,
        /// Standard deviations of L − R.
        noise: f64,
        reference_noise: f64,
    }

    impl World {
        fn found(&self, stream: &mut Stream) -> SeedEstimates {
            let count = self.pairs as usize;
            let pairs = (0..self.pairs).map(|i| [i, i]).collect();
            let pairs = Pairs { candidates: self.pairs.into(), undecided: 0, different: 0, epsilon: 0.01, pairs };
            let right = vec![[2.0f32; 3]; count];
            let mut reference = || -> Vec<[f32; 3]> {
                let left = |_| [(2.0 + self.from_reference + self.reference_noise * stream.normal()) as f32; 3];
                (0..count).map(left).collect()
            };
            let (first, second) = (reference(), reference());
            let agreement = ReferenceAgreement::new(&pairs, [&first, &right], [&second, &right]);
            let mut lasting = LastingContrast::new(&agreement);
            for _ in 0..self.seeds {
                lasting.add((0..count).map(|_| self.lasting + self.noise * stream.normal()));
            }
            lasting.found(&vec![2.0; count]).expect("pairs and seeds")
        }

        /// The mean of `squared` over repetitions, and its standard error.
        fn squared(&self, repetitions: u32) -> (f64, f64) {
            let mut stream = Stream::new(11, u64::from(self.seeds));
            let values: Vec<f64> = (0..repetitions).map(|_| self.found(&mut stream).unbiased.squared).collect();
            let (mean, sd) = cyclopean_analysis::special::mean_sd(&values);
            (mean, sd.expect("repetitions") / f64::from(repetitions).sqrt())
        }
    }

    #[test]
    fn noise_of_method_and_references_drops_out() {
        for seeds in [2, 3, 9] {
            // With 0.3 the references differ between the eyes as well, and the method exactly as they do, so 0 is
            // expected.
            for from_reference in [0.0, 0.3] {
                let world = World {
                    pairs: 20,
                    seeds,
                    lasting: from_reference,
                    from_reference,
                    noise: 0.8,
                    reference_noise: 0.2,
                };
                let (mean, error) = world.squared(1500);
                // The square of the mean difference would be too large by 0.64/n, before it is divided by 4.
                assert!(mean.abs() < 4.0 * error && error < 0.005, "{seeds} seeds: {mean} ± {error}");
            }
        }
    }

    #[test]
    fn a_known_offset_is_recovered_from_few_seeds() {
        for seeds in [2, 3, 5] {
            let world = World { pairs: 20, seeds, lasting: 0.5, from_reference: 0.1, noise: 0.8, reference_noise: 0.2 };
            let (mean, error) = world.squared(1500);
            // (0.4 / 2)² takes the base to be 2. It is really about 2.05 and a little noisy. The tolerance allows for
            // both.
            assert!((mean - 0.04).abs() < 4.0 * error + 1e-3 * 0.04, "{seeds} seeds: {mean} ± {error}");
        }
        let exact = World { pairs: 5, seeds: 3, lasting: 0.5, from_reference: 0.1, noise: 0.0, reference_noise: 0.0 };
        let found = exact.found(&mut Stream::new(1, 1)).unbiased;
        // The base is (2.1 + 2)/2.
        assert!((found.squared - (0.4 / 2.05f64).powi(2)).abs() < 1e-6, "{found:?}");
        assert!((found.rms - 0.4 / 2.05).abs() < 1e-6);
    }

    #[test]
    fn a_base_that_moves_with_the_noise_brings_no_difference_of_its_own() {
        // Both eyes have the same skewed noise above a dark reference, so the base is the method's luminance.
        let pairs = Pairs { candidates: 1, undecided: 0, different: 0, epsilon: 0.01, pairs: vec![[0, 0]] };
        let dark = [[0.1f32; 3]];
        let agreement = ReferenceAgreement::new(&pairs, [&dark, &dark], [&dark, &dark]);
        let mut stream = Stream::new(17, 1);
        let once = |_: u32| {
            let seeds: [[f64; 2]; 3] = std::array::from_fn(|_| [0, 1].map(|_| stream.normal().exp()));
            let mut lasting = LastingContrast::new(&agreement);
            seeds.iter().for_each(|[l, r]| lasting.add([l - r]));
            let own = seeds.iter().map(|[l, r]| (l + r) / 2.0).sum::<f64>() / 3.0;
            lasting.found(&[own]).expect("three seeds").unbiased.squared
        };
        let (mean, sd) = cyclopean_analysis::special::mean_sd(&(0..20_000).map(once).collect::<Vec<_>>());
        let error = sd.expect("repetitions") / 20_000f64.sqrt();
        assert!(mean.abs() < 4.0 * error && error < 0.01, "{mean} ± {error}");
        // What only one eye sees, where the reference is dark, has the largest contrast that is possible, 2.
        let mut lasting = LastingContrast::new(&agreement);
        (0..3).for_each(|_| lasting.add([5.0]));
        assert_eq!(lasting.found(&[2.5]).expect("three seeds").unbiased.squared, 4.0);
    }

    #[test]
    fn intervals_hold_the_truth_about_95_times_in_100() {
        // 21 seeds make groups of three and of two seeds.
        for seeds in [16, 21] {
            let world = World { pairs: 40, seeds, lasting: 0.5, from_reference: 0.1, noise: 0.8, reference_noise: 0.0 };
            let truth = (0.4 / 2.05f64).powi(2);
            let mut stream = Stream::new(13, u64::from(seeds));
            let (mut squared, mut variance) = (0, 0);
            for _ in 0..1000 {
                let found = world.found(&mut stream);
                let [lo, hi] = found.unbiased.interval.expect("eight groups");
                squared += u32::from(lo <= truth && truth <= hi);
                let [lo, hi] = found.noise_variance.expect("eight groups");
                variance += u32::from((lo..=hi).contains(&0.64));
            }
            // With 1,000 tries, three standard errors are 2 %.
            for held in [squared, variance] {
                assert!((930..=975).contains(&held), "{seeds} seeds: {squared} and {variance} of 1,000");
            }
        }
    }

    #[test]
    fn the_share_is_that_of_the_consistency_and_has_an_interval() {
        let world =
            World { pairs: 3000, seeds: 16, lasting: 0.0, from_reference: 0.0, noise: 0.1, reference_noise: 0.0 };
        let [lo, hi] = world.found(&mut Stream::new(2, 1)).share.expect("eight groups");
        assert!(lo == 0.0 && hi < 0.1, "{lo} {hi}");
        let world = World { lasting: 0.5, ..world };
        let found = world.found(&mut Stream::new(2, 1));
        assert_eq!(found.share, Some([1.0; 2]));
        assert_eq!(found.replicates.seeds, [2; 8]);
    }

    #[test]
    fn too_few_seeds_have_no_interval() {
        let world = World { pairs: 4, seeds: 2, lasting: 0.5, from_reference: 0.1, noise: 0.1, reference_noise: 0.0 };
        let two = world.found(&mut Stream::new(2, 1));
        assert_eq!((two.unbiased.interval, two.share, two.noise_variance), (None, None, None));
        assert!(two.unbiased.squared.is_finite() && two.replicates.noise_variance.is_empty());
        let three = World { seeds: 3, ..world }.found(&mut Stream::new(2, 1));
        assert!(three.unbiased.interval.is_some());
        assert_eq!(three.replicates.seeds, [1; 3]);
    }
}
