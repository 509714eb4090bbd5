//! The subcommands, one in each file: its arguments (`Args`) and `run(args, &Console) -> anyhow::Result<()>`.
//!
//! Exit codes: 0 done, 1 failed, 2 wrong usage (reported by clap, by [`WrongUsage`], or for a light whose values are
//! out of range).

#[cfg(feature = "gpu")]
mod ao;
mod catalogue;
mod compare;
#[cfg(feature = "gpu")]
mod demo;
#[cfg(feature = "gpu")]
mod desk;
#[cfg(feature = "gpu")]
mod device;
#[cfg(feature = "gpu")]
mod display;
#[cfg(feature = "gpu")]
mod doctor;
mod find_study;
#[cfg(feature = "gpu")]
mod live;
mod networks;
mod outside;
#[cfg(feature = "gpu")]
mod paper;
#[cfg(feature = "gpu")]
mod path;
mod pictures;
pub mod prepare;
#[cfg(feature = "gpu")]
mod render;
pub mod run;
mod scene;
#[cfg(feature = "gpu")]
mod sequence;
mod show;
#[cfg(feature = "gpu")]
mod simulated;
#[cfg(feature = "gpu")]
mod stimulus;
#[cfg(feature = "gpu")]
mod stress;
pub mod study;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use cyclopean_analysis::manual::{Completions, Manual};
use cyclopean_analysis::terminal;

use crate::console::Console;
use crate::scene::SceneError;
use crate::study::validate::StudyError;

/// A request that can never work as written, on any machine: exit code 2.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct WrongUsage(pub String);

/// Stereo-consistent screen-space reflections: render, compare, run studies.
#[derive(Debug, Parser)]
#[command(version, propagate_version = true)]
struct Cli {
    /// Print one JSON object on stdout; everything else goes to stderr.
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Scene(scene::Args),
    #[cfg(feature = "gpu")]
    Render(render::Args),
    Compare(compare::Args),
    #[cfg(feature = "gpu")]
    Paper(paper::Args),
    #[cfg(feature = "gpu")]
    Doctor(doctor::Args),
    #[cfg(feature = "gpu")]
    Demo(demo::Args),
    #[cfg(feature = "gpu")]
    Stress(stress::Args),
    #[cfg(feature = "gpu")]
    Live(live::Args),
    #[cfg(feature = "gpu")]
    Display(display::Args),
    Prepare(prepare::Args),
    Run(run::Args),
    Study(study::Args),
    /// Print a script that completes this program's command line in a shell.
    Completions(Completions),
    /// Write this program's manual pages.
    Man(Manual),
}

fn dispatch(cli: Cli) -> anyhow::Result<()> {
    let console = Console::new(cli.json);
    match cli.command {
        Command::Scene(args) => scene::run(args, &console),
        #[cfg(feature = "gpu")]
        Command::Render(args) => render::run(args, &console),
        Command::Compare(args) => compare::run(args, &console),
        #[cfg(feature = "gpu")]
        Command::Paper(args) => paper::run(args, &console),
        #[cfg(feature = "gpu")]
        Command::Doctor(args) => doctor::run(args, &console),
        #[cfg(feature = "gpu")]
        Command::Demo(args) => demo::run(args, &console),
        #[cfg(feature = "gpu")]
        Command::Stress(args) => stress::run(args, &console),
        #[cfg(feature = "gpu")]
        Command::Live(args) => live::run(args, &console),
        #[cfg(feature = "gpu")]
        Command::Display(args) => display::run(args, &console),
        Command::Prepare(args) => prepare::run(args, &console),
        Command::Run(args) => run::run(args, &console),
        Command::Study(args) => study::run(args, &console),
        Command::Completions(completions) => Ok(completions.print(Cli::command())?),
        Command::Man(manual) => {
            let pages = manual.write(Cli::command())?;
            console.object(&serde_json::json!({ "files": pages }))?;
            pages.iter().for_each(|page| console.line(page.display().to_string()));
            Ok(())
        }
    }
}

/// Parses the arguments, runs the command, and turns a failure into one sentence and an exit code.
pub fn main() -> ExitCode {
    crate::console::start();
    let cli = Cli::try_parse().unwrap_or_else(|error| terminal::exit_usage(&error));
    match dispatch(cli).and_then(|()| Ok(crate::console::finish()?)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            match error.downcast_ref::<StudyError>() {
                // The problems of a study file are printed one on each line; each is escaped already.
                Some(error @ StudyError::Invalid { .. }) => terminal::say(&format!("error: {error}\n")),
                _ => terminal::say_error("error", error.as_ref()),
            }
            ExitCode::from(if is_wrong_usage(&error) { 2 } else { 1 })
        }
    }
}

/// Whether an error is wrong usage. A light outside its range counts as a wrong value of an option does, because no
/// machine and no other file changes it.
fn is_wrong_usage(error: &anyhow::Error) -> bool {
    let is_light = error.downcast_ref::<SceneError>().is_some_and(|e| matches!(e, SceneError::Light { .. }));
    is_light || error.downcast_ref::<WrongUsage>().is_some()
}
