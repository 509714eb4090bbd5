//! Where a glTF's other files come from: its folder, memory, or the URI itself; every byte read is hashed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::scene::error::Reason;

/// The place relative URIs lead to.
#[derive(Debug)]
pub enum Files {
    /// A folder on disk.
    Folder(PathBuf),
    /// Files made in memory, by name: the built-in scenes, which thereby take the same path as all others.
    Memory(BTreeMap<String, Vec<u8>>),
}

/// Changes when the same bytes become another scene than before: what is kept by a scene's hash is made again.
const READING: &[u8] = b"reading 2";

/// Reads URIs and keeps the hash over what was read, in reading order.
pub struct Reader {
    files: Files,
    hash: Sha256,
}

impl Reader {
    pub fn new(files: Files) -> Reader {
        let mut reader = Reader { files, hash: Sha256::new() };
        reader.hash(READING);
        reader
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
        } else if uri.contains("://") || uri.starts_with("file:") {
            return Err(format!("`{uri}` is not a relative path or a data URI"));
        } else {
            self.read_relative(&percent_decode(uri)?)?
        };
        self.hash(&bytes);
        Ok(bytes)
    }

    fn read_relative(&self, name: &str) -> Result<Vec<u8>, Reason> {
        match &self.files {
            Files::Folder(folder) => {
                if Path::new(name).is_absolute() {
                    return Err(format!("`{name}` is absolute; glTF paths are relative to the file"));
                }
                let path = folder.join(name);
                std::fs::read(&path).map_err(|error| format!("cannot read {}: {error}", path.display()))
            }
            Files::Memory(files) => files.get(name).cloned().ok_or_else(|| format!("there is no file `{name}`")),
        }
    }
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
