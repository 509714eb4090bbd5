//! Keeps what loaders and runtimes print on standard error off the terminal.

/// Runs `asks`. What is printed to standard error meanwhile goes to the log (`RUST_LOG=debug` shows it).
#[cfg(unix)]
pub(super) fn quietly<T>(asks: impl FnOnce() -> T) -> T {
    use std::io::{Read as _, Seek as _};
    use std::os::fd::{AsRawFd as _, FromRawFd as _, OwnedFd};

    let Some(mut kept) = unnamed_file() else { return asks() };
    // SAFETY: duplicating a descriptor touches no memory; one that is not open gives -1.
    let copy = unsafe { libc::dup(libc::STDERR_FILENO) };
    if copy < 0 {
        return asks();
    }
    // SAFETY: the copy was just made and belongs to us alone.
    let before = unsafe { OwnedFd::from_raw_fd(copy) };
    // SAFETY: both descriptors are open.
    unsafe { libc::dup2(kept.as_raw_fd(), libc::STDERR_FILENO) };
    let answer = asks();
    // SAFETY: both descriptors are open; standard error is again what it was.
    unsafe { libc::dup2(before.as_raw_fd(), libc::STDERR_FILENO) };
    let mut said = String::new();
    if kept.rewind().is_ok() && kept.read_to_string(&mut said).is_ok() {
        said.lines().filter(|l| !l.trim().is_empty()).for_each(|line| tracing::debug!("openxr: {line}"));
    }
    answer
}

/// A file that no other program sees, and that is gone with its last descriptor.
#[cfg(unix)]
fn unnamed_file() -> Option<std::fs::File> {
    let path = std::env::temp_dir().join(format!("cyclopean-openxr-{}", std::process::id()));
    let file = std::fs::File::options().read(true).write(true).create_new(true).open(&path).ok()?;
    std::fs::remove_file(&path).ok()?;
    Some(file)
}

/// On other systems it is printed.
#[cfg(not(unix))]
pub(super) fn quietly<T>(asks: impl FnOnce() -> T) -> T {
    asks()
}
