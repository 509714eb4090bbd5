//! `cyclopean display`: tests whether a display keeps time, and whether it gives each eye its own picture.

mod desktop;
mod openxr;
mod shared;

use clap::{Subcommand, ValueEnum};

use crate::console::Console;
use crate::display::intervals::Intervals;

/// Test a display before a participant uses it.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Show a flickering square for a photodiode, measure the intervals between frames, and ask which eye sees what,
    /// and about depth.
    Test(TestArgs),
}

#[derive(Debug, clap::Args)]
struct TestArgs {
    /// The display to test.
    #[arg(long, value_enum, default_value_t = DisplayKind::Desktop)]
    display: DisplayKind,
    /// How long intervals are measured, seconds.
    #[arg(long, default_value_t = 5.0, value_parser = seconds)]
    seconds: f64,
    /// Ask nothing; only measure intervals.
    #[arg(long)]
    unattended: bool,
    /// Refresh rate, Hz, of a monitor that does not state it.
    #[arg(long, value_parser = hz)]
    hz: Option<f64>,
    #[command(flatten)]
    desk: super::desk::DeskArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum DisplayKind {
    Desktop,
    Openxr,
}

/// See [`Args`].
///
/// # Errors
/// This machine has no such display, or the eyes are exchanged.
pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    let Command::Test(args) = args.command;
    let found = match args.display {
        DisplayKind::Desktop => {
            let options = crate::display::desktop::DesktopOptions { hz: args.hz, ..args.desk.options() };
            desktop::test(options, args.seconds, args.unattended, console)?
        }
        DisplayKind::Openxr => openxr::test(args.seconds, args.unattended, console)?,
    };
    console.object(&found)?;
    console.line(format!("{}, timed by {}", found.display, found.timing));
    for line in found.intervals.iter().flat_map(Intervals::lines) {
        console.line(line);
    }
    if let Some((right, of)) = found.depth_right {
        let word = if right == of { "depth is seen" } else { "depth is not seen reliably" };
        console.line(format!("stereograms: {right} of {of} right; {word}"));
    }
    match found.eyes_right {
        None => Ok(()),
        Some(true) => {
            console.line("each eye sees its own picture");
            Ok(())
        }
        Some(false) => {
            anyhow::bail!(
                "the eyes are exchanged: turn the glasses or the cable round, or use another --mode; a headset's software may have them crossed"
            )
        }
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    text.parse::<f64>().ok().filter(|s| (0.5..=3600.0).contains(s)).ok_or("a number from 0.5 to 3600".to_owned())
}

fn hz(text: &str) -> Result<f64, String> {
    text.parse::<f64>().ok().filter(|s| (1.0..=1000.0).contains(s)).ok_or("a number from 1 to 1000".to_owned())
}
