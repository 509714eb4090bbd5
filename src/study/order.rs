//! Orders of n conditions: random, fixed, blocked, and Williams squares. Pure functions of (seed, row).

use super::random::Stream;

/// Rows after which a Williams design repeats: n for even n, 2n for odd.
pub fn williams_rows(n: usize) -> u64 {
    if n < 2 { 1 } else { (n * (1 + n % 2)) as u64 }
}

/// Row `row` (any number; it wraps) of the Williams square of n conditions.
///
/// Over all rows, every condition follows every other equally often (Williams 1949). The first row is 0, 1, n−1, 2,
/// n−2, …; row i adds i modulo n. For odd n a second half holds the rows reversed.
pub fn williams(n: usize, row: u64) -> Vec<usize> {
    let row = (row % williams_rows(n)) as usize;
    let (shift, reversed) = if n == 0 { (0, false) } else { (row % n, row >= n) };
    let zigzag = (0..n).map(|i| if i % 2 == 1 { i.div_ceil(2) } else { (n - i / 2) % n });
    let mut order: Vec<usize> = zigzag.map(|c| (c + shift) % n).collect();
    if reversed {
        order.reverse();
    }
    order
}

/// `repetitions` passes through a Williams design, each by another row of the same half. No condition is shown twice in
/// a row.
pub fn williams_passes(n: usize, repetitions: u32, row: u64) -> Vec<Vec<usize>> {
    let mut passes: Vec<Vec<usize>> = Vec::new();
    let (half, start) = if n == 0 { (0, 0) } else { ((row % williams_rows(n)) / n as u64, row % n as u64) };
    let mut step = 0;
    for _ in 0..repetitions {
        let mut pass;
        loop {
            pass = williams(n, half * n as u64 + (start + step) % n.max(1) as u64);
            step += 1;
            if n < 2 || passes.last().and_then(|p| p.last()) != pass.first() {
                break;
            }
        }
        passes.push(pass);
    }
    passes
}

/// `repetitions` random permutations. No condition is shown twice in a row (n ≥ 2).
pub fn random_passes(n: usize, repetitions: u32, stream: &mut Stream) -> Vec<Vec<usize>> {
    let mut passes: Vec<Vec<usize>> = Vec::new();
    for _ in 0..repetitions {
        let mut pass: Vec<usize> = (0..n).collect();
        loop {
            stream.shuffle(&mut pass);
            if n < 2 || passes.last().and_then(|p| p.last()) != pass.first() {
                break;
            }
        }
        passes.push(pass);
    }
    passes
}

/// Groups in random order, each with random passes of its members; `group[i]` is the group of condition i.
///
/// The result has one entry for each group, which holds its passes.
pub fn blocked(group: &[usize], repetitions: u32, stream: &mut Stream) -> Vec<Vec<Vec<usize>>> {
    let mut groups: Vec<usize> = group.to_vec();
    groups.sort_unstable();
    groups.dedup();
    stream.shuffle(&mut groups);
    groups
        .into_iter()
        .map(|g| {
            let members: Vec<usize> = (0..group.len()).filter(|&i| group[i] == g).collect();
            let passes = random_passes(members.len(), repetitions, stream);
            passes.into_iter().map(|pass| pass.into_iter().map(|i| members[i]).collect()).collect()
        })
        .collect()
}

/// For each of n presentations, whether `method` is A. This is so for half of them; the next row of a pair has the
/// complement.
pub fn assignments(n: usize, seed: u64, row: u64) -> Vec<bool> {
    let mut is_a: Vec<bool> = (0..n).map(|i| i < n / 2).collect();
    Stream::new(seed, row / 2, "assignment").shuffle(&mut is_a);
    if row % 2 == 1 {
        is_a.iter_mut().for_each(|a| *a = !*a);
    }
    is_a
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn williams_squares_balance_positions_and_successions() {
        for n in 2..=40 {
            let rows = williams_rows(n);
            let mut place = vec![vec![0u32; n]; n];
            let mut follows = vec![vec![0u32; n]; n];
            for row in 0..rows {
                let order = williams(n, row);
                for (at, &c) in order.iter().enumerate() {
                    place[at][c] += 1;
                }
                for pair in order.windows(2) {
                    follows[pair[0]][pair[1]] += 1;
                }
            }
            let each = (rows / n as u64) as u32;
            assert!(place.iter().flatten().all(|&k| k == each), "n = {n}: positions");
            for (a, row) in follows.iter().enumerate() {
                for (b, &k) in row.iter().enumerate() {
                    assert_eq!(k, if a == b { 0 } else { each }, "n = {n}: {b} after {a}");
                }
            }
        }
    }

    #[test]
    fn repeated_passes_keep_the_balance_over_all_rows() {
        for n in 2..=12 {
            for repetitions in 1..=4 {
                let mut follows = vec![vec![0u32; n]; n];
                for row in 0..williams_rows(n) {
                    for pass in williams_passes(n, repetitions, row) {
                        for pair in pass.windows(2) {
                            follows[pair[0]][pair[1]] += 1;
                        }
                    }
                }
                let each = follows[0][1];
                let off_diagonal = (0..n * n).filter(|i| i / n != i % n);
                assert!(off_diagonal.map(|i| follows[i / n][i % n]).all(|k| k == each), "n = {n}, {repetitions}");
            }
        }
    }

    #[test]
    fn a_pair_of_rows_assigns_complements_and_an_even_number_is_halved() {
        for n in 1..=20 {
            for row in [0, 2, 8, 1_000_000] {
                let (first, second) = (assignments(n, 5, row), assignments(n, 5, row + 1));
                assert!(first.iter().zip(&second).all(|(a, b)| a != b));
                assert_eq!(first.iter().filter(|&&a| a).count(), n / 2);
            }
        }
    }

    proptest! {
        #[test]
        fn every_pass_is_a_permutation_and_no_condition_follows_itself(
            n in 2usize..30, repetitions in 1u32..5, seed: u64, row: u64,
        ) {
            let mut stream = Stream::new(seed, row, "order");
            for passes in [williams_passes(n, repetitions, row), random_passes(n, repetitions, &mut stream)] {
                prop_assert_eq!(passes.len(), repetitions as usize);
                for pass in &passes {
                    let mut sorted = pass.clone();
                    sorted.sort_unstable();
                    prop_assert_eq!(sorted, (0..n).collect::<Vec<_>>());
                }
                prop_assert!(passes.concat().windows(2).all(|w| w[0] != w[1]));
            }
        }

        #[test]
        fn blocks_hold_their_group_and_nothing_else(group in prop::collection::vec(0usize..4, 1..20), seed: u64) {
            let blocks = blocked(&group, 2, &mut Stream::new(seed, 0, "order"));
            let mut seen = vec![0; group.len()];
            for block in &blocks {
                let first = group[block[0][0]];
                for &c in block.iter().flatten() {
                    prop_assert_eq!(group[c], first);
                    seen[c] += 1;
                }
            }
            prop_assert!(seen.iter().all(|&k| k == 2));
        }
    }
}
