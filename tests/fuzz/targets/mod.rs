//! What is fuzzed: each target takes any bytes as one kind of input, gives them to the program's own entry points, and
//! panics where these panic or break a promise. A refusal is no failure.
//!
//! `tests/fuzz/main.rs` runs them over the seeds in `./x test`; the crate in `fuzz/` runs them under libFuzzer.

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
    /// Of its folders below `fuzz/seeds` and `fuzz/regressions`, and of its program.
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

/// A folder of this thread, on a file system in memory where there is one.
struct Scratch(tempfile::TempDir);

thread_local! {
    static SCRATCH: Scratch = {
        let (memory, temporary) = (Path::new("/dev/shm"), std::env::temp_dir());
        // `fuzz/run` names a folder that it removes: a fuzzer ends without destructors.
        let chosen = if memory.is_dir() && std::env::var_os("TMPDIR").is_none() { memory } else { &temporary };
        Scratch(tempfile::Builder::new().prefix("cyclopean-fuzz-").tempdir_in(chosen).expect("a temporary folder"))
    };
}

/// A path in the folder of this thread.
fn path(name: &str) -> PathBuf {
    SCRATCH.with(|scratch| scratch.0.path().join(name))
}

/// A file in the folder of this thread, overwritten with these bytes.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = path(name);
    std::fs::write(&path, bytes).expect("a temporary file");
    path
}

/// Whether these bytes are one of about `n` inputs, always the same ones: for what takes too long to be done with each.
fn one_of(n: u64, bytes: &[u8]) -> bool {
    u64::from(crc32fast::hash(bytes)).is_multiple_of(n)
}

/// What the program would print of an error: making the sentence must not fail either.
fn said(error: &dyn std::fmt::Display) {
    assert!(!error.to_string().is_empty(), "an error without words");
}
