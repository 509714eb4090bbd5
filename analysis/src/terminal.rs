//! The one way to print: control sequences are made visible, and a reader who has gone is no failure.

use std::error::Error;
use std::io::{self, Write};

use crate::escape;

/// Prints a page to standard output.
///
/// # Errors
/// What the system says, such as a full disk; a reader who has gone (`… | head`) is no failure.
pub fn print(page: &str) -> io::Result<()> {
    put(&escape::terminal(page))
}

/// Prints a JSON text to standard output.
///
/// # Errors
/// As [`print()`].
pub fn print_json(text: &str) -> io::Result<()> {
    put(&escape::json(text))
}

fn put(text: &str) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// Prints text to standard error. A failure to print is ignored, because it cannot be reported anywhere.
pub fn say(page: &str) {
    let _ = io::stderr().lock().write_all(escape::terminal(page).as_bytes());
}

/// An error with its causes as one sentence, without the parts that an outer message already quotes.
fn one_sentence(error: &(dyn Error + 'static)) -> String {
    let mut text = String::new();
    for cause in std::iter::successors(Some(error), |e| (*e).source()).map(ToString::to_string) {
        if text.is_empty() {
            text = cause;
        } else if !text.contains(&cause) {
            text.push_str(": ");
            text.push_str(&cause);
        }
    }
    text
}

/// Longest error message, in characters. A message may quote text that is as long as a file.
const LONGEST_ERROR: usize = 3000;

/// Prints an error with its causes to standard error, as one line. Of a message that is too long, both ends are
/// printed.
pub fn say_error(program: &str, error: &(dyn Error + 'static)) {
    let text = one_sentence(error);
    let text = escape::line(&text);
    let length = text.chars().count();
    if length <= LONGEST_ERROR {
        return say(&format!("{program}: {text}\n"));
    }
    let cut = |characters: usize| text.char_indices().nth(characters).map_or(text.len(), |(at, _)| at);
    let (head, tail) = (cut(LONGEST_ERROR - 500), cut(length - 500));
    say(&format!("{program}: {} … {}\n", &text[..head], &text[tail..]));
}

/// Ends the program as the command line's parser asks: help and version go to standard output, mistakes to standard error.
///
/// What was typed may hold names of files, so a mistake that quotes a hidden character is printed without colours.
pub fn exit_usage(error: &clap::Error) -> ! {
    let text = error.render().to_string();
    if error.use_stderr() && escape::terminal(&text) != text {
        say(&text);
    } else {
        // A failure to print cannot be reported anywhere.
        let _ = error.print();
    }
    std::process::exit(error.exit_code())
}
