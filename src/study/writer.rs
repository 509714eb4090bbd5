//! The only writer of journals: appends and syncs lines, and opens a journal again after the program or the power
//! failed.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufReader, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::Duration;

use chrono::{DateTime, Utc};
use cyclopean_analysis::files::{self, MOST_DATA};
use cyclopean_analysis::journal::record::{Kind, Record};
use cyclopean_analysis::journal::{self, Entry, JournalError, Verifier, VerifyError};

use super::disk::Disk;

/// A journal cannot be written or resumed. The lines that were synced before are safe.
#[derive(Debug, thiserror::Error)]
pub enum WriterError {
    #[error(
        "cannot {what} journal {}: {source}; every accepted answer is safe. Mend the cause (space, rights), then \
         `cyclopean run … --resume`", path.display()
    )]
    Io {
        what: &'static str,
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    #[error("journal {} is in use by another program; only one may write it", path.display())]
    Locked { path: PathBuf },
    #[error(transparent)]
    Journal(#[from] JournalError),
    #[error("{}: {source}. Restore the file from a copy", path.display())]
    Verify {
        path: PathBuf,
        #[source]
        source: VerifyError,
    },
    #[error("cannot write journal {}: a value has no JSON form: {source}", path.display())]
    Encode {
        path: PathBuf,
        #[source]
        source: serde_json::Error,
    },
}

/// When what was written must be on the disk.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Durability {
    /// At every sync of the protocol, as sessions with people need.
    #[default]
    Synced,
    /// Whenever the system writes it; only for simulated observers.
    Relaxed,
}

/// See the module's documentation. It holds a lock on the file.
#[derive(Debug)]
pub struct JournalWriter {
    disk: Disk,
    file: File,
    path: PathBuf,
    kind: Kind,
    durability: Durability,
    seq: u64,
    last_ns: u64,
    last_wall: DateTime<Utc>,
    bytes: u64,
    synced_bytes: u64,
    line: Vec<u8>,
}

impl JournalWriter {
    /// Makes a new file; its name is durable when this returns.
    ///
    /// # Errors
    /// The file exists, or the folder cannot be written.
    pub fn create(disk: Disk, path: &Path, kind: Kind, durability: Durability) -> Result<JournalWriter, WriterError> {
        let fail = |what| move |source| WriterError::Io { what, path: path.to_owned(), source };
        let file = disk.create_new(path).map_err(fail("create"))?;
        lock(&file, path)?;
        if let Some(parent) = path.parent() {
            disk.sync_folder(parent).map_err(fail("create"))?;
        }
        Ok(JournalWriter::around(disk, file, path, kind, durability))
    }

    fn around(disk: Disk, file: File, path: &Path, kind: Kind, durability: Durability) -> JournalWriter {
        JournalWriter {
            disk,
            file,
            path: path.to_owned(),
            kind,
            durability,
            seq: 0,
            last_ns: 0,
            last_wall: Utc::now(),
            bytes: 0,
            synced_bytes: 0,
            line: Vec::new(),
        }
    }

    /// Opens a journal to append to it. `take` gets every entry; a torn last line is set aside in a file beside it.
    ///
    /// Returns the writer and the number of bytes that were set aside.
    ///
    /// # Errors
    /// A line before the last is damaged, the file is in use, or `take` refuses an entry.
    pub fn reopen<E: From<WriterError>>(
        disk: Disk,
        path: &Path,
        durability: Durability,
        mut take: impl FnMut(Entry) -> Result<(), E>,
    ) -> Result<(JournalWriter, u64), E> {
        let fail = |what| move |source| WriterError::Io { what, path: path.to_owned(), source };
        let file = files::open_with(OpenOptions::new().read(true).append(true), path).map_err(fail("open"))?;
        lock(&file, path)?;
        let mut writer = JournalWriter::around(disk, file, path, Kind::Real, durability);
        let source = writer.file.try_clone().map_err(fail("open"))?;
        let mut reader = journal::read_from(path, BufReader::with_capacity(1 << 18, source));
        let mut verifier = Verifier::default();
        let mut torn = false;
        // The file was created, but the program ended before the first line: no entries, no error.
        let empty = writer.file.metadata().map_err(fail("open"))?.len() == 0;
        for entry in reader.by_ref().take(if empty { 0 } else { usize::MAX }) {
            let entry = match entry {
                Ok(entry) => entry,
                Err(JournalError::Torn { .. }) => {
                    torn = true;
                    break;
                }
                Err(error) => return Err(WriterError::from(error).into()),
            };
            verifier.check(&entry).map_err(|source| WriterError::Verify { path: path.to_owned(), source })?;
            (writer.seq, writer.kind, writer.last_ns, writer.last_wall) =
                (entry.seq + 1, entry.kind, entry.t_ns, entry.wall);
            take(entry)?;
        }
        writer.bytes = reader.good_bytes();
        writer.synced_bytes = writer.bytes;
        let cut = if torn { set_aside(&writer.disk, &writer.file, path, writer.bytes)? } else { 0 };
        Ok((writer, cut))
    }

