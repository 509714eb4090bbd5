//! Writing: whole under the final name, or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::parts::{Part, folder_of};

/// A file could not be written. Under its final name there is what was there before.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    /// The final name.
    pub path: PathBuf,
    /// What the system said.
    #[source]
    pub source: io::Error,
}

/// Writes `path` through a temporary file beside it that belongs to this writer alone. The content is synced, the file
/// is renamed, and then the folder is synced.
///
/// A crash at any moment leaves the old file or the new one, never a part of it. Of several writers at once, the last
/// one's file stays.
///
/// # Errors
/// [`WriteError`] with the final path when the folder is missing, full or read-only, or `fill` fails.
pub fn write_whole(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), WriteError> {
    let written = Part::beside(path).and_then(|part| {
        let mut out = BufWriter::new(part.file());
        fill(&mut out)?;
        out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
        part.place(path)?;
        sync_directory(folder_of(path))
    });
    written.map_err(|source| WriteError { path: path.to_owned(), source })
}

/// Fills a folder beside `path` and then moves it there as a whole. A folder that stands there already stays if
/// `is_whole` says that it is whole. Of several writers at once the first one's folder stays, so all must write equally
/// good content.
///
/// # Errors
/// What `fill` says, and `path` is then as it was; or [`WriteError`].
pub fn write_folder<E: From<WriteError>>(
    path: &Path,
    is_whole: impl Fn() -> bool,
    fill: impl FnOnce(&Path) -> Result<(), E>,
) -> Result<(), E> {
    let error = |source| E::from(WriteError { path: path.to_owned(), source });
    let part = Part::beside(path).map_err(error)?;
    let folder = part.folder();
    fs::create_dir(&folder).map_err(error)?;
    fill(&folder)?;
    part.place_folder(path, is_whole).and_then(|()| sync_directory(folder_of(path))).map_err(error)
}

/// [`write_whole`] for bytes that are in memory.
///
/// # Errors
/// As [`write_whole`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_whole(path, |out| out.write_all(bytes))
}

/// Makes a created or renamed entry durable. On Unix the folder is synced; elsewhere the system does it.
///
/// # Errors
/// What the system says.
pub fn sync_directory(directory: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(directory)?.sync_all() } else { Ok(()) }
}
