//! Splits the bytes of a `.gltf` or `.glb` into its JSON, which is parsed and validated, and its binary chunk. Called
//! by [`super::document`].

use gltf::json::mesh::Semantic;
use gltf::json::validation::{Checked, Error as JsonError, Validate};
use gltf::json::{Path as JsonPath, Root};

use super::extensions::{self, ExtensionUse};
use super::limits;
use crate::scene::error::SceneError;

/// A checked document.
pub struct Parsed {
    pub root: Root,
    /// The binary chunk of a `.glb`.
    pub blob: Option<Vec<u8>>,
    pub uses: Vec<ExtensionUse>,
    /// What was left out of the document as a whole, one sentence each.
    pub notes: Vec<String>,
}

/// Splits and checks a `.gltf` or `.glb`. `file` is its name in messages.
pub fn parse(file: &str, bytes: &[u8]) -> Result<Parsed, SceneError> {
    let invalid = |reason: String| SceneError::Invalid { file: file.to_owned(), reason };
    let (json, blob) = if bytes.starts_with(b"glTF") { split_glb(bytes).map_err(invalid)? } else { (bytes, None) };
    limits::json(json).map_err(invalid)?;
    let mut root = document(json).map_err(invalid)?;
    check_version(&root.asset.version, root.asset.min_version.as_deref()).map_err(invalid)?;
    limits::names(&root).map_err(invalid)?;
    let unknown = extensions::unknown(&root);
    if !unknown.is_empty() {
        return Err(SceneError::Extension { file: file.to_owned(), names: unknown });
    }
    let uses = extensions::uses(&root);
    // The extensions that remain are all known here, whatever features the `gltf` crate was built with.
    root.extensions_required.clear();
    let mut notes = extensions::left_out(&root);
    drop_unnamed_attributes(&mut root, &mut notes);
    complete_positions(&mut root).map_err(invalid)?;
    let mut first: Option<(String, JsonError)> = None;
    root.validate(&root, JsonPath::new, &mut |path: &dyn Fn() -> JsonPath, error: JsonError| {
        let place = path().to_string();
        // An accessor without a buffer view holds zeros (glTF 2.0 §3.6.2.2). Compressed primitives have such accessors,
        // too.
        let zeros = place.starts_with("accessors[") && place.ends_with(".bufferView");
        if !(zeros && matches!(error, JsonError::Missing)) {
            first.get_or_insert((place, error));
        }
    });
    match first {
        Some((path, error)) => Err(invalid(format!("{path}: {}", error.to_string().to_lowercase()))),
        None => Ok(Parsed { root, blob, uses, notes }),
    }
}

/// Parses the JSON. The `gltf` crate requires some things that the format does not require, and others that are not
/// used here. Where they are missing they are filled in: the node lists of scenes without nodes, and empty channels for
/// animations that `KHR_animation_pointer` extends (animations are not played).
fn document(json: &[u8]) -> Result<Root, String> {
    let error = match serde_json::from_slice(json) {
        Ok(root) => return Ok(root),
        Err(error) => format!("not glTF JSON: {error}"),
    };
    let Ok(mut value) = serde_json::from_slice::<serde_json::Value>(json) else { return Err(error) };
    if !value.is_object() {
        return Err(error);
    }
    // glTF 1 names its parts where glTF 2 numbers them, so little of it can be parsed.
    let said = |key: &str| value.get("asset").and_then(|a| a.get(key)).and_then(|v| v.as_str());
    if let Some(version) = said("version") {
        check_version(version, said("minVersion"))?;
    }
    if value.get("accessors").is_some_and(serde_json::Value::is_object) {
        return Err("this is glTF 1; only glTF 2 is read".to_owned());
    }
    let list = |value: &mut serde_json::Value, key: &str| -> Vec<serde_json::Value> {
        value.get_mut(key).and_then(serde_json::Value::as_array_mut).map(std::mem::take).unwrap_or_default()
    };
    let mut scenes = list(&mut value, "scenes");
    for scene in scenes.iter_mut().filter_map(serde_json::Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| serde_json::json!([]));
    }
    let mut animations = list(&mut value, "animations");
    animations.iter_mut().for_each(|a| *a = serde_json::json!({ "channels": [], "samplers": [] }));
    (value["scenes"], value["animations"]) = (scenes.into(), animations.into());
    // If the file is wrong in another way, the error of the unchanged file is given, because it names the line.
    serde_json::from_value(value).map_err(|_| error)
}