    /// Appends a record. When this returns, the system has it, but not necessarily the disk.
    ///
    /// # Errors
    /// The disk is full or gone; the last line may then be torn, and nothing more must be written.
    pub fn append(&mut self, t_ns: u64, record: Record) -> Result<(), WriterError> {
        self.last_ns = self.last_ns.max(t_ns);
        self.last_wall = Utc::now();
        let entry = Entry { seq: self.seq, t_ns: self.last_ns, wall: self.last_wall, kind: self.kind, record };
        self.line.clear();
        journal::encode(&entry, &mut self.line)
            .map_err(|source| WriterError::Encode { path: self.path.clone(), source })?;
        self.disk.append(&mut self.file, &self.line).map_err(|source| WriterError::Io {
            what: "write",
            path: self.path.clone(),
            source,
        })?;
        self.seq += 1;
        self.bytes += self.line.len() as u64;
        Ok(())
    }

    /// Everything appended so far is on the disk when this returns.
    ///
    /// # Errors
    /// The disk cannot sync the file.
    pub fn sync(&mut self) -> Result<(), WriterError> {
        if self.durability == Durability::Synced {
            self.disk.sync(&self.file).map_err(|source| WriterError::Io {
                what: "sync",
                path: self.path.clone(),
                source,
            })?;
            self.synced_bytes = self.bytes;
        }
        Ok(())
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of lines so far.
    pub fn lines(&self) -> u64 {
        self.seq
    }

    /// The session clock of the last line.
    pub fn last_ns(&self) -> u64 {
        self.last_ns
    }

    /// Wall time of the last line.
    pub fn last_wall(&self) -> DateTime<Utc> {
        self.last_wall
    }

    /// Number of bytes that a power loss cannot take.
    pub fn synced_bytes(&self) -> u64 {
        self.synced_bytes
    }
}

/// How often a lock is tried, and how long the wait between two tries is. A process that is being started holds its
/// parent's files open for an instant.
const LOCK_TRIES: u32 = 10;
const LOCK_WAIT: Duration = Duration::from_millis(20);

/// Takes a journal's lock, which is released when the file is closed.
///
/// # Errors
/// Another program holds the lock.
pub fn lock(file: &File, path: &Path) -> Result<(), WriterError> {
    for _ in 0..LOCK_TRIES {
        match file.try_lock() {
            Ok(()) => return Ok(()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(LOCK_WAIT),
            Err(TryLockError::Error(source)) => {
                return Err(WriterError::Io { what: "lock", path: path.to_owned(), source });
            }
        }
    }
    Err(WriterError::Locked { path: path.to_owned() })
}

/// Copies all bytes from `keep` on into a file beside the journal, then cuts them off. Returns their number.
///
/// # Errors
/// The copy cannot be made durable; nothing is cut then.
pub fn set_aside(disk: &Disk, file: &File, path: &Path, keep: u64) -> Result<u64, WriterError> {
    let fail = |source| WriterError::Io { what: "repair", path: path.to_owned(), source };
    let mut tail = Vec::new();
    let mut source = file;
    let read = source.seek(SeekFrom::Start(keep)).and_then(|_| files::read_at_most(source, MOST_DATA, &mut tail));
    read.map_err(fail)?;
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let aside = (1u32..)
        .map(|i| path.with_file_name(format!("{name}.aside-{i}")))
        .find(|p| !p.exists())
        .unwrap_or_else(|| path.with_extension("aside"));
    disk.replace(&aside, &tail).map_err(fail)?;
    disk.truncate(file, keep).and_then(|()| disk.sync(file)).map_err(fail)?;
    Ok(tail.len() as u64)
}
