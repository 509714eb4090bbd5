//! What a command prints, and whether the user has asked it to stop. Results go to standard output; progress, notes and
//! the log go to standard error. The commands and the modules that do long work for them call it.

use std::io::{self, IsTerminal, Write};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use cyclopean_analysis::{escape, terminal};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Installs logging and the handler of Ctrl-C. `commands::main` calls it once.
pub fn start() {
    let filter = tracing_subscriber::EnvFilter::try_from_env("CYCLOPEAN_LOG")
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("warn,winit=error"));
    // In tests it may be called again; then the first subscriber stays.
    let _ = tracing_subscriber::fmt().with_env_filter(filter).with_writer(|| Log).without_time().try_init();
    let handler = || {
        if INTERRUPTED.swap(true, Ordering::SeqCst) {
            // The second Ctrl-C ends the program at once. Files are written under another name and renamed when they
            // are whole, so nothing that was finished is lost.
            std::process::exit(130);
        }
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        tracing::warn!("Ctrl-C cannot be caught, so it will end the program at once: {error}");
    }
}

/// Standard error, to which the log is written. An error of writing is ignored, because there is no other place to
/// report it.
struct Log;

impl Write for Log {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _ = io::stderr().lock().write_all(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The error of the first result that could not be printed.
static FAILED: Mutex<Option<io::Error>> = Mutex::new(None);

/// A result could not be written to standard output.
#[derive(Debug, thiserror::Error)]
#[error("cannot write to standard output: {0}")]
pub struct PrintError(#[source] io::Error);

/// Reports the first result that could not be printed; `commands::main` calls it at the end. A reader that has closed
/// the pipe (`… | head`) is no failure.
pub fn finish() -> Result<(), PrintError> {
    FAILED.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take().map_or(Ok(()), |e| Err(PrintError(e)))
}

/// Ctrl-C was pressed. Long work stops after the step that it is at.
#[derive(Debug, thiserror::Error)]
#[error("interrupted; every file that was finished is whole, and the work can be resumed")]
pub struct Interrupted;

/// Fails with [`Interrupted`] once Ctrl-C was pressed. Long loops call it at each step.
pub fn check_interrupted() -> Result<(), Interrupted> {
    if INTERRUPTED.load(Ordering::SeqCst) { Err(Interrupted) } else { Ok(()) }
}

/// Prints what a command has to say, as text for people or as JSON.
#[derive(Debug, Clone, Copy)]
pub struct Console {
    json: bool,
}

impl Console {
    pub fn new(json: bool) -> Console {
        Console { json }
    }

    /// Prints a line of the result for people. Prints nothing with `--json`.
    pub fn line(&self, text: impl AsRef<str>) {
        if !self.json {
            keep(terminal::print(&format!("{}\n", escape::line(text.as_ref()))));
        }
    }

    /// Prints lines of the result for people that the caller has made. They are printed as they are, so the caller has
    /// already made sure that no name in them contains a line break. Prints nothing with `--json`.
    pub fn page(&self, text: impl AsRef<str>) {
        if !self.json {
            keep(terminal::print(&format!("{}\n", text.as_ref())));
        }
    }

    /// Prints the result as JSON. Prints nothing without `--json`.
    pub fn object(&self, value: &impl serde::Serialize) -> Result<(), serde_json::Error> {
        if self.json {
            keep(terminal::print_json(&format!("{}\n", serde_json::to_string(value)?)));
        }
        Ok(())
    }

    /// Prints a line about the work on standard error.
    pub fn note(&self, text: impl AsRef<str>) {
        terminal::say(&format!("{}\n", escape::line(text.as_ref())));
    }

    /// Shows progress over `total` steps on standard error: a bar on a terminal, elsewhere a line every few seconds.
    pub fn progress(&self, what: &str, total: u64) -> Progress {
        let bar = std::io::stderr().is_terminal().then(|| {
            let bar = indicatif::ProgressBar::new(total);
            let style = indicatif::ProgressStyle::with_template("{msg:24} {wide_bar} {pos}/{len}  {eta} left");
            bar.set_style(style.unwrap_or_else(|_| indicatif::ProgressStyle::default_bar()));
            bar.set_message(what.to_owned());
            bar
        });
        Progress { what: what.to_owned(), total, done: 0, bar, started: Instant::now(), said: None }
    }
}

/// Keeps an error of printing for [`finish`]. The work goes on, because its files are still wanted.
fn keep(printed: io::Result<()>) {
    if let Err(error) = printed {
        FAILED.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(error);
    }
}

/// The progress of one piece of work; made by [`Console::progress`].
pub struct Progress {
    what: String,
    total: u64,
    done: u64,
    bar: Option<indicatif::ProgressBar>,
    started: Instant,
    said: Option<Instant>,
}

impl Progress {
    /// Shows that one more step is done. `detail` names the step.
    pub fn step(&mut self, detail: &str) {
        self.advance_to(self.done + 1, detail);
    }

    /// Shows that `done` steps are done in total. `detail` names the last of them.
    pub fn advance_to(&mut self, done: u64, detail: &str) {
        self.done = done;
        let detail = escape::line(detail);
        if let Some(bar) = &self.bar {
            bar.set_message(format!("{} {detail}", self.what));
            bar.set_position(done);
            return;
        }
        let now = Instant::now();
        let due = self.said.is_none_or(|t| now - t >= Duration::from_secs(5)) || self.done == self.total;
        if due {
            self.said = Some(now);
            let left =
                self.started.elapsed().as_secs_f64() / self.done as f64 * (self.total.saturating_sub(self.done)) as f64;
            terminal::say(&format!("{}: {}/{} {detail}, {left:.0} s left\n", self.what, self.done, self.total));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
