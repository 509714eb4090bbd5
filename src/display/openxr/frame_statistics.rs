//! Measures how regular frames are, and how much of a period this program takes.

/// Rates of known headsets, Hz. A runtime that reports 89.97 means 90; phases are counted in nominal frames.
const KNOWN_HZ: [f64; 10] = [60.0, 72.0, 75.0, 80.0, 90.0, 96.0, 100.0, 120.0, 144.0, 160.0];

/// The nominal rate behind a reported one: a known rate within half a percent, else as reported to 0.01 Hz.
pub(super) fn nominal_hz(reported_hz: f64) -> f64 {
    let known = KNOWN_HZ.into_iter().find(|known| (reported_hz / known - 1.0).abs() < 0.005);
    known.unwrap_or((reported_hz * 100.0).round() / 100.0)
}

/// Mean rate, Hz, and standard deviation of the intervals, milliseconds.
pub(super) fn regularity(times_ns: &[i64]) -> Option<(f64, f64)> {
    let (first, last) = (times_ns.first()?, times_ns.last()?);
    let n = times_ns.len() as f64 - 1.0;
    if n < 2.0 || last <= first {
        return None;
    }
    let mean = (last - first) as f64 / n;
    let square: f64 = times_ns.windows(2).map(|w| ((w[1] - w[0]) as f64 - mean).powi(2)).sum();
    Some((1e9 / mean, (square / (n - 1.0)).sqrt() / 1e6))
}

/// Statistics of the frames given to the runtime.
#[derive(Debug, Clone, Default)]
pub struct FrameStatistics {
    /// Frames given to the runtime.
    pub frames: u64,
    /// Frames among them without layers, because `shouldRender` was false or nothing was visible.
    pub empty: u64,
    /// Periods without a frame of this program (Σ round(Δ/period) − 1), by predicted display times.
    pub missed: u64,
    /// Missed periods during which a picture of the study was shown.
    pub missed_in_stimuli: u64,
    /// Missed periods in stimuli that this program caused: its part of the frame before (from the end of waiting to the
    /// end of `xrEndFrame`) took longer than a period. (A slow device may miss one while it draws words, but nothing is
    /// timed then.)
    pub missed_by_us: u64,
    /// From `xrBeginFrame`'s return to the call of `xrEndFrame`, as a share of the period.
    shares: Vec<f32>,
    last: Option<LastFrame>,
}

#[derive(Debug, Clone, Copy)]
struct LastFrame {
    at_ns: i64,
    busy_ns: u64,
    is_stimulus: bool,
}

/// One frame that was given to the runtime.
#[derive(Debug, Clone, Copy)]
pub(super) struct SubmittedFrame {
    /// Predicted display time, on the runtime's clock.
    pub at_ns: i64,
    pub period_ns: i64,
    /// From `xrBeginFrame`'s return to the call of `xrEndFrame`.
    pub drawing_ns: u64,
    /// From `xrWaitFrame`'s return to that of `xrEndFrame`; this includes the session's work.
    pub busy_ns: u64,
    pub is_empty: bool,
    /// Whether the frame shows a picture of the study.
    pub is_stimulus: bool,
}

impl FrameStatistics {
    pub(super) fn add(&mut self, frame: SubmittedFrame) {
        let period = frame.period_ns.max(1);
        self.frames += 1;
        self.empty += u64::from(frame.is_empty);
        self.shares.push(frame.drawing_ns as f32 / period as f32);
        if let Some(last) = self.last {
            let steps = (frame.at_ns - last.at_ns + period / 2) / period;
            let missed = (steps - 1).max(0) as u64;
            self.missed += missed;
            if last.is_stimulus {
                self.missed_in_stimuli += missed;
                self.missed_by_us += if last.busy_ns > period as u64 { missed } else { 0 };
            }
        }
        let SubmittedFrame { at_ns, busy_ns, is_stimulus, .. } = frame;
        self.last = Some(LastFrame { at_ns, busy_ns, is_stimulus });
    }

    /// Starts anew: the next frame does not follow the last one, because the session stood still.
    pub(super) fn cut(&mut self) {
        self.last = None;
    }

    /// The share of the period within which a `part` of the frames was drawn (0.5: the median; 0.99); none without
    /// frames.
    pub fn share(&self, part: f64) -> Option<f64> {
        let mut sorted = self.shares.clone();
        sorted.sort_by(f32::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        Some(f64::from(sorted[(part * last as f64).round() as usize]))
    }

    /// The statistics in one line, for the operator.
    pub fn sentence(&self) -> String {
        let percent = |part| self.share(part).map_or(0.0, |s| 100.0 * s);
        format!(
            "frames: {} given to the runtime, {} of them empty; {} missed, {} of them under a stimulus, {} by us; drawing took {:.2} % of the period (median), {:.2} % (99 of 100)",
            self.frames,
            self.empty,
            self.missed,
            self.missed_in_stimuli,
            self.missed_by_us,
            percent(0.5),
            percent(0.99)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_become_nominal_ones() {
        assert_eq!(nominal_hz(89.97), 90.0);
        assert_eq!(nominal_hz(1e9 / 11_111_111.0), 90.0);
        assert_eq!(nominal_hz(59.94), 60.0);
        assert_eq!(nominal_hz(50.0), 50.0);
        assert_eq!(nominal_hz(133.333_33), 133.33);
    }

    #[test]
    fn misses_are_counted_and_ours_told_apart() {
        let mut statistics = FrameStatistics::default();
        let frame = |at_ns, busy_ns| SubmittedFrame {
            at_ns,
            period_ns: 10,
            drawing_ns: 1,
            busy_ns,
            is_empty: false,
            is_stimulus: at_ns != 30,
        };
        for given in [frame(0, 2), frame(10, 2), frame(30, 25), frame(51, 2), frame(60, 25), frame(80, 2)] {
            statistics.add(given);
        }
        assert_eq!(
            (statistics.frames, statistics.missed, statistics.missed_in_stimuli, statistics.missed_by_us),
            (6, 3, 2, 1)
        );
        assert!((statistics.share(0.5).unwrap() - 0.1).abs() < 1e-6);
        let (hz, sd) = regularity(&[0, 10_000_000, 20_000_000, 30_000_000]).unwrap();
        assert!((hz - 100.0).abs() < 1e-9 && sd < 1e-9);
        assert!(regularity(&[0, 10]).is_none());
    }
}
