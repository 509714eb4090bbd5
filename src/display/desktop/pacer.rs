//! Predicts when the next frame will be displayed: on a steady grid of times, corrected by how presenting blocks.

/// Predicts display times on the session's clock.
#[derive(Debug, Clone)]
pub struct Pacer {
    period_ns: f64,
    /// Whether presenting blocks until the monitor takes a picture; otherwise a timer keeps the rate.
    blocks: bool,
    last_ns: Option<f64>,
}

/// Share of an observed error by which the grid is moved.
const GAIN: f64 = 0.1;

impl Pacer {
    pub fn new(period_ns: f64, blocks: bool) -> Pacer {
        Pacer { period_ns, blocks, last_ns: None }
    }

    pub fn period_ns(&self) -> f64 {
        self.period_ns
    }

    pub fn blocks(&self) -> bool {
        self.blocks
    }

    /// The time before which there is nothing to do.
    pub fn wake_ns(&self) -> u64 {
        match self.last_ns {
            // Composing and copying need the rest of the period before the picture is out.
            Some(last) if !self.blocks => (last + 0.75 * self.period_ns) as u64,
            _ => 0,
        }
    }

    /// The display time of a frame that is begun now.
    pub fn next(&mut self, now_ns: u64) -> u64 {
        let earliest = now_ns as f64 + if self.blocks { self.period_ns } else { 0.0 };
        let at = match self.last_ns {
            None => earliest.max(now_ns as f64),
            Some(last) => {
                // A whole number of periods after the last frame; late work gets a later one.
                let steps = if self.blocks {
                    ((earliest - last) / self.period_ns).round().max(1.0)
                } else {
                    ((earliest - last) / self.period_ns).ceil().max(1.0)
                };
                let grid = last + steps * self.period_ns;
                let error = if self.blocks { earliest - grid } else { 0.0 };
                grid + (GAIN * error).clamp(-0.1 * self.period_ns, 0.1 * self.period_ns)
            }
        };
        self.last_ns = Some(at);
        at as u64
    }

    /// Corrects the display time of the last frame to the reported one.
    pub fn reported(&mut self, at_ns: u64) {
        self.last_ns = Some(at_ns as f64);
    }

    /// Forgets the grid, because the window was not visible.
    pub fn reset(&mut self) {
        self.last_ns = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jitter_is_smoothed_and_a_late_frame_is_missed_by_whole_periods() {
        let period = 1e9 / 60.0;
        let mut pacer = Pacer::new(period, true);
        let mut last = pacer.next(0);
        for i in 1..600u64 {
            let jitter = if i % 2 == 0 { 2_000_000 } else { 0 };
            let at = pacer.next((i as f64 * period) as u64 + jitter);
            assert!(((at - last) as f64 - period).abs() < 0.25 * period, "frame {i}: {}", at - last);
            last = at;
        }
        let at = pacer.next((603.0 * period) as u64);
        assert_eq!(((at - last) as f64 / period).round(), 4.0);
    }

    #[test]
    fn a_timer_keeps_its_grid() {
        let mut pacer = Pacer::new(10e6, false);
        let first = pacer.next(0);
        assert_eq!(pacer.wake_ns(), first + 7_500_000);
        assert_eq!(pacer.next(first + 8_000_000), first + 10_000_000);
        // The frame is late by one and a half periods, so the next but one is the first that can be shown.
        assert_eq!(pacer.next(first + 25_000_000), first + 30_000_000);
    }
}
