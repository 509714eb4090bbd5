//! A window with a graphics device: gives the window's events, presents pictures, and predicts when each frame will be
//! seen.

use std::rc::Rc;
use std::time::{Duration, Instant};

use super::compose::{Composer, Composition};
use super::options::DesktopOptions;
use super::pacer::Pacer;
use super::shell::{MonitorInfo, Shell, ShellError, ShellEvent};
use crate::gpu::{Gpu, GpuError, GpuOptions, Image, OwnDevice, PresentOutcome, Surface, Swapchain, WithSurface};

/// Why a stage cannot be opened, or why it was lost.
#[derive(Debug, thiserror::Error)]
pub enum StageError {
    #[error(transparent)]
    Shell(#[from] ShellError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error("the window was closed from outside")]
    Gone,
    #[error("monitor `{0}` was taken away")]
    MonitorLost(String),
}

/// Refresh rate if neither the monitor nor the operator states one, Hz.
const USUAL_HZ: f64 = 60.0;
/// Usual rates of monitors, Hz. Where a monitor states none, the measured rate is taken for the nearest of these.
const USUAL_RATES: [f64; 13] = [24.0, 30.0, 50.0, 60.0, 72.0, 75.0, 90.0, 100.0, 120.0, 144.0, 165.0, 180.0, 240.0];
/// Frames that warm up the window and measure its rate.
const WARM_UP: usize = 45;

/// The nominal and the measured refresh rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rate {
    pub nominal_hz: f64,
    /// None: presenting does not wait for the monitor, so nothing can be measured.
    pub measured_hz: Option<f64>,
    pub interval_sd_ms: Option<f64>,
}

/// Fields are dropped in this order: what was made with the device goes before it, and the surface before the window.
pub struct Stage {
    picture: Option<Image>,
    composer: Composer,
    chain: Swapchain,
    pacer: Pacer,
    rate: Rate,
    started: Instant,
    start_ns: u64,
    is_visible: bool,
    /// Whether the last frame was announced but not shown.
    was_stale: bool,
    last_queued: Option<u64>,
    last_seen_ns: Option<u64>,
    looked_at_monitor: Instant,
    monitor: Option<MonitorInfo>,
    gpu: Rc<Gpu>,
    shell: Shell,
}

impl Stage {
    /// Opens the window, the device and the swapchain between them, and measures the rate.
    ///
    /// # Errors
    /// [`StageError`] naming what is missing.
    pub fn open(options: &DesktopOptions) -> Result<Stage, StageError> {
        let shell = Shell::open(options)?;
        let (display, window) = shell.handles()?;
        let creator = WithSurface::new(OwnDevice { name: options.device.clone() }, display)?;
        let gpu = Gpu::open(&creator, &GpuOptions::from_environment())?;
        let surface = Surface::new(&gpu, display, window)?;
        let chain = Swapchain::new(surface, creator.waits_for_presents())?;
        let monitor = shell.monitor();
        let said_hz = options.hz.or(monitor.as_ref().and_then(|m| m.hz));
        let nominal_hz = said_hz.unwrap_or(USUAL_HZ);
        let rate = Rate { nominal_hz, measured_hz: None, interval_sd_ms: None };
        let now = Instant::now();
        let mut stage = Stage {
            picture: None,
            composer: Composer::new(&gpu)?,
            chain,
            pacer: Pacer::new(1e9 / nominal_hz, false),
            rate,
            started: now,
            start_ns: 0,
            is_visible: true,
            was_stale: false,
            last_queued: None,
            last_seen_ns: None,
            looked_at_monitor: now,
            monitor,
            gpu,
            shell,
        };
        stage.warm_up(said_hz.is_some())?;
        tracing::info!("{} at {:?}, timed by {}", stage.gpu.info().name, stage.rate, stage.timing());
        Ok(stage)
    }

