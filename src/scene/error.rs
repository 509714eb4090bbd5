//! Errors of the scene loader. Each message names the file and the place in it.

use std::path::PathBuf;

/// A scene could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Neither a built-in name nor a file of a known kind.
    #[error("unknown scene `{name}`: give a built-in name ({known}), a manifest (.json), or a .gltf or .glb file")]
    Unknown { name: String, known: String },
    /// The file that the user named cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// The file requires glTF extensions that this program does not know.
    #[error(
        "{file}: requires the glTF {}, which this program does not read; docs/scenes.md lists those it does",
        listed(names)
    )]
    Extension { file: String, names: Vec<String> },
    /// A light of the manifest has impossible values: `reason` names the light and what is wrong with it.
    #[error("{file}: {reason}")]
    Light { file: String, reason: String },
    /// The content is wrong: `reason` names the place and what is wrong there.
    #[error("{file}: {reason}")]
    Invalid { file: String, reason: String },
}

/// An error message that does not name its file yet: inner functions name the place, and the outermost one adds the
/// file.
pub(crate) type Reason = String;

/// "extension `A`" or "extensions `A`, `B`".
fn listed(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().take(8).map(|name| format!("`{name}`")).collect();
    let more = if names.len() > quoted.len() { ", …" } else { "" };
    format!("extension{} {}{more}", if names.len() == 1 { "" } else { "s" }, quoted.join(", "))
}
