//! Compares means, intervals, screening, Friedman's test and corrections for multiple tests with reference numbers,
//! which other programs (such as sureal) computed. They lie in `shared/data/mos.json` beside the repository. The tests
//! are skipped, with a message, where that file is absent.

use cyclopean_analysis::adjust::{Correction, adjust};
use cyclopean_analysis::friedman::friedman;
use cyclopean_analysis::interval::{Scale, binomial_model, normal, share_wilson, student_t};
use cyclopean_analysis::screen::{P910Options, Sigma, bt500, p910, remove_bias};
use cyclopean_analysis::special::mean_sd;
use serde_json::Value;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/mos.json");

#[derive(Default)]
struct Worst {
    checked: u32,
    value: f64,
    place: String,
}

impl Worst {
    fn check(&mut self, place: &str, got: f64, want: &Value) {
        let want = want.as_f64().unwrap_or_else(|| panic!("{place}: {want}"));
        // Biases are near zero but are differences of ratings of size one. Below 0.01 the tolerance is therefore
        // absolute.
        let off = (got - want).abs() / want.abs().max(1e-2);
        assert!(off < 1e-12, "{place}: {got} instead of {want} ({off:e})");
        self.checked += 1;
        if off > self.value {
            (self.value, self.place) = (off, place.to_owned());
        }
    }

    fn all(&mut self, place: &str, got: &[f64], want: &Value) {
        let want = want.as_array().unwrap();
        assert_eq!(got.len(), want.len(), "{place}");
        got.iter().zip(want).enumerate().for_each(|(i, (g, w))| self.check(&format!("{place}[{i}]"), *g, w));
    }
}

fn file() -> Option<Value> {
    let Ok(text) = std::fs::read_to_string(FILE) else {
        println!("skipped: {FILE} is absent");
        return None;
    };
    Some(serde_json::from_str(&text).unwrap())
}

fn matrix(v: &Value) -> Vec<Vec<Option<f64>>> {
    v.as_array().unwrap().iter().map(|r| r.as_array().unwrap().iter().map(Value::as_f64).collect()).collect()
}

fn means(votes: &[Vec<Option<f64>>], keep: &[bool]) -> (Vec<f64>, Vec<f64>) {
    votes
        .iter()
        .map(|r| {
            let kept: Vec<f64> = r.iter().zip(keep).filter(|k| *k.1).filter_map(|k| *k.0).collect();
            let (mean, sd) = mean_sd(&kept);
            (mean, sd.unwrap() / (kept.len() as f64).sqrt())
        })
        .unzip()
}

#[test]
fn intervals() {
    let Some(file) = file() else { return };
    let mut worst = Worst::default();
    let scale = Scale { low: 1.0, high: 5.0 };
    for (name, case) in file["cases"].as_object().unwrap() {
        for (j, (row, want)) in
            matrix(&case["ratings"]).iter().zip(case["ci_per_stimulus"].as_array().unwrap()).enumerate()
        {
            let x: Vec<f64> = row.iter().flatten().copied().collect();
            let (mean, sd) = mean_sd(&x);
            worst.check(&format!("{name} {j} mos"), mean, &want["mos"]);
            worst.check(&format!("{name} {j} sd"), sd.unwrap(), &want["sd_n-1"]);
            for (key, got) in [
                ("normal", normal(&x, 0.95)),
                ("student_t", student_t(&x, 0.95)),
                ("binom_clopper_pearson", binomial_model(&x, scale, 0.95, false)),
                ("binom_jeffreys", binomial_model(&x, scale, 0.95, true)),
            ] {
                worst.all(&format!("{name} {j} {key}"), &[got.lo.unwrap(), got.hi.unwrap()], &want[key]);
            }
            let (trials, k) = (4.0 * x.len() as f64, x.iter().map(|v| v - 1.0).sum::<f64>());
            let (lo, hi) = share_wilson(k, trials, 0.95);
            worst.all(&format!("{name} {j} wilson"), &[1.0 + 4.0 * lo, 1.0 + 4.0 * hi], &want["binom_wilson_cc"]);
        }
    }
    println!("intervals: {} numbers, largest deviation {:e} at {}", worst.checked, worst.value, worst.place);
}

