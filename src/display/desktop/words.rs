//! All words in the window: what changes is drawn again, what comes back is kept.

use std::rc::Rc;

use cyclopean_analysis::journal::record::Shown;

use super::options::{DesktopOptions, Mode};
use crate::display::content::Content;
use crate::display::panel::{DrawnView, Panel, View, em_px};
use crate::gpu::{Gpu, GpuError, Image};
use crate::study::protocol::Screen;

/// The panel's drawer, with the pictures that it has drawn.
pub(super) struct WordImages {
    /// Pages and panels, drawn again at each change.
    page: Option<Image>,
    /// The words over the blank frame, a stimulus, stimulus A and stimulus B: drawn once, so that a toggle draws
    /// nothing.
    kept: [Option<Image>; 4],
    drawn: DrawnView,
    letter_at: Option<f32>,
    panel: Panel,
}

impl WordImages {
    pub fn new(gpu: &Rc<Gpu>, content: &Content, options: &DesktopOptions) -> Result<WordImages, GpuError> {
        let mut panel = Panel::new(gpu, options.px_per_degree, content.font.as_deref(), true)?;
        if options.mode == Mode::HalfSideBySide {
            // Two columns of an eye's view are one pixel of the monitor.
            panel.set_dot_px(2);
        }
        let letter_at = WordImages::letter_px(content, options);
        let letter_at = (letter_at > 0).then_some(letter_at as f32 / 2.0);
        Ok(WordImages { page: None, kept: [None, None, None, None], drawn: DrawnView::default(), letter_at, panel })
    }

    /// Height that the letters A and B need below a stimulus, pixels; 0 where there are none.
    pub fn letter_px(content: &Content, options: &DesktopOptions) -> u32 {
        if content.has_letters { (2.4 * em_px(options.px_per_degree)) as u32 } else { 0 }
    }

    /// What can be pointed at in the last picture.
    pub fn drawn(&self) -> &DrawnView {
        &self.drawn
    }

    /// Draws the picture of a view, for an eye's view of this size.
    pub fn draw(&mut self, content: &Content, view: &View, size: (u32, u32)) -> Result<&Image, GpuError> {
        if self.page.as_ref().is_none_or(|page| page.extent() != size) {
            self.page = Some(self.panel.image(size.0, size.1)?);
            self.kept = [None, None, None, None];
        }
        let place = match view.screen {
            Screen::Blank => Some(0),
            Screen::Stimulus { show: Shown::A, .. } => Some(2),
            Screen::Stimulus { show: Shown::B, .. } => Some(3),
            Screen::Stimulus { .. } => Some(1),
            _ => None,
        };
        let mut view = view.clone();
        if let Some(up) = self.letter_at {
            view.label_at = Some([size.0 as f32 / 2.0, size.1 as f32 - up]);
        }
        let Some(place) = place else {
            let image = self.page.take().map_or_else(|| self.panel.image(size.0, size.1), Ok)?;
            self.drawn = self.panel.draw(content, &view, &image)?;
            return Ok(self.page.insert(image));
        };
        self.drawn = DrawnView::default();
        let image = match self.kept[place].take() {
            Some(image) => image,
            None => {
                let image = self.panel.image(size.0, size.1)?;
                self.panel.draw(content, &view, &image)?;
                image
            }
        };
        Ok(self.kept[place].insert(image))
    }
}
