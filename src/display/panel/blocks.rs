//! The blocks that pages are made of: texts, gaps, rows and columns of buttons, a stereogram.

use std::sync::Arc;

use egui::{Align, Align2, Color32, CornerRadius, FontId, Galley, Pos2, Rect, Stroke, StrokeKind, Vec2, pos2, vec2};

use super::Target;
use super::style::Palette;
use crate::study::protocol::Input;

/// How a button looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ButtonStyle {
    Plain,
    /// For the choice that was made, or the button that goes on.
    Strong,
    /// Only text, for a button that few people need.
    Quiet,
    /// For a button that cannot be used yet.
    Off,
}

/// Where a button shows its key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum KeyPlacement {
    Below,
    Left,
}

pub(super) struct Button {
    pub text: Arc<Galley>,
    /// The key to press, in small letters, below the words or before them.
    pub key: Option<(Arc<Galley>, KeyPlacement)>,
    pub input: Input,
    pub look: ButtonStyle,
}

pub(super) enum Block {
    /// Centred, or flush left in a column of this width.
    Text {
        galley: Arc<Galley>,
        column: Option<f32>,
    },
    Gap(f32),
    /// Buttons side by side; each of this width, or as wide as its words; centred, or flush left in a column of this
    /// width.
    Row {
        buttons: Vec<Button>,
        each: Option<f32>,
        column: Option<f32>,
    },
    /// Buttons below each other, all of this width.
    Column {
        buttons: Vec<Button>,
        each: f32,
    },
    /// A stereogram, whose four corners can be chosen.
    Dots {
        size: f32,
        texture: egui::TextureId,
        corners: Vec<Button>,
    },
}

/// What blocks are drawn with, and where.
pub(super) struct Brush<'a> {
    pub painter: &'a egui::Painter,
    pub palette: Palette,
    pub em: f32,
    /// Horizontal middle of the image.
    pub middle_x: f32,
    pub hover: Option<usize>,
    pub targets: Vec<Target>,
}

