//! Runs the program under test with Vulkan validation, in a folder of the test's own.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

pub fn cyclopean(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().expect("the program starts")
}

/// The same as a command that is not started yet.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cyclopean"));
    command
        .args(arguments)
        .current_dir(folder)
        .env("CYCLOPEAN_VALIDATION", "1")
        .env("XDG_CACHE_HOME", folder.join("cache"));
    command
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Every file below a folder, by its path there, with its bytes. Hidden files are included. `timing.json` is left out:
/// it says how long rendering took and is the only file that may differ. An unfinished file that disappears before it
/// is read is left out too.
#[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "only tests that render use it"))]
pub fn tree(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut out = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for path in std::fs::read_dir(&next).into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.file_name().is_some_and(|name| name != "timing.json")
                && let Ok(bytes) = std::fs::read(&path)
            {
                out.insert(path.strip_prefix(folder).expect("below").to_owned(), bytes);
            }
        }
    }
    out
}

/// The unfinished files of a store.
#[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "only tests that render use it"))]
pub fn unfinished(store: &Path) -> Vec<PathBuf> {
    let list = |folder: PathBuf| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let files = list(store.join("objects")).flat_map(list);
    files.filter(|path| path.extension().is_some_and(|e| e == "part")).collect()
}
