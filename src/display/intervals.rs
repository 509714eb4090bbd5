//! The intervals between frames: how regular a display is. `display test` measures them.

use serde::Serialize;

/// Statistics of the times at which frames went out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Intervals {
    pub frames: usize,
    pub nominal_hz: f64,
    /// All intervals are in milliseconds.
    pub mean_ms: f64,
    pub sd_ms: f64,
    pub shortest_ms: f64,
    pub longest_ms: f64,
    /// Missed frames: Σ (round(Δ / period) − 1) over the intervals Δ.
    pub missed: u64,
    /// Lower edge (milliseconds) and count of each bin, a tenth of a period wide.
    pub histogram: Vec<(f64, usize)>,
}

impl Intervals {
    /// Statistics of rising `times_ns`; none for fewer than two frames.
    pub fn of(times_ns: &[u64], nominal_hz: f64) -> Option<Intervals> {
        let intervals: Vec<f64> = times_ns.windows(2).map(|w| w[1].saturating_sub(w[0]) as f64 / 1e6).collect();
        if intervals.is_empty() {
            return None;
        }
        let (n, period) = (intervals.len() as f64, 1e3 / nominal_hz);
        let mean_ms = intervals.iter().sum::<f64>() / n;
        let sd_ms = (intervals.iter().map(|i| (i - mean_ms).powi(2)).sum::<f64>() / n).sqrt();
        let missed = intervals.iter().map(|i| ((i / period).round() as u64).saturating_sub(1)).sum();
        let bin = |ms: f64| (ms / period * 10.0 + 0.5).floor();
        let mut histogram = std::collections::BTreeMap::new();
        for &ms in &intervals {
            *histogram.entry(bin(ms) as i64).or_insert(0) += 1;
        }
        Some(Intervals {
            frames: times_ns.len(),
            nominal_hz,
            mean_ms,
            sd_ms,
            shortest_ms: intervals.iter().copied().fold(f64::INFINITY, f64::min),
            longest_ms: intervals.iter().copied().fold(0.0, f64::max),
            missed,
            histogram: histogram.into_iter().map(|(b, n)| ((b as f64 - 0.5) * period / 10.0, n)).collect(),
        })
    }

    /// The result for people: a line of numbers, and a bar for each bin.
    pub fn lines(&self) -> Vec<String> {
        let most = self.histogram.iter().map(|(_, n)| *n).max().unwrap_or(1);
        let mut lines = vec![format!(
            "{} frames, {:.3} ± {:.3} ms ({:.2} Hz of {:.2}), {:.2} to {:.2} ms, {} missed",
            self.frames,
            self.mean_ms,
            self.sd_ms,
            1e3 / self.mean_ms,
            self.nominal_hz,
            self.shortest_ms,
            self.longest_ms,
            self.missed
        )];
        let width = 100.0 / self.nominal_hz;
        lines.extend(self.histogram.iter().map(|(ms, n)| {
            let bar = "█".repeat((40 * n).div_ceil(most));
            format!("{:7.2} … {:6.2} ms {n:7} {bar}", ms.max(0.0), ms + width)
        }));
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::Intervals;

    #[test]
    fn missed_frames_are_counted_by_whole_periods() {
        let times: Vec<u64> = [0, 10, 20, 50, 60].iter().map(|ms| ms * 1_000_000).collect();
        let i = Intervals::of(&times, 100.0).unwrap();
        assert_eq!((i.frames, i.missed), (5, 2));
        assert_eq!((i.mean_ms, i.shortest_ms, i.longest_ms), (15.0, 10.0, 30.0));
        assert_eq!(i.histogram.iter().map(|(_, n)| n).sum::<usize>(), 4);
        assert!(Intervals::of(&times[..1], 100.0).is_none());
    }
}
