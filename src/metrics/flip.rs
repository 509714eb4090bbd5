//! FLIP for low dynamic range (Andersson et al. 2020): how different two pictures look when they alternate, from 0 to 1
//! for each pixel. Display values of a reference and of a picture go in. [`super::Judge`] calls it.
//!
//! It computes in f32, in the same order as version 1.1 of NVIDIA's C++ tool and with the same separated filters, so
//! that it gives the tool's numbers.

use std::f32::consts::PI;

/// The tool's default: a monitor that is 0.7 m wide and has 3840 pixels across, seen from 0.7 m away.
pub const PIXELS_PER_DEGREE: f32 = 67.0;

/// These five are q_c, p_c, p_t, w and q_f of the paper.
const COLOR_EXPONENT: f32 = 0.7;
const COLOR_KNEE: f32 = 0.4;
const KNEE_VALUE: f32 = 0.95;
const FEATURE_WIDTH_DEG: f32 = 0.082;
const FEATURE_EXPONENT: f32 = 0.5;

/// Contrast sensitivity as Gaussians a·√(π/b)·exp(−π²x²/b), each given as (a, b): one for the achromatic channel, one
/// for red-green, and two for blue-yellow.
const SENSITIVITY: [(f32, f32); 4] = [(1.0, 0.0047), (1.0, 0.0053), (34.1, 0.04), (13.5, 0.025)];

/// The white D65 in XYZ, and 1 over each of its values.
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];
const PER_WHITE: [f32; 3] = [1.052_156_9, 1.0, 0.918_357_7];

/// A reference that is filtered once, for comparison with many pictures.
pub struct Flip {
    width: usize,
    height: usize,
    filters: Filters,
    reference: PerceivedPicture,
}

struct Filters {
    /// The weights of the achromatic Gaussian, of the red-green one and of both blue-yellow ones, by offset.
    spatial: Vec<[f32; 4]>,
    /// The weights of a Gaussian and of its first and second derivative, by offset.
    feature: Vec<[f32; 3]>,
}

/// A picture after the filters that model the eye.
struct PerceivedPicture {
    /// CIELAB after the filter of contrast sensitivity, with chroma scaled by lightness (Hunt).
    color: Vec<[f32; 3]>,
    /// The strength of edges and of points.
    features: Vec<[f32; 2]>,
}

impl Flip {
    /// Filters the reference, whose values are sRGB-encoded and in [0, 1].
    pub fn new(width: usize, height: usize, reference: &[[f32; 3]], pixels_per_degree: f32) -> Flip {
        let filters = Filters::new(pixels_per_degree);
        let reference = filters.perceive(width, height, reference);
        Flip { width, height, filters, reference }
    }

    /// The error of each pixel.
    pub fn map(&self, picture: &[[f32; 3]]) -> Vec<f32> {
        let perceived = self.filters.perceive(self.width, self.height, picture);
        let most = most_different();
        let color = self.reference.color.iter().zip(&perceived.color).map(|(r, t)| color_error(hyab(*r, *t), most));
        let features = self.reference.features.iter().zip(&perceived.features).map(|(r, t)| {
            let difference = (r[0] - t[0]).abs().max((r[1] - t[1]).abs());
            (difference / 2.0f32.sqrt()).powf(FEATURE_EXPONENT)
        });
        color.zip(features).map(|(c, f)| c.powf(1.0 - f)).collect()
    }

    /// The mean error over the pixels of the mask. `None` where the mask has no pixel.
    pub fn over(&self, picture: &[[f32; 3]], mask: &[bool]) -> Option<f64> {
        super::mean(self.map(picture).into_iter().zip(mask).filter(|(_, m)| **m).map(|(e, _)| f64::from(e)))
    }
}

