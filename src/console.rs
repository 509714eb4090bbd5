//! What a command says and when it must stop: results on stdout, everything else on stderr.

use std::io::{self, IsTerminal, Write};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use cyclopean_analysis::{escape, terminal};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Installs logging and the Ctrl-C handler; called once by `main`.
pub fn start() {
    let filter = tracing_subscriber::EnvFilter::try_from_env("CYCLOPEAN_LOG")
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("warn,winit=error"));
    // A second call (tests) keeps the first subscriber.
    let _ = tracing_subscriber::fmt().with_env_filter(filter).with_writer(|| Log).without_time().try_init();
    let handler = || {
        if INTERRUPTED.swap(true, Ordering::SeqCst) {
            // Asked twice: whole files are guaranteed by rename, so leaving now loses nothing finished.
            std::process::exit(130);
        }
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        tracing::warn!("Ctrl-C will end the program at once: {error}");
    }
}

/// Standard error for the log: where nobody reads it any more, nothing can be said of that either.
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

/// The first result that could not be printed.
static FAILED: Mutex<Option<io::Error>> = Mutex::new(None);

/// A result could not be printed.
#[derive(Debug, thiserror::Error)]
#[error("cannot write to standard output: {0}")]
pub struct Unprinted(#[source] io::Error);

/// Fails when a result did not reach standard output; a reader who has gone (`… | head`) wanted no more.
pub fn finish() -> Result<(), Unprinted> {
    FAILED.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take().map_or(Ok(()), |e| Err(Unprinted(e)))
}

/// Ctrl-C was pressed: long work stops at its next whole step.
#[derive(Debug, thiserror::Error)]
#[error("interrupted; finished files are whole and the work can be resumed")]
pub struct Interrupted;

/// Fails with [`Interrupted`] once Ctrl-C was pressed; long loops call it at each step.
pub fn check_interrupted() -> Result<(), Interrupted> {
    if INTERRUPTED.load(Ordering::SeqCst) { Err(Interrupted) } else { Ok(()) }
}

/// Where a command's words go.
#[derive(Debug, Clone, Copy)]
pub struct Console {
    json: bool,
}

impl Console {
    pub fn new(json: bool) -> Console {
        Console { json }
    }

    /// `--json` was given: exactly one object goes to stdout.
    pub fn is_json(&self) -> bool {
        self.json
    }

    /// A line of the human result; silent under `--json`.
    pub fn line(&self, text: impl AsRef<str>) {
        if !self.json {
            keep(terminal::print(&format!("{}\n", escape::line(text.as_ref()))));
        }
    }

    /// Lines of the human result that were made elsewhere, each name in them one line already.
    pub fn page(&self, text: impl AsRef<str>) {
        if !self.json {
            keep(terminal::print(&format!("{}\n", text.as_ref())));
        }
    }

    /// The JSON result; silent otherwise.
    pub fn object(&self, value: &impl serde::Serialize) -> Result<(), serde_json::Error> {
        if self.json {
            keep(terminal::print_json(&format!("{}\n", serde_json::to_string(value)?)));
        }
        Ok(())
    }

    /// A line about the work, on stderr.
    pub fn note(&self, text: impl AsRef<str>) {
        terminal::say(&format!("{}\n", escape::line(text.as_ref())));
    }

    /// Progress over `total` steps: a bar on a terminal, a plain line every few seconds elsewhere; on stderr.
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

/// What was not printed is said at the end: the work goes on, for its files.
fn keep(printed: io::Result<()>) {
    if let Err(error) = printed {
        FAILED.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(error);
    }
}

/// See [`Console::progress`].
pub struct Progress {
    what: String,
    total: u64,
    done: u64,
    bar: Option<indicatif::ProgressBar>,
    started: Instant,
    said: Option<Instant>,
}

impl Progress {
    /// One step done; `detail` says which.
    pub fn step(&mut self, detail: &str) {
        self.advance_to(self.done + 1, detail);
    }

    /// `done` steps are done in all.
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
