//! The subcommands of `mos`, one in each file, and what they share.

pub mod check;
pub mod coverage;
pub mod export;
pub mod friedman;
pub mod input;
pub mod power;
pub mod preference;
pub mod report;
pub mod screen;
pub mod table;
pub mod test;
pub mod wilcoxon;

use std::process::ExitCode;

use anyhow::Result;
use clap::{CommandFactory, Parser, Subcommand};
use cyclopean_analysis::manual::{Completions, Manual};
use cyclopean_analysis::report::text;

/// Statistics for rating studies: mean opinion scores, paired tests, screening, planning.
///
/// Reads session journals (files, folders, patterns) or tidy CSV with the columns participant and rating.
#[derive(Parser)]
#[command(name = "mos", version, propagate_version = true)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Mean opinion scores with intervals, by condition
    Table(table::Table),
    /// Paired signed-rank tests of participants' sums, with effect sizes and corrections
    Test(test::Test),
    /// Forced choices: exact binomial tests, participant-level test, Davidson's model
    Preference(preference::Preference),
    /// Friedman's test of several conditions, followed by tests of all pairs
    Friedman(friedman::Friedman),
    /// Screening of observers by BT.500, P.910 and their agreement; it is shown, and leaves nobody out
    Screen(screen::Screen),
    /// Power and size of a planned study, by simulation
    Power(power::Power),
    /// Coverage of every kind of interval, by simulation
    Coverage(coverage::Coverage),
    /// The whole analysis as one HTML page, Markdown, LaTeX, CSV or JSON
    Report(report::Report),
    /// Write tidy CSV, a data dictionary, a Psych-DS folder and an R script from journals
    Export(export::Export),
    /// Check journals without analysing them: check sums, order, gaps, duplicates, kinds, timing
    Check(check::Check),
    /// The signed-rank test of plain numbers: one column of differences, or two columns x and y
    Wilcoxon(wilcoxon::Wilcoxon),
    /// Print a script that completes this program's command line in a shell
    Completions(Completions),
    /// Write this program's manual pages
    Man(Manual),
}

/// Runs the command.
pub fn run(arguments: Arguments) -> Result<ExitCode> {
    match arguments.command {
        Command::Table(c) => c.run(),
        Command::Test(c) => c.run(),
        Command::Wilcoxon(c) => c.run(),
        Command::Preference(c) => c.run(),
        Command::Friedman(c) => c.run(),
        Command::Screen(c) => c.run(),
        Command::Power(c) => c.run(),
        Command::Coverage(c) => c.run(),
        Command::Report(c) => c.run(),
        Command::Export(c) => c.run(),
        Command::Check(c) => c.run(),
        Command::Completions(c) => Ok(c.print(Arguments::command())?),
        Command::Man(m) => input::print(
            &m.write(Arguments::command())?
                .iter()
                .map(|path| text::line(&path.display().to_string()))
                .collect::<String>(),
        ),
    }?;
    Ok(ExitCode::SUCCESS)
}
