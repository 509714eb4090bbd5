//! Measures the speed of simulated sessions and of reading their journals. It prints figures and has no limits. Needs
//! no GPU. To run it by hand:
//!
//! `cargo test --profile traced --no-default-features --test all speed:: -- --ignored --nocapture --test-threads 1`

use std::time::Instant;

use cyclopean::study::session::{Options, simulate};
use cyclopean::study::writer::Durability;
use cyclopean_analysis::journal::record::Kind;
use cyclopean_analysis::journal::{self, collect};

use crate::lab::{self, Lab};

fn many(conditions: usize, repetitions: u32) -> serde_json::Value {
    let scenes: Vec<String> = (0..conditions / 2).map(|i| format!("scene-{i}")).collect();
    let names: Vec<&str> = scenes.iter().map(String::as_str).collect();
    let mut study = lab::rate(&names, repetitions);
    study["breaks"] = serde_json::json!({"every_minutes": 0});
    study
}

/// The peak resident memory of this process in MiB.
fn peak_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|l| l.starts_with("VmHWM")).unwrap_or("0");
    let kib: f64 = line.chars().filter(char::is_ascii_digit).collect::<String>().parse().unwrap_or(0.0);
    kib / 1024.0
}

#[test]
#[ignore = "a measurement"]
fn a_hundred_thousand_trials() {
    for (repetitions, durability) in
        [(100, Durability::Relaxed), (1000, Durability::Relaxed), (100, Durability::Synced)]
    {
        let lab = Lab::new(&many(100, repetitions));
        let study = lab.load();
        let options = Options { durability, ..Options::new(Kind::Simulated) };
        let started = Instant::now();
        let ended = simulate(&study, &lab.store(), &lab.sessions(), "s01", 90.0, &options).unwrap();
        let seconds = started.elapsed().as_secs_f64();
        let bytes = std::fs::metadata(&ended.journal).unwrap().len();
        let trials = 100 * repetitions;
        println!(
            "{trials} trials, {durability:?}: {seconds:.2} s, {:.0} trials/s, journal {:.1} MB, peak memory {:.0} MiB",
            f64::from(trials) / seconds,
            bytes as f64 / 1e6,
            peak_mib()
        );
        let started = Instant::now();
        let lines = journal::read(&ended.journal).unwrap().map(Result::unwrap).count();
        let seconds = started.elapsed().as_secs_f64();
        println!("  read and checked: {lines} lines, {:.0} MB/s", bytes as f64 / 1e6 / seconds);
        let started = Instant::now();
        let votes = collect(&ended.journal).unwrap();
        let seconds = started.elapsed().as_secs_f64();
        println!("  verified and collected: {} votes, {:.0} MB/s", votes.votes.len(), bytes as f64 / 1e6 / seconds);
        assert_eq!(votes.votes.len(), trials as usize);
    }
}
