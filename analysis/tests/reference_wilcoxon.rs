//! Compares the signed-rank test with SciPy 1.17.1, R 4.2.2, coin 1.4-2 and exactRankTests 0.8-35, and looks for the z
//! that the paper reports. The other programs' numbers lie in `shared/data/wilcoxon.json` beside the repository. The
//! comparison is skipped, with a message, where that file is absent.

use cyclopean_analysis::wilcoxon::{Alternative, Exact, Options, SignedRank, Zeros, signed_rank};
use serde_json::Value;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/wilcoxon.json");

/// The largest relative deviation so far, the place where it was found, and how many numbers were compared.
#[derive(Default)]
struct Worst {
    checked: u32,
    value: f64,
    place: String,
}

impl Worst {
    fn check(&mut self, place: &str, got: Option<f64>, want: &Value) {
        let Some(want) = number(want) else { return };
        let got = got.unwrap_or_else(|| panic!("{place}: no number, expected {want}"));
        let off = if want == 0.0 { got.abs() } else { (got / want - 1.0).abs() };
        assert!(off < 1e-12, "{place}: {got} instead of {want} (relative {off:e})");
        self.checked += 1;
        if off > self.value {
            (self.value, self.place) = (off, place.to_owned());
        }
    }
}

fn number(v: &Value) -> Option<f64> {
    v.as_f64().filter(|x| x.is_finite())
}

fn zeros(name: &str) -> Zeros {
    match name.to_lowercase().as_str() {
        "wilcox" | "wilcoxon" => Zeros::Wilcox,
        "pratt" => Zeros::Pratt,
        "zsplit" => Zeros::Zsplit,
        other => panic!("{other}"),
    }
}

fn alternative(name: &str) -> Alternative {
    match name {
        "two-sided" | "two.sided" => Alternative::TwoSided,
        "greater" => Alternative::Greater,
        "less" => Alternative::Less,
        other => panic!("{other}"),
    }
}

fn run(d: &[f64], zeros: Zeros, alternative: Alternative, correction: bool) -> SignedRank {
    let options = Options { zeros, alternative, correction, exact: Exact::Always, level: 0.95 };
    signed_rank(d, &options).unwrap()
}

