//! The program `cyclopean`. It runs `commands::main`, which parses the arguments and calls a subcommand.

use std::process::ExitCode;

fn main() -> ExitCode {
    cyclopean::commands::main()
}
