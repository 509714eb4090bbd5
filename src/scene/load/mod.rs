//! Loads a complete [`Scene`] from a built-in name, a path or bytes.

mod accessor;
mod assemble;
mod basis;
mod budget;
mod container;
mod document;
mod draco;
mod extensions;
mod files;
mod framing;
mod image;
mod instancing;
mod lights;
mod limits;
mod material;
mod mesh;
mod meshopt;
mod nodes;
mod repair;
mod tangents;
mod triangle_list;
mod weld;

use std::path::{Path, PathBuf};

use cyclopean_analysis::files::{self as disk, MOST_DATA, MOST_TEXT};

pub use extensions::{ExtensionUse, Treatment};
pub use files::Files;

use super::builtin;
use super::error::{Reason, SceneError};
use super::manifest::{Geometry, Manifest};
use super::{Scene, environment};
use budget::most_bytes;
use files::{FileRefusal, Reader};

/// How a scene is loaded.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Loading {
    /// Scales the triangle count of built-in geometry (0.01–4), in place of what the manifest says. Other geometry
    /// ignores it.
    pub detail: Option<f64>,
    /// Whether the files that a glTF and its side-car name may lie outside the glTF's folder.
    pub allow_outside: bool,
}

/// Loads a scene: a built-in name, a manifest (`.json`), or a `.gltf`/`.glb`.
///
/// A glTF with a side-car `NAME.cyclopean.json` beside it is loaded through that manifest. A glTF without one gets the
/// default sky and, when it has no camera, a view that frames the part with the most detail. The files that a glTF
/// names are read only from its own folder. A manifest that the caller names may name files anywhere.
///
/// # Errors
/// [`SceneError`] that names the file and the place in it: an unknown name, a missing or broken file, a required
/// extension that is not supported, an accessor out of range, a position that is not finite, …
pub fn load(source: &str) -> Result<Scene, SceneError> {
    load_with(source, Loading::default())
}

/// As [`load`], with the options in `loading`.
///
/// # Errors
/// As [`load`].
pub fn load_with(source: &str, loading: Loading) -> Result<Scene, SceneError> {
    if let Some(manifest) = builtin::manifest(source) {
        return from_manifest(source, manifest.as_bytes(), Path::new(""), None, loading);
    }
    let path = Path::new(source);
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "json" => {
            let bytes = read(path, MOST_TEXT)?;
            from_manifest(source, &bytes, folder(path), None, loading)
        }
        "gltf" | "glb" => {
            let sidecar = path.with_extension("cyclopean.json");
            if sidecar.is_file() {
                let bytes = read(&sidecar, MOST_TEXT)?;
                return from_manifest(&sidecar.display().to_string(), &bytes, folder(path), Some(path), loading);
            }
            let bytes = read(path, most_bytes())?;
            let mut reader = reader_of(folder(path), loading);
            let document = document::read(source, &bytes, &mut reader)?;
            let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
            assemble::bare(name, document, reader)
        }
        _ => Err(SceneError::Unknown { name: source.to_owned(), known: builtin::NAMES.join(", ") }),
    }
}

/// Loads a glTF that is already in memory, as [`load`] would without a side-car. `name` becomes the scene's name.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(name: &str, bytes: &[u8]) -> Result<Scene, SceneError> {
    let mut reader = Reader::new(Files::Memory(std::collections::BTreeMap::new()));
    let document = document::read(name, bytes, &mut reader)?;
    assemble::bare(name.to_owned(), document, reader)
}

fn from_manifest(
    file: &str,
    bytes: &[u8],
    folder: &Path,
    sidecar_of: Option<&Path>,
    loading: Loading,
) -> Result<Scene, SceneError> {
    let invalid = |reason: String| SceneError::Invalid { file: file.to_owned(), reason };
    let manifest: Manifest =
        serde_json::from_slice(bytes).map_err(|error| invalid(format!("not a manifest: {error}")))?;
    limits::manifest(&manifest).map_err(invalid)?;
    let (mut reader, mut document);
    match (&manifest.geometry, sidecar_of) {
        (_, Some(path)) => {
            let gltf = read(path, most_bytes())?;
            reader = reader_of(folder, loading);
            assemble::hash_manifest(&mut reader, &manifest);
            document = document::read(&path.display().to_string(), &gltf, &mut reader)?;
        }
        (Some(Geometry::File(name)), None) => {
            let path = folder.join(name);
            let gltf = read(&path, most_bytes())?;
            reader = reader_of(self::folder(&path), loading);
            assemble::hash_manifest(&mut reader, &manifest);
            document = document::read(&path.display().to_string(), &gltf, &mut reader)?;
        }
        (Some(Geometry::Builtin { name, detail: given }), None) => {
            let detail = loading.detail.unwrap_or(*given);
            let made = builtin::generate(name, detail).map_err(invalid)?;
            let gltf = made.gltf;
            reader = Reader::new(Files::Memory(made.files));
            assemble::hash_manifest(&mut reader, &manifest);
            document = document::read(name, &gltf, &mut reader)?;
        }
        (None, None) => return Err(invalid("`geometry` is missing; only a side-car may leave it out".to_owned())),
    }
    let map = match &manifest.environment {
        Some(super::manifest::EnvironmentSpec::Map(map)) => {
            // A side-car is found beside its glTF without being named, so it follows the rule of the glTF.
            let path = match sidecar_of {
                Some(_) if !loading.allow_outside => beside(folder, &map.file).map_err(invalid)?,
                _ => folder.join(&map.file),
            };
            let bytes = read(&path, MOST_DATA)?;
            reader.hash(&bytes);
            let decoded = environment::file::decode(&bytes);
            Some(decoded.map_err(|reason| invalid(format!("environment `{}`: {reason}", map.file)))?)
        }
        _ => None,
    };
    let lights = lights::of_manifest(&manifest, &mut document);
    let lights = lights.map_err(|reason| SceneError::Light { file: file.to_owned(), reason })?;
    assemble::with_manifest(&manifest, (document, lights), map, reader).map_err(invalid)
}

fn reader_of(folder: &Path, loading: Loading) -> Reader {
    Reader::new(Files::Folder { folder: folder.to_owned(), allow_outside: loading.allow_outside })
}

/// The path of the environment file that a side-car names.
fn beside(folder: &Path, name: &str) -> Result<PathBuf, Reason> {
    files::inside(folder, name).map_err(|refused| match refused {
        FileRefusal::Outside(why) => files::outside(&format!("environment `{name}`"), why),
        FileRefusal::Io(error) => format!("cannot read {}: {error}", folder.join(name).display()),
    })
}

fn read(path: &Path, most: u64) -> Result<Vec<u8>, SceneError> {
    disk::read(path, most).map_err(|source| SceneError::Read { path: path.to_owned(), source })
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}