#[test]
fn screening() {
    let Some(file) = file() else { return };
    let mut worst = Worst::default();
    for (name, case) in file["cases"].as_object().unwrap() {
        let votes = matrix(&case["ratings"]);
        let everyone = vec![true; votes[0].len()];
        let sureal = &case["sureal"];
        let (mos, sem) = means(&votes, &everyone);
        worst.all(&format!("{name} MOS"), &mos, &sureal["MosModel"]["mos"]);
        worst.all(&format!("{name} SEM"), &sem, &sureal["MosModel"]["sem_or_sos"]);
        repaired(name, &votes, &case["bt500_skip_zero_variance"]);
        let (removed, bias) = remove_bias(&votes);
        let (mos, sem) = means(&removed, &everyone);
        let want = &sureal["BiasremvMosModel"];
        worst.all(&format!("{name} bias-removed MOS"), &mos, &want["mos"]);
        worst.all(&format!("{name} bias-removed SEM"), &sem, &want["sem_or_sos"]);
        worst.all(&format!("{name} bias"), &bias, &want["observer_bias"]);
        // P.913 § 12.4 removes biases and then rejects by BT.500. Without the biases no stimulus has unanimous votes.
        let want = &sureal["P913124Model"];
        let screened = bt500(&removed, Sigma::Population);
        for (i, o) in screened.observers.iter().enumerate() {
            assert_eq!(want["observer_rejected"][i].as_bool(), Some(o.rejected), "{name} {i}");
            worst.check(&format!("{name} P913 share {i}"), o.share, &want["observer_rejected_1st_stats"][i]);
            assert_eq!(want["observer_rejected_2nd_stats"][i].as_f64(), o.imbalance, "{name} {i}");
        }
        let kept: Vec<bool> = screened.observers.iter().map(|o| !o.rejected).collect();
        let (mos, sem) = means(&removed, &kept);
        worst.all(&format!("{name} P913 MOS"), &mos, &want["mos"]);
        worst.all(&format!("{name} P913 SEM"), &sem, &want["sem_or_sos"]);
        let want = &sureal["P910AnnexEModel"];
        let got = p910(&votes, P910Options { floor: None });
        let place = format!("{name} P910");
        worst.all(&format!("{place} bias"), &got.bias, &want["observer_bias"]);
        worst.all(&format!("{place} SE"), &got.standard_error, &want["sem_or_sos"]);
        worst.all(&format!("{place} quality"), &got.quality, &want["mos"]);
        worst.all(&format!("{place} inconsistency"), &got.inconsistency, &want["observer_inconsistency"]);
    }
    println!("screening: {} numbers, largest deviation {:e} at {}", worst.checked, worst.value, worst.place);
}

fn repaired(name: &str, votes: &[Vec<Option<f64>>], want: &Value) {
    for (key, sigma) in [("population_sd_as_sureal", Sigma::Population), ("sample_sd_as_ITU_text", Sigma::Sample)] {
        let got = bt500(votes, sigma);
        let rejected: Vec<usize> = (0..got.observers.len()).filter(|i| got.observers[*i].rejected).collect();
        assert_eq!(serde_json::to_value(rejected).unwrap(), want[key]["rejected"], "{name} {key}");
        let high: Vec<u32> = got.observers.iter().map(|o| o.high).collect();
        let low: Vec<u32> = got.observers.iter().map(|o| o.low).collect();
        assert_eq!(serde_json::to_value(high).unwrap(), want[key]["P"], "{name} {key}");
        assert_eq!(serde_json::to_value(low).unwrap(), want[key]["Q"], "{name} {key}");
    }
}

#[test]
fn friedman_and_corrections() {
    let Some(file) = file() else { return };
    let mut worst = Worst::default();
    let want = &file["friedman"];
    let rows: Vec<Vec<f64>> =
        matrix(&want["ratings_subjects_x_conditions"]).into_iter().map(|r| r.into_iter().flatten().collect()).collect();
    let got = friedman(&rows).unwrap();
    worst.check("chi2", got.chi_squared.unwrap(), &want["chi2"]);
    worst.check("W", got.kendall_w.unwrap(), &want["kendall_w"]);
    let p = want["p"].as_f64().unwrap();
    assert!((got.p / p - 1.0).abs() < 1e-12, "{} {p}", got.p);
    assert_eq!(want["df"], got.df);
    let p: Vec<f64> = matrix(&Value::Array(vec![file["multiple"]["p"].clone()]))[0].iter().flatten().copied().collect();
    worst.all("holm", &adjust(&p, Correction::Holm), &file["multiple"]["holm"]);
    for (key, correction) in [
        ("bonferroni", Correction::Bonferroni),
        ("hommel", Correction::Hommel),
        ("fdr_by", Correction::BenjaminiYekutieli),
    ] {
        worst.all(key, &adjust(&p, correction), &file["multiple"][key]);
    }
    worst.all("bh", &adjust(&p, Correction::BenjaminiHochberg), &file["multiple"]["fdr_bh"]);
    println!(
        "Friedman, corrections: {} numbers, largest deviation {:e} at {}",
        worst.checked, worst.value, worst.place
    );
}
