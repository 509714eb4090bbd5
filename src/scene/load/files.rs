//! Where a glTF's other files come from: its folder, memory, or the URI itself; every byte read is hashed.
//!
//! A glTF is often somebody else's. What it names is read from its own folder and the folders below alone, wherever
//! `..`, its percent-encoded form or a symbolic link may lead, unless the caller asks otherwise.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use cyclopean_analysis::files;
use sha2::{Digest, Sha256};

use super::budget::Budget;
use crate::scene::error::Reason;

/// The place relative URIs lead to.
#[derive(Debug)]
pub enum Files {
    /// A folder on disk, and whether URIs may lead out of it.
    Folder { folder: PathBuf, allow_outside: bool },
    /// Files made in memory, by name: the built-in scenes, which thereby take the same path as all others.
    Memory(BTreeMap<String, Vec<u8>>),
}

/// Changes when the same bytes become another scene than before: what is kept by a scene's hash is made again.
const READING: &[u8] = b"reading 2";

/// Reads URIs and keeps the hash over what was read, in reading order.
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
        // The length keeps two files from hashing like one longer file.
        self.hash.update((bytes.len() as u64).to_le_bytes());
        self.hash.update(bytes);
    }

    /// SHA-256 of everything so far, hex.
    pub fn finish(self) -> String {
        self.hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// The bytes behind a glTF URI: a data URI or a relative path, percent-encoded.
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
                        Refused::Outside(why) => outside(&format!("the URI `{uri}`"), why),
                        Refused::Io(error) => cannot(error),
                    })?;
                }
                files::read(&path, self.budget.left()).map_err(cannot)
            }
            Files::Memory(files) => files.get(name).cloned().ok_or_else(|| format!("there is no file `{name}`")),
        }
    }
}

/// Longer than any path that a system takes.
const LONGEST_URI: usize = 4096;

/// Why a name is not a file of a folder.
pub enum Refused {
    /// It leads out of the folder: how.
    Outside(&'static str),
    /// The system does not find it.
    Io(std::io::Error),
}

/// The sentence for what leads out of a scene's folder.
pub fn outside(what: &str, why: &str) -> Reason {
    format!(
        "{what} leads out of the scene's folder ({why}), and a scene reads nothing outside it unless --allow-outside is given"
    )
}

/// The real path of the file `name` of `folder`, with every symbolic link followed.
pub fn inside(folder: &Path, name: &str) -> Result<PathBuf, Refused> {
    // Before the system is asked: a refusal tells nothing of what is outside.
    let mut depth = 0usize;
    for part in Path::new(name).components() {
        match part {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir => depth = depth.checked_sub(1).ok_or(Refused::Outside("by `..`"))?,
            Component::RootDir | Component::Prefix(_) => return Err(Refused::Outside("it is absolute")),
        }
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let root = here.canonicalize().map_err(Refused::Io)?;
    let path = here.join(name).canonicalize().map_err(Refused::Io)?;
    if path.starts_with(&root) { Ok(path) } else { Err(Refused::Outside("by a symbolic link")) }
}

/// `data:` was stripped: `[media type][;base64],payload`.
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