/// Checks the version that the file is written in, and the least version that a reader must support (glTF 2.0 §5.9).
/// This reader supports 2.0.
fn check_version(version: &str, least: Option<&str>) -> Result<(), String> {
    let quoted = |text: &str| text.chars().take(40).collect::<String>();
    if !matches!(numbers(version), Some((2, _))) {
        return Err(format!("asset.version is `{}`; only glTF 2 is read", quoted(version)));
    }
    match least {
        Some(least) if numbers(least).is_none_or(|n| n > (2, 0)) => {
            Err(format!("asset.minVersion is `{}`; this program reads glTF 2.0", quoted(least)))
        }
        _ => Ok(()),
    }
}

/// Major and minor number of a version such as `2.0`.
fn numbers(version: &str) -> Option<(u32, u32)> {
    let (major, minor) = version.split_once('.')?;
    let number = |text: &str| text.bytes().all(|b| b.is_ascii_digit()).then(|| text.parse().ok()).flatten();
    Some((number(major)?, number(minor)?))
}

/// Leaves out attributes whose names are neither those of the core format nor begin with an underscore.
fn drop_unnamed_attributes(root: &mut Root, notes: &mut Vec<String>) {
    for (m, mesh) in root.meshes.iter_mut().enumerate() {
        let mut dropped = false;
        for primitive in &mut mesh.primitives {
            dropped |= primitive.attributes.remove(&Checked::Invalid).is_some();
        }
        if dropped {
            let name = mesh.name.clone().unwrap_or_else(|| format!("meshes[{m}]"));
            notes.push(format!("mesh `{name}`: attributes with names that glTF does not know are left out"));
        }
    }
}

/// Gives POSITION accessors the bounds that the format requires. Nothing here reads them, and a file without them is
/// usable otherwise. A POSITION whose accessor does not exist is refused here, because the validator trusts it.
fn complete_positions(root: &mut Root) -> Result<(), String> {
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            let Some(index) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) else { continue };
            let Some(accessor) = root.accessors.get_mut(index.value()) else {
                let at = format!("meshes[{m}].primitives[{k}].attributes.POSITION");
                return Err(format!("{at}: accessors[{}] does not exist", index.value()));
            };
            for bound in [&mut accessor.min, &mut accessor.max] {
                bound.get_or_insert_with(|| serde_json::json!([0.0, 0.0, 0.0]));
            }
        }
    }
    Ok(())
}

type JsonAndBinary<'a> = (&'a [u8], Option<Vec<u8>>);

/// Splits a `.glb`: a header (magic, version, length), then chunks (length, type, bytes), of which the first is JSON
/// and the second, if there is one, is BIN.
fn split_glb(bytes: &[u8]) -> Result<JsonAndBinary<'_>, String> {
    let word =
        |at: usize| -> Option<u32> { bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])) };
    let (version, length) = word(4).zip(word(8)).ok_or("GLB: the file ends within its 12-byte header")?;
    if version != 2 {
        return Err(format!("GLB: version {version}; only 2 is read"));
    }
    if (length as usize) > bytes.len() {
        return Err(format!("GLB: the header promises {length} bytes, the file has {}", bytes.len()));
    }
    let chunk = |at: usize, kind: u32, name: &str| -> Result<Option<&[u8]>, String> {
        let Some((size, found)) = word(at).zip(word(at + 4)) else { return Ok(None) };
        if found != kind {
            return Ok(None);
        }
        let content = bytes.get(at + 8..(at + 8).saturating_add(size as usize));
        content.map(Some).ok_or_else(|| format!("GLB: the {name} chunk of {size} bytes runs past the end"))
    };
    let json = chunk(12, 0x4E4F_534A, "JSON")?.ok_or("GLB: the first chunk is not JSON")?;
    let after = 20 + json.len().next_multiple_of(4);
    let blob = chunk(after, 0x004E_4942, "BIN")?.map(<[u8]>::to_vec);
    Ok((json, blob))
}
