//! Structural similarity (Wang et al. 2004): Gaussian window of 11×11 pixels, σ = 1.5, K = 0.01 and 0.03, range 1.
//!
//! Equal to scikit-image's `structural_similarity(x, y, channel_axis=2, gaussian_weights=True, sigma=1.5,
//! use_sample_covariance=False, data_range=1)`: the mean over R, G and B, five pixels left out at each border.

/// Pixels on each side of a window's centre.
const RADIUS: usize = 5;
const SIGMA: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// A reference made ready for many comparisons.
pub struct Ssim {
    width: usize,
    height: usize,
    window: [f64; 2 * RADIUS + 1],
    /// By channel: values, windowed mean, windowed mean of squares.
    planes: [Plane; 3],
}

struct Plane {
    values: Vec<f64>,
    mean: Vec<f64>,
    square: Vec<f64>,
}

impl Ssim {
    /// `reference` is display-encoded, in [0, 1]. `None`: a side is shorter than the window's 11 pixels.
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

    /// Mean similarity; 1 = equal.
    pub fn of(&self, picture: &[[f32; 3]]) -> f64 {
        let map = self.map(picture);
        map.iter().sum::<f64>() / map.len() as f64
    }

    /// Mean similarity over windows whose centre the mask holds; `None` where it holds none.
    pub fn over(&self, picture: &[[f32; 3]], mask: &[bool]) -> Option<f64> {
        let map = self.map(picture);
        let inner = self.width - 2 * RADIUS;
        let centre = |i: usize| (i / inner + RADIUS) * self.width + i % inner + RADIUS;
        super::mean(map.iter().enumerate().filter(|(i, _)| mask[centre(*i)]).map(|(_, s)| *s))
    }

    /// Similarity about each pixel at least five from every border, mean of the channels.
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

/// Weighted means over every window that lies inside the picture.
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
