//! The targets of fuzzing. Each takes any bytes as one kind of input and gives them to the program's own entry points.
//! It panics if they panic or break a promise. It is no failure when the program refuses an input.
//!
//! `tests/fuzz/main.rs` runs the targets in `./x test`. The crate in `fuzz/` runs them under libFuzzer.

mod journal;
mod order;
mod picture;
mod replay;
mod scene;
mod stimulus;
mod study;
mod table;

pub use replay::journal_of;

use std::path::{Path, PathBuf};

/// A kind of input.
#[derive(Clone, Copy)]
pub struct Target {
    /// The name of the target's program, and of its folders below `fuzz/seeds` and `fuzz/regressions`.
    pub name: &'static str,
    pub run: fn(&[u8]),
}

pub const ALL: [Target; 10] = [
    Target { name: "study", run: study::run },
    Target { name: "order", run: order::run },
    Target { name: "replay", run: replay::run },
    Target { name: "journal", run: journal::run },
    Target { name: "csv", run: table::run },
    Target { name: "manifest", run: scene::manifest },
    Target { name: "gltf", run: scene::gltf },
    Target { name: "glb", run: scene::glb },
    Target { name: "exr", run: picture::run },
    Target { name: "stimulus", run: stimulus::run },
];

/// A temporary folder for each thread, on a file system in memory where there is one.
struct Scratch(tempfile::TempDir);

thread_local! {
    static SCRATCH: Scratch = {
        let (memory, temporary) = (Path::new("/dev/shm"), std::env::temp_dir());
        // `fuzz/run` sets TMPDIR to a folder that it removes itself, because a fuzzer exits without running
        // destructors.
        let chosen = if memory.is_dir() && std::env::var_os("TMPDIR").is_none() { memory } else { &temporary };
        Scratch(tempfile::Builder::new().prefix("cyclopean-fuzz-").tempdir_in(chosen).expect("a temporary folder"))
    };
}

/// A path in this thread's folder.
fn path(name: &str) -> PathBuf {
    SCRATCH.with(|scratch| scratch.0.path().join(name))
}

/// Writes these bytes to a file in this thread's folder, and returns its path.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = path(name);
    std::fs::write(&path, bytes).expect("a temporary file");
    path
}

/// Selects about one of `n` inputs, and always the same ones, for steps that are too slow to be done with every input.
fn one_of(n: u64, bytes: &[u8]) -> bool {
    u64::from(crc32fast::hash(bytes)).is_multiple_of(n)
}

/// Formats an error as the program would print it. This must not panic either.
fn said(error: &dyn std::fmt::Display) {
    assert!(!error.to_string().is_empty(), "an error has no message");
}
