//! Named, portable random streams: one ChaCha stream for each purpose, with draws that no library update changes.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::special::normal_quantile;

/// A seeded stream for one purpose; the same seed and purpose give the same draws on every machine.
#[derive(Clone, Debug)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream `purpose` of `seed`; different purposes never overlap.
    pub fn new(seed: u64, purpose: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(purpose);
        Self(rng)
    }

    /// A whole number in 0..n without bias (Lemire's multiplication with rejection), 0 < n < 2³².
    pub fn index(&mut self, n: u32) -> u32 {
        let threshold = n.wrapping_neg() % n;
        loop {
            let wide = u64::from(self.0.next_u32()) * u64::from(n);
            if wide as u32 >= threshold {
                return (wide >> 32) as u32;
            }
        }
    }

    /// Uniform in the open interval (0, 1): 53 random bits plus half a step, so that neither end occurs.
    pub fn unit(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// A standard normal number: the quantile of one uniform draw, so that nothing is rejected and no state is kept.
    pub fn normal(&mut self) -> f64 {
        normal_quantile(self.unit())
    }

    /// One fair sign.
    pub fn sign(&mut self) -> bool {
        self.0.next_u32() & 1 == 1
    }

    /// An index drawn with the given weights, which need not sum to one.
    pub fn weighted(&mut self, weights: &[f64]) -> usize {
        let total: f64 = weights.iter().sum();
        let mut left = self.unit() * total;
        for (i, w) in weights.iter().enumerate() {
            left -= w;
            if left < 0.0 {
                return i;
            }
        }
        weights.len() - 1
    }
}
