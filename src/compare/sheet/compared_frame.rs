//! Computes what a row of a sheet shows: a method's pictures, how far they are from the reference, and how far one eye
//! is from the other. A method's [`Frame`] goes into the [`Truth`]; [`ComparedFrame`] and [`Scores`] come out.

use super::canvas::Rect;
use crate::metrics::{Ssim, errors, luminance, mean, tone};
use crate::picture::StereoPicture;

/// Linear radiance of both eyes.
pub struct Frame {
    /// The composite.
    pub composite: StereoPicture,
    /// The outgoing reflection alone.
    pub reflection: StereoPicture,
}

/// The reference of a sheet, with which its rows are compared.
pub struct Truth<'a> {
    pub width: usize,
    pub height: usize,
    exposure: f32,
    /// The composite as sRGB values in [0, 1].
    shown: [Vec<[f32; 3]>; 2],
    reflection: &'a StereoPicture,
    /// SSIM with the tone-mapped reflection. `None`: the picture is smaller than a window.
    ssim: [Option<Ssim>; 2],
    /// Which pixels trace a reflection ray.
    traced: [Vec<bool>; 2],
    /// The pairs, as indices in the left and in the right eye.
    pairs: &'a [[usize; 2]],
    /// The least luminance that a contrast is divided by.
    epsilon: f64,
}

/// A method's frame, and how it compares with the reference.
pub struct ComparedFrame {
    frame: Frame,
    /// The composite as sRGB values in [0, 1].
    pub shown: [Vec<[f32; 3]>; 2],
    /// For each pixel of the left eye with a partner, the contrast between the two: the difference of the luminances of
    /// their reflections over the mean luminance of their composites. Only the reflection is compared, because the
    /// texture of a surface has another disparity than what the surface reflects.
    pub contrast: Vec<Option<f32>>,
    /// For each pixel of the left eye, the mean absolute error of its sRGB values. Where it has a partner, the
    /// partner's error counts as much.
    error: Vec<f32>,
}

/// The scores of a part of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scores {
    /// 1 − SSIM of the tone-mapped reflection by eye, over the windows whose centre is a pixel of the part that traces.
    pub dissimilarity: [Option<f64>; 2],
    /// The relative squared error of the reflection by eye, over the pixels that trace.
    pub rse: [Option<f64>; 2],
    /// The mean of [`ComparedFrame::contrast`] over the part's pairs.
    pub contrast: Option<f64>,
    pub pairs: usize,
}

impl<'a> Truth<'a> {
    pub fn new(
        (composite, reflection): (&'a StereoPicture, &'a StereoPicture),
        traced: [Vec<bool>; 2],
        exposure: f32,
        pairs: &'a [[usize; 2]],
        epsilon: f64,
    ) -> Truth<'a> {
        let (width, height) = (composite.width as usize, composite.height as usize);
        let shown = composite.eyes().map(|eye| tone::displayed(eye, exposure));
        let ssim = reflection.eyes().map(|eye| Ssim::new(width, height, &tone::displayed(eye, exposure)));
        Truth { width, height, exposure, shown, reflection, ssim, traced, pairs, epsilon }
    }

    pub fn compare(&self, frame: Frame) -> ComparedFrame {
        let shown = frame.composite.eyes().map(|eye| tone::displayed(eye, self.exposure));
        let mut error: Vec<f32> = (0..self.width * self.height).map(|i| self.pixel_error(&shown, 0, i)).collect();
        let mut contrast = vec![None; error.len()];
        for &[left, right] in self.pairs {
            let pair = |picture: &StereoPicture| [(0, left), (1, right)].map(|(e, i)| luminance(picture.eyes[e][i]));
            let ([l, r], seen) = (pair(&frame.reflection), pair(&frame.composite));
            contrast[left] = Some(((l - r).abs() / ((seen[0] + seen[1]) / 2.0).max(self.epsilon)) as f32);
            error[left] = (error[left] + self.pixel_error(&shown, 1, right)) / 2.0;
        }
        ComparedFrame { frame, shown, contrast, error }
    }

    fn pixel_error(&self, shown: &[Vec<[f32; 3]>; 2], eye: usize, at: usize) -> f32 {
        shown[eye][at].iter().zip(self.shown[eye][at]).map(|(x, y)| (x - y).abs()).sum::<f32>() / 3.0
    }

    /// The scores of a part in the left eye and of its counterpart in the right eye.
    pub fn scores(&self, compared: &ComparedFrame, parts: [Rect; 2]) -> Scores {
        let of = |eye: usize| {
            let mask: Vec<bool> = self.mask(parts[eye]).iter().zip(&self.traced[eye]).map(|(m, t)| *m && *t).collect();
            let reflection = &compared.frame.reflection.eyes[eye];
            let shown = tone::displayed(reflection, self.exposure);
            let ssim = self.ssim[eye].as_ref().and_then(|s| s.over(&shown, &mask));
            (ssim.map(|s| 1.0 - s), errors(reflection, &self.reflection.eyes[eye], &mask).and_then(|e| e.rse))
        };
        let eyes = [of(0), of(1)];
        let mask = self.mask(parts[0]);
        let known = || compared.contrast.iter().zip(&mask).filter(|(_, m)| **m).filter_map(|(c, _)| *c);
        Scores {
            dissimilarity: eyes.map(|e| e.0),
            rse: eyes.map(|e| e.1),
            contrast: mean(known().map(f64::from)),
            pairs: known().count(),
        }
    }

    fn mask(&self, part: Rect) -> Vec<bool> {
        let (columns, rows) = (part.x..part.x + part.width, part.y..part.y + part.height);
        (0..self.width * self.height)
            .map(|i| columns.contains(&(i % self.width)) && rows.contains(&(i / self.width)))
            .collect()
    }

    /// The counterpart of a part of the left eye in the right eye. It is moved by the median disparity of the part's
    /// pairs, and stays at least `margin` away from the border.
    pub fn counterpart(&self, part: Rect, margin: usize) -> Rect {
        let mask = self.mask(part);
        let inside = || self.pairs.iter().filter(|pair| mask[pair[0]]);
        let median = |along: &dyn Fn(usize) -> usize| {
            let mut moves: Vec<isize> = inside().map(|p| along(p[1]) as isize - along(p[0]) as isize).collect();
            moves.sort_unstable();
            moves.get(moves.len() / 2).copied().unwrap_or(0)
        };
        let moved = |from: usize, by: isize, side: usize, whole: usize| {
            from.saturating_add_signed(by).clamp(margin, (whole - margin).saturating_sub(side).max(margin))
        };
        let (dx, dy) = (median(&|i| i % self.width), median(&|i| i / self.width));
        let (x, y) = (moved(part.x, dx, part.width, self.width), moved(part.y, dy, part.height, self.height));
        Rect { x, y, ..part }
    }
}

