//! Makes mutants by changing an input in a few places. This mutator is not guided by coverage; libFuzzer is (see
//! `fuzz/`).

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha20Rng;

/// Words and numbers on which readers often fail.
const WORDS: &[&[u8]] = &[
    b"null",
    b"-1",
    b"0",
    b"1e999",
    b"4294967295",
    b"18446744073709551615",
    b"0.0000001",
    b"\"\"",
    b"[]",
    b"{}",
    b"true",
    b"\xff\xff\xff\xff",
    b"\0\0\0\0",
    b"\0\0\0\x80",
    b"\xff\xff\xff\x7f",
    b"\n",
    b"\"",
    b",",
    b"\xef\xbb\xbf",
    b"\\u0000",
];

pub struct Mutator(ChaCha20Rng);

impl Mutator {
    pub fn new(seed: u64) -> Mutator {
        Mutator(ChaCha20Rng::seed_from_u64(seed))
    }

    /// A random number below `n`, or 0 if `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        if n == 0 { 0 } else { (self.0.next_u64() % n as u64) as usize }
    }

    /// One of the inputs `from`, changed one to eight times. Parts may be copied from another of them.
    pub fn mutant(&mut self, from: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = from[self.below(from.len())].clone();
        for _ in 0..=self.below(8) {
            let other = &from[self.below(from.len())];
            self.change(&mut bytes, other);
        }
        bytes
    }

    fn change(&mut self, bytes: &mut Vec<u8>, other: &[u8]) {
        let at = self.below(bytes.len());
        let length = self.below(16).min(bytes.len() - at);
        match self.below(8) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << self.below(8),
            1 if !bytes.is_empty() => bytes[at] = self.below(256) as u8,
            2 => drop(bytes.drain(at..at + length)),
            3 => {
                let again = bytes[at..at + length].to_vec();
                bytes.splice(at..at, again);
            }
            4 => {
                let word = WORDS[self.below(WORDS.len())];
                bytes.splice(at..at + length.min(word.len()), word.iter().copied());
            }
            // Replaces a decimal number by another one.
            5 => {
                let digits = bytes[at..].iter().position(u8::is_ascii_digit).map(|d| at + d);
                if let Some(from) = digits {
                    let to = from + bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
                    let number = self.0.next_u64() >> self.below(64);
                    bytes.splice(from..to, number.to_string().into_bytes());
                }
            }
            6 => bytes.truncate(at),
            _ => {
                let from = self.below(other.len());
                let to = from + self.below(64).min(other.len() - from);
                bytes.splice(at..at + length, other[from..to].iter().copied());
            }
        }
    }
}
