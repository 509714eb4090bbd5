//! The desktop display: a window with two eyes' pictures side by side, crossed or in red and cyan; answers by keys,
//! mouse and joystick.

mod compose;
mod joystick;
mod keys;
mod options;
mod pacer;
mod shell;
mod stage;
mod stills;
mod words;

use std::collections::VecDeque;

use cyclopean_analysis::journal::record::{self, Shown, Trust};
use cyclopean_analysis::{escape, terminal};

use super::content::Content;
use super::panel::View;
use super::{Display, DisplayError, DisplayInfo, StimulusFiles, TimedEvent};
use crate::gpu::Image;
use crate::study::protocol::{Event, Input, Screen};

pub use compose::{Composer, Composition, Picture, fit};
pub use options::{DesktopOptions, Mode};
pub use pacer::Pacer;
pub use shell::{MonitorInfo, ShellError, ShellEvent, monitors};
pub use stage::{Rate, Stage, StageError};

use joystick::{GamepadInput, Joysticks};
use keys::{KeyContext, KeyEffect};
use words::WordImages;

const DISPLAY: &str = "desktop";

/// See the module's documentation. Fields are dropped in this order, so owners come last.
pub struct Desktop {
    options: DesktopOptions,
    info: DisplayInfo,
    content: Option<Content>,
    /// Uploaded pictures, by stimulus and frame.
    stills: Vec<Vec<Image>>,
    word_images: Option<WordImages>,
    /// The view that is in the window now.
    shown: Option<View>,
    screen: Screen,
    hover: Option<usize>,
    /// Time at which the panel on the screen was opened.
    panel_since_ns: u64,
    pending: VecDeque<Event>,
    joysticks: Joysticks,
    frame_is_due: bool,
    hz_reported: f64,
    stage: Stage,
}

impl Desktop {
    /// Opens the window.
    ///
    /// # Errors
    /// [`StageError`] naming what is missing.
    pub fn open(options: DesktopOptions) -> Result<Desktop, StageError> {
        let stage = Stage::open(&options)?;
        let info = information(&options, &stage);
        Ok(Desktop {
            hz_reported: info.nominal_hz,
            options,
            info,
            content: None,
            stills: Vec::new(),
            word_images: None,
            shown: None,
            screen: Screen::Blank,
            hover: None,
            panel_since_ns: 0,
            pending: VecDeque::new(),
            joysticks: Joysticks::default(),
            frame_is_due: false,
            stage,
        })
    }

    /// Sets the content to show from now on, and the time at which the session's clock goes on.
    ///
    /// # Errors
    /// The words cannot be drawn.
    pub fn begin(&mut self, content: Content, start_ns: u64) -> Result<(), DisplayError> {
        self.word_images = Some(WordImages::new(self.stage.gpu(), &content, &self.options).map_err(failed)?);
        self.content = Some(content);
        self.stage.start_clock(start_ns);
        Ok(())
    }

    fn handle(&mut self, event: ShellEvent) {
        let (Some(content), Some(word_images)) = (&self.content, &self.word_images) else { return };
        let context =
            KeyContext { screen: &self.screen, content, targets: &word_images.drawn().targets, mark: self.hover };
        let effect = match event {
            ShellEvent::Key { is_repeat: true, .. } => None,
            ShellEvent::Key { key, modifiers, .. } => context.effect(&key, modifiers),
            ShellEvent::Pointer(at) => {
                let size = self.stage.size().unwrap_or((1, 1));
                self.hover = word_images.drawn().at(self.options.mode.place(at, size));
                None
            }
            ShellEvent::Click => self.hover.and_then(|mark| word_images.drawn().input(mark)).map(KeyEffect::Input),
            ShellEvent::Focus(has) => {
                self.pending.push_back(Event::Focus(has));
                None
            }
            ShellEvent::Visible(is) => {
                self.pending.push_back(Event::Visible(is));
                None
            }
            ShellEvent::Resized => {
                self.shown = None;
                None
            }
            ShellEvent::Close => Some(KeyEffect::Input(Input::Quit)),
            ShellEvent::KeyUp(_) | ShellEvent::Release | ShellEvent::Moved(_) | ShellEvent::Gone => None,
        };
        self.apply(effect);
    }