impl ComparedFrame {
    /// How much better another frame is at each pixel of the left eye: by how much less the eyes differ (contrast, at
    /// most 1), plus by how much it is nearer to the reference (sRGB values).
    pub fn change_to(&self, other: &ComparedFrame) -> Vec<f32> {
        let contrast = |c: Option<f32>| c.unwrap_or(0.0).min(1.0);
        let contrasts = self.contrast.iter().zip(&other.contrast).map(|(a, b)| contrast(*a) - contrast(*b));
        contrasts.zip(self.error.iter().zip(&other.error)).map(|(c, (a, b))| c + a - b).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const W: usize = 24;
    const H: usize = 16;

    /// A frame that shows only reflection. The right eye's is `right` times as bright as the left eye's would be.
    fn frame(right: f32) -> Frame {
        let texture = |scale: f32| (0..W * H).map(|i| [scale * (0.2 + 0.1 * (i % W % 7) as f32); 3]).collect();
        let picture = StereoPicture { width: W as u32, height: H as u32, eyes: [texture(1.0), texture(right)] };
        Frame { composite: picture.clone(), reflection: picture }
    }

    #[test]
    fn equal_pictures_score_nothing_and_a_darker_eye_its_contrast() {
        let pairs: Vec<[usize; 2]> = (0..W * H).filter(|i| i % W >= 7).map(|i| [i, i - 7]).collect();
        let reference = frame(1.0);
        let pictures = (&reference.composite, &reference.reflection);
        let truth = Truth::new(pictures, [(); 2].map(|()| vec![true; W * H]), 1.0, &pairs, 1e-3);
        let part = Rect { x: 8, y: 4, width: 8, height: 8 };
        let other = truth.counterpart(part, 1);
        assert_eq!(other, Rect { x: 1, ..part });
        let same = truth.scores(&truth.compare(frame(1.0)), [part, other]);
        assert!(same.dissimilarity.iter().flatten().all(|d| d.abs() < 1e-12) && same.rse == [Some(0.0); 2]);
        assert_eq!((same.contrast, same.pairs), (Some(0.0), 64));
        // |1 − 0.5| / 0.75
        let dark = truth.compare(frame(0.5));
        let scores = truth.scores(&dark, [part, other]);
        assert!((scores.contrast.expect("pairs") - 2.0 / 3.0).abs() < 1e-6);
        assert!(scores.rse[0] == Some(0.0) && scores.rse[1] > Some(0.1));
        let change = dark.change_to(&truth.compare(frame(1.0)));
        assert_eq!(change[0], 0.0, "no partner and no error");
        assert!(change[part.y * W + part.x] > 0.66);
    }
}
