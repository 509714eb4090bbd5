//! Checks by enumeration, without Monte Carlo error, that the exact test keeps its level of 5 % if the methods are
//! exchangeable.

use cyclopean_analysis::power::{Rate, rejection_of_votes};
use cyclopean_analysis::wilcoxon::tails;

/// The probability that p ≤ 5 %, given |d| with `groups[v]` differences of magnitude v + 1.
fn conditional_size(groups: &[u64]) -> f64 {
    let mut doubled = Vec::new();
    let mut ranks = Vec::new();
    let mut before = 0;
    for n in groups.iter().filter(|n| **n > 0) {
        let rank = 2 * before + n + 1;
        doubled.extend(std::iter::repeat_n(rank, *n as usize));
        ranks.push((rank, *n));
        before += n;
    }
    // The distribution of the doubled R₊ is found by plain convolution, without the crate's own code.
    let total: u64 = doubled.iter().sum();
    let mut p = vec![0.0; total as usize + 1];
    p[0] = 1.0;
    for (rank, n) in ranks {
        for _ in 0..n {
            for k in (0..p.len()).rev() {
                p[k] = 0.5 * p[k] + if k as u64 >= rank { 0.5 * p[k - rank as usize] } else { 0.0 };
            }
        }
    }
    (0..=total).filter(|o| p[*o as usize] > 0.0 && tails(&doubled, *o).two_sided() <= 0.05).map(|o| p[o as usize]).sum()
}

#[test]
fn exact_size_for_every_five_point_sample_of_up_to_sixteen() {
    let mut worst = (0.0, Vec::new());
    let mut tried = 0u32;
    for n in 1..=16u64 {
        for a in 0..=n {
            for b in 0..=n - a {
                for c in 0..=n - a - b {
                    // Every sample of n differences that are not zero. Zeros are dropped and need no samples of their
                    // own.
                    let groups = [a, b, c, n - a - b - c];
                    let size = conditional_size(&groups);
                    tried += 1;
                    if size > worst.0 {
                        worst = (size, groups.to_vec());
                    }
                }
            }
        }
    }
    println!("{tried} samples, largest size {:.4} at {:?}", worst.0, worst.1);
    assert!(worst.0 <= 0.05, "{worst:?}");
}

#[test]
fn equal_means_of_different_shapes_are_another_null() {
    // With `a` everybody votes 4. With `b` most vote 4 or 5, and 19 % vote 1. Both means are 4, but the median
    // difference is not 0. With ten participants and one scene the test rejects in 12 % of studies.
    let a = [0.0, 0.0, 0.0, 1.0, 0.0];
    let b = [0.19, 0.0, 0.0, 0.24, 0.57];
    let r = rejection_of_votes(&a, &b, 10, 0.05).unwrap();
    println!("{r:?}");
    assert!((r.mean_a - r.mean_b).abs() < 1e-12 && r.exact > 0.1, "{r:?}");
    let rate = Rate::of(5, 100);
    assert!((rate.se - (0.05f64 * 0.95 / 100.0).sqrt()).abs() < 1e-15);
}
