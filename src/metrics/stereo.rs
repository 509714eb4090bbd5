//! Measures consistency between the eyes over chosen pairs of pixels. `compare` adds the frames of a method, one for
//! each seed, and then asks for the [`Inconsistency`].
//!
//! With the luminances L and R of a pair, the Weber contrast is |L − R| / max((L + R)/2, ε). *Systematic* inconsistency
//! is the contrast of the means over the seeds; missing geometry and fades cause it. *Noise* inconsistency is the
//! spread of L − R over the seeds, and the contrast within single frames.

use serde::{Deserialize, Serialize};

use super::lasting_contrast::{LastingContrast, ReferenceAgreement, SeedEstimates, chance, share};
use super::pairs::{MATCH, Pairs, pair_luminances};

/// The Weber contrasts beyond which pairs are counted. The first is one that an observer hardly sees.
pub const THRESHOLDS: [f64; 4] = [MATCH, 0.05, 0.10, 0.20];

/// Collects the luminances of the pairs over the frames of one method.
#[derive(Debug, Clone)]
pub struct Consistency<'a> {
    pairs: &'a Pairs,
    frames: u32,
    /// The running means of L and R, by pair.
    mean: Vec<[f64; 2]>,
    /// The running sums Σ(D − mean D)² with D = L − R, by pair.
    squares: Vec<f64>,
    /// The number of pairs beyond each threshold, summed over the frames.
    beyond: [u64; THRESHOLDS.len()],
    lasting: LastingContrast<'a>,
}

/// The measures of inconsistency between the eyes. Shares are of the pairs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Inconsistency {
    /// The contrast that stays whatever the seed is. `None` with fewer than two frames.
    pub systematic: Option<Systematic>,
    /// The mean over the pairs of the variance of L − R over the seeds, luminance². `None` with fewer than two frames.
    pub noise_variance: Option<f64>,
    /// The same with each pair's variance divided by its squared mean luminance.
    pub noise_variance_relative: Option<f64>,
    /// The shares of pairs whose contrast in single frames is above each of [`THRESHOLDS`].
    pub noise_over: [f64; THRESHOLDS.len()],
}

/// The contrast of the pairs' mean luminances over n seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Systematic {
    /// An estimate of the share of pairs that differ by more than 2 % whatever the seed is. It is
    /// (`raw` − `by_chance`) / (1 − `by_chance`), cut at 0 (Storey 2002, with a threshold for each pair). Where there
    /// is only noise it is about 0. Where a true difference can hide below the threshold it is a lower bound.
    pub share: f64,
    /// The share of pairs whose means differ by more than 2 %. Noise that is left in the means counts too.
    pub raw: f64,
    /// The share that noise alone would bring beyond 2 %. It is the mean over the pairs of P(|t| > 2 %·base / (s/√n)),
    /// where t has n − 1 degrees of freedom.
    pub by_chance: f64,
    /// `share` with each of [`THRESHOLDS`] in place of 2 %. Differences by fades and missing geometry are still counted
    /// at the larger ones; small offsets are not.
    pub over: [f64; THRESHOLDS.len()],
    /// The root of the mean squared Weber contrast of the means. For each pair the share of the noise, s²/n over its
    /// squared mean luminance, is subtracted, so that the square is unbiased.
    pub rms: f64,
}

