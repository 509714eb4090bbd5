//! The `mos` command.

mod commands;

use std::process::ExitCode;

use clap::Parser;
use cyclopean_analysis::{Error, terminal};

fn main() -> ExitCode {
    let arguments = commands::Arguments::try_parse_from(arguments()).unwrap_or_else(|e| terminal::exit_usage(&e));
    match commands::run(arguments) {
        Ok(code) => code,
        Err(error) => {
            terminal::say_error("mos", error.as_ref());
            let usage = matches!(error.downcast_ref(), Some(Error::Usage(_)));
            ExitCode::from(if usage { 2 } else { 1 })
        }
    }
}

/// The arguments, with `--allow-kind simulated` written as `--allow-kind=simulated`.
///
/// The option's value may be left out, and a path that follows it must not be taken for one.
fn arguments() -> Vec<std::ffi::OsString> {
    let mut out: Vec<std::ffi::OsString> = Vec::new();
    for argument in std::env::args_os() {
        let kinds = argument.to_str().is_some_and(|a| {
            !a.is_empty() && a.split(',').all(|k| matches!(k, "real" | "pilot" | "simulated" | "all"))
        });
        match out.last_mut() {
            Some(last) if kinds && last == "--allow-kind" => {
                last.push("=");
                last.push(argument);
            }
            _ => out.push(argument),
        }
    }
    out
}
