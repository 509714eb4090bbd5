//! Words and bars at given places: for operators, and for tests of displays.

use egui::{Align2, Color32, CornerRadius, FontId, Painter, Rect, pos2, vec2};

use super::style::Palette;

/// The point of a note that is placed at its coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Corner {
    UpperLeft,
    LowerLeft,
    Middle,
}

/// A note to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum Note {
    /// Lines of text on a plate; `at`: pixels; `size`: ems.
    Text { text: String, at: [f32; 2], corner: Corner, size: f32 },
    /// A bar: left, top, width, height, pixels; its grey is a display value.
    Bar { rect: [f32; 4], grey: u8 },
}

pub(super) fn draw(painter: &Painter, em: f32, notes: &[Note]) {
    let palette = Palette::on(128);
    for note in notes {
        match note {
            Note::Bar { rect: [x, y, width, height], grey } => {
                let rect = Rect::from_min_size(pos2(*x, *y), vec2(*width, *height));
                painter.rect_filled(rect, CornerRadius::ZERO, Color32::from_gray(*grey));
            }
            Note::Text { text, at, corner, size } => {
                let font = FontId::proportional((size * em).round());
                let galley = painter.layout(text.clone(), font, palette.text, painter.clip_rect().width() - 2.0 * em);
                let align = match corner {
                    Corner::UpperLeft => Align2::LEFT_TOP,
                    Corner::LowerLeft => Align2::LEFT_BOTTOM,
                    Corner::Middle => Align2::CENTER_CENTER,
                };
                let room = galley.size() + vec2(1.0, 0.5) * em * *size;
                let plate = align.anchor_size(pos2(at[0], at[1]), room);
                let radius = CornerRadius::same((0.2 * em) as u8);
                painter.rect_filled(plate, radius, Color32::from_gray(200));
                painter.galley(plate.min + vec2(0.5, 0.25) * em * *size, galley, palette.text);
            }
        }
    }
}