impl<'a> Consistency<'a> {
    /// Begins without any frame. `agreement` is what two references show at these pairs.
    pub fn new(pairs: &'a Pairs, agreement: &'a ReferenceAgreement) -> Consistency<'a> {
        let n = pairs.pairs.len();
        Consistency {
            pairs,
            frames: 0,
            mean: vec![[0.0; 2]; n],
            squares: vec![0.0; n],
            beyond: [0; THRESHOLDS.len()],
            lasting: LastingContrast::new(agreement),
        }
    }

    /// Adds a frame, given as the linear composites of both eyes.
    pub fn add(&mut self, eyes: [&[[f32; 3]]; 2]) {
        self.frames += 1;
        let n = f64::from(self.frames);
        for ((pair, mean), squares) in self.pairs.pairs.iter().zip(&mut self.mean).zip(&mut self.squares) {
            let seen = pair_luminances(pair, eyes);
            let off = (seen[0] - seen[1]) - (mean[0] - mean[1]);
            for (m, l) in mean.iter_mut().zip(seen) {
                *m += (l - *m) / n;
            }
            *squares += off * ((seen[0] - seen[1]) - (mean[0] - mean[1]));
            let contrast = weber(seen, self.pairs.epsilon);
            for (count, threshold) in self.beyond.iter_mut().zip(THRESHOLDS) {
                *count += u64::from(contrast > threshold);
            }
        }
        self.lasting.add(self.pairs.pairs.iter().map(|pair| pair_luminances(pair, eyes)).map(|[l, r]| l - r));
    }

    /// The lasting difference, free of the noise of the method and of the references, and intervals over the seeds.
    /// `None` with fewer than two frames or without pairs.
    pub fn over_seeds(&self) -> Option<SeedEstimates> {
        let bases: Vec<f64> = self.mean.iter().map(|mean| base(*mean, self.pairs.epsilon)).collect();
        self.lasting.found(&bases)
    }

    /// What the frames so far show. `None` without pairs or without frames.
    pub fn found(&self) -> Option<Inconsistency> {
        if self.mean.is_empty() || self.frames == 0 {
            return None;
        }
        let (n, pairs) = (f64::from(self.frames), self.mean.len() as f64);
        let noise_over = self.beyond.map(|b| b as f64 / (n * pairs));
        if self.frames < 2 {
            return Some(Inconsistency {
                systematic: None,
                noise_variance: None,
                noise_variance_relative: None,
                noise_over,
            });
        }
        let (mut raw, mut by_chance) = ([0.0; THRESHOLDS.len()], [0.0; THRESHOLDS.len()]);
        let (mut square, mut variance, mut relative) = (0.0, 0.0, 0.0);
        for (mean, squares) in self.mean.iter().zip(&self.squares) {
            let base = base(*mean, self.pairs.epsilon);
            let s2 = squares / (n - 1.0);
            // The standard error of the contrast.
            let error = (s2 / n).sqrt() / base;
            let contrast = (mean[0] - mean[1]) / base;
            for (i, threshold) in THRESHOLDS.into_iter().enumerate() {
                raw[i] += f64::from(u8::from(contrast.abs() > threshold)) / pairs;
                by_chance[i] += chance(threshold, error, n) / pairs;
            }
            square += contrast * contrast - error * error;
            variance += s2;
            relative += s2 / (base * base);
        }
        let over = std::array::from_fn(|i| share(raw[i], by_chance[i]));
        let rms = (square / pairs).max(0.0).sqrt();
        Some(Inconsistency {
            systematic: Some(Systematic { share: over[0], raw: raw[0], by_chance: by_chance[0], over, rms }),
            noise_variance: Some(variance / pairs),
            noise_variance_relative: Some(relative / pairs),
            noise_over,
        })
    }
}

/// The share of pairs whose contrast in one picture is above [`MATCH`]; noise is not allowed for. Computed of the
/// reference with another seed, it is the floor of every method's raw share.
pub fn share_beyond(pairs: &Pairs, eyes: [&[[f32; 3]]; 2]) -> Option<f64> {
    super::mean(pairs.pairs.iter().map(|pair| {
        let seen = pair_luminances(pair, eyes);
        f64::from(u8::from(weber(seen, pairs.epsilon) > MATCH))
    }))
}

fn base([l, r]: [f64; 2], epsilon: f64) -> f64 {
    ((l + r) / 2.0).max(epsilon)
}