    /// Presents grey frames as fast as possible. They are what the window shows first, and they measure how long
    /// presenting blocks.
    fn warm_up(&mut self, is_said: bool) -> Result<(), StageError> {
        self.fit()?;
        let mut times = Vec::new();
        let mut tries = 0;
        while times.len() < WARM_UP && tries < 4 * WARM_UP {
            tries += 1;
            self.shell.pump(Duration::ZERO);
            self.fit()?;
            let Some(picture) = &self.picture else { continue };
            match self.chain.present(picture)? {
                PresentOutcome::Queued(_) => times.push(Instant::now()),
                PresentOutcome::Stale => self.picture = None,
            }
        }
        // The first frames only fill the queue.
        let intervals: Vec<f64> = times.windows(2).skip(5).map(|w| (w[1] - w[0]).as_secs_f64() * 1e3).collect();
        if intervals.is_empty() {
            return Ok(());
        }
        let n = intervals.len() as f64;
        let mean = intervals.iter().sum::<f64>() / n;
        let sd = (intervals.iter().map(|i| (i - mean).powi(2)).sum::<f64>() / n).sqrt();
        tracing::info!("presenting takes {mean:.2} ± {sd:.2} ms");
        let is_steady = sd < 0.15 * mean;
        if !is_said && is_steady {
            let near = |hz: &&f64| (1e3 / mean / **hz - 1.0).abs() < 0.02;
            self.rate.nominal_hz = USUAL_RATES.iter().find(near).copied().unwrap_or(USUAL_HZ);
        }
        let nominal_ms = 1e3 / self.rate.nominal_hz;
        // Presenting may wait for the monitor at every picture, every second one and so on. Software that is merely
        // slow has no such rhythm.
        let every = (mean / nominal_ms).round().max(1.0);
        let blocks = is_steady && (mean / nominal_ms / every - 1.0).abs() < 0.04;
        if blocks {
            self.rate.measured_hz = Some(1e3 / mean);
            self.rate.interval_sd_ms = Some(sd);
        }
        let period_ns = if blocks { mean * 1e6 } else { nominal_ms * 1e6 };
        self.pacer = Pacer::new(period_ns, blocks);
        Ok(())
    }

    /// Gives the images the window's size. True: they are new, so everything must be composed again.
    fn fit(&mut self) -> Result<bool, StageError> {
        let Some(size) = self.shell.size() else { return Ok(false) };
        let fits = self.picture.as_ref().is_some_and(|p| p.extent() == size) && self.chain.extent() == Some(size);
        if fits {
            return Ok(false);
        }
        // The old picture may still be on its way to the monitor; `resize` waits for it.
        self.chain.resize(size.0, size.1)?;
        self.last_queued = None;
        self.picture = match self.chain.extent() {
            Some(extent) => Some(self.composer.image(extent)?),
            None => None,
        };
        Ok(true)
    }

    pub fn gpu(&self) -> &Rc<Gpu> {
        &self.gpu
    }

    pub fn rate(&self) -> Rate {
        self.rate
    }

    pub fn monitor(&self) -> Option<&MonitorInfo> {
        self.monitor.as_ref()
    }

    pub fn pacer(&self) -> &Pacer {
        &self.pacer
    }

