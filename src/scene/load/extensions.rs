//! How this program treats each glTF extension. The one table here is used by the loader and by `scene check`, and is
//! what the documentation states.

use std::collections::BTreeSet;

use gltf::json::Root;
use serde::Serialize;

/// How much of an extension reaches the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Treatment {
    /// Everything that the extension says is followed.
    Read,
    /// The extension is followed as far as a surface with a single highlight can show it.
    Approximated,
    /// The extension is not followed; the scene is complete without it.
    Ignored,
}

/// An extension that a file names, and what became of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ExtensionUse {
    pub name: String,
    /// The file says that it cannot be shown without the extension.
    pub required: bool,
    pub treatment: Treatment,
    /// What the treatment means for this extension, in words.
    pub how: String,
}

use Treatment::{Approximated, Ignored, Read};

/// Every extension that is known here. A file that requires another one is refused with its name.
pub const KNOWN: [(&str, Treatment, &str); 35] = [
    ("EXT_mesh_gpu_instancing", Read, "one instance for each translation, rotation and scale"),
    ("EXT_meshopt_compression", Read, "attributes and indices are unpacked, all filters undone"),
    ("EXT_texture_webp", Read, "the WebP picture is shown"),
    ("KHR_draco_mesh_compression", Read, "the compressed triangles are unpacked"),
    (
        "KHR_lights_punctual",
        Read,
        "directional, point and spot lights, with hard shadows unless the manifest says otherwise",
    ),
    ("KHR_materials_emissive_strength", Read, "it multiplies the emission"),
    ("KHR_materials_ior", Read, "it sets the reflectance at normal incidence"),
    ("KHR_mesh_quantization", Read, "integer attributes, normalised or not"),
    ("KHR_meshopt_compression", Read, "attributes and indices are unpacked, all filters undone"),
    ("KHR_node_visibility", Read, "nodes that are hidden at the start stay hidden, with all below them"),
    ("KHR_texture_basisu", Read, "the largest level of the KTX2 picture is unpacked"),
    ("KHR_texture_transform", Read, "offset, rotation, scale and UV set"),
    (
        "KHR_materials_clearcoat",
        Approximated,
        "a surface has one highlight: the coat's where it reflects at least half as much as what is below it",
    ),
    (
        "KHR_materials_pbrSpecularGlossiness",
        Approximated,
        "factors as they are; a specular texture is converted to metal and roughness, texel by texel",
    ),
    ("KHR_materials_specular", Approximated, "factors as they are; of textures the mean"),
    ("KHR_materials_transmission", Approximated, "transmitting surfaces are drawn as opaque ones"),
    (
        "KHR_materials_unlit",
        Approximated,
        "the base colour is emitted and reflects almost nothing; vertex colours are left out",
    ),
    ("KHR_animation_pointer", Ignored, "animations are not played"),
    ("KHR_materials_anisotropy", Ignored, "highlights are round"),
    ("KHR_materials_diffuse_transmission", Ignored, "no light passes through surfaces"),
    ("KHR_materials_dispersion", Ignored, "no light passes through surfaces"),
    ("KHR_materials_iridescence", Ignored, "thin films do not colour reflections"),
    ("KHR_materials_sheen", Ignored, "fabric has no second highlight"),
    ("KHR_materials_variants", Ignored, "the materials that meshes name themselves are drawn"),
    ("KHR_materials_volume", Ignored, "no light passes through surfaces"),
    ("KHR_materials_volume_scatter", Ignored, "no light passes through surfaces"),
    ("KHR_node_hoverability", Ignored, "nothing can be pointed at"),
    ("KHR_node_selectability", Ignored, "nothing can be selected"),
    ("KHR_audio_emitter", Ignored, "there is no sound"),
    ("KHR_interactivity", Ignored, "nothing reacts"),
    ("KHR_physics_rigid_bodies", Ignored, "nothing falls"),
    ("KHR_implicit_shapes", Ignored, "they bound what can be hit, not what is seen"),
    ("KHR_xmp", Ignored, "facts about the file"),
    ("KHR_xmp_json_ld", Ignored, "facts about the file"),
    ("MSFT_lod", Ignored, "the finest level is drawn"),
];

/// The treatment of the extension `name`; an unknown one is ignored.
pub fn treatment(name: &str) -> (Treatment, &'static str) {
    let known = KNOWN.iter().find(|(known, ..)| *known == name);
    known.map_or((Ignored, "this program does not know it"), |(_, treatment, how)| (*treatment, *how))
}

/// The names of extensions that the file requires and that are not known here, in the file's order, each once.
pub fn unknown(root: &Root) -> Vec<String> {
    let mut seen = BTreeSet::new();
    let unknown = |name: &&String| !KNOWN.iter().any(|(known, ..)| known == name) && seen.insert((*name).clone());
    root.extensions_required.iter().filter(unknown).cloned().collect()
}

/// All extensions that the file names, and what became of each, sorted by name.
pub fn uses(root: &Root) -> Vec<ExtensionUse> {
    let names: BTreeSet<&str> =
        root.extensions_used.iter().chain(&root.extensions_required).map(String::as_str).collect();
    let required: BTreeSet<&str> = root.extensions_required.iter().map(String::as_str).collect();
    let describe = |name: &str| {
        let (treatment, how) = treatment(name);
        let required = required.contains(name);
        ExtensionUse { name: name.to_owned(), required, treatment, how: how.to_owned() }
    };
    names.into_iter().map(describe).collect()
}

/// Sentences about parts of the document as a whole that are left out: material variants and animations.
pub fn left_out(root: &Root) -> Vec<String> {
    let mut said = Vec::new();
    let others = root.extensions.as_ref().map(|e| &e.others);
    let variants = others.and_then(|o| o.get("KHR_materials_variants")?.get("variants")?.as_array());
    if let Some(variants) = variants.filter(|v| !v.is_empty()) {
        let name =
            |v: &serde_json::Value| v.get("name").and_then(|n| n.as_str()).unwrap_or("without a name").to_owned();
        let names: Vec<String> = variants.iter().take(8).map(|v| format!("`{}`", name(v))).collect();
        let more = if variants.len() > 8 { ", …" } else { "" };
        said.push(format!(
            "the material variants {}{more} are not used: the default materials are drawn",
            names.join(", ")
        ));
    }
    match root.animations.len() {
        0 => {}
        n => said.push(format!("animations are not played ({n}): everything stands as its nodes say")),
    }
    said
}

#[cfg(test)]
mod tests {
    use super::super::{draco, instancing, meshopt, nodes};
    use super::*;

    #[test]
    fn the_docs_list_every_extension_with_its_treatment() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/scenes.md");
        let docs = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"));
        for (name, treatment, _) in KNOWN {
            let word = format!("{treatment:?}").to_lowercase();
            let listed = docs.lines().any(|l| l.starts_with(&format!("| `{name}` | {word}")));
            assert!(listed, "docs/scenes.md has no line `| `{name}` | {word}`");
        }
    }

    #[test]
    fn what_the_code_reads_is_known_once() {
        let names = [draco::NAME, instancing::NAME, nodes::VISIBILITY, meshopt::NAMES[0], meshopt::NAMES[1]];
        assert!(names.iter().all(|n| treatment(n).0 == Read));
        let once: BTreeSet<&str> = KNOWN.iter().map(|(name, ..)| *name).collect();
        assert_eq!(once.len(), KNOWN.len());
    }
}
