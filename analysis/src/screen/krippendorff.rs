//! Agreement between observers: Krippendorff's α for ordinal ratings.

use serde::Serialize;

/// The coefficient, with the numbers of stimuli and votes that it is computed from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Alpha {
    /// 1: complete agreement; 0: agreement as by chance; `None`: all ratings are equal, or no stimulus has two votes.
    pub alpha: Option<f64>,
    /// Stimuli with at least two votes.
    pub units: usize,
    /// Votes of these stimuli.
    pub votes: usize,
}

/// α = 1 − D_o/D_e with the ordinal metric δ²(c, k) = (Σ_{g=c..k} n_g − (n_c + n_k)/2)² (Krippendorff 2011).
///
/// `votes` are stimuli × observers; missing votes are allowed.
///
/// ```
/// use cyclopean_analysis::screen::krippendorff_ordinal;
/// let unit = |v: [u8; 4]| v.map(|v| (v > 0).then_some(f64::from(v))).to_vec();
/// // Krippendorff (2011), "Computing Krippendorff's Alpha-Reliability": four observers, twelve units, 0 = missing.
/// let data = [
///     [1, 1, 0, 1], [2, 2, 3, 2], [3, 3, 3, 3], [3, 3, 3, 3], [2, 2, 2, 2], [1, 2, 3, 4],
///     [4, 4, 4, 4], [1, 1, 2, 1], [2, 2, 2, 2], [0, 5, 5, 5], [0, 0, 1, 1], [0, 3, 0, 0],
/// ];
/// let alpha = krippendorff_ordinal(&data.map(unit)).alpha.unwrap();
/// assert!((alpha - 0.8154).abs() < 5e-5);
/// ```
pub fn krippendorff_ordinal(votes: &[Vec<Option<f64>>]) -> Alpha {
    let pairable: Vec<Vec<f64>> =
        votes.iter().map(|r| r.iter().flatten().copied().collect::<Vec<_>>()).filter(|r| r.len() > 1).collect();
    let mut values: Vec<f64> = pairable.iter().flatten().copied().collect();
    let total = values.len();
    values.sort_unstable_by(f64::total_cmp);
    values.dedup();
    let index = |v: f64| values.partition_point(|x| *x < v);
    let mut counts = vec![0.0; values.len()];
    pairable.iter().flatten().for_each(|v| counts[index(*v)] += 1.0);
    let mut up_to = vec![0.0; values.len() + 1];
    for (i, n) in counts.iter().enumerate() {
        up_to[i + 1] = up_to[i] + n;
    }
    let distance = |c: usize, k: usize| {
        let (c, k) = (c.min(k), c.max(k));
        let between: f64 = up_to[k + 1] - up_to[c];
        (between - 0.5 * (counts[c] + counts[k])).powi(2)
    };
    let observed: f64 = pairable
        .iter()
        .map(|unit| {
            let mut here = vec![0.0; values.len()];
            unit.iter().for_each(|v| here[index(*v)] += 1.0);
            let used: Vec<usize> = (0..here.len()).filter(|i| here[*i] > 0.0).collect();
            let pairs: f64 =
                used.iter().flat_map(|c| used.iter().map(|k| here[*c] * here[*k] * distance(*c, *k))).sum();
            pairs / (unit.len() as f64 - 1.0)
        })
        .sum();
    let expected: f64 = (0..values.len())
        .flat_map(|c| (0..values.len()).map(move |k| (c, k)))
        .map(|(c, k)| counts[c] * counts[k] * distance(c, k))
        .sum();
    let alpha = (expected > 0.0).then(|| 1.0 - (total as f64 - 1.0) * observed / expected);
    Alpha { alpha, units: pairable.len(), votes: total }
}