    /// Describes where the times of display come from.
    pub fn timing(&self) -> &'static str {
        match (self.chain.says_when(), self.pacer.blocks()) {
            (true, _) => "FIFO, corrected by VK_KHR_present_wait",
            (false, true) => "FIFO",
            (false, false) => "a timer: presenting does not wait for the monitor",
        }
    }

    /// Size of the window, pixels; none while it has no area.
    pub fn size(&self) -> Option<(u32, u32)> {
        self.picture.as_ref().map(Image::extent)
    }

    /// Starts the clock at this time, nanoseconds.
    pub fn start_clock(&mut self, start_ns: u64) {
        (self.started, self.start_ns) = (Instant::now(), start_ns);
        self.pacer.reset();
    }

    pub fn now_ns(&self) -> u64 {
        self.start_ns + self.started.elapsed().as_nanos() as u64
    }

    /// Waits for the next event; none when the next frame is due. At `Resized` the images already have the new size.
    ///
    /// # Errors
    /// The window, its monitor or the device is gone.
    pub fn wait(&mut self) -> Result<Option<ShellEvent>, StageError> {
        loop {
            self.shell.pump(Duration::ZERO);
            match self.shell.take() {
                Some(ShellEvent::Gone) => return Err(StageError::Gone),
                Some(ShellEvent::Resized) => {
                    if self.fit()? {
                        return Ok(Some(ShellEvent::Resized));
                    }
                    continue;
                }
                Some(ShellEvent::Visible(is)) => {
                    self.is_visible = is;
                    self.pacer.reset();
                    return Ok(Some(ShellEvent::Visible(is)));
                }
                Some(other) => return Ok(Some(other)),
                None => {}
            }
            if self.looked_at_monitor.elapsed() > Duration::from_secs(1) {
                self.look_at_monitor()?;
            }
            if self.fit()? {
                return Ok(Some(ShellEvent::Resized));
            }
            let (now, wake) = (self.now_ns(), self.pacer.wake_ns());
            let wake = if self.is_visible { wake } else { wake.max(now) };
            if now >= wake {
                return Ok(None);
            }
            let left = Duration::from_nanos(wake - now);
            // The desktop's own waiting is too coarse for the last millisecond.
            if left > Duration::from_millis(2) {
                self.shell.pump(left - Duration::from_millis(1));
            } else {
                std::thread::sleep(left);
            }
        }
    }

    fn look_at_monitor(&mut self) -> Result<(), StageError> {
        self.looked_at_monitor = Instant::now();
        if self.shell.has_lost_its_monitor() {
            let name = self.monitor.as_ref().map_or("?".to_owned(), |m| m.name.clone());
            return Err(StageError::MonitorLost(name));
        }
        self.monitor = self.shell.monitor().or(self.monitor.take());
        Ok(())
    }

    /// The time at which a frame that is begun now will be seen, and whether it can be drawn.
    pub fn frame(&mut self) -> (u64, bool) {
        if let Some(picture) = self.last_queued.take()
            && self.chain.says_when()
            && self.chain.wait_until_shown(picture, Duration::from_millis(100))
        {
            let now = self.now_ns();
            self.pacer.reported(now);
            self.last_seen_ns = Some(now);
        }
        if !self.is_visible {
            // Presenting does not limit the rate of a window that nobody sees, so this waits for a period.
            std::thread::sleep(Duration::from_nanos(self.pacer.period_ns() as u64));
        }
        let rendered = self.is_visible && self.picture.is_some() && !std::mem::take(&mut self.was_stale);
        let now = self.now_ns();
        (self.pacer.next(now), rendered)
    }

    /// # Errors
    /// What Vulkan said.
    pub fn compose(&self, parts: &Composition<'_>) -> Result<(), StageError> {
        match &self.picture {
            Some(picture) => Ok(self.composer.compose(parts, picture)?),
            None => Ok(()),
        }
    }

    /// Presents the picture that was composed last.
    ///
    /// # Errors
    /// The window or the device is gone.
    pub fn present(&mut self) -> Result<(), StageError> {
        if !self.is_visible {
            return Ok(());
        }
        let Some(picture) = &self.picture else {
            self.was_stale = true;
            return Ok(());
        };
        match self.chain.present(picture)? {
            PresentOutcome::Queued(number) => self.last_queued = Some(number),
            PresentOutcome::Stale => self.was_stale = true,
        }
        Ok(())
    }

    /// The time at which the last picture but one was on the monitor; none where the system does not report it.
    pub fn last_seen_ns(&self) -> Option<u64> {
        self.last_seen_ns
    }

    pub fn show_pointer(&self, is_shown: bool) {
        self.shell.show_pointer(is_shown);
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        // The window's picture may still be on its way to the monitor.
        if let Err(error) = self.chain.rest() {
            tracing::warn!("the window did not come to rest: {error}");
        }
    }
}
