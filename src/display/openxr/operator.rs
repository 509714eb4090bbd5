//! The operator's keyboard beside a headset: a letter and Enter on standard input.

use std::sync::mpsc::{Receiver, channel};

use cyclopean_analysis::{files, terminal};

use crate::study::protocol::Input;

/// What an operator can do from the keyboard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Key {
    Input(Input),
    /// Place the pictures where the participant looks now.
    Recentre,
}

/// The list of keys that the operator reads.
pub const KEYS: &str = "operator, each with Enter: p pause, c continue, s skip, r centre the view, 1–9 choose, y confirm, n decline, q quit (resume later), abandon, withdraw";

/// The most bytes of a line, more than anybody types.
const LONGEST_LINE: u64 = 4096;

pub(super) fn key(line: &str) -> Option<Key> {
    let input = match line.trim() {
        "p" => Input::Pause { by_operator: true },
        "c" => Input::Continue,
        "s" => Input::Skip,
        "y" => Input::Confirm,
        "n" => Input::Decline,
        "q" => Input::Quit,
        // These are whole words, so that nobody types them by accident.
        "abandon" => Input::Abandon,
        "withdraw" => Input::Withdraw,
        "r" => return Some(Key::Recentre),
        digit => Input::Choose(digit.parse::<u32>().ok().filter(|n| (1..=9).contains(n))? - 1),
    };
    Some(Key::Input(input))
}

/// Listens on a thread of its own, which ends with standard input or with the program.
pub(super) fn listen() -> Receiver<Key> {
    let (sender, receiver) = channel();
    let hear = move || {
        for line in files::lines(std::io::stdin().lock(), LONGEST_LINE).map_while(Result::ok) {
            match key(&line) {
                Some(key) => {
                    if sender.send(key).is_err() {
                        return;
                    }
                }
                None if line.trim().is_empty() => {}
                None => terminal::say(&format!("{KEYS}\n")),
            }
        }
    };
    // Without the thread only the keyboard is missing.
    if let Err(error) = std::thread::Builder::new().name("operator".to_owned()).spawn(hear) {
        tracing::warn!("the operator's keyboard is not heard: {error}");
    }
    receiver
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_digits_and_words() {
        assert_eq!(key(" p "), Some(Key::Input(Input::Pause { by_operator: true })));
        assert_eq!(key("3"), Some(Key::Input(Input::Choose(2))));
        assert_eq!(key("withdraw"), Some(Key::Input(Input::Withdraw)));
        assert_eq!(key("r"), Some(Key::Recentre));
        assert_eq!((key("0"), key("w"), key("")), (None, None, None));
    }
}