fn weber(seen: [f64; 2], epsilon: f64) -> f64 {
    (seen[0] - seen[1]).abs() / base(seen, epsilon)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cyclopean_analysis::chance::Stream;

    const N: u32 = 20_000;

    fn pairs() -> Pairs {
        let pairs = (0..N).map(|i| [i, i]).collect();
        Pairs { candidates: N.into(), undecided: 0, different: 0, epsilon: 0.01, pairs }
    }

    /// What is found at luminance 1 with normal noise of this spread, where the first `share` of the pairs differ by
    /// `contrast`.
    fn found(frames: u32, noise: f64, share: f64, contrast: f64) -> Inconsistency {
        let pairs = pairs();
        let mut stream = Stream::new(5, 2);
        let grey = vec![[1.0; 3]; N as usize];
        let agreement = ReferenceAgreement::new(&pairs, [&grey, &grey], [&grey, &grey]);
        let mut consistency = Consistency::new(&pairs, &agreement);
        for _ in 0..frames {
            let mut eye = |offset: f64| -> Vec<[f32; 3]> {
                (0..N)
                    .map(|i| {
                        let differs = f64::from(u8::from(f64::from(i) < share * f64::from(N)));
                        [(1.0 + offset * differs + noise * stream.normal()) as f32; 3]
                    })
                    .collect()
            };
            let (left, right) = (eye(contrast / 2.0), eye(-contrast / 2.0));
            consistency.add([&left, &right]);
        }
        let found = consistency.found().expect("pairs and frames");
        // The sums by group must agree with the running means.
        if let (Some(systematic), Some(over_seeds)) = (found.systematic, consistency.over_seeds()) {
            assert!((over_seeds.unbiased.rms - systematic.rms).abs() < 3e-3, "{over_seeds:?}");
            let [lo, hi] = over_seeds.share.expect("frames");
            // The sums are in another order, so they round differently.
            assert!(lo - 1e-9 <= systematic.share && systematic.share <= hi + 1e-9, "{over_seeds:?}");
            let [lo, hi] = over_seeds.noise_variance.expect("frames");
            assert!((lo - 1e-9..=hi + 1e-9).contains(&found.noise_variance.expect("frames")), "{over_seeds:?}");
        }
        found
    }

    #[test]
    fn noise_alone_is_no_systematic_difference() {
        for (frames, noise) in [(16, 0.02), (16, 0.1), (64, 0.3)] {
            let s = found(frames, noise, 0.0, 0.0).systematic.expect("frames");
            assert!((s.raw - s.by_chance).abs() < 0.02, "{s:?}");
            assert!(s.share < 0.05, "{s:?}");
        }
    }

    #[test]
    fn what_differs_is_found_under_noise() {
        for noise in [0.0, 0.02, 0.1] {
            let s = found(16, noise, 0.3, 0.25).systematic.expect("frames");
            assert!((s.share - 0.3).abs() < 0.03, "noise {noise}: {s:?}");
            // √(0.3 · 0.25²)
            assert!((s.rms - 0.1369).abs() < 0.003, "noise {noise}: {s:?}");
            assert!((s.over[2] - 0.3).abs() < 0.02 && s.over[0] == s.share, "noise {noise}: {s:?}");
        }
        assert!(found(16, 0.1, 0.3, 0.25).systematic.expect("frames").raw > 0.5);
    }

    #[test]
    fn noise_is_measured() {
        let f = found(16, 0.1, 0.0, 0.0);
        assert!((f.noise_variance.expect("frames") - 0.02).abs() < 4e-4, "{f:?}");
        assert!((f.noise_variance_relative.expect("frames") - 0.02).abs() < 1e-3, "{f:?}");
        // D has σ = 0.1·√2. |D| > 2 % has the probability 2·(1 − Φ(0.1414)) = 0.8875, and |D| > 20 % has
        // 2·(1 − Φ(1.414)) = 0.1573.
        assert!((f.noise_over[0] - 0.8875).abs() < 0.01, "{f:?}");
        assert!((f.noise_over[3] - 0.1573).abs() < 0.01, "{f:?}");
    }

    #[test]
    fn one_frame_or_no_pair_says_little() {
        let one = found(1, 0.1, 0.0, 0.0);
        assert_eq!((one.systematic, one.noise_variance), (None, None));
        let none = Pairs { pairs: Vec::new(), ..pairs() };
        let agreement = ReferenceAgreement::new(&none, [&[], &[]], [&[], &[]]);
        let consistency = Consistency::new(&none, &agreement);
        assert!(consistency.found().is_none() && consistency.over_seeds().is_none());
    }
}
