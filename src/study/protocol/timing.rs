//! Measures a presentation by its frames: when it was shown, how exactly, and whether it counts.

use cyclopean_analysis::journal::record::{Film, Presentation, Segment as Logged};

use super::setup::{Segment, Setup};

/// Follows one attempt from its first frame to the first frame of what comes after.
#[derive(Debug, Clone)]
pub struct Timing {
    pub segments: Vec<Logged>,
    missed: u64,
    unrendered: u64,
    lost_ns: u64,
    longest_gap_ns: u64,
    rate_changed: bool,
    /// Time of the last frame, and whether it was seen.
    last: Option<(u64, bool)>,
}

impl Timing {
    pub fn new() -> Timing {
        Timing {
            segments: Vec::new(),
            missed: 0,
            unrendered: 0,
            lost_ns: 0,
            longest_gap_ns: 0,
            rate_changed: false,
            last: None,
        }
    }

    pub fn rate_changed(&mut self) {
        self.rate_changed = true;
    }

    /// Begins a segment with its first frame.
    pub fn open(&mut self, segment: Segment, at_ns: u64) {
        self.segments.push(Logged {
            show: segment.show,
            frames_asked: segment.frames,
            frames_shown: 0,
            first_ns: at_ns,
            last_ns: at_ns,
            film_onsets_ns: Vec::new(),
        });
    }

    /// Notes which frame of a film these display frames show; returns whether it is later than the one before.
    pub fn film_frame(&mut self, frame: u32, run: &FrameRun) -> bool {
        let Some(segment) = self.segments.last_mut() else { return false };
        let onsets = &mut segment.film_onsets_ns;
        let is_new = frame as usize >= onsets.len();
        // A frame that the runtime does not draw is not seen, so the film's frame begins with the next drawn display
        // frame.
        if is_new && run.rendered {
            onsets.resize(frame as usize, None);
            onsets.push(Some(run.first_ns));
        }
        is_new
    }

    /// Whether the last frame of this segment's film is on the display.
    pub fn film_is_over(&self, segment: usize, film: Film) -> bool {
        self.segments.get(segment).is_some_and(|s| s.film_onsets_ns.len() >= film.frames as usize)
    }

    /// Adds a run of frames, which begins `steps` nominal periods after the frame before.
    pub fn frames(&mut self, run: FrameRun) {
        self.interval(run.first_ns, run.steps);
        if run.count > 1 {
            let (span, intervals) = (run.last_ns.saturating_sub(run.first_ns), run.count - 1);
            if !run.seen {
                self.lost_ns += span;
            }
            self.longest_gap_ns = self.longest_gap_ns.max(span / intervals);
            self.missed += (run.inner_steps - 1) * intervals;
        }
        if !run.rendered {
            self.unrendered += run.count;
        }
        if let Some(segment) = self.segments.last_mut() {
            segment.frames_shown += run.count;
            segment.last_ns = run.last_ns;
        }
        self.last = Some((run.last_ns, run.seen && run.rendered));
    }

    /// Adds the interval from the last frame to this one. A frame that is not seen counts as lost until the next.
    fn interval(&mut self, at_ns: u64, steps: u64) {
        if let Some((before, seen)) = self.last {
            let gap = at_ns.saturating_sub(before);
            self.longest_gap_ns = self.longest_gap_ns.max(gap);
            self.missed += steps.saturating_sub(1);
            if !seen {
                self.lost_ns += gap;
            }
        }
    }

    /// Ends the attempt with the first frame of what follows; returns the record, with every reason not to count it.
    pub fn finish(mut self, setup: &Setup, key: (u32, u32), end_ns: u64, steps: u64) -> Presentation {
        self.interval(end_ns, steps);
        let ms = |ns: u64| ns as f64 / 1e6;
        let start = self.segments.first().map_or(end_ns, |s| s.first_ns);
        let duration_ms = ms(end_ns.saturating_sub(start));
        let v = &setup.validity;
        let period_ms = setup.period_ns() / 1e6;
        let asked_ms = self.segments.iter().map(|s| s.frames_asked).sum::<u64>() as f64 * period_ms;
        let mut invalid = Vec::new();
        if ms(self.lost_ns) > v.lost_ms {
            invalid.push(format!("not seen for {:.0} ms", ms(self.lost_ns)));
        }
        if ms(self.longest_gap_ns) > v.gap_ms {
            invalid.push(format!("no frame for {:.0} ms", ms(self.longest_gap_ns)));
        }
        if (duration_ms - asked_ms).abs() > asked_ms * v.duration_percent / 100.0 {
            invalid.push(format!("lasted {duration_ms:.1} ms instead of {asked_ms:.1}"));
        }
        let tolerance_ms = (v.toggle_frames * period_ms).max(v.toggle_ms);
        let mut due_ms = 0.0;
        for (i, segment) in self.segments.iter().enumerate() {
            let off_ms = ms(segment.first_ns.saturating_sub(start)) - due_ms;
            if off_ms.abs() > tolerance_ms {
                invalid.push(format!("change {i} was off by {off_ms:.1} ms"));
                break;
            }
            due_ms += segment.frames_asked as f64 * period_ms;
        }
        let (mut due, mut skipped) = (0, 0);
        for segment in &self.segments {
            if let Some(film) = setup.film_of(key.0, segment.show) {
                let frames = setup.film_frame(film, segment.frames_asked.max(1) - 1) as usize + 1;
                due += frames;
                skipped += frames - segment.film_onsets_ns.iter().take(frames).flatten().count();
            }
        }
        if 100.0 * skipped as f64 > v.skipped_percent * due as f64 {
            invalid.push(format!("{skipped} of {due} frames of the moving stimulus were never displayed"));
        }
        if self.rate_changed {
            invalid.push("the refresh rate changed".to_owned());
        }
        Presentation {
            presentation: key.0,
            attempt: key.1,
            segments: self.segments,
            missed: self.missed,
            unrendered: self.unrendered,
            lost_ms: ms(self.lost_ns),
            // Rounded to the microsecond, because of a run of frames only the mean interval is known.
            longest_gap_ms: (self.longest_gap_ns as f64 / 1e3).round() / 1e3,
            duration_ms,
            trust: setup.trust,
            invalid,
        }
    }
}

/// A run of frames at regular intervals.
#[derive(Debug, Clone, Copy)]
pub struct FrameRun {
    pub count: u64,
    pub first_ns: u64,
    pub last_ns: u64,
    /// Nominal periods since the frame before the run.
    pub steps: u64,
    /// Nominal periods between two frames of the run.
    pub inner_steps: u64,
    /// Whether the program had focus and visibility.
    pub seen: bool,
    pub rendered: bool,
}
