//! Files that are being written: each writer has a temporary name of its own beside the final one. What killed writers
//! left is removed.
//!
//! A writer makes the file `.NAME.PID.N.part` in the folder of NAME and holds a lock on it until it is done. Two
//! machines that share a folder can have equal process numbers, so a name that exists is never taken. Folders that
//! belong to a part have its name with another ending: `.folder` is being filled and will become NAME, `.dead` is being
//! removed. [`sweep`] removes the parts that no writer holds. [`crate::files`] writes through parts.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use crate::files;

/// Names that are tried before a writer gives up.
const MOST_NAMES: u32 = 10_000;

/// A temporary file that only its writer uses; it is removed on drop unless it was placed.
#[derive(Debug)]
pub struct Part {
    path: PathBuf,
    file: File,
    placed: bool,
}

impl Part {
    /// Makes a new, empty file in the folder of `path`, and locks it if the file system can.
    ///
    /// # Errors
    /// What the system says: no folder, no space, no permission.
    pub fn beside(path: &Path) -> io::Result<Part> {
        let no_name = || io::Error::new(io::ErrorKind::InvalidInput, "no file name");
        let name = path.file_name().ok_or_else(no_name)?.to_string_lossy();
        for number in 0..MOST_NAMES {
            let path = folder_of(path).join(format!(".{name}.{}.{number}.part", std::process::id()));
            let file = match File::create_new(&path) {
                Ok(file) => file,
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                Err(error) => return Err(error),
            };
            // A process that sweeps may have locked the file first, and removed it.
            let swept = matches!(file.try_lock(), Err(TryLockError::WouldBlock)) || !path.exists();
            if !swept {
                return Ok(Part { path, file, placed: false });
            }
        }
        Err(io::Error::new(io::ErrorKind::AlreadyExists, format!("{MOST_NAMES} unfinished files stand beside it")))
    }

    /// The file to write into.
    pub fn file(&self) -> &File {
        &self.file
    }

    /// Path of the folder that belongs to this part. The caller makes and fills it.
    pub fn folder(&self) -> PathBuf {
        self.path.with_extension("folder")
    }

    /// Renames the file to its final name and replaces what stands there.
    ///
    /// # Errors
    /// What the system says.
    pub fn place(mut self, path: &Path) -> io::Result<()> {
        fs::rename(&self.path, path)?;
        self.placed = true;
        Ok(())
    }

    /// Renames the part's folder to its final name. A folder that stands there already stays if `is_whole` says that it
    /// is whole, and the part's folder is then removed. Otherwise the part's folder replaces it.
    ///
    /// # Errors
    /// What the system says.
    pub fn place_folder(self, path: &Path, is_whole: impl Fn() -> bool) -> io::Result<()> {
        let folder = self.folder();
        loop {
            let error = match fs::rename(&folder, path) {
                Ok(()) => return Ok(()),
                Err(error) => error,
            };
            let taken = [io::ErrorKind::DirectoryNotEmpty, io::ErrorKind::AlreadyExists].contains(&error.kind());
            if !folder.exists() || !(taken || path.is_dir()) {
                return Err(error);
            }
            if is_whole() {
                return gone(fs::remove_dir_all(&folder));
            }
            // The old folder is renamed in one step, so that nobody finds half of it.
            let dead = self.path.with_extension("dead");
            gone(fs::rename(path, &dead))?;
            gone(fs::remove_dir_all(&dead))?;
        }
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // Once the file has its final name, another writer may own a file of the temporary name.
        if self.placed {
            return;
        }
        // The caller has reported what went wrong. What remains here is of no use.
        let _ = fs::remove_dir_all(self.folder());
        let _ = fs::remove_file(&self.path);
    }
}

/// Removes what killed writers have left in a folder, and nothing that a writer is at work on. Where the file system
/// has no locks, nothing is removed. Returns the number of parts removed.
///
/// # Errors
/// What the system says about the folder. A missing folder is no error: it holds nothing.
pub fn sweep(folder: &Path) -> io::Result<usize> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(0),
        entries => entries?,
    };
    let mut swept = 0;
    for entry in entries {
        let path = entry?.path();
        swept += usize::from(is_part(&path) && remove_if_dead(&path));
    }
    Ok(swept)
}

