//! The states of an OpenXR session (OpenXR 1.0, section 9.3), and what each of them demands of this program.
//!
//! ```text
//! IDLE → READY (begin) → SYNCHRONIZED (frames, nothing seen) ⇄ VISIBLE (seen) ⇄ FOCUSED (seen and answered)
//!      ← STOPPING (end) ←                         anywhere → LOSS_PENDING, EXITING (over)
//! ```
//! Nothing here calls the runtime.

use openxr::SessionState;

use crate::study::protocol::Event;

/// The state of the OpenXR session.
#[derive(Debug, Clone)]
pub(super) struct Lifecycle {
    state: SessionState,
    running: bool,
    /// Whether the headset is worn; true where the runtime cannot say.
    worn: bool,
    /// What the session's state machine was told last. It begins with both true.
    told_visible: bool,
    told_focus: bool,
}

/// What this program must do at a change of state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LifecycleAction {
    Nothing,
    /// `xrBeginSession`
    Begin,
    /// `xrEndSession`
    End,
    /// The headset or its runtime goes away.
    Lost,
    /// Somebody closed this program from within the headset.
    Exit,
}

impl Lifecycle {
    pub fn new() -> Lifecycle {
        Lifecycle { state: SessionState::UNKNOWN, running: false, worn: true, told_visible: true, told_focus: true }
    }

    /// Whether frames may be waited for: between `xrBeginSession` and `xrEndSession`.
    pub fn is_running(&self) -> bool {
        self.running
    }

    /// Whether layers are seen; in other states a frame has no layers.
    pub fn is_visible(&self) -> bool {
        self.worn && matches!(self.state, SessionState::VISIBLE | SessionState::FOCUSED)
    }

    /// Whether this program gets the controllers' actions.
    pub fn is_focused(&self) -> bool {
        self.worn && self.state == SessionState::FOCUSED
    }

    /// Takes a state that the runtime reports.
    pub fn enter(&mut self, state: SessionState) -> LifecycleAction {
        self.state = state;
        match state {
            SessionState::READY => {
                self.running = true;
                LifecycleAction::Begin
            }
            SessionState::STOPPING => {
                let was = std::mem::replace(&mut self.running, false);
                if was { LifecycleAction::End } else { LifecycleAction::Nothing }
            }
            SessionState::LOSS_PENDING => {
                self.running = false;
                LifecycleAction::Lost
            }
            SessionState::EXITING => {
                self.running = false;
                LifecycleAction::Exit
            }
            _ => LifecycleAction::Nothing,
        }
    }

    /// Takes a report of `XR_EXT_user_presence`: the headset was put on or taken off.
    pub fn set_worn(&mut self, worn: bool) {
        self.worn = worn;
    }

    /// What the session's state machine must be told since the last call; visibility comes first.
    pub fn changes(&mut self) -> Vec<Event> {
        let mut out = Vec::new();
        if self.told_visible != self.is_visible() {
            self.told_visible = self.is_visible();
            out.push(Event::Visible(self.told_visible));
        }
        if self.told_focus != self.is_focused() {
            self.told_focus = self.is_focused();
            out.push(Event::Focus(self.told_focus));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_headset_put_on_taken_off_and_put_on_again() {
        let mut life = Lifecycle::new();
        assert_eq!(life.changes(), [Event::Visible(false), Event::Focus(false)]);
        assert_eq!(life.enter(SessionState::IDLE), LifecycleAction::Nothing);
        assert!(!life.is_running());
        assert_eq!(life.enter(SessionState::READY), LifecycleAction::Begin);
        assert!(life.is_running());
        assert_eq!(life.enter(SessionState::SYNCHRONIZED), LifecycleAction::Nothing);
        assert!(life.changes().is_empty());
        life.enter(SessionState::VISIBLE);
        assert_eq!(life.changes(), [Event::Visible(true)]);
        life.enter(SessionState::FOCUSED);
        assert_eq!(life.changes(), [Event::Focus(true)]);
        life.set_worn(false);
        assert_eq!(life.changes(), [Event::Visible(false), Event::Focus(false)]);
        life.set_worn(true);
        assert_eq!(life.changes(), [Event::Visible(true), Event::Focus(true)]);
        life.enter(SessionState::VISIBLE);
        life.enter(SessionState::SYNCHRONIZED);
        assert_eq!(life.changes(), [Event::Visible(false), Event::Focus(false)]);
        assert!(life.is_running());
        assert_eq!(life.enter(SessionState::STOPPING), LifecycleAction::End);
        assert_eq!(life.enter(SessionState::STOPPING), LifecycleAction::Nothing);
        assert!(!life.is_running());
        assert_eq!(life.enter(SessionState::READY), LifecycleAction::Begin);
    }

    #[test]
    fn loss_and_exit_end_it() {
        for (state, asked) in
            [(SessionState::LOSS_PENDING, LifecycleAction::Lost), (SessionState::EXITING, LifecycleAction::Exit)]
        {
            let mut life = Lifecycle::new();
            life.enter(SessionState::READY);
            assert_eq!(life.enter(state), asked);
            assert!(!life.is_running());
        }
    }
}
