//! Times the exact signed-rank test: `cargo run --release -p cyclopean-analysis --example speed`.

use std::time::Instant;

use cyclopean_analysis::chance::Stream;
use cyclopean_analysis::wilcoxon::{Exact, Options, hodges_lehmann, signed_rank};

fn main() -> Result<(), cyclopean_analysis::Error> {
    let mut stream = Stream::new(1, 0);
    let options = Options { exact: Exact::Always, ..Options::default() };
    for n in [100u32, 500, 1000, 2000] {
        // Differences about zero: the observed sum stands in the middle, the longest way for the exact null.
        let untied: Vec<f64> = (1..=n).map(|i| f64::from(i) * if stream.sign() { 1.0 } else { -1.0 }).collect();
        let pairs: Vec<f64> = (0..n).map(|i| f64::from(i / 2 + 1) * if stream.sign() { 1.0 } else { -1.0 }).collect();
        let likert: Vec<f64> = (0..n).map(|_| f64::from(stream.index(41)) - 20.0).collect();
        for (name, d) in [("untied", untied), ("tied in pairs", pairs), ("41 values, zeros", likert)] {
            let (mut best, mut p) = (f64::INFINITY, 0.0);
            // The best of many: a busy machine interrupts most of the longer ones.
            for _ in 0..if n <= 500 { 40 } else { 6 } {
                let start = Instant::now();
                p = signed_rank(&d, &options)?.p();
                best = best.min(start.elapsed().as_secs_f64());
            }
            println!("n = {n:5}, {name:16}: {:8.2} ms (p = {p:.4})", 1e3 * best);
        }
    }
    let million: Vec<f64> = (0..1_000_000).map(|_| stream.normal()).collect();
    let start = Instant::now();
    let shift = hodges_lehmann(&million, 0.95);
    println!("Hodges-Lehmann of 10^6 differences: {:.2} s ({:.5})", start.elapsed().as_secs_f64(), shift.estimate);
    Ok(())
}
