//! The meaning of each key in a desktop window.
//!
//! | key | meaning |
//! |---|---|
//! | 1 … 9 | choose |
//! | arrows, Tab | move the choice, or the mark of what Enter would press |
//! | Enter, Space | confirm, go on, press what is marked |
//! | Backspace | no answer; on the consent page: I do not agree |
//! | Esc, P | pause |
//! | F9 | the operator pauses |
//! | F10 | the operator skips this state |
//! | Ctrl+Q | close; the session can be resumed |
//! | Ctrl+Shift+A | the operator gives the session up |
//! | Ctrl+Shift+W | the participant withdraws, together with the data |

use winit::keyboard::{Key, ModifiersState, NamedKey};

use crate::display::content::Content;
use crate::display::panel::Target;
use crate::study::protocol::{Input, Page, Screen};

/// What a key leads to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum KeyEffect {
    Input(Input),
    /// The mark moves to this target.
    Mark(usize),
}

/// The screen on which a key was pressed, and what is marked on it.
pub struct KeyContext<'a> {
    pub screen: &'a Screen,
    pub content: &'a Content,
    pub targets: &'a [Target],
    /// The target that is marked.
    pub mark: Option<usize>,
}

impl KeyContext<'_> {
    /// The effect of a key; none: it means nothing here.
    pub fn effect(&self, key: &Key, modifiers: ModifiersState) -> Option<KeyEffect> {
        let input = |input| Some(KeyEffect::Input(input));
        let (control, shift) = (modifiers.control_key(), modifiers.shift_key());
        if control {
            return match (key, shift) {
                (Key::Character(c), false) if c.eq_ignore_ascii_case("q") => input(Input::Quit),
                (Key::Character(c), true) if c.eq_ignore_ascii_case("a") => input(Input::Abandon),
                (Key::Character(c), true) if c.eq_ignore_ascii_case("w") => input(Input::Withdraw),
                _ => None,
            };
        }
        match key {
            Key::Named(NamedKey::Escape) => self.pause(),
            Key::Named(NamedKey::F9) => input(Input::Pause { by_operator: true }),
            Key::Named(NamedKey::F10) => input(Input::Skip),
            Key::Named(NamedKey::Enter | NamedKey::Space) => self.press(),
            Key::Named(NamedKey::Backspace) => {
                let declines = self.targets.iter().any(|t| t.input == Input::Decline);
                declines.then_some(KeyEffect::Input(Input::Decline))
            }
            Key::Named(NamedKey::Tab) => self.step(if shift { -1 } else { 1 }),
            Key::Named(NamedKey::ArrowLeft | NamedKey::ArrowUp) => self.step(-1),
            Key::Named(NamedKey::ArrowRight | NamedKey::ArrowDown) => self.step(1),
            Key::Character(c) if c.eq_ignore_ascii_case("p") => self.pause(),
            Key::Character(c) => self.choose(c.parse::<u32>().ok()?.checked_sub(1)?),
            _ => None,
        }
    }

    /// Pause, unless the session is paused already.
    pub fn pause(&self) -> Option<KeyEffect> {
        let is_paused = *self.screen == Screen::Page(Page::Paused);
        (!is_paused).then_some(KeyEffect::Input(Input::Pause { by_operator: false }))
    }

    /// Choose the alternative of this number, if there is one.
    pub fn choose(&self, choice: u32) -> Option<KeyEffect> {
        ((choice as usize) < self.content.choices_of(self.screen)).then_some(KeyEffect::Input(Input::Choose(choice)))
    }

    /// Press the marked target; without a mark, the button that goes on from a page. On a panel, a choice that was made
    /// is confirmed wherever the pointer is.
    pub fn press(&self) -> Option<KeyEffect> {
        if let Screen::Panel { chosen: Some(_), .. } = self.screen {
            return Some(KeyEffect::Input(Input::Confirm));
        }
        let marked = self.mark.and_then(|mark| self.targets.get(mark));
        let plain = || {
            let on = |t: &&Target| matches!(t.input, Input::Confirm | Input::Continue);
            self.targets.iter().find(on)
        };
        marked.or_else(plain).map(|target| KeyEffect::Input(target.input.clone()))
    }

    /// Moves the choice on a panel, and the mark elsewhere.
    pub fn step(&self, by: i32) -> Option<KeyEffect> {
        let next = |at: Option<usize>, n: usize| match at {
            None if by > 0 => 0,
            None => n - 1,
            Some(at) => (at as i32 + by).rem_euclid(n as i32) as usize,
        };
        if let Screen::Panel { chosen, .. } = self.screen {
            let n = self.content.choices.len();
            return (n > 0).then(|| KeyEffect::Input(Input::Choose(next(chosen.map(|c| c as usize), n) as u32)));
        }
        let n = self.targets.len();
        (n > 0).then(|| KeyEffect::Mark(next(self.mark, n)))
    }
}
