//! Squared errors over the pixels of a mask, with all three channels taken together. `compare` calls it, mostly through
//! [`super::Judge`].

use serde::Serialize;

/// How far a picture x is from its reference y. ȳ is the mean of y.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// The mean of (x − y)², in linear radiance squared.
    pub mse: f64,
    /// Σ(x − y)² / Σ(y − ȳ)². A constant picture of value ȳ would have 1. `None`: the reference is constant.
    pub rse: Option<f64>,
    /// The mean of (x − y)² / (y² + ε), with ε = (0.01·ȳ)². `None`: the reference is black.
    pub relmse: Option<f64>,
}

/// The errors of `x` against the reference `y` over the pixels of `mask`. `None` where the mask has no pixel.
///
/// # Panics
/// When the lengths differ.
pub fn errors(x: &[[f32; 3]], y: &[[f32; 3]], mask: &[bool]) -> Option<Errors> {
    assert!(x.len() == y.len() && y.len() == mask.len(), "one value a pixel");
    let masked = || x.iter().zip(y).zip(mask).filter(|(_, m)| **m).map(|(pair, _)| pair);
    let values = || masked().flat_map(|(x, y)| (0..3).map(|c| (f64::from(x[c]), f64::from(y[c]))));
    let n = 3.0 * masked().count() as f64;
    if n == 0.0 {
        return None;
    }
    let mean = values().map(|(_, y)| y).sum::<f64>() / n;
    let epsilon = (0.01 * mean).powi(2);
    let (mut squares, mut spread, mut relative) = (0.0, 0.0, 0.0);
    for (x, y) in values() {
        let square = (x - y).powi(2);
        squares += square;
        spread += (y - mean).powi(2);
        relative += square / (y * y + epsilon);
    }
    Some(Errors {
        mse: squares / n,
        rse: (spread > 0.0).then(|| squares / spread),
        relmse: (epsilon > 0.0).then(|| relative / n),
    })
}

/// The mean of (x − y)² over the channels of the pixels of `mask`. `None` where the mask has no pixel.
///
/// # Panics
/// When the lengths differ.
pub fn mean_square(x: &[[f32; 3]], y: &[[f32; 3]], mask: &[bool]) -> Option<f64> {
    assert!(x.len() == y.len() && y.len() == mask.len(), "one value a pixel");
    let masked = x.iter().zip(y).zip(mask).filter(|(_, m)| **m);
    super::mean(masked.flat_map(|((x, y), _)| (0..3).map(|c| (f64::from(x[c]) - f64::from(y[c])).powi(2))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_by_hand() {
        // y is 0, 0, 0, 2, 2, 2 with the mean 1, and x is y + 1 in one channel of each pixel. The third pixel is masked
        // out.
        let y = [[0.0; 3], [2.0; 3], [9.0; 3]];
        let x = [[1.0, 0.0, 0.0], [3.0, 2.0, 2.0], [0.0; 3]];
        let e = errors(&x, &y, &[true, true, false]).expect("a mask");
        assert!((e.mse - 2.0 / 6.0).abs() < 1e-15);
        assert!((e.rse.expect("it varies") - 2.0 / 6.0).abs() < 1e-15);
        assert!((mean_square(&x, &y, &[true, true, false]).expect("a mask") - e.mse).abs() < 1e-15);
        // ε = 1e-4: (1/1e-4 + 1/4.0001)/6
        assert!((e.relmse.expect("light") - (1e4 + 1.0 / 4.0001) / 6.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_undefined_is_none() {
        assert_eq!(errors(&[[1.0; 3]], &[[1.0; 3]], &[false]), None);
        assert_eq!(mean_square(&[[1.0; 3]], &[[1.0; 3]], &[false]), None);
        let constant = errors(&[[1.0; 3]; 2], &[[3.0; 3]; 2], &[true; 2]).expect("a mask");
        assert_eq!((constant.mse, constant.rse), (4.0, None));
        assert_eq!(errors(&[[1.0; 3]], &[[0.0; 3]], &[true]).expect("a mask").relmse, None);
    }
}
