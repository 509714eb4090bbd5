//! The display test in a headset.

use std::time::Instant;

use super::shared::{self, DisplayTestResult, FLICKER, GROUND, WHICH_WORD};
use crate::console::{Console, check_interrupted};
use crate::display::content::Content;
use crate::display::intervals::Intervals;
use crate::display::openxr::{HeadsetInput, StandaloneHeadset};
use crate::display::panel::{Corner, Note, Panel, View};
use crate::gpu::Image;
use crate::study::protocol::{Input, Screen};

struct Test {
    words: Image,
    is_new: bool,
    panel: Panel,
    px: (u32, u32),
    headset: StandaloneHeadset,
}

/// Runs the whole test.
///
/// # Errors
/// No headset, or one that went away.
pub fn test(seconds: f64, is_unattended: bool, console: &Console) -> anyhow::Result<DisplayTestResult> {
    let headset = StandaloneHeadset::open()?;
    let (px, px_per_degree) = headset.page_px();
    let panel = Panel::new(headset.gpu(), px_per_degree, None, false)?;
    let words = panel.image(px.0, px.1)?;
    let mut test = Test { words, is_new: false, panel, px, headset };
    let intervals = test.measure(seconds)?;
    let (mut eyes_right, mut depth_right) = (None, None);
    if !is_unattended {
        console.note("answers: the stick and the trigger, or typed with Enter: 1 left, 2 right; then 1 to 4");
        eyes_right = Some(test.ask_eyes(console)?);
        depth_right = Some(shared::ask_depth(console, |content, at| test.ask_one(content, at))?);
    }
    test.headset.gpu().check_validation()?;
    let info = test.headset.info();
    Ok(DisplayTestResult {
        display: format!("{} at {:.2} Hz, {}", info.system, info.nominal_hz, info.runtime),
        timing: "the runtime's prediction".to_owned(),
        intervals,
        eyes_right,
        depth_right,
    })
}

impl Test {
    /// Gives the runtime one frame with the words written last; returns its predicted time, and what was done before
    /// it.
    fn frame(&mut self) -> anyhow::Result<(u64, HeadsetInput)> {
        loop {
            check_interrupted()?;
            let Some(frame) = self.headset.wait()? else { continue };
            let (at_ns, acts) = (frame.at_ns, frame.acts.clone());
            self.headset.show_page(frame, &self.words, self.is_new)?;
            self.is_new = false;
            return Ok((at_ns, acts));
        }
    }

    fn write(&mut self, notes: [&[Note]; 2]) -> anyhow::Result<()> {
        self.panel.write(notes, [GROUND, GROUND, GROUND, 1.0], &self.words)?;
        self.is_new = true;
        Ok(())
    }

    fn line(&self, text: &str, down: f32) -> Note {
        let at = [self.px.0 as f32 / 2.0, self.px.1 as f32 * down];
        Note::Text { text: text.to_owned(), at, corner: Corner::Middle, size: 1.0 }
    }

    /// Measures the intervals between frames while a square flickers in the middle of the view, where a photodiode is
    /// held to the lens.
    fn measure(&mut self, seconds: f64) -> anyhow::Result<Option<Intervals>> {
        let hz = self.headset.info().nominal_hz;
        let note = self.line("Measuring. The square is for a photodiode.", 0.25);
        let side = self.px.1 as f32 / 6.0;
        let square = |grey: u8| Note::Bar {
            rect: [(self.px.0 as f32 - side) / 2.0, (self.px.1 as f32 - side) / 2.0, side, side],
            grey,
        };
        let cards = [[note.clone(), square(0)], [note, square(255)]];
        let began = Instant::now();
        let (mut times, mut frame) = (Vec::new(), 0);
        while began.elapsed().as_secs_f64() < seconds {
            if frame % FLICKER == 0 {
                let card = &cards[usize::from(frame / FLICKER % 2 == 1)];
                self.write([card, card])?;
            }
            times.push(self.frame()?.0);
            frame += 1;
        }
        // The first frames are left out, because words are drawn in them.
        Ok(Intervals::of(times.get(5..).unwrap_or_default(), hz))
    }

    /// Shows each eye one of two words; true if the open eye sees its own.
    fn ask_eyes(&mut self, console: &Console) -> anyhow::Result<bool> {
        let question = self.line("Close your right eye. Push the stick towards the word that you see.", 0.3);
        let left = [question.clone(), self.line("left", 0.5)];
        let right = [question, self.line("right", 0.5)];
        self.write([&left, &right])?;
        console.note(WHICH_WORD);
        loop {
            let (_, acts) = self.frame()?;
            let typed = acts.typed.iter().find_map(|i| if let Input::Choose(at) = i { Some(*at) } else { None });
            match (acts.step, typed) {
                (-1, _) | (_, Some(0)) => return Ok(true),
                (1, _) | (_, Some(1)) => return Ok(false),
                _ if acts.typed.contains(&Input::Quit) => anyhow::bail!("the test was given up"),
                _ => {}
            }
        }
    }

    /// Asks for one square: the stick moves the highlight over the four numbers, and the trigger takes one.
    fn ask_one(&mut self, content: &Content, at: usize) -> anyhow::Result<u32> {
        let mut lit: Option<usize> = None;
        let mut drawn = None;
        loop {
            if drawn != Some(lit) {
                let view = View { hover: lit, ..View::of(&Screen::Dots(at)) };
                self.panel.draw(content, &view, &self.words)?;
                (self.is_new, drawn) = (true, Some(lit));
            }
            let (_, acts) = self.frame()?;
            if acts.step != 0 {
                lit = Some(lit.map_or(0, |n| (n as i32 + acts.step).rem_euclid(4) as usize));
            }
            if let Some(chosen) = lit.filter(|_| acts.confirm) {
                return Ok(chosen as u32);
            }
            for input in acts.typed {
                match input {
                    Input::Choose(n) if n < 4 => return Ok(n),
                    Input::Quit => anyhow::bail!("the test was given up"),
                    _ => {}
                }
            }
        }
    }
}
