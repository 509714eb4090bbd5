//! Structural similarity (Wang et al. 2004), with a Gaussian window of 11×11 pixels, σ = 1.5, K = 0.01 and 0.03, and
//! values from 0 to 1. Display values of a reference and of a picture go in. [`super::Judge`] and the sheets of
//! `compare` call it.
//!
//! It gives the same as scikit-image's `structural_similarity(x, y, channel_axis=2, gaussian_weights=True, sigma=1.5,
//! use_sample_covariance=False, data_range=1)`. This is the mean over R, G and B, without the five pixels next to each
//! border.

/// The number of pixels on each side of a window's centre.
const RADIUS: usize = 5;
const SIGMA: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// A reference that is filtered once, for comparison with many pictures.
pub struct Ssim {
    width: usize,
    height: usize,
    window: [f64; 2 * RADIUS + 1],
    /// The channels of the reference.
    planes: [Plane; 3],
}

/// One channel: its values, and their mean and mean square over every window.
struct Plane {
    values: Vec<f64>,
    mean: Vec<f64>,
    square: Vec<f64>,
}

impl Ssim {
    /// Filters the reference, whose display values are in [0, 1]. `None`: a side is shorter than the window's 11
    /// pixels.
    pub fn new(width: usize, height: usize, reference: &[[f32; 3]]) -> Option<Ssim> {
        if width.min(height) < 2 * RADIUS + 1 {
            return None;
        }
        let mut window = [0.0; 2 * RADIUS + 1];
        for (i, w) in window.iter_mut().enumerate() {
            *w = (-0.5 * ((i as f64 - RADIUS as f64) / SIGMA).powi(2)).exp();
        }
        let sum: f64 = window.iter().sum();
        window.iter_mut().for_each(|w| *w /= sum);
        let planes = [0, 1, 2].map(|c| {
            let values = channel(reference, c);
            let mean = windowed(&values, width, &window);
            let square = windowed(&product(&values, &values), width, &window);
            Plane { values, mean, square }
        });
        Some(Ssim { width, height, window, planes })
    }

    /// The mean similarity. Equal pictures have 1.
    pub fn of(&self, picture: &[[f32; 3]]) -> f64 {
        let map = self.map(picture);
        map.iter().sum::<f64>() / map.len() as f64
    }

    /// The mean similarity over the windows whose centre is in the mask. `None` where there is no such window.
    pub fn over(&self, picture: &[[f32; 3]], mask: &[bool]) -> Option<f64> {
        let map = self.map(picture);
        let inner = self.width - 2 * RADIUS;
        let centre = |i: usize| (i / inner + RADIUS) * self.width + i % inner + RADIUS;
        super::mean(map.iter().enumerate().filter(|(i, _)| mask[centre(*i)]).map(|(_, s)| *s))
    }

    /// The similarity around each pixel that is at least five pixels from every border, as the mean over the channels.
    fn map(&self, picture: &[[f32; 3]]) -> Vec<f64> {
        assert_eq!(picture.len(), self.width * self.height, "pictures of one size");
        let mut map = vec![0.0; (self.width - 2 * RADIUS) * (self.height - 2 * RADIUS)];
        for (c, reference) in self.planes.iter().enumerate() {
            let values = channel(picture, c);
            let mean = windowed(&values, self.width, &self.window);
            let square = windowed(&product(&values, &values), self.width, &self.window);
            let cross = windowed(&product(&values, &reference.values), self.width, &self.window);
            for (i, s) in map.iter_mut().enumerate() {
                let (ux, uy) = (mean[i], reference.mean[i]);
                let (vx, vy) = (square[i] - ux * ux, reference.square[i] - uy * uy);
                let covariance = cross[i] - ux * uy;
                let likeness = (2.0 * ux * uy + C1) * (2.0 * covariance + C2);
                *s += likeness / ((ux * ux + uy * uy + C1) * (vx + vy + C2)) / 3.0;
            }
        }
        map
    }
}

fn channel(picture: &[[f32; 3]], c: usize) -> Vec<f64> {
    picture.iter().map(|p| f64::from(p[c])).collect()
}

fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

/// The weighted mean over every window that lies inside the picture.
fn windowed(values: &[f64], width: usize, window: &[f64; 2 * RADIUS + 1]) -> Vec<f64> {
    let inner = width - 2 * RADIUS;
    let rows: Vec<f64> = values
        .chunks_exact(width)
        .flat_map(|row| row.windows(window.len()).map(|w| w.iter().zip(window).map(|(a, b)| a * b).sum::<f64>()))
        .collect();
    let height = rows.len() / inner - 2 * RADIUS;
    let mut out = vec![0.0; inner * height];
    for (y, line) in out.chunks_exact_mut(inner).enumerate() {
        for (k, weight) in window.iter().enumerate() {
            let row = &rows[(y + k) * inner..(y + k + 1) * inner];
            line.iter_mut().zip(row).for_each(|(o, r)| *o += weight * r);
        }
    }
    out
}