    /// Takes the gamepads' events: a stick moves the choice, its first button confirms, its start button pauses.
    fn look_at_joysticks(&mut self) {
        for moved in self.joysticks.take() {
            let (Some(content), Some(word_images)) = (&self.content, &self.word_images) else { return };
            let context =
                KeyContext { screen: &self.screen, content, targets: &word_images.drawn().targets, mark: self.hover };
            let effect = match moved {
                GamepadInput::Step(by) => context.step(by),
                GamepadInput::Press => context.press(),
                GamepadInput::Pause => context.pause(),
            };
            self.apply(effect);
        }
    }

    fn apply(&mut self, effect: Option<KeyEffect>) {
        match effect {
            Some(KeyEffect::Input(input)) => self.pending.push_back(Event::Input(input)),
            Some(KeyEffect::Mark(target)) => self.hover = Some(target),
            None => {}
        }
    }

    /// Composes every kind of picture once. Drivers compile a shader when it first runs, and that must not happen in a
    /// trial.
    fn warm_up(&mut self) -> Result<(), DisplayError> {
        let Some(content) = &self.content else { return Ok(()) };
        let shows = if content.has_letters { &[Shown::A, Shown::B][..] } else { &[Shown::Stimulus] };
        let reference = content.is_mirrored_pair.then_some(0);
        let stimulus =
            |&show: &Shown| Screen::Stimulus { presentation: 0, attempt: 0, show, stimulus: 0, reference, frame: 0 };
        let mut screens: Vec<Screen> =
            if self.stills.is_empty() { Vec::new() } else { shows.iter().map(stimulus).collect() };
        screens.push(Screen::Blank);
        let screen = self.screen.clone();
        for warm in screens {
            self.screen = warm;
            self.compose()?;
        }
        (self.screen, self.shown) = (screen, None);
        Ok(())
    }

    /// Composes the window's picture if it differs from the one shown.
    fn compose(&mut self) -> Result<(), DisplayError> {
        let (Some(content), Some(word_images), Some(size)) = (&self.content, &mut self.word_images, self.stage.size())
        else {
            return Ok(());
        };
        let mut view = View { hover: self.hover, ..View::of(&self.screen) };
        if let Screen::Panel { reminder: true, .. } = self.screen {
            let open_s = self.stage.now_ns().saturating_sub(self.panel_since_ns) as f64 / 1e9;
            view.time_left_s = Some(content.time_left_s(open_s));
        }
        if self.shown.as_ref() == Some(&view) {
            return Ok(());
        }
        let eye_view = self.options.mode.view(size);
        let words = word_images.draw(content, &view, eye_view).map_err(failed)?;
        let (picture, shape) = match self.screen {
            Screen::Stimulus { presentation, stimulus, reference, frame, .. } => {
                let eye = content.presentations.get(presentation as usize).map_or(0, |p| p.eye);
                let still = |at: u32| {
                    let what = format!("frame {frame} of stimulus {at} was never loaded");
                    let frames = self.stills.get(at as usize);
                    frames.and_then(|f| f.get(frame as usize)).ok_or(DisplayError { display: DISPLAY, what })
                };
                let test = still(stimulus)?;
                let (width, height) = test.extent();
                match reference {
                    None => (Picture::Stereo { image: test, is_encoded: false }, (width, height)),
                    Some(at) => (Picture::Pair { reference: still(at)?, test, eye }, (2 * width, height)),
                }
            }
            _ => (Picture::None, (1, 1)),
        };
        let most = (content.quad_deg * f64::from(self.options.px_per_degree)) as u32;
        let place = fit(eye_view, shape, most.max(16), WordImages::letter_px(content, &self.options));
        let is_stimulus = matches!(self.screen, Screen::Stimulus { .. });
        let parts = Composition {
            mode: self.options.mode,
            picture,
            place,
            words,
            apart_px: self.options.apart_px,
            ground: content.blank.linear(),
            patch: self.options.patch.then_some(if is_stimulus { 1.0 } else { 0.0 }),
        };
        self.stage.compose(&parts).map_err(lost)?;
        let points =
            !word_images.drawn().targets.is_empty() && !matches!(self.options.mode, Mode::SideBySide | Mode::Crossed);
        self.stage.show_pointer(points);
        self.shown = Some(view);
        Ok(())
    }
}

