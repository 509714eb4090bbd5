//! Checks properties of the signed-rank test that must hold for every set of differences: with random sets, with all
//! sign patterns of some sets, and with a few sets whose answer is known.

use cyclopean_analysis::wilcoxon::{Alternative, Exact, Options, SignedRank, Zeros, signed_rank};
use proptest::prelude::*;

fn run(d: &[f64], zeros: Zeros, alternative: Alternative, correction: bool) -> SignedRank {
    signed_rank(d, &Options { zeros, alternative, correction, exact: Exact::Always, level: 0.9 }).unwrap()
}

fn zeros() -> impl Strategy<Value = Zeros> {
    prop_oneof![Just(Zeros::Wilcox), Just(Zeros::Pratt), Just(Zeros::Zsplit)]
}

fn close(a: Option<f64>, b: Option<f64>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= 1e-13 * (1.0 + a.abs()),
        (a, b) => a == b,
    }
}

proptest! {
    // Failing cases are only printed: beside an integration test proptest finds no place to keep them.
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn negated_differences_mirror_the_statistic(d in proptest::collection::vec(-6i32..=6, 1..60), rule in zeros(), correction: bool) {
        let d: Vec<f64> = d.into_iter().map(f64::from).collect();
        let mirrored: Vec<f64> = d.iter().map(|v| -v).collect();
        let pairs = [
            (Alternative::TwoSided, Alternative::TwoSided),
            (Alternative::Greater, Alternative::Less),
            (Alternative::Less, Alternative::Greater),
        ];
        for (side, other) in pairs {
            let (a, b) = (run(&d, rule, side, correction), run(&mirrored, rule, other, correction));
            prop_assert_eq!(a.p_exact, b.p_exact);
            prop_assert_eq!(a.p_mid, b.p_mid);
            prop_assert!(close(a.p_asymptotic, b.p_asymptotic));
            prop_assert!(close(a.z, b.z.map(|z| -z)));
            prop_assert_eq!((a.r_plus, a.r_minus), (b.r_minus, b.r_plus));
            prop_assert!(close(a.rank_biserial, b.rank_biserial.map(|r| -r)));
            prop_assert_eq!(a.hodges_lehmann, b.hodges_lehmann.map(|h| -h + 0.0));
            prop_assert_eq!(a.hodges_lehmann_lo, b.hodges_lehmann_hi.map(|h| -h + 0.0));
        }
    }

    #[test]
    fn order_and_unit_do_not_matter(
        d in proptest::collection::vec(-6i32..=6, 1..40).prop_shuffle(), rule in zeros(), factor in 1u32..1000,
    ) {
        let plain: Vec<f64> = d.iter().map(|v| f64::from(*v)).collect();
        let mut other: Vec<f64> = plain.iter().map(|v| v * f64::from(factor)).collect();
        other.reverse();
        let (a, b) = (run(&plain, rule, Alternative::TwoSided, false), run(&other, rule, Alternative::TwoSided, false));
        prop_assert_eq!((a.p_exact, a.p_mid, a.z, a.statistic), (b.p_exact, b.p_mid, b.z, b.statistic));
    }

    #[test]
    fn tails_and_mid_p_are_consistent(d in proptest::collection::vec(-6i32..=6, 1..40), rule in zeros()) {
        let d: Vec<f64> = d.into_iter().map(f64::from).collect();
        let less = run(&d, rule, Alternative::Less, false).p_exact.unwrap();
        let greater = run(&d, rule, Alternative::Greater, false).p_exact.unwrap();
        let two = run(&d, rule, Alternative::TwoSided, false);
        prop_assert!(less + greater >= 1.0 - 1e-12);
        prop_assert!((two.p_exact.unwrap() - (2.0 * less.min(greater)).min(1.0)).abs() < 1e-15);
        prop_assert!(two.p_mid.unwrap() <= two.p_exact.unwrap());
        prop_assert_eq!(two.r_plus + two.r_minus, (two.n_used * (two.n_used + 1)) as f64 / 2.0
            + if rule == Zeros::Pratt { (two.n_used * two.n_zero) as f64 } else { 0.0 });
    }

    #[test]
    fn splitting_zeros_has_pratts_exact_p(d in proptest::collection::vec(-3i32..=3, 1..30)) {
        let d: Vec<f64> = d.into_iter().map(f64::from).collect();
        let (a, b) = (run(&d, Zeros::Pratt, Alternative::Less, false), run(&d, Zeros::Zsplit, Alternative::Less, false));
        prop_assert_eq!(a.p_exact, b.p_exact);
    }
}

