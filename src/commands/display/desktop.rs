//! The display test in a window.

use std::time::Instant;

use winit::keyboard::{Key, NamedKey};

use super::shared::{self, DisplayTestResult, FLICKER, GROUND, WHICH_WORD};
use crate::console::{Console, check_interrupted};
use crate::display::content::Content;
use crate::display::desktop::{Composition, DesktopOptions, Picture, ShellEvent, Stage};
use crate::display::intervals::Intervals;
use crate::display::panel::{Corner, Note, Panel, View};
use crate::gpu::Image;
use crate::study::protocol::Screen;

struct Test {
    options: DesktopOptions,
    words: Option<Image>,
    panel: Panel,
    stage: Stage,
}

/// What a picture of the test is made of.
struct TestPicture<'a> {
    notes: [&'a [Note]; 2],
    patch: Option<f32>,
}

/// Runs the whole test.
///
/// # Errors
/// No desktop, a window that was closed, a failing device.
pub fn test(
    options: DesktopOptions,
    seconds: f64,
    is_unattended: bool,
    console: &Console,
) -> anyhow::Result<DisplayTestResult> {
    let stage = Stage::open(&DesktopOptions { title: "cyclopean display test".to_owned(), ..options.clone() })?;
    let panel = Panel::new(stage.gpu(), options.px_per_degree, None, true)?;
    let mut test = Test { words: None, panel, stage, options };
    test.stage.start_clock(0);
    let intervals = test.measure(seconds)?;
    let asks_eyes = !is_unattended && test.options.mode.is_stereo();
    let eyes_right = if asks_eyes { Some(test.ask_eyes(console)?) } else { None };
    let depth_right =
        if asks_eyes { Some(shared::ask_depth(console, |content, at| test.ask_one(content, at))?) } else { None };
    test.stage.gpu().check_validation()?;
    let monitor = test.stage.monitor().map_or("unknown monitor".to_owned(), |m| m.name.clone());
    Ok(DisplayTestResult {
        display: format!("{monitor} at {:.2} Hz, {}", test.stage.rate().nominal_hz, test.options.mode.name()),
        timing: test.stage.timing().to_owned(),
        intervals,
        eyes_right,
        depth_right,
    })
}

impl Test {
    fn view_px(&self) -> (u32, u32) {
        self.options.mode.view(self.stage.size().unwrap_or((64, 64)))
    }

    /// Presents one card in the next frame; returns the keys that were pressed before it.
    fn show(&mut self, picture: &TestPicture<'_>, is_new: bool) -> anyhow::Result<Vec<Key>> {
        let mut keys = Vec::new();
        let mut is_new = is_new;
        loop {
            check_interrupted()?;
            match self.stage.wait()? {
                None => break,
                Some(ShellEvent::Key { key, is_repeat: false, .. }) => keys.push(key),
                Some(ShellEvent::Close) => anyhow::bail!("the window was closed before the test was over"),
                Some(ShellEvent::Resized) => is_new = true,
                Some(_) => {}
            }
        }
        self.stage.frame();
        if is_new {
            let (width, height) = self.view_px();
            let words = match self.words.take().filter(|w| w.extent() == (width, height)) {
                Some(words) => words,
                None => self.panel.image(width, height)?,
            };
            self.panel.write(picture.notes, [GROUND, GROUND, GROUND, 1.0], &words)?;
            self.compose(&words, picture.patch)?;
            self.words = Some(words);
        }
        self.stage.present()?;
        Ok(keys)
    }

    fn compose(&self, words: &Image, patch: Option<f32>) -> anyhow::Result<()> {
        let parts = Composition {
            mode: self.options.mode,
            picture: Picture::None,
            place: [0; 4],
            words,
            apart_px: 0,
            ground: GROUND,
            patch,
        };
        Ok(self.stage.compose(&parts)?)
    }

    fn line(&self, text: &str, up: f32) -> Note {
        let (width, height) = self.view_px();
        let at = [width as f32 / 2.0, height as f32 * up];
        Note::Text { text: text.to_owned(), at, corner: Corner::Middle, size: 1.0 }
    }

    /// Measures the intervals between frames while the square flickers.
    fn measure(&mut self, seconds: f64) -> anyhow::Result<Option<Intervals>> {
        let hz = self.stage.rate().nominal_hz;
        let note = [self.line("Measuring. The square in the corner is for a photodiode.", 0.5)];
        let began = Instant::now();
        let (mut times, mut frame) = (Vec::new(), 0);
        while began.elapsed().as_secs_f64() < seconds {
            let patch = Some(if (frame / FLICKER).is_multiple_of(2) { 0.0 } else { 1.0 });
            self.show(&TestPicture { notes: [&note, &note], patch }, frame.is_multiple_of(FLICKER))?;
            // The time at which the picture was presented; or, if the driver reports it, at which the one before was
            // seen.
            times.push(self.stage.last_seen_ns().unwrap_or_else(|| self.stage.now_ns()));
            frame += 1;
        }
        // The first frames are left out, because words are drawn in them.
        Ok(Intervals::of(times.get(5..).unwrap_or_default(), hz))
    }

    /// Shows each eye one of two words, and asks which one is seen.
    fn ask_eyes(&mut self, console: &Console) -> anyhow::Result<bool> {
        let question = self.line("Close your right eye. Which word do you see? Press L or R.", 0.3);
        let notes = |word: &str, test: &Test| vec![question.clone(), test.line(word, 0.5)];
        let (left, right) = (notes("L  left", self), notes("R  right", self));
        let mut is_new = true;
        console.note(WHICH_WORD);
        loop {
            let keys = self.show(&TestPicture { notes: [&left, &right], patch: None }, is_new)?;
            is_new = false;
            for key in keys {
                match key {
                    Key::Character(c) if c.eq_ignore_ascii_case("l") => return Ok(true),
                    Key::Character(c) if c.eq_ignore_ascii_case("r") => return Ok(false),
                    _ => {}
                }
            }
        }
    }

    fn ask_one(&mut self, content: &Content, at: usize) -> anyhow::Result<u32> {
        let (width, height) = self.view_px();
        let words = self.panel.image(width, height)?;
        self.panel.draw(content, &View::of(&Screen::Dots(at)), &words)?;
        self.compose(&words, None)?;
        loop {
            for key in self.show(&TestPicture { notes: [&[], &[]], patch: None }, false)? {
                match &key {
                    Key::Character(c) => {
                        if let Ok(n @ 1..=4) = c.parse::<u32>() {
                            return Ok(n - 1);
                        }
                    }
                    Key::Named(NamedKey::Escape) => anyhow::bail!("the test was given up"),
                    _ => {}
                }
            }
        }
    }
}