impl Brush<'_> {
    /// Lays out wrapped text of a colour, with centred lines or flush left.
    pub fn text(&self, text: &str, size: f32, color: Color32, wrap: f32, align: Align) -> Arc<Galley> {
        let font = FontId::proportional((size * self.em).round());
        let mut job = egui::text::LayoutJob::simple(text.to_owned(), font, color, wrap);
        job.halign = align;
        for section in &mut job.sections {
            section.format.line_height = Some((1.4 * size * self.em).round());
        }
        self.painter.layout_job(job)
    }

    fn padding(&self) -> Vec2 {
        vec2(0.8, 0.5) * self.em
    }

    fn button_size(&self, button: &Button, each: Option<f32>) -> Vec2 {
        let key = key_below(button);
        let width = each.unwrap_or(button.text.size().x + 2.0 * self.padding().x + 0.8 * self.em);
        vec2(width, button.text.size().y + key + 2.0 * self.padding().y)
    }

    fn row_height(&self, buttons: &[Button], each: Option<f32>) -> f32 {
        buttons.iter().map(|b| self.button_size(b, each).y).fold(0.0, f32::max)
    }

    pub fn height(&self, block: &Block) -> f32 {
        match block {
            Block::Text { galley, .. } => galley.size().y,
            Block::Gap(height) => *height,
            Block::Row { buttons, each, .. } => self.row_height(buttons, *each),
            Block::Column { buttons, each } => {
                let row = self.row_height(buttons, Some(*each));
                buttons.len() as f32 * (row + 0.4 * self.em) - 0.4 * self.em
            }
            Block::Dots { size, .. } => size + 0.6 * self.em,
        }
    }

    pub fn width(&self, block: &Block) -> f32 {
        match block {
            Block::Text { galley, column } => column.unwrap_or(galley.size().x),
            Block::Gap(_) => 0.0,
            Block::Row { buttons, each, .. } => {
                let all: f32 = buttons.iter().map(|b| self.button_size(b, *each).x).sum();
                all + 0.6 * self.em * (buttons.len().saturating_sub(1)) as f32
            }
            Block::Column { each, .. } => *each,
            Block::Dots { size, .. } => size + 8.0 * self.em,
        }
    }

    /// Draws a block whose upper edge is at `y`.
    pub fn draw(&mut self, block: &Block, y: f32) {
        match block {
            Block::Text { galley, column } => {
                let x = column.map_or(self.middle_x, |width| self.middle_x - width / 2.0);
                self.painter.galley(pos2(x.round(), y.round()), Arc::clone(galley), self.palette.text);
            }
            Block::Gap(_) => {}
            Block::Row { buttons, each, column } => {
                let height = self.row_height(buttons, *each);
                let mut x = self.middle_x - column.unwrap_or(self.width(block)) / 2.0;
                for button in buttons {
                    let width = self.button_size(button, *each).x;
                    self.button(button, Rect::from_min_size(pos2(x, y), vec2(width, height)));
                    x += width + 0.6 * self.em;
                }
            }
            Block::Column { buttons, each } => {
                let height = self.row_height(buttons, Some(*each));
                let mut y = y;
                for button in buttons {
                    let at = pos2(self.middle_x - each / 2.0, y);
                    self.button(button, Rect::from_min_size(at, vec2(*each, height)));
                    y += height + 0.4 * self.em;
                }
            }
            Block::Dots { size, texture, corners } => self.dots(y, *size, *texture, corners),
        }
    }

    fn button(&mut self, button: &Button, rect: Rect) {
        let rect = Rect::from_min_max(rect.min.round(), rect.max.round());
        let is_hovered = self.hover == Some(self.targets.len()) && button.look != ButtonStyle::Off;
        let palette = self.palette;
        let (fill, line) = match (button.look, is_hovered) {
            (ButtonStyle::Plain, false) => (palette.button, palette.line),
            (ButtonStyle::Plain, true) => (palette.hovered, palette.text),
            (ButtonStyle::Strong, false) => (palette.strong, palette.strong),
            (ButtonStyle::Strong, true) => (palette.strong_hovered, palette.text),
            (ButtonStyle::Quiet, false) => (Color32::TRANSPARENT, Color32::TRANSPARENT),
            (ButtonStyle::Quiet, true) => (Color32::TRANSPARENT, palette.text),
            (ButtonStyle::Off, _) => (Color32::TRANSPARENT, palette.line),
        };
        let radius = CornerRadius::same((0.3 * self.em) as u8);
        let width = if is_hovered { 0.1 } else { 0.05 } * self.em;
        self.painter.rect(rect, radius, fill, Stroke::new(width.max(1.0), line), StrokeKind::Inside);
        let key = key_below(button);
        place(self.painter, &button.text, rect.center() - vec2(0.0, key / 2.0));
        match &button.key {
            Some((galley, KeyPlacement::Below)) => {
                place(self.painter, galley, pos2(rect.center().x, rect.bottom() - (self.padding().y + key) / 2.0));
            }
            Some((galley, KeyPlacement::Left)) => {
                place(self.painter, galley, pos2(rect.left() + 0.9 * self.em, rect.center().y));
            }
            None => {}
        }
        if button.look != ButtonStyle::Off {
            let rect = [rect.left(), rect.top(), rect.right(), rect.bottom()];
            self.targets.push(Target { rect, input: button.input.clone() });
        }
    }

    fn dots(&mut self, y: f32, size: f32, texture: egui::TextureId, corners: &[Button]) {
        // The place is rounded to whole pixels, because a dot is a display pixel.
        let at = pos2((self.middle_x - size / 2.0).round(), (y + 0.3 * self.em).round());
        let rect = Rect::from_min_size(at, Vec2::splat(size));
        // A frame that both eyes see alike helps to keep the eyes' views fused.
        let frame = Stroke::new((0.12 * self.em).max(2.0), self.palette.text);
        self.painter.rect_stroke(rect.expand(0.25 * self.em), CornerRadius::ZERO, frame, StrokeKind::Outside);
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        self.painter.image(texture, rect, whole, Color32::WHITE);
        let side = 2.2 * self.em;
        let away = 1.0 * self.em + side / 2.0;
        for (i, button) in corners.iter().enumerate() {
            let x = if i % 2 == 0 { rect.left() - away } else { rect.right() + away };
            let y = if i < 2 { rect.top() + size / 4.0 } else { rect.bottom() - size / 4.0 };
            self.button(button, Rect::from_center_size(pos2(x, y), Vec2::splat(side)));
        }
    }

    /// Small text at the lower edge, in the middle.
    pub fn footer(&self, text: &str, height: f32) {
        let font = FontId::proportional((0.8 * self.em).round());
        let at = pos2(self.middle_x, height - 1.0 * self.em);
        self.painter.text(at, Align2::CENTER_BOTTOM, text, font, self.palette.quiet);
    }
}

/// Height of the key below a button's words.
fn key_below(button: &Button) -> f32 {
    match &button.key {
        Some((galley, KeyPlacement::Below)) => galley.size().y,
        _ => 0.0,
    }
}

/// Places a text, whose lines are centred, around a point.
fn place(painter: &egui::Painter, galley: &Arc<Galley>, middle: Pos2) {
    let y = middle.y - galley.size().y / 2.0;
    painter.galley(pos2(middle.x.round(), y.round()), Arc::clone(galley), Color32::PLACEHOLDER);
}
