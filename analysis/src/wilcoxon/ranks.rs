//! Mid-ranks of absolute differences, doubled so that they are whole numbers.

use super::Zeros;

/// The absolute differences ranked under one zero rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ranks {
    /// Doubled mid-ranks of the non-zero differences, ascending in |d|, with their signs (true: d > 0).
    pub signed: Vec<(u64, bool)>,
    /// Doubled rank sum of the zeros; 0 under `wilcox`, where zeros have no ranks.
    pub zero_sum: u64,
    /// Number of zero differences.
    pub zeros: u64,
    /// Sizes of the tie groups among the non-zero differences, groups of one left out.
    pub ties: Vec<u64>,
}

impl Ranks {
    /// Ranks `d` (finite) under `rule`: `wilcox` ranks only the non-zero differences, the other rules rank all.
    pub fn new(d: &[f64], rule: Zeros) -> Self {
        let mut sorted: Vec<(f64, bool)> = d.iter().filter(|v| **v != 0.0).map(|v| (v.abs(), *v > 0.0)).collect();
        sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let zeros = (d.len() - sorted.len()) as u64;
        let offset = if rule == Zeros::Wilcox { 0 } else { zeros };
        let mut signed = Vec::with_capacity(sorted.len());
        let mut ties = Vec::new();
        let mut first = 0;
        while first < sorted.len() {
            let mut end = first + 1;
            while end < sorted.len() && sorted[end].0 == sorted[first].0 {
                end += 1;
            }
            // Ranks offset + first + 1 ..= offset + end; twice their mean is the sum of the two ends.
            let doubled = 2 * offset + (first + 1 + end) as u64;
            signed.extend(sorted[first..end].iter().map(|(_, plus)| (doubled, *plus)));
            if end - first > 1 {
                ties.push((end - first) as u64);
            }
            first = end;
        }
        Self { signed, zero_sum: if rule == Zeros::Wilcox { 0 } else { zeros * (zeros + 1) }, zeros, ties }
    }

    /// Doubled sum of the ranks with a positive sign, zeros left out.
    pub fn plus(&self) -> u64 {
        self.signed.iter().filter(|r| r.1).map(|r| r.0).sum()
    }

    /// Doubled sum of the ranks with a negative sign, zeros left out.
    pub fn minus(&self) -> u64 {
        self.signed.iter().filter(|r| !r.1).map(|r| r.0).sum()
    }

    /// Σ(t³ − t) over the tie groups of the non-zero differences.
    pub fn tie_sum(&self) -> f64 {
        self.ties.iter().map(|&t| cube_less(t)).sum()
    }
}

/// t³ − t in f64, exact up to t = 2¹⁷.
pub(super) fn cube_less(t: u64) -> f64 {
    let t = t as f64;
    t * (t * t - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mid_ranks_are_doubled_and_zeros_follow_the_rule() {
        let d = [0.0, -1.0, 1.0, 2.0, 0.0];
        let wilcox = Ranks::new(&d, Zeros::Wilcox);
        assert_eq!((wilcox.plus(), wilcox.minus(), wilcox.zeros), (3 + 6, 3, 2));
        assert_eq!(wilcox.ties, [2]);
        let pratt = Ranks::new(&d, Zeros::Pratt);
        // Ranks 1 and 2 belong to the zeros, 3.5 to the pair, 5 to the last one.
        assert_eq!((pratt.plus(), pratt.minus(), pratt.zero_sum), (7 + 10, 7, 6));
    }
}
