//! Turns stick, ray and trigger into what a person means on this screen. It calls no runtime.

use crate::display::panel::DrawnView;
use crate::study::protocol::{Input, Screen};

/// What the participant points at on a board.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Chooser {
    /// The target that is highlighted.
    hover: Option<usize>,
    /// The target that the ray met last. While the ray stays on it, the stick can highlight another one.
    pointed: Option<usize>,
}

impl Chooser {
    pub fn hover(&self) -> Option<usize> {
        self.hover
    }

    /// Called for another screen: nothing is highlighted, and a target that the ray still meets is highlighted only
    /// when the ray moves.
    pub fn reset(&mut self) {
        self.hover = None;
    }

    /// Takes the target that the ray meets, or none.
    pub fn point(&mut self, target: Option<usize>) {
        if self.pointed != target {
            self.pointed = target;
            self.hover = target;
        }
    }

    /// Called when the stick was pushed: it moves the choice on the rating panel, and the highlight elsewhere.
    pub fn step(&mut self, screen: &Screen, choices: usize, drawn: &DrawnView, by: i32) -> Option<Input> {
        let moved = |from: Option<usize>, n: usize| match from {
            Some(at) => (at as i32 + by).clamp(0, n as i32 - 1) as usize,
            // The first push in either direction chooses the middle, because neither end is nearer.
            None => (n - 1) / 2,
        };
        if let Screen::Panel { chosen, .. } = screen {
            self.hover = None;
            if choices == 0 {
                return None;
            }
            let at = moved(chosen.map(|c| c as usize), choices) as u32;
            return (*chosen != Some(at)).then_some(Input::Choose(at));
        }
        if !drawn.targets.is_empty() {
            let first = if by > 0 { 0 } else { drawn.targets.len() - 1 };
            self.hover = Some(self.hover.map_or(first, |at| moved(Some(at), drawn.targets.len())));
        }
        None
    }

    /// Called when the trigger was pulled: it takes the highlighted target, or else the only one that can be meant.
    pub fn confirm(&self, screen: &Screen, drawn: &DrawnView) -> Option<Input> {
        if let Some(input) = self.hover.and_then(|at| drawn.input(at)) {
            return Some(input);
        }
        match screen {
            Screen::Panel { chosen: Some(_), .. } => Some(Input::Confirm),
            Screen::Page(_) if drawn.targets.len() == 1 => drawn.input(0),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::panel::Target;
    use crate::study::protocol::Page;

    fn drawn(inputs: &[Input]) -> DrawnView {
        let target = |input: &Input| Target { rect: [0.0; 4], input: input.clone() };
        DrawnView { targets: inputs.iter().map(target).collect(), ..DrawnView::default() }
    }

    fn panel(chosen: Option<u32>) -> Screen {
        Screen::Panel { presentation: 0, attempt: 0, chosen, reminder: false }
    }

    #[test]
    fn the_stick_moves_the_choice_from_the_middle_and_stops_at_the_ends() {
        let mut chooser = Chooser::default();
        let none = DrawnView::default();
        assert_eq!(chooser.step(&panel(None), 5, &none, -1), Some(Input::Choose(2)));
        assert_eq!(chooser.step(&panel(Some(2)), 5, &none, 1), Some(Input::Choose(3)));
        assert_eq!(chooser.step(&panel(Some(4)), 5, &none, 1), None);
        assert_eq!(chooser.confirm(&panel(None), &none), None);
        assert_eq!(chooser.confirm(&panel(Some(4)), &none), Some(Input::Confirm));
    }

    #[test]
    fn what_is_pointed_at_counts_until_the_stick_moves() {
        let mut chooser = Chooser::default();
        let offers = drawn(&[Input::Choose(0), Input::Choose(1), Input::Confirm]);
        chooser.point(Some(1));
        assert_eq!(chooser.confirm(&panel(None), &offers), Some(Input::Choose(1)));
        assert_eq!(chooser.step(&panel(Some(1)), 2, &offers, -1), Some(Input::Choose(0)));
        chooser.point(Some(1));
        assert_eq!(chooser.confirm(&panel(Some(0)), &offers), Some(Input::Confirm));
        chooser.point(None);
        chooser.point(Some(1));
        assert_eq!(chooser.hover(), Some(1));
    }

    #[test]
    fn a_page_with_one_way_on_needs_no_aim_but_consent_does() {
        let mut chooser = Chooser::default();
        let page = Screen::Page(Page::Instructions);
        assert_eq!(chooser.confirm(&page, &drawn(&[Input::Continue])), Some(Input::Continue));
        let consent = drawn(&[Input::Continue, Input::Decline]);
        assert_eq!(chooser.confirm(&Screen::Page(Page::Consent), &consent), None);
        chooser.step(&Screen::Page(Page::Consent), 0, &consent, 1);
        assert_eq!(chooser.confirm(&Screen::Page(Page::Consent), &consent), Some(Input::Continue));
        chooser.step(&Screen::Page(Page::Consent), 0, &consent, 1);
        assert_eq!(chooser.confirm(&Screen::Page(Page::Consent), &consent), Some(Input::Decline));
    }
}
