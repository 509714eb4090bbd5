//! Simulates the coverage of some intervals with 4,000 samples each, and compares it with the nominal 90 %. This is a
//! small version of the coverage table in the documentation.

use cyclopean_analysis::interval::{Bootstrap, Method};
use cyclopean_analysis::power::{Coverage, coverage, shapes};

fn of(name: &str, n: u32) -> impl Fn(Method) -> Coverage {
    let shape = shapes().into_iter().find(|s| s.name == name).unwrap();
    let all = coverage(shape, n, 4_000, 0.9, Bootstrap { resamples: 199, seed: 3 }).unwrap();
    move |method| all.iter().find(|c| c.method == method).unwrap().clone()
}

#[test]
fn student_t_holds_in_the_middle_and_the_binomial_model_fails_at_the_poles() {
    let middle = of("middle", 10);
    assert!((middle(Method::T).coverage.rate - 0.9).abs() < 0.02, "{:?}", middle(Method::T));
    let poles = of("polarised", 10);
    // The coverage is 65 % where 90 % is nominal. This is why `mos` prints the variance ratio and warns when it is
    // high.
    assert!((poles(Method::ClopperPearson).coverage.rate - 0.65).abs() < 0.03);
    assert!((poles(Method::T).coverage.rate - 0.9).abs() < 0.02);
    let ceiling = of("ceiling", 10);
    let unanimous = ceiling(Method::T).unanimous;
    // A share of 0.75¹⁰ of the samples consists of fives alone. They are counted as unanimous.
    assert!((unanimous - 0.75f64.powi(10)).abs() < 0.015, "{unanimous}");
}
