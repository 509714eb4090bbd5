//! The one way to read a file, and the one way to write one.
//!
//! Reading: only regular files are opened, and no more of one is read than its reader can use. A device can be endless,
//! and a named pipe can make its reader wait for ever. Neither is opened, whatever its name is and whatever link leads
//! to it. Writing: a file appears whole under its final name, or not at all.

use std::fs::{self, File, FileType, OpenOptions};
use std::io::{self, BufRead, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use crate::parts::{Part, folder_of};

/// The most bytes that are read of a file that people write (study, manifest, language) or that describes another file
/// (side-car, rows).
pub const MOST_TEXT: u64 = 16 << 20;

/// The most bytes that are read of a file of results or numbers, of a picture or of a font.
pub const MOST_DATA: u64 = 1 << 30;

/// Opens a regular file for reading, without waiting.
///
/// # Errors
/// What the system says, or that it is a folder, a named pipe, a device or a socket.
pub fn open(path: &Path) -> io::Result<File> {
    open_with(OpenOptions::new().read(true), path)
}

/// [`open`] with other options, such as appending.
///
/// # Errors
/// As [`open`].
pub fn open_with(options: &mut OpenOptions, path: &Path) -> io::Result<File> {
    // The type is checked before opening as well, because opening a device can already have an effect.
    match fs::metadata(path) {
        Ok(found) => regular(found.file_type())?,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    // Something else may have taken the file's place since the check. These flags keep a named pipe from blocking, and
    // a terminal from becoming this process's controlling terminal.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(options, libc::O_NONBLOCK | libc::O_NOCTTY);
    let file = options.open(path)?;
    regular(file.metadata()?.file_type())?;
    Ok(file)
}

fn regular(kind: FileType) -> io::Result<()> {
    if kind.is_file() {
        return Ok(());
    }
    let what = if kind.is_dir() { "a folder" } else { special(kind) };
    Err(io::Error::new(io::ErrorKind::InvalidInput, format!("it is {what}, and only regular files are read")))
}

#[cfg(unix)]
fn special(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match () {
        () if kind.is_fifo() => "a named pipe",
        () if kind.is_socket() => "a socket",
        () => "a device",
    }
}

#[cfg(not(unix))]
fn special(_: FileType) -> &'static str {
    "no file"
}

/// Reads all bytes of a regular file that has at most `most`.
///
/// # Errors
/// As [`open`], or that the file is larger.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    if length > most {
        return Err(too_large(&format!("it has {length} bytes"), most));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    read_at_most(file, most, &mut bytes)?;
    Ok(bytes)
}

/// [`read`] for text.
///
/// # Errors
/// As [`read`], or that the bytes are not UTF-8.
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    String::from_utf8(read(path, most)?).map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not UTF-8 text"))
}

/// Appends to `into` everything that a source such as standard input gives, which may be at most `most` bytes.
///
/// # Errors
/// What the system says, or that there is more.
pub fn read_at_most(source: impl Read, most: u64, into: &mut Vec<u8>) -> io::Result<()> {
    source.take(most.saturating_add(1)).read_to_end(into)?;
    // A file that grows while it is read holds more than its length said.
    if into.len() as u64 > most { Err(too_large("there is more", most)) } else { Ok(()) }
}

fn too_large(what: &str, most: u64) -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, format!("{what}, and at most {most} are read"))
}

/// The lines of a source, each of at most `longest` bytes. A longer line, or one that is not UTF-8, gives an error and
/// ends the iteration.
pub fn lines(mut source: impl BufRead, longest: u64) -> impl Iterator<Item = io::Result<String>> {
    let mut over = false;
    std::iter::from_fn(move || {
        if over {
            return None;
        }
        let mut line = Vec::new();
        let read = source.by_ref().take(longest.saturating_add(1)).read_until(b'\n', &mut line);
        let ended = line.pop_if(|last| *last == b'\n').is_some();
        line.pop_if(|last| ended && *last == b'\r');
        let next = match read {
            Ok(0) => return None,
            Ok(_) if line.len() as u64 > longest => Err(too_large("a line is longer", longest)),
            Ok(_) => String::from_utf8(line)
                .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "a line is not UTF-8 text")),
            Err(error) => Err(error),
        };
        over = next.is_err();
        Some(next)
    })
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_of_a_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "four").unwrap();
        assert_eq!(read(&path, 4).unwrap(), b"four");
        let error = read(&path, 3).unwrap_err().to_string();
        assert!(error.contains("4 bytes") && error.contains("at most 3"), "{error}");
        assert!(read(folder.path(), 9).unwrap_err().to_string().contains("a folder"));
        assert_eq!(read(&folder.path().join("none"), 9).unwrap_err().kind(), io::ErrorKind::NotFound);
        fs::write(&path, [0xff]).unwrap();
        assert!(read_text(&path, 9).unwrap_err().to_string().contains("UTF-8"));
    }

    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_at_once_even_behind_links() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        assert!(std::process::Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
        std::os::unix::fs::symlink("/dev/zero", at("zero")).unwrap();
        std::os::unix::fs::symlink(at("pipe"), at("link")).unwrap();
        for (name, what) in [("pipe", "a named pipe"), ("link", "a named pipe"), ("zero", "a device")] {
            for options in [OpenOptions::new().read(true), OpenOptions::new().create(true).append(true)] {
                let error = open_with(options, &at(name)).unwrap_err().to_string();
                assert!(error.contains(what), "{name}: {error}");
            }
        }
    }

    #[test]
    fn lines_are_bounded() {
        let read = |text: &str| lines(text.as_bytes(), 3).collect::<io::Result<Vec<String>>>();
        assert_eq!(read("a\r\n\nabc\nd").unwrap(), ["a", "", "abc", "d"]);
        assert_eq!(read("").unwrap(), [""; 0]);
        assert!(read("a\nabcd\nb").unwrap_err().to_string().contains("at most 3"));
    }
}
