//! Reading: only regular files are opened, and no more of one is read than its reader can use.

use std::fs::{self, File, FileType, OpenOptions};
use std::io::{self, BufRead, Read};
use std::path::Path;

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
