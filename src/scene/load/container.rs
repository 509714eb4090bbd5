//! Bytes → the glTF's JSON (validated) and its binary chunk.

use gltf::json::mesh::Semantic;
use gltf::json::validation::{Checked, Error as JsonError, Validate};
use gltf::json::{Path as JsonPath, Root};

use crate::scene::error::SceneError;

/// Extensions that this loader implements; anything else in `extensionsRequired` is refused by name.
pub const SUPPORTED_EXTENSIONS: [&str; 7] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Splits and checks a `.gltf` or `.glb`; `file` is for messages.
pub fn parse(file: &str, bytes: &[u8]) -> Result<(Root, Option<Vec<u8>>), SceneError> {
    let invalid = |reason: String| SceneError::Invalid { file: file.to_owned(), reason };
    let (json, blob) = if bytes.starts_with(b"glTF") { split_glb(bytes).map_err(invalid)? } else { (bytes, None) };
    let mut root: Root = serde_json::from_slice(json).map_err(|error| invalid(format!("not glTF JSON: {error}")))?;
    if !root.asset.version.starts_with("2.") {
        return Err(invalid(format!("asset.version is `{}`; only glTF 2 is read", root.asset.version)));
    }
    if let Some(unknown) = root.extensions_required.iter().find(|e| !SUPPORTED_EXTENSIONS.contains(&e.as_str())) {
        return Err(SceneError::Extension {
            file: file.to_owned(),
            extension: unknown.clone(),
            supported: SUPPORTED_EXTENSIONS.join(", "),
        });
    }
    // What is left is implemented here, whatever the parsing crate has been built with.
    root.extensions_required.clear();
    complete_positions(&mut root).map_err(invalid)?;
    let mut first: Option<(String, JsonError)> = None;
    root.validate(&root, JsonPath::new, &mut |path: &dyn Fn() -> JsonPath, error: JsonError| {
        first.get_or_insert_with(|| (path().to_string(), error));
    });
    match first {
        Some((path, error)) => Err(invalid(format!("{path}: {}", error.to_string().to_lowercase()))),
        None => Ok((root, blob)),
    }
}

/// Gives POSITION accessors the bounds that the format asks for: nothing here reads them, and a file without
/// them is whole otherwise. A POSITION that leads nowhere is refused here, before the validator trusts it.
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

type Split<'a> = (&'a [u8], Option<Vec<u8>>);

/// Header (magic, version, length), then chunks (length, type, bytes): JSON first, BIN second if any.
fn split_glb(bytes: &[u8]) -> Result<Split<'_>, String> {
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
