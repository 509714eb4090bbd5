//! Measures of pictures for the cases and sweeps, in f64.

use crate::picture::StereoPicture;

/// The methods of cases that are not about a particular method. They ask the views or the geometry, use one eye or
/// both, and use back faces or not.
pub const METHODS: [&str; 6] =
    ["sssr", "stereo", "stereo-adaptive", "stereo-hybrid-50", "sssr-thickness", "path-traced@2"];

fn texels(picture: &StereoPicture) -> impl Iterator<Item = [f64; 3]> {
    picture.eyes.iter().flatten().map(|t| t.map(f64::from))
}

/// The largest |value − expected| of all channels.
pub fn farthest_from(picture: &StereoPicture, expected: f64) -> f64 {
    largest(texels(picture).flatten().map(|v| (v - expected).abs()))
}

/// The largest value of all channels.
pub fn most(picture: &StereoPicture) -> f64 {
    largest(texels(picture).flatten())
}

/// The largest value, or 0 if none is larger. Unlike with `f64::max`, NaN gives NaN.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |a, b| if a.is_nan() || a > b { a } else { b })
}

/// The per cent of the pixels in which a channel differs by more than `relative` times the larger value. Values below
/// the mean of the pictures are compared with that mean instead, so that nearly black pixels do not count.
pub fn differing_percent(a: &StereoPicture, b: &StereoPicture, relative: f64) -> f64 {
    let floor = mean(a).max(mean(b)).max(f64::MIN_POSITIVE);
    let differs = |(x, y): &([f64; 3], [f64; 3])| {
        // NaN counts as different from everything.
        let is_alike = |c: usize| (x[c] - y[c]).abs() <= relative * x[c].abs().max(y[c].abs()).max(floor);
        !(0..3).all(is_alike)
    };
    let pairs: Vec<_> = texels(a).zip(texels(b)).collect();
    100.0 * pairs.iter().filter(|p| differs(p)).count() as f64 / pairs.len().max(1) as f64
}

/// The number of pixels that differ in any bit.
pub fn unequal(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let bits = |t: &[f32; 3]| t.map(f32::to_bits);
    a.iter().zip(b).filter(|(x, y)| bits(x) != bits(y)).count() as f64 + a.len().abs_diff(b.len()) as f64
}

/// The mean over pixels and channels.
pub fn mean(picture: &StereoPicture) -> f64 {
    let n = 3 * picture.eyes.iter().map(Vec::len).sum::<usize>();
    texels(picture).flatten().sum::<f64>() / n.max(1) as f64
}

/// Σ(x − y)²/Σ(y − ȳ)² over the pixels where the reference y is not black.
pub fn relative_squared_error(x: &StereoPicture, y: &StereoPicture) -> f64 {
    let lit = |(_, y): &([f64; 3], [f64; 3])| *y != [0.0; 3];
    let pairs: Vec<(f64, f64)> =
        texels(x).zip(texels(y)).filter(lit).flat_map(|(x, y)| [0, 1, 2].map(|c| (x[c], y[c]))).collect();
    let mean = pairs.iter().map(|p| p.1).sum::<f64>() / pairs.len().max(1) as f64;
    let sum = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(|p| f(p) * f(p)).sum::<f64>();
    sum(&|p| p.0 - p.1) / sum(&|p| p.1 - mean)
}

/// The mean of (x − y)²/(y² + ε) with ε = (mean y/100)², over the pixels where the reference y is not black.
pub fn relative_mse(x: &StereoPicture, y: &StereoPicture) -> f64 {
    let lit: Vec<_> = texels(x).zip(texels(y)).filter(|(_, y)| *y != [0.0; 3]).collect();
    let n = (3 * lit.len()).max(1) as f64;
    let mean = lit.iter().flat_map(|(_, y)| y).sum::<f64>() / n;
    let least = (0.01 * mean).powi(2).max(f64::MIN_POSITIVE);
    let terms = lit.iter().flat_map(|(x, y)| [0, 1, 2].map(|c| (x[c] - y[c]).powi(2) / (y[c] * y[c] + least)));
    terms.sum::<f64>() / n
}

/// Σx/Σy − 1 over the pixels where the reference y is not black.
pub fn relative_bias(x: &StereoPicture, y: &StereoPicture) -> f64 {
    let lit = texels(x).zip(texels(y)).filter(|(_, y)| *y != [0.0; 3]);
    let (a, b) = lit.fold((0.0, 0.0), |(a, b), (x, y)| (a + x.iter().sum::<f64>(), b + y.iter().sum::<f64>()));
    a / b - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(values: &[f32]) -> StereoPicture {
        let eye: Vec<[f32; 3]> = values.iter().map(|&v| [v; 3]).collect();
        StereoPicture { width: values.len() as u32, height: 1, eyes: [eye.clone(), eye] }
    }

    #[test]
    fn measures_of_known_pictures() {
        let (a, b) = (picture(&[1.0, 2.0, 0.0, 1.0]), picture(&[1.0, 2.2, 0.0, 1.0]));
        assert!((differing_percent(&a, &b, 0.01) - 25.0).abs() < 1e-9);
        assert!((farthest_from(&a, 1.0) - 1.0).abs() < 1e-9 && (most(&b) - 2.2).abs() < 1e-6);
        assert!((unequal(&a.eyes[0], &b.eyes[0]) - 1.0).abs() < 1e-9);
        assert!((relative_bias(&b, &a) - 0.05).abs() < 1e-6);
        assert!((relative_squared_error(&b, &a) - 0.04 / (2.0 / 3.0)).abs() < 1e-6);
        assert!(farthest_from(&picture(&[f32::NAN, 1.0]), 1.0).is_nan());
        assert!(differing_percent(&picture(&[f32::NAN]), &picture(&[f32::NAN]), 0.1) > 99.0);
    }
}