#[test]
fn the_upper_tail_with_half_ranks_is_whole() {
    // If the upper tail were wrong by half a step, this set would give 0.0469 with one sign and 0.03125 with the other.
    let d = [-1., -1., 2., 2., 3., 3., 4., 4.];
    let mirrored: Vec<f64> = d.iter().map(|v| -v).collect();
    for d in [&d[..], &mirrored] {
        assert_eq!(run(d, Zeros::Wilcox, Alternative::TwoSided, false).p_exact, Some(0.03125));
    }
}

#[test]
fn no_p_is_zero() {
    let d: Vec<f64> = (1..=5000).map(f64::from).collect();
    let r = signed_rank(&d, &Options { alternative: Alternative::Greater, ..Options::default() }).unwrap();
    assert!(r.z.unwrap() > 60.0 && r.p_asymptotic.unwrap() > 0.0);
    let r = run(&d[..1500], Zeros::Wilcox, Alternative::TwoSided, false);
    assert!(r.p_exact.unwrap() > 0.0 && r.p_exact.unwrap() < 1e-300);
    // All 500 signs agree, so that p is exactly 2·2⁻⁵⁰⁰.
    assert_eq!(run(&d[..500], Zeros::Wilcox, Alternative::TwoSided, false).p_exact, Some(0.5f64.powi(499)));
}

#[test]
fn equal_pairs_are_never_significant() {
    for rule in [Zeros::Wilcox, Zeros::Pratt, Zeros::Zsplit] {
        for side in [Alternative::TwoSided, Alternative::Greater, Alternative::Less] {
            let r = run(&[0.0; 8], rule, side, true);
            assert_eq!((r.p_exact, r.p_asymptotic, r.p_mid, r.z), (Some(1.0), Some(1.0), Some(1.0), None));
            assert!(r.notes[0].starts_with("no differences"));
        }
    }
    assert!(signed_rank(&[], &Options::default()).unwrap_err().to_string().contains("no pairs"));
    assert!(signed_rank(&[1.0, f64::NAN], &Options::default()).unwrap_err().to_string().contains("difference 2"));
}

#[test]
fn size_by_enumeration_never_exceeds_the_level() {
    // If the methods are exchangeable, all 2ⁿ sign patterns of given |d| are equally likely. The size of the test is
    // therefore the share of patterns with p ≤ 5 %.
    let sets: [&[f64]; 4] = [
        &[1., 1., 1., 1., 2., 2., 2., 3., 3., 4., 4., 5.],
        &[1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12.],
        &[1.; 12],
        &[0., 0., 0., 1., 1., 1., 1., 2., 2., 2., 2., 3.],
    ];
    for d in sets {
        for n in 1..=d.len() {
            let (mut rejected, mut tried) = (0u32, 0u32);
            for signs in 0u32..1 << n {
                let signed: Vec<f64> = (0..n).map(|i| if signs >> i & 1 == 1 { d[i] } else { -d[i] }).collect();
                rejected +=
                    u32::from(run(&signed, Zeros::Wilcox, Alternative::TwoSided, false).p_exact.unwrap() <= 0.05);
                tried += 1;
            }
            assert!(f64::from(rejected) / f64::from(tried) <= 0.05, "{d:?} {n}");
        }
    }
}

#[test]
fn large_samples_are_quick() {
    // The limit allows for a loaded machine and an unoptimised build.
    let d: Vec<f64> = (0..500).map(|i| f64::from((i * 7919) % 41 - 20)).collect();
    let start = std::time::Instant::now();
    run(&d, Zeros::Wilcox, Alternative::TwoSided, false);
    assert!(start.elapsed().as_millis() < 500, "{:?}", start.elapsed());
}
