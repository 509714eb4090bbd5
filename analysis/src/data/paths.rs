//! Finds journals and tidy CSV files by paths of files, folders and patterns.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// What a path turned out to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A tidy CSV file; `-` is standard input.
    Csv(PathBuf),
    /// Journals, sorted by path.
    Journals(Vec<PathBuf>),
}

/// Sorts paths into CSV files and journals. Folders are searched for `.jsonl` files, with all folders in them.
///
/// Head poses (`.poses.jsonl`) beside a journal are passed over, whether a path, a folder or a pattern names them.
///
/// A path with `*` or `?` that does not exist as it stands is a pattern, for shells that expand none;
/// `**` stands for any number of folders.
///
/// # Errors
/// [`Error::Read`] for what cannot be read, [`Error::Data`] for a folder or pattern without a journal, or head poses
/// alone.
pub fn expand(paths: &[PathBuf]) -> Result<Vec<Source>> {
    let mut sources = Vec::new();
    let mut journals = Vec::new();
    let mut poses = None;
    for path in paths {
        let matches = match path.to_str() {
            Some(text) if text.contains(['*', '?']) && !path.exists() => {
                let mut found = Vec::new();
                let parts: Vec<&str> = text.split('/').filter(|p| !p.is_empty()).collect();
                let start = if text.starts_with('/') { PathBuf::from("/") } else { PathBuf::new() };
                pattern(&start, &parts, &mut found);
                if found.is_empty() {
                    return Err(Error::data(format!("nothing matches the pattern {text}")));
                }
                found.sort();
                found.dedup();
                found
            }
            _ => vec![path.clone()],
        };
        for path in matches {
            if path.is_dir() {
                let before = journals.len();
                walk(&path, &mut journals)?;
                if journals.len() == before {
                    return Err(Error::data(format!(
                        "no journal (.jsonl) in the folder {}; give a folder of sessions or a tidy CSV file",
                        path.display()
                    )));
                }
            } else if is_poses(&path) {
                poses = Some(path);
            } else if path.extension().is_some_and(|e| e == "jsonl") {
                journals.push(path);
            } else {
                sources.push(Source::Csv(path));
            }
        }
    }
    if let (Some(path), true, true) = (poses, journals.is_empty(), sources.is_empty()) {
        let name = path.display();
        return Err(Error::data(format!(
            "{name} holds head poses, which are never analysed; give the journal beside it"
        )));
    }
    if !journals.is_empty() {
        journals.sort();
        journals.dedup();
        sources.push(Source::Journals(journals));
    }
    Ok(sources)
}

/// Whether the file holds a session's head poses instead of its journal.
fn is_poses(path: &Path) -> bool {
    path.file_name().is_some_and(|n| n.to_string_lossy().ends_with(".poses.jsonl"))
}

fn walk(folder: &Path, found: &mut Vec<PathBuf>) -> Result<()> {
    let error = |source| Error::Read { path: folder.to_owned(), source };
    for entry in fs::read_dir(folder).map_err(error)? {
        let entry = entry.map_err(error)?;
        let path = entry.path();
        // Links are not followed, because a loop of links would never end.
        if entry.file_type().map_err(error)?.is_dir() {
            walk(&path, found)?;
        } else if path.extension().is_some_and(|e| e == "jsonl") && !is_poses(&path) {
            found.push(path);
        }
    }
    Ok(())
}

fn pattern(at: &Path, parts: &[&str], found: &mut Vec<PathBuf>) {
    let Some((part, rest)) = parts.split_first() else {
        if at.exists() {
            found.push(at.to_owned());
        }
        return;
    };
    if *part == "**" {
        pattern(at, rest, found);
    } else if !part.contains(['*', '?']) {
        return pattern(&at.join(part), rest, found);
    }
    let folder = if at.as_os_str().is_empty() { Path::new(".") } else { at };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let next = at.join(&name);
        if *part == "**" {
            if entry.file_type().is_ok_and(|t| t.is_dir()) {
                pattern(&next, parts, found);
            }
        } else if name.to_str().is_some_and(|n| matches(part.as_bytes(), n.as_bytes()) && !n.starts_with('.')) {
            pattern(&next, rest, found);
        }
    }
}

/// Whether a name matches a pattern: `*` stands for any run of bytes, `?` for any one byte.
fn matches(pattern: &[u8], name: &[u8]) -> bool {
    match (pattern.split_first(), name.split_first()) {
        (None, None) => true,
        (Some((b'*', rest)), _) => matches(rest, name) || (!name.is_empty() && matches(pattern, &name[1..])),
        (Some((p, rest)), Some((n, tail))) if *p == b'?' || p == n => matches(rest, tail),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_and_folders_find_the_journals() {
        let dir = tempfile::tempdir().unwrap();
        for p in ["study/p01/a.jsonl", "study/p02/b.jsonl", "study/p02/b.poses.jsonl", "study/p02/x.csv"] {
            let path = dir.path().join(p);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        let at = |p: &str| dir.path().join(p);
        let both = vec![Source::Journals(vec![at("study/p01/a.jsonl"), at("study/p02/b.jsonl")])];
        assert_eq!(expand(&[dir.path().to_owned()]).unwrap(), both);
        assert_eq!(expand(&[at("study/p0?/?.jsonl")]).unwrap(), both);
        assert_eq!(expand(&[at("**/?.jsonl")]).unwrap(), both);
        assert_eq!(expand(&[at("study/p0?/*.jsonl")]).unwrap(), both);
        let named = ["study/p01/a.jsonl", "study/p02/b.jsonl", "study/p02/b.poses.jsonl"].map(at);
        assert_eq!(expand(&named).unwrap(), both);
        assert!(expand(&named[2..]).unwrap_err().to_string().contains("never analysed"));
        assert!(expand(&[at("nothing/*.jsonl")]).is_err());
        assert!(matches(b"p*2", b"p02") && !matches(b"p*2", b"p03"));
    }
}
