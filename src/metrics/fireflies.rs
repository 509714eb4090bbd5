//! Counts fireflies: single pixels that are far brighter than anything the reference shows near them. Display values of
//! a reference and of a picture go in. `compare` calls it.
//!
//! Rare, very bright samples make the mean squared error change from seed to seed. So they are counted separately.

use super::luminance;

/// A firefly is brighter than the brightest pixel in the reference's neighbourhood by more than this, in display
/// luminance.
pub const EXCESS: f64 = 0.25;

/// How many pixels the neighbourhood reaches to each side. It has 7×7 pixels, or fewer at the picture's border.
pub const REACH: usize = 3;

/// A reference with the limit of every pixel, which is computed once for many pictures.
#[derive(Debug, Clone)]
pub struct Fireflies {
    /// By pixel, the maximum of the reference's neighbourhood plus [`EXCESS`], in display luminance.
    limit: Vec<f64>,
    /// Pixels that count.
    mask: Vec<bool>,
}

impl Fireflies {
    /// `shown` holds the reference's display values ([`super::tone`]) of `width`×`height` pixels, rows from the top.
    ///
    /// # Panics
    /// When the lengths differ from the size.
    pub fn new((width, height): (usize, usize), shown: &[[f32; 3]], mask: Vec<bool>) -> Fireflies {
        assert!(shown.len() == width * height && mask.len() == shown.len(), "one value a pixel");
        let luminances: Vec<f64> = shown.iter().map(|c| luminance(*c)).collect();
        // The maximum over a square is the maximum over its rows, then over its columns.
        let rows = maxima(&luminances, width, |i| (i % width, 1));
        let limit = maxima(&rows, height, |i| (i / width, width)).into_iter().map(|m| m + EXCESS).collect();
        Fireflies { limit, mask }
    }

    /// The number of fireflies among the pixels that count. `shown` holds a picture's display values with the
    /// reference's exposure.
    ///
    /// # Panics
    /// When the length differs from the reference's.
    pub fn count(&self, shown: &[[f32; 3]]) -> u64 {
        assert_eq!(shown.len(), self.limit.len(), "one value a pixel");
        let counted = shown.iter().zip(&self.limit).zip(&self.mask).filter(|(_, m)| **m);
        counted.filter(|((c, limit), _)| luminance(**c) > **limit).count() as u64
    }

    /// A number of fireflies, as a number per million of the pixels that count. `None` where no pixel counts.
    pub fn per_megapixel(&self, count: u64) -> Option<f64> {
        let pixels = self.mask.iter().filter(|m| **m).count();
        (pixels > 0).then(|| count as f64 * 1e6 / pixels as f64)
    }
}

/// For each value, the maximum over it and [`REACH`] neighbours to each side along one axis. The axis has `length`
/// places. `along` gives a value's place on the axis and the step from one place to the next.
fn maxima(values: &[f64], length: usize, along: impl Fn(usize) -> (usize, usize)) -> Vec<f64> {
    let maximum = |i: usize| {
        let (place, step) = along(i);
        let first = i - place.min(REACH) * step;
        let last = i + (length - 1 - place).min(REACH) * step;
        (first..=last).step_by(step).map(|k| values[k]).fold(f64::NEG_INFINITY, f64::max)
    };
    (0..values.len()).map(maximum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (12, 9);
    const PIXELS: usize = SIZE.0 * SIZE.1;

    fn at(x: usize, y: usize) -> usize {
        y * SIZE.0 + x
    }

    #[test]
    fn what_is_bright_beyond_its_neighbourhood_is_counted() {
        let reference = vec![[0.25; 3]; PIXELS];
        let fireflies = Fireflies::new(SIZE, &reference, vec![true; PIXELS]);
        assert_eq!(fireflies.count(&reference), 0);
        // Just below the limit of 0.25 + 0.25 nothing is counted. Just above it pixels are counted, also in the
        // corners.
        let mut picture = reference.clone();
        picture[at(5, 4)] = [0.499; 3];
        assert_eq!(fireflies.count(&picture), 0);
        for corner in [at(0, 0), at(11, 0), at(0, 8), at(11, 8)] {
            picture[corner] = [0.501; 3];
        }
        assert_eq!(fireflies.count(&picture), 4);
        assert!((fireflies.per_megapixel(4).expect("pixels") - 4e6 / PIXELS as f64).abs() < 1e-9);
        // What counts is the luminance, in which blue weighs only 0.0722.
        let blue = vec![[0.25, 0.25, 1.0]; PIXELS];
        assert_eq!(fireflies.count(&blue), 0);
    }

    #[test]
    fn a_light_of_the_reference_excuses_three_pixels_around_it() {
        let mut reference = vec![[0.0; 3]; PIXELS];
        reference[at(4, 4)] = [0.9; 3];
        let fireflies = Fireflies::new(SIZE, &reference, vec![true; PIXELS]);
        // Everything is white. The limit is 1.15 within three pixels of the light in x and y, and 0.25 elsewhere.
        let excused = 7 * 7;
        assert_eq!(fireflies.count(&vec![[1.0; 3]; PIXELS]), (PIXELS - excused) as u64);
        let mut picture = vec![[0.0; 3]; PIXELS];
        (picture[at(7, 7)], picture[at(8, 7)], picture[at(1, 1)], picture[at(0, 1)]) =
            ([1.0; 3], [1.0; 3], [1.0; 3], [1.0; 3]);
        assert_eq!(fireflies.count(&picture), 2, "the second and the fourth lie outside");
        // A light at the end of a row excuses nothing at the beginning of the next row.
        let mut reference = vec![[0.0; 3]; PIXELS];
        reference[at(11, 0)] = [0.9; 3];
        let mut picture = vec![[0.0; 3]; PIXELS];
        picture[at(0, 1)] = [1.0; 3];
        assert_eq!(Fireflies::new(SIZE, &reference, vec![true; PIXELS]).count(&picture), 1);
    }

    #[test]
    fn only_pixels_of_the_mask_count() {
        let mut mask = vec![false; PIXELS];
        mask[at(3, 3)] = true;
        let fireflies = Fireflies::new(SIZE, &vec![[0.0; 3]; PIXELS], mask);
        assert_eq!(fireflies.count(&vec![[1.0; 3]; PIXELS]), 1);
        assert_eq!(fireflies.per_megapixel(1), Some(1e6));
        let none = Fireflies::new(SIZE, &vec![[0.0; 3]; PIXELS], vec![false; PIXELS]);
        assert_eq!((none.count(&vec![[1.0; 3]; PIXELS]), none.per_megapixel(0)), (0, None));
    }
}