fn remove_if_dead(path: &Path) -> bool {
    let Ok(file) = files::open_with(OpenOptions::new().read(true).write(true), path) else { return false };
    if file.try_lock().is_err() {
        return false;
    }
    let (folder, dead) = (path.with_extension("folder"), path.with_extension("dead"));
    // The folder is moved before it is emptied. Should the lock have failed to show a writer, that writer then fails
    // instead of placing a part of its folder.
    gone(fs::remove_dir_all(&dead))
        .and_then(|()| gone(fs::rename(&folder, &dead)))
        .and_then(|()| gone(fs::remove_dir_all(&dead)))
        .and_then(|()| gone(fs::remove_file(path)))
        .is_ok()
}

/// Whether a name has the form `.NAME.PID.N.part`.
fn is_part(path: &Path) -> bool {
    let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
    let mut words = name.rsplit('.');
    let is_number = |word: Option<&str>| word.is_some_and(|w| !w.is_empty() && w.bytes().all(|b| b.is_ascii_digit()));
    name.starts_with('.') && words.next() == Some("part") && is_number(words.next()) && is_number(words.next())
}

/// The folder that a file lies in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Takes "not found" for success: what should be gone is gone.
fn gone(done: io::Result<()>) -> io::Result<()> {
    match done {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        done => done,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// What a killed writer leaves: its files, and no lock.
    fn leave(folder: &Path, name: &str) {
        fs::write(folder.join(format!("{name}.part")), "half").unwrap();
        for ending in ["folder", "dead"] {
            fs::create_dir(folder.join(format!("{name}.{ending}"))).unwrap();
            fs::write(folder.join(format!("{name}.{ending}")).join("a"), "half").unwrap();
        }
    }

    #[test]
    fn no_two_writers_share_a_name_even_with_one_process_number() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        // A part of another machine's process that has this process's number.
        let other = folder.path().join(format!(".a.json.{}.0.part", std::process::id()));
        fs::write(&other, "theirs").unwrap();
        let (one, two) = (Part::beside(&path).unwrap(), Part::beside(&path).unwrap());
        assert_ne!(one.path, two.path);
        one.place(&path).unwrap();
        drop(two);
        assert_eq!(names(folder.path()), [other.file_name().unwrap().to_str().unwrap(), "a.json"]);
        assert_eq!(fs::read(&other).unwrap(), b"theirs");
        assert!(Part::beside(&folder.path().join("none").join("a")).is_err());
    }

    #[test]
    fn what_the_dead_have_left_is_swept_and_the_living_keep_theirs() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        leave(at, ".KEY.123.0");
        fs::write(at.join(".a.json.7.12.part"), "half").unwrap();
        let others = ["a.part", ".a.part", ".a.b.1.part", ".1.part", "KEY"];
        others.iter().for_each(|name| fs::write(at.join(name), "kept").unwrap());
        let living = Part::beside(&at.join("KEY")).unwrap();
        fs::create_dir(living.folder()).unwrap();
        assert_eq!(sweep(at).unwrap(), 2);
        assert!(living.path.exists() && living.folder().exists());
        assert_eq!(names(at).len(), others.len() + 2, "{:?}", names(at));
        drop(living);
        assert_eq!(sweep(at).unwrap(), 0);
        assert_eq!(names(at).len(), others.len());
        assert_eq!(sweep(&at.join("none")).unwrap(), 0);
    }

    #[test]
    fn a_folder_takes_the_place_of_a_damaged_one_and_leaves_a_whole_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("KEY");
        let put = |text: &str, is_whole: bool| {
            let part = Part::beside(&path).unwrap();
            fs::create_dir(part.folder()).unwrap();
            fs::write(part.folder().join("a"), text).unwrap();
            part.place_folder(&path, || is_whole).unwrap();
            assert_eq!(names(folder.path()), ["KEY"]);
            fs::read_to_string(path.join("a")).unwrap()
        };
        assert_eq!(put("first", false), "first");
        assert_eq!(put("second", true), "first");
        assert_eq!(put("third", false), "third");
        // A part that was swept by mistake gives an error, and no half folder appears.
        let part = Part::beside(&path).unwrap();
        assert!(part.place_folder(&path, || true).is_err());
        assert_eq!(names(folder.path()), ["KEY"]);
    }
}