impl Filters {
    fn new(pixels_per_degree: f32) -> Filters {
        let widest = SENSITIVITY.iter().map(|(_, b)| *b).fold(0.0, f32::max);
        let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        let mut spatial: Vec<[f32; 4]> = (-radius..=radius)
            .map(|x| {
                let degrees = x as f32 * (1.0 / pixels_per_degree);
                let mut weights = SENSITIVITY.map(|(a, b)| (a, b, (-PI * PI * (degrees * degrees) / b).exp()));
                // A sum of two Gaussians is not separable, but each of them is. Each is applied along rows and along
                // columns, so its weights have the root of its factor.
                weights.iter_mut().enumerate().for_each(|(i, w)| {
                    let factor = w.0 * (PI / w.1).sqrt();
                    w.2 *= if i < 2 { factor } else { factor.sqrt() };
                });
                weights.map(|w| w.2)
            })
            .collect();
        let sums = spatial.iter().fold([0.0f32; 4], |s, w| [0, 1, 2, 3].map(|i| s[i] + w[i]));
        let blue_yellow = 1.0 / (sums[2] * sums[2] + sums[3] * sums[3]).sqrt();
        let scale = [1.0 / sums[0], 1.0 / sums[1], blue_yellow, blue_yellow];
        spatial.iter_mut().for_each(|w| *w = [0, 1, 2, 3].map(|i| w[i] * scale[i]));

        let deviation = 0.5 * FEATURE_WIDTH_DEG * pixels_per_degree;
        let radius = (3.0 * deviation).ceil() as i32;
        let mut feature: Vec<[f32; 3]> = (-radius..=radius)
            .map(|x| {
                let x = x as f32;
                let g = (-(x * x) / (2.0 * deviation * deviation)).exp();
                [g, -x * g, (x * x / (deviation * deviation) - 1.0) * g]
            })
            .collect();
        // The Gaussian is scaled to sum to 1. The positive part of each derivative is scaled to sum to 1 and the
        // negative part to sum to −1.
        let sum = |i: usize, positive: bool| -> f32 {
            feature.iter().map(|w| w[i]).filter(|w| (*w > 0.0) == positive).fold(0.0, |s, w| s + w.abs())
        };
        let whole = sum(0, true);
        let parts = [[sum(1, false), sum(1, true)], [sum(2, false), sum(2, true)]];
        for w in &mut feature {
            let part = |i: usize| parts[i - 1][usize::from(w[i] > 0.0)];
            *w = [w[0] / whole, w[1] / part(1), w[2] / part(2)];
        }
        Filters { spatial, feature }
    }

    fn perceive(&self, width: usize, height: usize, picture: &[[f32; 3]]) -> PerceivedPicture {
        assert_eq!(picture.len(), width * height, "pictures of one size");
        let opponent: Vec<[f32; 3]> = picture.iter().map(|c| opponent(c.map(linear))).collect();
        let sideways = along_rows(&opponent, width, &self.spatial, |sum: &mut [f32; 4], w, c| {
            *sum = [sum[0] + w[0] * c[0], sum[1] + w[1] * c[1], sum[2] + w[2] * c[2], sum[3] + w[3] * c[2]];
        });
        let filtered = along_columns(&sideways, width, &self.spatial, |sum: &mut [f32; 4], w, c| {
            *sum = [0, 1, 2, 3].map(|i| sum[i] + w[i] * c[i]);
        });
        let color = filtered
            .into_iter()
            .map(|f| {
                let seen = rgb_from_opponent([f[0], f[1], f[2] + f[3]]).map(|c| c.clamp(0.0, 1.0));
                hunt(lab(xyz(seen)))
            })
            .collect();
        let grey: Vec<f32> = opponent.iter().map(|c| c[0] * (1.0 / 116.0) + 16.0 / 116.0).collect();
        // Along the rows: the first and the second derivative, and the Gaussian.
        let sideways = along_rows(&grey, width, &self.feature, |sum: &mut [f32; 3], w, y| {
            *sum = [sum[0] + w[1] * y, sum[1] + w[2] * y, sum[2] + w[0] * y];
        });
        // Along the columns: first both derivatives across, then both derivatives down.
        let derivatives = along_columns(&sideways, width, &self.feature, |sum: &mut [f32; 4], w, c| {
            *sum = [sum[0] + w[0] * c[0], sum[1] + w[0] * c[1], sum[2] + w[1] * c[2], sum[3] + w[2] * c[2]];
        });
        let features =
            derivatives.into_iter().map(|d| [(d[0] * d[0] + d[2] * d[2]).sqrt(), (d[1] * d[1] + d[3] * d[3]).sqrt()]);
        PerceivedPicture { color, features: features.collect() }
    }
}

