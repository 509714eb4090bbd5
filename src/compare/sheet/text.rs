//! Draws words on a sheet. The text code of egui lays them out and rasterises them, on the processor and without a
//! window.

use std::sync::Arc;

use egui::epaint::FontColorTransferFunction;
use egui::epaint::text::{Fonts, TextOptions};
use egui::{Color32, FontData, FontDefinitions, FontFamily, FontId, Galley};

use super::canvas::{Canvas, Color};

/// The font of the panel. It is part of the program, so that every machine draws the same letters and makes the same
/// bytes.
const FONT: &[u8] = include_bytes!("../../../languages/fonts/NotoSans-Regular.ttf");

/// The font, and its letters that were rasterised so far.
pub struct Typesetter {
    fonts: Fonts,
}

/// Which point of a text is at the given x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    Left,
    Middle,
    Right,
}

impl Typesetter {
    pub fn new() -> Typesetter {
        let mut fonts = FontDefinitions::default();
        fonts.font_data.insert("text".to_owned(), Arc::new(FontData::from_static(FONT)));
        fonts.families.entry(FontFamily::Proportional).or_default().insert(0, "text".to_owned());
        // The text is dark on a light ground.
        let color_transfer_function = FontColorTransferFunction::LIGHT_MODE_DEFAULT;
        Typesetter { fonts: Fonts::new(TextOptions { color_transfer_function, ..TextOptions::default() }, fonts) }
    }

    /// The width of a line of text, pixels.
    pub fn width(&mut self, text: &str, size: f32) -> usize {
        self.laid_out(text, size).size().x.ceil() as usize
    }

    /// Draws a line of text whose top is at y. `size` is in pixels.
    pub fn draw(
        &mut self,
        canvas: &mut Canvas,
        (x, y): (usize, usize),
        (size, align): (f32, Align),
        color: Color,
        text: &str,
    ) {
        let galley = self.laid_out(text, size);
        let width = galley.size().x.ceil() as usize;
        let x = match align {
            Align::Left => x,
            Align::Middle => x.saturating_sub(width / 2),
            Align::Right => x.saturating_sub(width),
        };
        let atlas = self.fonts.texture_atlas().image();
        for row in &galley.rows {
            for glyph in &row.row.glyphs {
                // Glyphs are placed as egui's tessellator does: at whole pixels. Fractions of a pixel are in the
                // glyph's own raster.
                let at = row.pos + (glyph.pos + glyph.uv_rect.offset).to_vec2();
                let (left, top) = (at.x.round() as isize, at.y.round() as isize);
                let [from, to] = [glyph.uv_rect.min, glyph.uv_rect.max].map(|corner| corner.map(usize::from));
                for v in from[1]..to[1] {
                    for u in from[0]..to[0] {
                        let coverage = f32::from(atlas.pixels[v * atlas.size[0] + u].a()) / 255.0;
                        let px = x.checked_add_signed(left + (u - from[0]) as isize);
                        let py = y.checked_add_signed(top + (v - from[1]) as isize);
                        if let (Some(px), Some(py)) = (px, py) {
                            canvas.blend(px, py, color, coverage);
                        }
                    }
                }
            }
        }
    }

    fn laid_out(&mut self, text: &str, size: f32) -> Arc<Galley> {
        let font = FontId::proportional(size);
        self.fonts.with_pixels_per_point(1.0).layout_no_wrap(text.to_owned(), font, Color32::BLACK)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_leave_ink_within_their_width() {
        let mut canvas = Canvas::new(200, 40, [255; 3]);
        let mut letters = Typesetter::new();
        let width = letters.width("1 − SSIM", 15.0);
        letters.draw(&mut canvas, (190, 10), (15.0, Align::Right), [0; 3], "1 − SSIM");
        let dark = |x: usize| (0..40).any(|y| canvas.rgb[3 * (y * 200 + x)] < 128);
        let inked: Vec<usize> = (0..200).filter(|x| dark(*x)).collect();
        let (first, last) = (inked[0], inked[inked.len() - 1]);
        assert!(first >= 188 - width && first <= 192 - width && (186..191).contains(&last), "{first} to {last}");
    }
}
