//! Where the other files of a glTF come from: its folder, memory, or the URI itself. Everything that is read is hashed.
//!
//! A glTF is often somebody else's. The files that it names are read only from its own folder and the folders below it,
//! wherever `..`, its percent-encoded form or a symbolic link may lead. Only the caller can allow more.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use cyclopean_analysis::files;
use sha2::{Digest, Sha256};

use super::budget::Budget;
use crate::scene::error::Reason;

/// The place that relative URIs are resolved in.
#[derive(Debug)]
pub enum Files {
    /// A folder on disk, and whether URIs may lead out of it.
    Folder { folder: PathBuf, allow_outside: bool },
    /// Files in memory, by name. The built-in scenes use this, so that they are loaded by the same code as all others.
    Memory(BTreeMap<String, Vec<u8>>),
}

/// Must be changed whenever the same bytes become another scene than before. It is part of a scene's hash, so
/// everything that was stored under the old hash is then computed again.
const READING: &[u8] = b"reading 2";

/// Reads URIs and hashes what was read, in the order of reading.
pub struct Reader {
    files: Files,
    hash: Sha256,
    budget: Budget,
}

impl Reader {
    pub fn new(files: Files) -> Reader {
        let mut reader = Reader { files, hash: Sha256::new(), budget: Budget::default() };
        reader.hash(READING);
        reader
    }

    /// The bytes that the scene may still take, shared by all readers.
    pub fn budget(&self) -> &Budget {
        &self.budget
    }

    /// Adds bytes that did not come through [`Reader::read`] to the hash.
    pub fn hash(&mut self, bytes: &[u8]) {
        // Hashing the length as well keeps two files from having the hash of one longer file.
        self.hash.update((bytes.len() as u64).to_le_bytes());
        self.hash.update(bytes);
    }

    /// The SHA-256 of everything read so far, in hexadecimal.
    pub fn finish(self) -> String {
        self.hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// The bytes that a glTF URI stands for: a data URI, or a percent-encoded relative path.
    pub fn read(&mut self, uri: &str) -> Result<Vec<u8>, Reason> {
        let bytes = if let Some(data) = uri.strip_prefix("data:") {
            decode_data_uri(data)?
        } else if uri.len() > LONGEST_URI {
            return Err(format!("a URI has {} bytes; at most {LONGEST_URI} are read", uri.len()));
        } else if uri.contains("://") || uri.starts_with("file:") {
            return Err(format!("`{uri}` is not a relative path or a data URI"));
        } else {
            self.read_relative(uri, &percent_decode(uri)?)?
        };
        self.budget.take(bytes.len() as u64)?;
        self.hash(&bytes);
        Ok(bytes)
    }

    fn read_relative(&self, uri: &str, name: &str) -> Result<Vec<u8>, Reason> {
        match &self.files {
            Files::Folder { folder, allow_outside } => {
                if Path::new(name).is_absolute() {
                    return Err(format!("`{name}` is absolute; glTF paths are relative to the file"));
                }
                let mut path = folder.join(name);
                let cannot = |error: std::io::Error| format!("cannot read {}: {error}", folder.join(name).display());
                if !allow_outside {
                    path = inside(folder, name).map_err(|refused| match refused {
                        FileRefusal::Outside(why) => outside(&format!("the URI `{uri}`"), why),
                        FileRefusal::Io(error) => cannot(error),
                    })?;
                }
                files::read(&path, self.budget.left()).map_err(cannot)
            }
            Files::Memory(files) => files.get(name).cloned().ok_or_else(|| format!("there is no file `{name}`")),
        }
    }
}

/// The longest URI that is read, in bytes. No system takes a longer path.
const LONGEST_URI: usize = 4096;

/// Why a file cannot be read from a folder.
pub enum FileRefusal {
    /// The name leads out of the folder, in this way.
    Outside(&'static str),
    /// The system does not find the file.
    Io(std::io::Error),
}

/// The message about a name that leads out of a scene's folder.
pub fn outside(what: &str, why: &str) -> Reason {
    format!(
        "{what} leads out of the scene's folder ({why}), and a scene reads nothing outside it unless --allow-outside is given"
    )
}

/// The real path of the file `name` in `folder`, with all symbolic links resolved.
pub fn inside(folder: &Path, name: &str) -> Result<PathBuf, FileRefusal> {
    // This is checked before the system is asked, so that a refusal does not reveal what exists outside.
    let mut depth = 0usize;
    for part in Path::new(name).components() {
        match part {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir => depth = depth.checked_sub(1).ok_or(FileRefusal::Outside("by `..`"))?,
            Component::RootDir | Component::Prefix(_) => return Err(FileRefusal::Outside("it is absolute")),
        }
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let root = here.canonicalize().map_err(FileRefusal::Io)?;
    let path = here.join(name).canonicalize().map_err(FileRefusal::Io)?;
    if path.starts_with(&root) { Ok(path) } else { Err(FileRefusal::Outside("by a symbolic link")) }
}

/// Decodes what follows `data:` in a URI: `[media type][;base64],payload`.
fn decode_data_uri(data: &str) -> Result<Vec<u8>, Reason> {
    let (head, payload) = data.split_once(',').ok_or("a data URI without a comma")?;
    if head.ends_with(";base64") { decode_base64(payload) } else { percent_decode(payload).map(String::into_bytes) }
}

fn decode_base64(text: &str) -> Result<Vec<u8>, Reason> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0u32, 0u32);
    for byte in text.trim_end_matches('=').bytes() {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return Err(format!("a data URI with the byte 0x{byte:02x}, which is not base64")),
        };
        bits = (bits << 6) | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    Ok(out)
}

fn percent_decode(uri: &str) -> Result<String, Reason> {
    let bytes = uri.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let escaped = (bytes[i] == b'%')
            .then(|| bytes.get(i + 1..i + 3))
            .flatten()
            .and_then(|hex| std::str::from_utf8(hex).ok())
            .and_then(|hex| u8::from_str_radix(hex, 16).ok());
        match escaped {
            Some(byte) => {
                out.push(byte);
                i += 3;
            }
            None => {
                out.push(bytes[i]);
                i += 1;
            }
        }
    }
    String::from_utf8(out).map_err(|_| format!("`{uri}` is not UTF-8 once decoded"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_and_percent_decode() {
        assert_eq!(decode_data_uri("application/octet-stream;base64,SGVsbG8=").as_deref(), Ok(b"Hello".as_slice()));
        assert_eq!(percent_decode("a%20b%zz").as_deref(), Ok("a b%zz"));
        assert!(decode_base64("a b").is_err());
    }
}