/// Applies a filter along the rows. Beyond a border, the last pixel before it repeats.
fn along_rows<T: Copy, W: Copy, S: Copy + Default>(
    image: &[T],
    width: usize,
    filter: &[W],
    add: impl Fn(&mut S, W, T),
) -> Vec<S> {
    let radius = filter.len() / 2;
    let mut out = Vec::with_capacity(image.len());
    for row in image.chunks_exact(width) {
        for x in 0..width {
            let mut sum = S::default();
            for (k, weight) in filter.iter().enumerate() {
                add(&mut sum, *weight, row[(x + k).saturating_sub(radius).min(width - 1)]);
            }
            out.push(sum);
        }
    }
    out
}

/// Applies a filter along the columns. Beyond a border, the last pixel before it repeats.
fn along_columns<T: Copy, W: Copy, S: Copy + Default>(
    image: &[T],
    width: usize,
    filter: &[W],
    add: impl Fn(&mut S, W, T),
) -> Vec<S> {
    let (radius, height) = (filter.len() / 2, image.len() / width.max(1));
    let mut out = vec![S::default(); image.len()];
    for (y, line) in out.chunks_exact_mut(width).enumerate() {
        for (k, weight) in filter.iter().enumerate() {
            let from = (y + k).saturating_sub(radius).min(height - 1) * width;
            for (sum, value) in line.iter_mut().zip(&image[from..from + width]) {
                add(sum, *weight, *value);
            }
        }
    }
    out
}

fn linear(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

fn xyz([r, g, b]: [f32; 3]) -> [f32; 3] {
    const D: f32 = 73_733_382.0;
    [
        10_135_552.0 / 24_577_794.0 * r + 8_788_810.0 / 24_577_794.0 * g + 4_435_075.0 / 24_577_794.0 * b,
        2_613_072.0 / 12_288_897.0 * r + 8_788_810.0 / 12_288_897.0 * g + 887_015.0 / 12_288_897.0 * b,
        1_425_312.0 / D * r + 8_788_810.0 / D * g + 70_074_185.0 / D * b,
    ]
}

/// The colour in YCxCz, the opponent space of the filters.
fn opponent(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = xyz(rgb);
    let [x, y, z] = [x * PER_WHITE[0], y * PER_WHITE[1], z * PER_WHITE[2]];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn rgb_from_opponent([l, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (l + 16.0) / 116.0;
    let (x, z) = ((y + cx / 500.0) * WHITE[0], (y - cz / 200.0) * WHITE[2]);
    [
        3.241_003_3 * x + -1.537_398_9 * y + -0.498_615_86 * z,
        -0.969_224_33 * x + 1.875_930_1 * y + 0.041_554_224 * z,
        0.055_639_423 * x + -0.204_011_2 * y + 1.057_148_9 * z,
    ]
}

fn lab([x, y, z]: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let root = |t: f32| {
        if t > DELTA * DELTA * DELTA { t.powf(1.0 / 3.0) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z] = [x * PER_WHITE[0], y * PER_WHITE[1], z * PER_WHITE[2]].map(root);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Hunt's effect: chroma is scaled by lightness, so that it counts less where it is dark.
fn hunt([l, a, b]: [f32; 3]) -> [f32; 3] {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// The HyAB distance, raised to q_c: city-block distance between lightness and chroma, Euclidean within chroma.
fn hyab(r: [f32; 3], t: [f32; 3]) -> f32 {
    let chroma = ((r[1] - t[1]) * (r[1] - t[1]) + (r[2] - t[2]) * (r[2] - t[2])).sqrt();
    ((r[0] - t[0]).abs() + chroma).powf(COLOR_EXPONENT)
}

/// The distance between the two most different colours of sRGB, green and blue.
fn most_different() -> f32 {
    hyab(hunt(lab(xyz([0.0, 1.0, 0.0]))), hunt(lab(xyz([0.0, 0.0, 1.0]))))
}

/// Maps a colour difference to [0, 1]. Differences up to the knee take up most of that range.
fn color_error(difference: f32, most: f32) -> f32 {
    let knee = COLOR_KNEE * most;
    match difference < knee {
        true => difference * (KNEE_VALUE / knee),
        false => KNEE_VALUE + (difference - knee) / (most - knee) * (1.0 - KNEE_VALUE),
    }
}
