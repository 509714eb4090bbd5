//! Named, portable randomness: one ChaCha20 stream per (study seed, row, purpose).
//!
//! The key of a stream is SHA-256 of `cyclopean stream 1\n{seed}\n{row}\n{purpose}\n` (decimal numbers, UTF-8); its
//! words are those of ChaCha20 with a zero nonce. Nothing here may change without a new number in that text.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha20Rng;
use sha2::{Digest, Sha256};

/// A stream of random numbers.
#[derive(Debug, Clone)]
pub struct Stream(ChaCha20Rng);

impl Stream {
    /// The stream for this seed, row and purpose.
    pub fn new(seed: u64, row: u64, purpose: &str) -> Stream {
        let key = Sha256::digest(format!("cyclopean stream 1\n{seed}\n{row}\n{purpose}\n"));
        Stream(ChaCha20Rng::from_seed(key.into()))
    }

    /// Uniform in `0..n`, n ≥ 1; words in the incomplete last interval are rejected.
    pub fn below(&mut self, n: u64) -> u64 {
        assert!(n > 0, "a choice among nothing");
        let limit = u64::MAX - (u64::MAX % n + 1) % n;
        loop {
            let word = self.0.next_u64();
            if word <= limit {
                return word % n;
            }
        }
    }

    /// Uniform in (0, 1), 53 bits, never 0 or 1.
    pub fn unit(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    /// A standard normal number, by Box and Muller (one of the pair is used).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.unit().ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }

    /// Shuffles by Fisher and Yates, from the end.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last as u64 + 1) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_is_the_same_everywhere_and_for_ever() {
        let mut stream = Stream::new(1, 2, "order");
        let drawn: Vec<u64> = (0..6).map(|_| stream.below(1000)).collect();
        assert_eq!(drawn, PINNED);
        assert_ne!(Stream::new(1, 2, "assignment").below(u64::MAX), Stream::new(1, 2, "order").below(u64::MAX));
    }

    // Eight-byte little-endian words of ChaCha20 (RFC 8439's block function, zero nonce, counter 0) under the key
    // sha256("cyclopean stream 1\n1\n2\norder\n"), modulo 1000; made with an independent implementation in Python.
    const PINNED: [u64; 6] = [799, 198, 20, 777, 209, 787];

    #[test]
    fn small_choices_are_uniform() {
        let mut stream = Stream::new(3, 0, "test");
        let mut counts = [0u32; 5];
        for _ in 0..50_000 {
            counts[stream.below(5) as usize] += 1;
        }
        // Chi-square, 4 degrees of freedom, 0.9999 quantile 23.5.
        let chi: f64 = counts.iter().map(|&c| (f64::from(c) - 10_000.0).powi(2) / 10_000.0).sum();
        assert!(chi < 23.5, "{counts:?}");
    }
}
