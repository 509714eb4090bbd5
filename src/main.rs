//! Arguments → a command; nothing else.

use std::process::ExitCode;

fn main() -> ExitCode {
    cyclopean::commands::main()
}
