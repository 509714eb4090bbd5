//! Every operation that writes study data to a disk, in one place, so that a test can make each single step fail.

use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use cyclopean_analysis::files::sync_directory;

/// The file system. In tests, its steps fail from a given number on, as if the program were killed there.
#[derive(Debug, Clone, Default)]
pub struct Disk {
    /// None: no step is made to fail.
    end: Option<Arc<InjectedFailure>>,
}

/// The failure that a test asks for.
#[derive(Debug)]
struct InjectedFailure {
    /// Number of steps that still succeed.
    left: AtomicI64,
    /// Length of each file (by its inode) when it was last synced: this is what a power loss keeps.
    synced: Mutex<HashMap<u64, u64>>,
}

impl Disk {
    /// The real file system, on which no step is made to fail.
    pub fn real() -> Disk {
        Disk::default()
    }

    /// A file system on which step number `steps` (from 0) is done in part and then fails, and no later step is done.
    pub fn failing_after(steps: u64) -> Disk {
        let left = AtomicI64::new(i64::try_from(steps).unwrap_or(i64::MAX));
        Disk { end: Some(Arc::new(InjectedFailure { left, synced: Mutex::default() })) }
    }

    /// Whether the failing step was reached.
    pub fn has_failed(&self) -> bool {
        self.end.as_ref().is_some_and(|end| end.left.load(Ordering::SeqCst) < 0)
    }

    /// How many bytes of a file a power loss would have kept; only a failing disk knows.
    pub fn synced_bytes(&self, path: &Path) -> Option<u64> {
        let id = file_id(&fs::metadata(path).ok()?);
        let synced = self.end.as_ref()?.synced.lock().unwrap_or_else(PoisonError::into_inner);
        Some(synced.get(&id).copied().unwrap_or(0))
    }

    /// Counts a step. Ok: do it. Err(true): do it in part, then fail. Err(false): do nothing and fail.
    fn step(&self) -> Result<(), bool> {
        match &self.end {
            None => Ok(()),
            Some(end) => match end.left.fetch_sub(1, Ordering::SeqCst) {
                n if n > 0 => Ok(()),
                n => Err(n == 0),
            },
        }
    }

    fn guard<T>(&self, work: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
        self.step().map_err(|_| stopped())?;
        work()
    }

    /// Makes a folder and its parents, readable by their owner alone. Each name is durable when this returns.
    pub fn create_folder(&self, path: &Path) -> io::Result<()> {
        if path.as_os_str().is_empty() || path.is_dir() {
            return Ok(());
        }
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        self.create_folder(parent)?;
        self.guard(|| {
            let mut builder = fs::DirBuilder::new();
            // Another program may make the folder at the same time.
            builder.recursive(true);
            #[cfg(unix)]
            std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
            builder.create(path)
        })?;
        self.sync_folder(parent)
    }

    /// Makes a new file, readable by its owner alone; fails when it exists.
    pub fn create_new(&self, path: &Path) -> io::Result<File> {
        self.guard(|| {
            let mut options = OpenOptions::new();
            options.read(true).append(true).create_new(true);
            #[cfg(unix)]
            std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
            options.open(path)
        })
    }

    /// Appends bytes; a step that fails leaves a part of them.
    pub fn append(&self, file: &mut File, bytes: &[u8]) -> io::Result<()> {
        match self.step() {
            Ok(()) => file.write_all(bytes),
            Err(true) => {
                file.write_all(&bytes[..bytes.len() / 2])?;
                Err(stopped())
            }
            Err(false) => Err(stopped()),
        }
    }

    pub fn sync(&self, file: &File) -> io::Result<()> {
        self.guard(|| file.sync_data())?;
        if let Some(end) = &self.end {
            let metadata = file.metadata()?;
            let mut synced = end.synced.lock().unwrap_or_else(PoisonError::into_inner);
            synced.insert(file_id(&metadata), metadata.len());
        }
        Ok(())
    }

    pub fn truncate(&self, file: &File, bytes: u64) -> io::Result<()> {
        self.guard(|| file.set_len(bytes))
    }

    pub fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.guard(|| fs::rename(from, to))
    }

    pub fn remove(&self, path: &Path) -> io::Result<()> {
        self.guard(|| fs::remove_file(path))
    }

    pub fn sync_folder(&self, path: &Path) -> io::Result<()> {
        self.guard(|| sync_directory(path))
    }

    /// Replaces a file. Under the final name there is the whole new file or the old one.
    pub fn replace(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let no_name = || io::Error::new(io::ErrorKind::InvalidInput, "no file name");
        let (parent, name) = (path.parent().ok_or_else(no_name)?, path.file_name().ok_or_else(no_name)?);
        let part = parent.join(format!(".{}.{}.part", name.to_string_lossy(), std::process::id()));
        // A part file may be left of a killed program that had the same process number.
        let _ = fs::remove_file(&part);
        let mut file = self.create_new(&part)?;
        let written = self.append(&mut file, bytes).and_then(|()| self.sync(&file));
        if let Err(error) = written.and_then(|()| self.rename(&part, path)) {
            let _ = fs::remove_file(&part);
            return Err(error);
        }
        self.sync_folder(parent)
    }
}

#[cfg(unix)]
fn file_id(metadata: &fs::Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(metadata)
}

/// Only tests ask for this, and they run on Unix.
#[cfg(not(unix))]
fn file_id(_metadata: &fs::Metadata) -> u64 {
    0
}

fn stopped() -> io::Error {
    io::Error::other("stopped here by a test")
}
