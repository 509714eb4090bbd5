//! Lays out each screen as a stack of blocks, as large as fits.

use egui::{Align, Align2, CornerRadius, FontId, Rect, Stroke, StrokeKind, Vec2, pos2, vec2};

use super::blocks::{Block, Brush, Button, ButtonStyle, KeyPlacement};
use super::style::{Palette, em_px};
use super::{DrawnView, View};
use crate::display::content::{Content, Words};
use crate::study::protocol::{Input, Screen};
use cyclopean_analysis::journal::record::Shown;

/// One picture that is laid out.
pub(super) struct PageLayout<'a> {
    pub painter: egui::Painter,
    pub content: &'a Content,
    pub view: &'a View,
    /// Size of the picture, pixels.
    pub size: Vec2,
    pub px_per_degree: f32,
    pub shows_keys: bool,
    pub dot_px: usize,
    /// The left eye's stereogram.
    pub dots: Option<egui::TextureId>,
}

/// Smallest scale; text that is smaller cannot be read. What does not fit even then is cut off.
const SMALLEST: f32 = 0.35;

impl PageLayout<'_> {
    pub fn draw(&self) -> DrawnView {
        let palette = Palette::on(self.content.blank.byte());
        let mut scale = 1.0;
        let mut brush = self.brush(palette, scale);
        let mut blocks = self.blocks(&brush);
        // There is room for the footer and the mark above and below.
        while !self.fits(&brush, &blocks) && scale > SMALLEST {
            scale *= 0.95;
            brush = self.brush(palette, scale);
            blocks = self.blocks(&brush);
        }
        let height: f32 = blocks.iter().map(|b| brush.height(b)).sum();
        // The blocks are a little above the middle, where the eye expects them.
        let mut y = (0.48 * (self.size.y - height)).max(1.2 * brush.em);
        for block in &blocks {
            brush.draw(block, y);
            y += brush.height(block);
        }
        if let Some(footer) = self.footer() {
            brush.footer(&footer, self.size.y);
        }
        self.signs(&brush);
        let is_stereo = matches!(self.view.screen, Screen::Dots(_));
        DrawnView { targets: brush.targets, scale, is_stereo }
    }

    fn brush(&self, palette: Palette, scale: f32) -> Brush<'_> {
        let em = scale * em_px(self.px_per_degree);
        Brush {
            painter: &self.painter,
            palette,
            em,
            middle_x: self.size.x / 2.0,
            hover: self.view.hover,
            targets: Vec::new(),
        }
    }

    fn fits(&self, brush: &Brush<'_>, blocks: &[Block]) -> bool {
        let height: f32 = blocks.iter().map(|b| brush.height(b)).sum();
        let width = blocks.iter().map(|b| brush.width(b)).fold(0.0, f32::max);
        height <= self.size.y - 5.0 * brush.em && width <= self.size.x - 2.0 * brush.em
    }

    fn blocks(&self, brush: &Brush<'_>) -> Vec<Block> {
        match &self.view.screen {
            Screen::Page(page) => match self.content.pages.get(page) {
                Some(page) => self.page(brush, page),
                None => Vec::new(),
            },
            Screen::Item(at) => self.item(brush, *at),
            Screen::Dots(at) => self.stereogram(brush, *at),
            Screen::Panel { chosen, reminder, .. } => self.panel(brush, *chosen, *reminder),
            Screen::Stimulus { .. } | Screen::Blank => Vec::new(),
        }
    }

    /// The width at which lines are wrapped: one that reads well, or as much as there is.
    fn line(&self, brush: &Brush<'_>) -> f32 {
        (30.0 * brush.em).min(self.size.x - 4.0 * brush.em)
    }

    fn page(&self, brush: &Brush<'_>, page: &crate::display::content::PageText) -> Vec<Block> {
        let (palette, wrap) = (brush.palette, self.line(brush));
        let body = brush.text(&page.body, 1.0, palette.text, wrap, Align::LEFT);
        // Short words are centred; a longer text is flush left in its column.
        let is_short = body.rows.len() <= 1;
        let mut blocks = Vec::new();
        let mut add = |text: &str, size: f32, color| {
            let align = if is_short { Align::Center } else { Align::LEFT };
            let galley = brush.text(text, size, color, wrap, align);
            blocks.push(Block::Text { galley, column: (!is_short).then_some(body.size().x) });
        };
        add(&page.title, 1.6, palette.text);
        add(&page.body, 1.0, palette.text);
        if let Some(small) = &page.small {
            add(" ", 0.4, palette.text);
            add(small, 0.8, palette.quiet);
        }
        blocks.insert(1, Block::Gap(0.6 * brush.em));
        blocks.push(Block::Gap(1.6 * brush.em));
        let mut buttons = Vec::new();
        for (i, (text, input)) in page.buttons.iter().enumerate() {
            let look = if i == 0 { ButtonStyle::Strong } else { ButtonStyle::Plain };
            buttons.push(self.button(brush, text, input.clone(), look));
        }
        blocks.push(Block::Row { buttons, each: None, column: (!is_short).then_some(body.size().x) });
        blocks
    }

    fn item(&self, brush: &Brush<'_>, at: usize) -> Vec<Block> {
        let Some(item) = self.content.items.get(at) else { return Vec::new() };
        let (palette, wrap) = (brush.palette, self.line(brush));
        let center = |text: &str, size: f32, color| Block::Text {
            galley: brush.text(text, size, color, wrap, Align::Center),
            column: None,
        };
        let each = 14.0 * brush.em;
        let buttons = (0..)
            .zip(&item.options)
            .map(|(i, option)| self.choice(brush, option, i, ButtonStyle::Plain, each, KeyPlacement::Left))
            .collect();
        let decline = &self.content.words.rather_not_say;
        vec![
            center(&item.lead, 0.9, palette.quiet),
            Block::Gap(0.3 * brush.em),
            center(&item.question, 1.5, palette.text),
            Block::Gap(1.0 * brush.em),
            Block::Column { buttons, each },
            Block::Gap(0.8 * brush.em),
            Block::Row {
                buttons: vec![self.button(brush, decline, Input::Decline, ButtonStyle::Quiet)],
                each: None,
                column: None,
            },
        ]
    }

    fn stereogram(&self, brush: &Brush<'_>, at: usize) -> Vec<Block> {
        let (Some(dots), Some(texture)) = (self.content.dots.get(at), self.dots) else { return Vec::new() };
        let question = brush.text(&self.content.words.dots, 1.2, brush.palette.text, self.line(brush), Align::Center);
        let corners = (0..4)
            .map(|i: u32| Button {
                text: brush.text(&(i + 1).to_string(), 1.0, brush.palette.on_button, f32::INFINITY, Align::Center),
                key: None,
                input: Input::Choose(i),
                look: ButtonStyle::Plain,
            })
            .collect();
        vec![
            Block::Text { galley: question, column: None },
            Block::Gap(1.2 * brush.em),
            Block::Dots { size: (self.dot_px * dots.size) as f32, texture, corners },
        ]
    }

    fn panel(&self, brush: &Brush<'_>, chosen: Option<u32>, reminder: bool) -> Vec<Block> {
        let (palette, em, words) = (brush.palette, brush.em, &self.content.words);
        let wrap = self.line(brush);
        let question = brush.text(&self.content.question, 1.5, palette.text, wrap, Align::Center);
        let n = self.content.choices.len().max(1) as f32;
        let room = self.size.x - 3.0 * em - 0.6 * em * (n - 1.0);
        let longest = self.content.choices.iter().flat_map(|c| c.split_whitespace()).map(|w| w.chars().count()).max();
        // No word is broken, so the longest one decides which width is too narrow.
        let narrow = (0.62 * longest.unwrap_or(1) as f32 + 1.6) * em;
        let each = (room / n).min(9.0 * em);
        let look = |i: u32| if chosen == Some(i) { ButtonStyle::Strong } else { ButtonStyle::Plain };
        let choices = |each: f32, key_at: KeyPlacement| -> Vec<Button> {
            let texts = (0..).zip(&self.content.choices);
            texts.map(|(i, text)| self.choice(brush, text, i, look(i), each, key_at)).collect()
        };
        let scale = if each >= narrow {
            Block::Row { buttons: choices(each, KeyPlacement::Below), each: Some(each), column: None }
        } else {
            let each = (20.0 * em).min(self.size.x - 3.0 * em);
            Block::Column { buttons: choices(each, KeyPlacement::Left), each }
        };
        let said = match (reminder, self.view.time_left_s) {
            (false, _) => " ".to_owned(),
            (true, None) => words.reminder.clone(),
            (true, Some(left)) => {
                format!("{}\n{}", words.reminder, words.time_left.replace("{seconds}", &left.to_string()))
            }
        };
        // There is room for the reminder from the start, so that nothing moves when it appears.
        let said = brush.text(&said, 0.9, palette.text, wrap, Align::Center);
        let gap = (2.6 * em - said.size().y).max(0.0);
        let look = if chosen.is_some() { ButtonStyle::Strong } else { ButtonStyle::Off };
        let confirm = self.button(brush, &words.confirm, Input::Confirm, look);
        vec![
            Block::Text { galley: question, column: None },
            Block::Gap(1.6 * em),
            scale,
            Block::Gap(1.4 * em),
            Block::Row { buttons: vec![confirm], each: None, column: None },
            Block::Gap(0.6 * em),
            Block::Text { galley: said, column: None },
            Block::Gap(gap),
        ]
    }

    /// The button for choice number `i`, of this width.
    fn choice(
        &self,
        brush: &Brush<'_>,
        text: &str,
        i: u32,
        look: ButtonStyle,
        each: f32,
        key_at: KeyPlacement,
    ) -> Button {
        let color = self.color(brush, look);
        let key = |i: u32| brush.text(&(i + 1).to_string(), 0.75, color, f32::INFINITY, Align::Center);
        let room = if key_at == KeyPlacement::Left && self.shows_keys { 3.0 } else { 1.2 };
        Button {
            text: brush.text(text, 1.0, color, each - room * brush.em, Align::Center),
            key: self.shows_keys.then(|| (key(i), key_at)),
            input: Input::Choose(i),
            look,
        }
    }

    fn button(&self, brush: &Brush<'_>, text: &str, input: Input, look: ButtonStyle) -> Button {
        let color = self.color(brush, look);
        let galley = brush.text(text, 1.0, color, f32::INFINITY, Align::Center);
        Button { text: galley, key: None, input, look }
    }

    fn color(&self, brush: &Brush<'_>, look: ButtonStyle) -> egui::Color32 {
        match look {
            ButtonStyle::Plain => brush.palette.on_button,
            ButtonStyle::Strong => brush.palette.on_strong,
            ButtonStyle::Quiet => brush.palette.quiet,
            ButtonStyle::Off => brush.palette.line,
        }
    }

    /// The progress in words: the number of the item or of the presentation.
    fn footer(&self) -> Option<String> {
        let words = &self.content.words;
        match &self.view.screen {
            Screen::Item(at) => Some(Words::progress(self.content.items.get(*at)?.progress, &words.progress)),
            Screen::Dots(at) => Some(Words::progress((at + 1, self.content.dots.len()), &words.progress)),
            Screen::Panel { presentation, .. } => {
                Some(match self.content.presentations.get(*presentation as usize)?.progress {
                    Some(progress) => Words::progress(progress, &words.progress),
                    None => words.practice.clone(),
                })
            }
            _ => None,
        }
    }

    /// Draws the fixation cross, the letter of a stimulus, and the mark of a session that is not real.
    fn signs(&self, brush: &Brush<'_>) {
        let middle = pos2(self.size.x / 2.0, self.size.y / 2.0);
        match &self.view.screen {
            Screen::Blank if self.content.blank.fixation => {
                let half = (0.4 * self.px_per_degree).max(8.0).round();
                let thick = (0.06 * self.px_per_degree).max(2.0).round();
                for arm in [vec2(2.0 * half, thick), vec2(thick, 2.0 * half)] {
                    self.painter.rect_filled(
                        Rect::from_center_size(middle, arm),
                        CornerRadius::ZERO,
                        brush.palette.text,
                    );
                }
            }
            Screen::Stimulus { show: show @ (Shown::A | Shown::B), .. } => {
                let letter = if *show == Shown::A { "A" } else { "B" };
                let at = self.view.label_at.map_or(middle, |[x, y]| pos2(x, y));
                let font = FontId::proportional((1.6 * brush.em).round());
                self.painter.text(at, Align2::CENTER_CENTER, letter, font, brush.palette.text);
            }
            _ => {}
        }
        if let Some(mark) = &self.content.mark {
            let whole = Rect::from_min_size(egui::Pos2::ZERO, self.size);
            let width = (0.16 * brush.em).max(3.0).round();
            let line = Stroke::new(width, brush.palette.mark);
            self.painter.rect_stroke(whole, CornerRadius::ZERO, line, StrokeKind::Inside);
            let font = FontId::proportional((0.7 * brush.em).round());
            let at = pos2(1.5 * width + 0.4 * brush.em, 1.5 * width);
            let galley = self.painter.layout_no_wrap(mark.clone(), font, egui::Color32::from_gray(250));
            let plate = Rect::from_min_size(
                pos2(0.0, 0.0),
                vec2(at.x + galley.size().x + 0.5 * brush.em, at.y + galley.size().y + 0.1 * brush.em),
            );
            self.painter.rect_filled(plate, CornerRadius::ZERO, brush.palette.mark);
            self.painter.galley(at, galley, egui::Color32::WHITE);
        }
    }
}
