//! The real program with validation on, in a folder of the test's own.

use std::path::Path;
use std::process::{Command, Output};

#[allow(dead_code, reason = "each test file uses its part")]
pub fn cyclopean(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("the program starts")
}

/// The same, not started yet.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cyclopean"));
    command
        .args(arguments)
        .current_dir(folder)
        .env("CYCLOPEAN_VALIDATION", "1")
        .env("XDG_CACHE_HOME", folder.join("cache"));
    command
}

#[allow(dead_code, reason = "each test file uses its part")]
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