impl Display for Desktop {
    fn info(&self) -> &DisplayInfo {
        &self.info
    }

    fn load(&mut self, stimuli: &[StimulusFiles]) -> Result<(), DisplayError> {
        self.stills = stills::load(self.stage.gpu(), stimuli, DISPLAY)?;
        self.warm_up()
    }

    fn wait(&mut self, _idle_frames: u64) -> Result<TimedEvent, DisplayError> {
        self.look_at_joysticks();
        loop {
            if let Some(event) = self.pending.pop_front() {
                return Ok(TimedEvent { now_ns: self.stage.now_ns(), event });
            }
            match self.stage.wait().map_err(lost)? {
                Some(event) => self.handle(event),
                None => break,
            }
        }
        if let Some(hz) = self.stage.monitor().and_then(|m| m.hz).filter(|_| self.options.hz.is_none())
            && (hz - self.hz_reported).abs() > 0.5
        {
            self.hz_reported = hz;
            return Ok(TimedEvent { now_ns: self.stage.now_ns(), event: Event::RefreshRate(hz) });
        }
        let (at_ns, rendered) = self.stage.frame();
        self.frame_is_due = true;
        Ok(TimedEvent { now_ns: self.stage.now_ns(), event: Event::Frame { at_ns, rendered } })
    }

    fn present(&mut self, screen: &Screen) -> Result<(), DisplayError> {
        if *screen != self.screen {
            let was_panel = matches!(self.screen, Screen::Panel { .. });
            if matches!(screen, Screen::Panel { .. }) && !was_panel {
                self.panel_since_ns = self.stage.now_ns();
            }
            if !was_panel || !matches!(screen, Screen::Panel { .. }) {
                self.hover = None;
            }
            self.screen = screen.clone();
        }
        if std::mem::take(&mut self.frame_is_due) {
            self.compose()?;
            self.stage.present().map_err(lost)?;
        }
        Ok(())
    }
}

impl Drop for Desktop {
    fn drop(&mut self) {
        // Tests run with validation, and none of its messages must go unnoticed.
        if let Err(error) = self.stage.gpu().check_validation() {
            terminal::say(&format!("error: {}\n", escape::line(&error.to_string())));
        }
    }
}

fn information(options: &DesktopOptions, stage: &Stage) -> DisplayInfo {
    let device = stage.gpu().info();
    let (width_px, height_px) = options.mode.view(stage.size().unwrap_or((1, 1)));
    let rate = stage.rate();
    let monitor = stage.monitor().map_or("unknown monitor".to_owned(), |m| m.name.clone());
    // Pixels of the window for each of an eye's pixels, horizontally.
    let wide = if options.mode == Mode::HalfSideBySide { 2.0 } else { 1.0 };
    DisplayInfo {
        kind: DISPLAY.to_owned(),
        system: format!("{monitor}, {}", options.mode.name()),
        runtime: format!("Vulkan {}, {}", device.vulkan, stage.timing()),
        // The times are predicted even where the system reports presents, because a frame is announced before it is
        // shown.
        trust: Trust::Predicted,
        nominal_hz: rate.nominal_hz,
        measured_hz: rate.measured_hz,
        interval_sd_ms: rate.interval_sd_ms,
        width_px,
        height_px,
        fov_deg: None,
        ipd_m: None,
        arcsec_per_px: wide * 3600.0 / f64::from(options.px_per_degree),
        tracks_head: false,
        device: Some(record::Device {
            gpu: device.name.clone(),
            driver: device.driver.clone(),
            vulkan: device.vulkan.clone(),
        }),
    }
}

fn failed(error: crate::gpu::GpuError) -> DisplayError {
    DisplayError { display: DISPLAY, what: error.to_string() }
}

fn lost(error: StageError) -> DisplayError {
    DisplayError { display: DISPLAY, what: error.to_string() }
}
