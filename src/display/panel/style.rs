//! Sizes, fonts and colours of all words.

use std::sync::Arc;

use egui::{Color32, FontData, FontDefinitions, FontFamily};

/// Pixels per em. At 20 px/degree the pixels limit legibility: 26 px give an x-height of 13 px, which is 0.65°. At a
/// desk the eye limits it: 0.55° per em are 8 mm at 80 cm.
pub fn em_px(px_per_degree: f32) -> f32 {
    (0.55 * px_per_degree).max(26.0)
}

/// egui's fonts, with another one in front for letters that they lack.
pub(super) fn fonts(more: Option<&[u8]>) -> FontDefinitions {
    let mut fonts = FontDefinitions::default();
    let family = fonts.families.entry(FontFamily::Proportional).or_default();
    let text = FontData::from_static(include_bytes!("../../../languages/fonts/NotoSans-Regular.ttf"));
    family.insert(0, "text".to_owned());
    if more.is_some() {
        family.insert(1, "more".to_owned());
    }
    fonts.font_data.insert("text".to_owned(), Arc::new(text));
    if let Some(bytes) = more {
        fonts.font_data.insert("more".to_owned(), Arc::new(FontData::from_owned(bytes.to_vec())));
    }
    fonts
}

/// Colours on a background of this grey; the contrast of all text to what it stands on is at least 4.5 : 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Palette {
    pub text: Color32,
    /// Less important text.
    pub quiet: Color32,
    /// A choice that can be made.
    pub button: Color32,
    pub hovered: Color32,
    pub on_button: Color32,
    /// The choice that was made, and the button that goes on.
    pub strong: Color32,
    pub strong_hovered: Color32,
    pub on_strong: Color32,
    pub line: Color32,
    pub mark: Color32,
}

impl Palette {
    pub fn on(ground: u8) -> Palette {
        let dark = Color32::from_gray(12);
        let light = Color32::from_gray(245);
        if ground >= 100 {
            Palette {
                text: dark,
                quiet: Color32::from_gray(24),
                button: Color32::from_gray(ground.saturating_add(38)),
                hovered: Color32::from_gray(ground.saturating_add(70)),
                on_button: dark,
                strong: Color32::from_gray(28),
                strong_hovered: Color32::from_gray(52),
                on_strong: light,
                line: Color32::from_gray(ground.saturating_sub(50)),
                mark: Color32::from_rgb(94, 30, 0),
            }
        } else {
            Palette {
                text: light,
                quiet: Color32::from_gray(220),
                button: Color32::from_gray(ground + 40),
                hovered: Color32::from_gray(ground + 70),
                on_button: light,
                strong: Color32::from_gray(225),
                strong_hovered: Color32::from_gray(250),
                on_strong: dark,
                line: Color32::from_gray(ground + 60),
                mark: Color32::from_rgb(255, 176, 64),
            }
        }
    }
}
