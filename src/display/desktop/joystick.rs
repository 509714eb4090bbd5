//! Gamepads, read from Linux's joystick devices (`/dev/input/js*`, Documentation/input/joydev/joystick-api.rst in the
//! kernel).
//!
//! The usual crate needs libudev to build, which even a machine that only analyses would have to install. This code
//! needs nothing. On other systems there are keyboard and mouse.

use std::fs::File;
use std::io::Read;

/// What somebody did with a gamepad.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GamepadInput {
    /// The stick was moved: −1 to the left or up, 1 to the right or down.
    Step(i32),
    /// The first button was pressed.
    Press,
    /// The start button was pressed.
    Pause,
}

/// Size of a `js_event`: time, value, type, number.
const EVENT_BYTES: usize = 8;
const BUTTON: u8 = 1;
const AXIS: u8 = 2;
/// Deflections, of 32767, from which an axis counts as pushed, and below which as released.
const PUSHED: i16 = 20_000;
const RELEASED: i16 = 8_000;
const FIRST_BUTTON: u8 = 0;
/// Numbers of the start button on most gamepads.
const START_BUTTONS: [u8; 2] = [7, 9];

struct Joystick {
    file: File,
    /// For each axis, by its number: whether it was pushed and not released yet.
    pushed: [bool; 256],
}

/// All gamepads that are plugged in.
#[derive(Default)]
pub struct Joysticks {
    open: Vec<Joystick>,
    has_looked: bool,
}

impl Joysticks {
    /// What was done with any gamepad since the last call.
    pub fn take(&mut self) -> Vec<GamepadInput> {
        if !self.has_looked {
            self.has_looked = true;
            self.open = (0..4).filter_map(|n| open(&format!("/dev/input/js{n}"))).collect();
        }
        let mut moved = Vec::new();
        self.open.retain_mut(|joystick| joystick.read(&mut moved));
        moved
    }
}

impl Joystick {
    /// Reads all waiting events; returns false if the gamepad was unplugged.
    fn read(&mut self, moved: &mut Vec<GamepadInput>) -> bool {
        let mut event = [0; EVENT_BYTES];
        loop {
            match self.file.read(&mut event) {
                Ok(EVENT_BYTES) => moved.extend(self.handle(event)),
                Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => return true,
                _ => return false,
            }
        }
    }

    fn handle(&mut self, event: [u8; EVENT_BYTES]) -> Option<GamepadInput> {
        let value = i16::from_le_bytes([event[4], event[5]]);
        match (event[6], event[7]) {
            (BUTTON, FIRST_BUTTON) if value == 1 => Some(GamepadInput::Press),
            (BUTTON, n) if value == 1 && START_BUTTONS.contains(&n) => Some(GamepadInput::Pause),
            (AXIS, n) => {
                let was = self.pushed[n as usize];
                let is = value.saturating_abs() > if was { RELEASED } else { PUSHED };
                self.pushed[n as usize] = is;
                (is && !was).then_some(GamepadInput::Step(if value < 0 { -1 } else { 1 }))
            }
            _ => None,
        }
    }
}

#[cfg(target_os = "linux")]
fn open(path: &str) -> Option<Joystick> {
    use std::os::unix::fs::OpenOptionsExt;
    /// The value of `O_NONBLOCK` on every Linux that this runs on.
    const NONBLOCK: i32 = 0o4000;
    let file = File::options().read(true).custom_flags(NONBLOCK).open(path).ok()?;
    Some(Joystick { file, pushed: [false; 256] })
}

#[cfg(not(target_os = "linux"))]
fn open(_path: &str) -> Option<Joystick> {
    None
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_stick_steps_once_a_push_and_buttons_press() {
        let mut stick = open("/dev/null").unwrap();
        let mut event = |kind: u8, number: u8, value: i16| {
            let [low, high] = value.to_le_bytes();
            stick.handle([0, 0, 0, 0, low, high, kind, number])
        };
        assert_eq!(event(AXIS, 0, 10_000), None);
        assert_eq!(event(AXIS, 0, -32_767), Some(GamepadInput::Step(-1)));
        assert_eq!(event(AXIS, 0, -15_000), None);
        assert_eq!(event(AXIS, 0, 0), None);
        assert_eq!(event(AXIS, 0, 32_767), Some(GamepadInput::Step(1)));
        assert_eq!(event(BUTTON, 0, 1), Some(GamepadInput::Press));
        assert_eq!(event(BUTTON, 0, 0), None);
        assert_eq!(event(BUTTON, 7, 1), Some(GamepadInput::Pause));
        // The kernel reports the initial state as events, which nobody caused.
        assert_eq!(event(BUTTON | 0x80, 0, 1), None);
    }
}
