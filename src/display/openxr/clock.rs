//! Converts between the runtime's clock and the session's.

use std::time::Instant;

/// Converts `XrTime` to the session clock. Both count nanoseconds and differ only in their zero.
#[derive(Debug, Clone)]
pub(super) struct Clock {
    /// `XrTime` of the session clock's `start_ns`.
    zero_xr: i64,
    start_ns: u64,
    /// This machine's clock at that moment, for runtimes that cannot be asked the time.
    zero: Instant,
}

impl Clock {
    /// Starts the session clock, which reads `start_ns` now. `now_xr` is the runtime's time now. Where that cannot be
    /// asked, the last predicted display time stands for it, and inputs are logged early by about the length of that
    /// prediction.
    pub fn start(start_ns: u64, now_xr: i64) -> Clock {
        Clock { zero_xr: now_xr, start_ns, zero: Instant::now() }
    }

    /// The session clock at one of the runtime's times.
    pub fn at_ns(&self, xr: i64) -> u64 {
        self.start_ns.saturating_add_signed(xr - self.zero_xr)
    }

    /// The session clock now.
    pub fn now_ns(&self, now_xr: Option<i64>) -> u64 {
        match now_xr {
            Some(xr) => self.at_ns(xr),
            None => self.start_ns + self.zero.elapsed().as_nanos() as u64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Clock;

    #[test]
    fn a_resumed_session_goes_on_where_the_journal_ended() {
        let clock = Clock::start(5_000, 1_000_000);
        assert_eq!(clock.at_ns(1_000_000), 5_000);
        assert_eq!(clock.at_ns(1_000_011), 5_011);
        assert_eq!(clock.at_ns(0), 0);
        assert_eq!(clock.now_ns(Some(1_000_100)), 5_100);
        assert!(clock.now_ns(None) >= 5_000);
    }
}