#[test]
fn every_number_is_reproduced() {
    let Ok(text) = std::fs::read_to_string(FILE) else {
        println!("skipped: {FILE} is absent");
        return;
    };
    let file: Value = serde_json::from_str(&text).unwrap();
    let mut worst = Worst::default();
    for set in file["sets"].as_array().unwrap() {
        let d: Vec<f64> = set["d"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        let id = set["id"].as_str().unwrap();
        let untied = set["n_zero"] == 0 && set["tie_counts_nonzero"].as_array().unwrap().is_empty();
        exact_conditional(id, &d, &set["exact_conditional"], &mut worst);
        scipy(id, &d, &set["results"], untied, &mut worst);
        r(id, &d, &set["r_results"], untied, &mut worst);
    }
    println!("{} numbers, largest relative deviation {:e} at {}", worst.checked, worst.value, worst.place);
    assert!(worst.checked > 600, "{}", worst.checked);
}

fn exact_conditional(id: &str, d: &[f64], want: &Value, worst: &mut Worst) {
    for (rule, want) in want.as_object().unwrap() {
        for (key, side) in [("p_two", "two-sided"), ("p_less", "less"), ("p_greater", "greater")] {
            let got = run(d, zeros(rule), alternative(side), false);
            worst.check(&format!("{id} exact {rule} {side}"), got.p_exact, &want[key]);
            worst.check(&format!("{id} {rule} R+"), Some(got.r_plus), &want["r_plus"]);
        }
    }
}

fn scipy(id: &str, d: &[f64], results: &Value, untied: bool, worst: &mut Worst) {
    for want in results.as_array().unwrap() {
        let text = |key: &str| want[key].as_str().unwrap();
        let place = format!("{id} scipy {want}");
        let side = alternative(text("alternative"));
        let got = run(d, zeros(text("zero_method")), side, want["correction"] == true);
        worst.check(&place, Some(got.statistic), &want["statistic"]);
        match text("method") {
            "asymptotic" => {
                // SciPy reports −|z| for two-sided tests. This crate's z keeps its sign.
                let z = if side == Alternative::TwoSided { got.z.map(|z| -z.abs()) } else { got.z };
                // If all differences are zero, SciPy may report z = 0 and p = ½. In this crate z is undefined and p is
                // 1.
                if d.iter().all(|v| *v == 0.0) {
                    assert_eq!((got.z, got.p_asymptotic), (None, Some(1.0)));
                    continue;
                }
                worst.check(&place, z, &want["z"]);
                worst.check(&place, got.p_asymptotic, &want["p"]);
            }
            // SciPy's "exact" uses the null distribution without ties even where there are ties or zeros. That is an
            // error of SciPy and is not compared.
            "exact" if !untied => {}
            "exact" => worst.check(&place, got.p_exact, &want["p"]),
            // SciPy's "auto" enumerates all signs for up to 13 pairs. For up to 50 pairs without ties it uses the exact
            // null distribution, and otherwise the normal approximation.
            _ if d.len() <= 13 || (untied && d.len() <= 50) => worst.check(&place, got.p_exact, &want["p"]),
            _ => worst.check(&place, got.p_asymptotic, &want["p"]),
        }
    }
}

fn r(id: &str, d: &[f64], results: &Value, untied: bool, worst: &mut Worst) {
    for want in results.as_array().unwrap() {
        if want.get("error").is_some() || d.iter().all(|v| *v == 0.0) {
            continue;
        }
        let place = format!("{id} {want}");
        let side = alternative(want["alternative"].as_str().unwrap());
        let correct = want["correct"] == true;
        match want["fn"].as_str().unwrap() {
            "stats::wilcox.test" => {
                let got = run(d, Zeros::Wilcox, side, correct);
                let exact = untied && (want["exact"] == "TRUE" || (want["exact"] == "default" && d.len() < 50));
                loose(worst, &place, if exact { got.p_exact } else { got.p_asymptotic }, &want["p"]);
                worst.check(&place, Some(got.r_plus), &want["V"]);
            }
            "coin::wilcoxsign_test" => {
                let got = run(d, zeros(want["zero.method"].as_str().unwrap()), side, false);
                let exact = want["distribution"] == "exact";
                loose(worst, &place, got.z, &want["z"]);
                loose(worst, &place, if exact { got.p_exact } else { got.p_asymptotic }, &want["p"]);
            }
            _ => loose(worst, &place, run(d, Zeros::Wilcox, side, false).p_exact, &want["p"]),
        }
    }
}

/// Compares with a number of R, which printed 15 significant digits. They suffice for the tolerance of 1e-12.
fn loose(worst: &mut Worst, place: &str, got: Option<f64>, want: &Value) {
    worst.check(place, got, want);
}

#[test]
fn the_z_and_p_that_the_paper_prints_follow_from_thirty_differences() {
    // These 30 pooled differences, one for each participant and scene, give the paper's z and p.
    let counts = [(-2.0, 2), (-1.0, 4), (0.0, 5), (1.0, 7), (2.0, 9), (3.0, 3)];
    let d: Vec<f64> = counts.iter().flat_map(|(v, n)| std::iter::repeat_n(*v, *n)).collect();
    let r = run(&d, Zeros::Wilcox, Alternative::TwoSided, false);
    assert!((r.z.unwrap().abs() - 2.87002).abs() < 5e-6 && (r.p_asymptotic.unwrap() - 0.004104).abs() < 5e-7, "{r:?}");
    // The nearest that the differences of ten participants come is −2.871. All ten have the same sign: six are 1, two
    // are 2, one is 3 and one is 4.
    let ten = [-1., -1., -1., -1., -1., -1., -2., -2., -3., -4.];
    let r = run(&ten, Zeros::Wilcox, Alternative::TwoSided, false);
    assert_eq!(format!("{:.3}", r.z.unwrap()), "-2.871");
}

#[test]
fn no_ten_participant_level_pairs_give_the_papers_z() {
    // z depends only on the tie groups of |d|, on the number of zeros and on R₊. The loops go through all numbers of
    // zeros and, by `cuts`, through all ways to divide the other differences into tie groups.
    for (rule, correction) in
        [Zeros::Wilcox, Zeros::Pratt, Zeros::Zsplit].into_iter().flat_map(|r| [(r, false), (r, true)])
    {
        for zeros in 0..10usize {
            let n = 10 - zeros;
            for cuts in 0u32..1 << (n - 1) {
                let mut level = 1.0;
                let magnitudes: Vec<f64> = (0..n)
                    .map(|i| {
                        if i > 0 && cuts >> (i - 1) & 1 == 1 {
                            level += 1.0;
                        }
                        level
                    })
                    .collect();
                // |z| = 2.87 needs a small R₊ or R₋, so that at most two small ranks can have the other sign. All signs
                // of the four smallest differences are tried.
                for flips in 0u32..1 << n.min(4) {
                    let mut d: Vec<f64> = magnitudes
                        .iter()
                        .enumerate()
                        .map(|(i, m)| if i < 4 && flips >> i & 1 == 1 { *m } else { -m })
                        .collect();
                    d.resize(10, 0.0);
                    let options = Options { zeros: rule, correction, exact: Exact::Never, ..Options::default() };
                    let z = signed_rank(&d, &options).unwrap().z.unwrap();
                    assert_ne!(format!("{:.3}", z.abs()), "2.870", "{rule:?} {correction} {d:?}");
                }
            }
        }
    }
}
