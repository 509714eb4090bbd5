//! Random-dot stereograms: a square in one of four places that can be seen only with both eyes together.
//!
//! The square's dots are *moved* in the right image, and fresh dots fill what they uncover (Julesz 1960). No dot of
//! either image is used twice, so each image alone is independent noise: there is no monocular cue.

use super::protocol::ScreeningTrial;
use super::random::Stream;

/// Both eyes' images: black (0) and white (255) dots, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stereogram {
    /// Number of dots along a side.
    pub size: usize,
    pub left: Vec<u8>,
    pub right: Vec<u8>,
}

/// Centre of the square for an alternative (0 left above, 1 right above, 2 left below, 3 right below), and half its side.
fn place(size: usize, alternative: u32) -> (usize, usize, usize) {
    let at = |far: bool| if far { 3 * size / 4 } else { size / 4 };
    (at(alternative % 2 == 1), at(alternative >= 2), size / 8)
}

impl Stereogram {
    /// The stereogram of a screening trial; a dot is a display pixel. `size` ≥ 16 × disparity keeps the square inside.
    pub fn new(study_seed: u64, row: u64, index: usize, trial: &ScreeningTrial, size: usize) -> Stereogram {
        let stream = Stream::new(study_seed, row, &format!("stereogram {index}"));
        Stereogram::draw(stream, size, trial.disparity_px as usize, trial.shown)
    }

    fn draw(mut stream: Stream, size: usize, disparity_px: usize, alternative: u32) -> Stereogram {
        let mut dot = || if stream.below(2) == 0 { 0 } else { 255 };
        let left: Vec<u8> = (0..size * size).map(|_| dot()).collect();
        let mut right = left.clone();
        let (cx, cy, half) = place(size, alternative);
        let shift = disparity_px.min(cx.saturating_sub(half));
        for y in cy - half..cy + half {
            for x in cx - half..cx + half {
                right[y * size + x - shift] = left[y * size + x];
            }
            for x in cx + half - shift..cx + half {
                right[y * size + x] = dot();
            }
        }
        Stereogram { size, left, right }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: usize = 64;
    const DISPARITY: usize = 2;
    const TRIALS: u64 = 2000;

    /// Share of trials in which the alternative with the highest score is the right one.
    fn share(score: impl Fn(&Stereogram, usize, usize, usize) -> f64) -> f64 {
        let mut right = 0;
        for i in 0..TRIALS {
            let shown = (i % 4) as u32;
            let image = Stereogram::draw(Stream::new(i, 0, "test"), SIZE, DISPARITY, shown);
            let of = |a: &u32| {
                let (cx, cy, half) = place(SIZE, *a);
                score(&image, cx, cy, half)
            };
            let best = (0..4).max_by(|a, b| of(a).total_cmp(&of(b)));
            right += u64::from(best == Some(shown));
        }
        right as f64 / TRIALS as f64
    }

    fn sum(half: usize, cx: usize, cy: usize, f: impl Fn(usize, usize) -> bool) -> f64 {
        let area = (cy - half..cy + half).flat_map(|y| (cx - half..cx + half).map(move |x| (x, y)));
        area.filter(|&(x, y)| f(x, y)).count() as f64
    }

    #[test]
    fn two_eyes_see_the_square() {
        let both = share(|s, cx, cy, half| {
            sum(half, cx, cy, |x, y| s.left[y * SIZE + x] == s.right[y * SIZE + x - DISPARITY])
        });
        assert!(both > 0.99, "{both}");
    }

    #[test]
    fn one_eye_stays_at_chance_whatever_it_looks_for() {
        // The chance rate 0.25 ± 4 standard errors.
        let chance = 0.25 - 0.039..0.25 + 0.039;
        for eye in [|s: &Stereogram| s.left.clone(), |s: &Stereogram| s.right.clone()] {
            for lag in 0..5 {
                let seen = share(|s, cx, cy, half| {
                    let image = eye(s);
                    // Brightness, and dots that repeat at each small distance, also across the left edge of the square.
                    sum(half + 4, cx, cy, |x, y| match lag {
                        0 => image[y * SIZE + x] == 255,
                        lag => image[y * SIZE + x] == image[y * SIZE + x - lag],
                    })
                });
                assert!(chance.contains(&seen), "lag {lag}: {seen}");
            }
        }
    }
}
