//! Bias and variance of a method over its random seeds, pixel by pixel. `compare` adds each round's frame and then asks
//! for the [`BiasVariance`].
//!
//! Only running means and sums of squares (Welford 1962) are kept, in f64, so that a thousand frames take no more
//! memory than one.

use serde::Serialize;

/// The mean and the spread of each value over the frames that were added. A value is one channel of one pixel.
#[derive(Debug, Clone, Default)]
pub struct Moments {
    frames: u32,
    mean: Vec<f64>,
    /// Σ(x − mean)².
    squares: Vec<f64>,
}

/// The mean squared error, split in two. The sum of `bias2` and `variance` is exactly the mean over the seeds of the
/// MSE.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BiasVariance {
    /// The mean over all values of (mean − reference)² − s²/n. It is an unbiased estimate but for the reference's own
    /// noise, which adds the reference's variance. Chance can make it a little negative.
    pub bias2: f64,
    /// The mean over all values of the sample variance s², with n − 1.
    pub variance: f64,
}

impl Moments {
    /// Adds a frame's values. Every frame must have as many values, and in the same order.
    ///
    /// # Panics
    /// When the frame has more or fewer values than the first one.
    pub fn add(&mut self, frame: impl IntoIterator<Item = f64>) {
        self.frames += 1;
        if self.frames == 1 {
            self.mean.extend(frame);
            self.squares = vec![0.0; self.mean.len()];
            return;
        }
        let n = f64::from(self.frames);
        let mut values = frame.into_iter();
        for (mean, squares) in self.mean.iter_mut().zip(&mut self.squares) {
            let value = values.next().expect("as many values as before");
            let off = value - *mean;
            *mean += off / n;
            *squares += off * (value - *mean);
        }
        assert!(values.next().is_none(), "as many values as before");
    }

    /// The number of frames that were added.
    pub fn frames(&self) -> u32 {
        self.frames
    }

    /// The mean of each value over the frames.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// The variance of each value over the frames, with n − 1. `None` with fewer than two frames.
    pub fn variances(&self) -> Option<impl Iterator<Item = f64>> {
        let free = f64::from(self.frames.saturating_sub(1));
        (self.frames > 1).then(|| self.squares.iter().map(move |s| s / free))
    }

    /// The split of the error against the reference's values. `None` with fewer than two frames or without values.
    pub fn split(&self, reference: impl IntoIterator<Item = f64>) -> Option<BiasVariance> {
        let n = f64::from(self.frames);
        let (mut bias2, mut variance, mut values) = (0.0, 0.0, 0u64);
        for ((mean, s2), y) in self.mean.iter().zip(self.variances()?).zip(reference) {
            bias2 += (mean - y).powi(2) - s2 / n;
            variance += s2;
            values += 1;
        }
        (values > 0).then(|| BiasVariance { bias2: bias2 / values as f64, variance: variance / values as f64 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cyclopean_analysis::chance::Stream;

    #[test]
    fn parts_add_up_to_the_mean_squared_error() {
        let frames = [[1.0, 5.0], [2.0, 7.0], [6.0, 3.0]];
        let reference = [2.0, 4.0];
        let mut moments = Moments::default();
        frames.iter().for_each(|f| moments.add(*f));
        let split = moments.split(reference).expect("three frames");
        let mse: f64 =
            frames.iter().flat_map(|f| f.iter().zip(reference).map(|(x, y)| (x - y).powi(2))).sum::<f64>() / 6.0;
        assert!((split.bias2 + split.variance - mse).abs() < 1e-14);
        // numpy 2.4.6: np.var([[1,5],[2,7],[6,3]], axis=0, ddof=1).mean()
        assert!((split.variance - 5.5).abs() < 1e-14);
        assert!(Moments::default().split(reference).is_none());
    }

    #[test]
    fn bias_is_not_inflated_by_noise() {
        // σ = 1 about the reference + 0.5: bias² 0.25, variance 1, from four frames only.
        let mut stream = Stream::new(7, 1);
        let mut moments = Moments::default();
        (0..4).for_each(|_| moments.add((0..100_000).map(|_| 3.5 + stream.normal()).collect::<Vec<_>>()));
        let split = moments.split(std::iter::repeat_n(3.0, 100_000)).expect("four frames");
        assert!((split.bias2 - 0.25).abs() < 0.01, "{split:?}");
        assert!((split.variance - 1.0).abs() < 0.01, "{split:?}");
    }
}
