//! A display that shows nothing: a virtual clock that jumps from deadline to deadline, and an observer who answers.

use std::collections::VecDeque;

use cyclopean_analysis::journal::record::Trust;

use super::{Display, DisplayError, DisplayInfo, StimulusFiles, TimedEvent};
use crate::study::observer::Observer;
use crate::study::protocol::{Event, Input, Screen};

/// Frame k is displayed at start + round(k / rate), and no frame is ever late.
pub struct Headless {
    info: DisplayInfo,
    observer: Box<dyn Observer>,
    start_ns: u64,
    frame: u64,
    now_ns: u64,
    screen: Option<Screen>,
    pending: VecDeque<(u64, Input)>,
    skips: bool,
}

impl Headless {
    /// The information of a headless display of this rate.
    pub fn information(hz: f64) -> DisplayInfo {
        DisplayInfo {
            kind: "headless".to_owned(),
            system: "none".to_owned(),
            runtime: "virtual clock".to_owned(),
            trust: Trust::Virtual,
            nominal_hz: hz,
            measured_hz: None,
            interval_sd_ms: None,
            width_px: 1920,
            height_px: 1080,
            fov_deg: None,
            ipd_m: None,
            arcsec_per_px: 60.0,
            tracks_head: false,
            device: None,
        }
    }

    /// `hz`: nominal and real rate, > 0. `start_ns`: the session clock at the first frame (after the journal's last
    /// time).
    pub fn new(hz: f64, start_ns: u64, observer: Box<dyn Observer>) -> Headless {
        let info = Headless::information(hz);
        let (frame, now_ns, screen, pending) = (0, start_ns, None, VecDeque::new());
        Headless { info, observer, start_ns, frame, now_ns, screen, pending, skips: true }
    }

    /// Sets another nominal rate; the rate given to [`Headless::new`] is then only the real one.
    pub fn with_nominal_hz(mut self, nominal_hz: f64) -> Headless {
        self.info.measured_hz = Some(self.info.nominal_hz);
        self.info.nominal_hz = nominal_hz;
        self
    }

    /// Visits every single frame instead of skipping some; the session is the same, only slower.
    pub fn stepping(mut self) -> Headless {
        self.skips = false;
        self
    }

    /// The session clock of the last event.
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// Whether [`Display::present`] would change what is shown.
    pub fn is_new(&self, screen: &Screen) -> bool {
        // To an observer all frames of a moving stimulus are one screen.
        self.screen.as_ref() != Some(&screen.first_frame())
    }

    fn rate(&self) -> f64 {
        self.info.measured_hz.unwrap_or(self.info.nominal_hz)
    }

    fn frame_ns(&self, frame: u64) -> u64 {
        self.start_ns + (frame as f64 * 1e9 / self.rate()).round() as u64
    }
}

impl Display for Headless {
    fn info(&self) -> &DisplayInfo {
        &self.info
    }

    fn load(&mut self, _stimuli: &[StimulusFiles]) -> Result<(), DisplayError> {
        Ok(())
    }

    fn wait(&mut self, idle_frames: u64) -> Result<TimedEvent, DisplayError> {
        let next_ns = self.frame_ns(self.frame);
        let input_ns = self.pending.front().map(|(at, _)| *at);
        if input_ns.is_some_and(|at| at <= next_ns)
            && let Some((at, input)) = self.pending.pop_front()
        {
            self.now_ns = self.now_ns.max(at);
            return Ok(TimedEvent { now_ns: self.now_ns, event: Event::Input(input) });
        }
        let until_input = match input_ns {
            // The frames before the input. Times are rounded, so the number may have to be raised.
            Some(at) => {
                let mut frames = ((at - self.start_ns) as f64 * self.rate() / 1e9) as u64;
                while self.frame_ns(frames) < at {
                    frames += 1;
                }
                while frames > 0 && self.frame_ns(frames - 1) >= at {
                    frames -= 1;
                }
                frames.saturating_sub(self.frame).max(1)
            }
            None if idle_frames == u64::MAX => {
                let what = "nobody answers, so that the session would stand still for ever".to_owned();
                return Err(DisplayError { display: "headless", what });
            }
            None => u64::MAX,
        };
        let count = if self.skips { idle_frames.min(until_input) } else { 1 };
        let event = if count <= 1 {
            self.frame += 1;
            self.now_ns = next_ns;
            Event::Frame { at_ns: next_ns, rendered: true }
        } else {
            let last_ns = self.frame_ns(self.frame + count - 1);
            self.frame += count;
            self.now_ns = last_ns;
            Event::Frames { count, first_ns: next_ns, last_ns }
        };
        Ok(TimedEvent { now_ns: self.now_ns, event })
    }

    fn present(&mut self, screen: &Screen) -> Result<(), DisplayError> {
        if self.is_new(screen) {
            self.pending.clear();
            let mut at = self.now_ns;
            for (delay_ns, input) in self.observer.respond(screen) {
                at += delay_ns;
                self.pending.push_back((at, input));
            }
            self.screen = Some(screen.first_frame());
        }
        Ok(())
    }
}
