//! Baked light on disk. A file's name is a hash of everything that determines the light. If a file is damaged, its light is
//! gathered again.

use std::path::{Path, PathBuf};

use cyclopean_analysis::files::{self, WriteError};
use sha2::{Digest, Sha256};

use super::super::error::RenderError;
use super::super::needs::FrameNeeds;
use super::super::shaders;
use super::{CLOSEST, LAST_RAYS, MOST_ROUNDS, POINTS, RAYS, SETTLED};
use crate::scene::Scene;

/// Must be changed whenever the positions of the points or the layout of the file change.
const VERSION: u32 = 1;

/// SHA-256 (hex) over scene bytes, shaders, kind of device, and how light is gathered.
pub fn key(scene: &Scene, needs: &FrameNeeds, device_kind: &str) -> String {
    let how = format!("{VERSION} {POINTS} {CLOSEST} {RAYS} {LAST_RAYS} {SETTLED} {MOST_ROUNDS} {:?}", needs.of_hits());
    hex(&Sha256::digest([scene.content_sha256.as_str(), &shaders::digest_of_reference(), &how, device_kind].join("\n")))
}

fn hex(digest: &[u8]) -> String {
    digest.iter().map(|b| format!("{b:02x}")).collect()
}

fn path(folder: &Path, key: &str) -> PathBuf {
    folder.join(format!("{key}.light"))
}

/// The content of a file: the spacing of the points in metres, and their light.
pub struct BakedLightFile {
    pub spacing: f64,
    pub values: Vec<[f32; 4]>,
}

/// Reads a file; `None` if it does not exist or is damaged.
pub fn read(folder: &Path, key: &str) -> Option<BakedLightFile> {
    let bytes = files::read(&path(folder, key), files::MOST_DATA).ok()?;
    let whole = bytes.split_at_checked(32).filter(|(digest, rest)| Sha256::digest(rest).as_slice() == *digest);
    let parts = whole.and_then(|(_, rest)| rest.split_at_checked(8)).filter(|(_, values)| values.len() % 16 == 0);
    let Some((spacing, values)) = parts else {
        tracing::warn!("{}: the file is damaged; its light is gathered again", path(folder, key).display());
        return None;
    };
    Some(BakedLightFile {
        spacing: bytemuck::pod_read_unaligned(spacing),
        values: values.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect(),
    })
}

/// Writes a file: the digest of the rest, then spacing and light.
///
/// # Errors
/// When the folder cannot be written.
pub fn write(folder: &Path, key: &str, kept: &BakedLightFile) -> Result<(), RenderError> {
    let mut rest = kept.spacing.to_ne_bytes().to_vec();
    rest.extend_from_slice(bytemuck::cast_slice(&kept.values));
    let mut bytes = Sha256::digest(&rest).to_vec();
    bytes.append(&mut rest);
    std::fs::create_dir_all(folder).map_err(|source| WriteError { path: folder.to_owned(), source })?;
    Ok(files::write_bytes(&path(folder, key), &bytes)?)
}
