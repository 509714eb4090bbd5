//! How many parts a scene may have. Asked before anything is made of the file's text: parts of three bytes become
//! structures of hundreds, and what is said of each part names it.

use gltf::json::Root;

use crate::scene::error::Reason;
use crate::scene::manifest::Manifest;

/// Texels of one picture, unpacked: what the crate for PNG and JPEG allows, too.
pub const MOST_TEXEL_BYTES: u64 = 512 << 20;

/// Of a glTF's JSON; what is large belongs into a `.bin` or a `.glb`.
const MOST_JSON: usize = 512 << 20;
const MOST_OBJECTS: usize = 1 << 20;
const MOST_VALUES: usize = 1 << 24;

/// In bytes.
const LONGEST_NAME: usize = 4096;

/// Nodes from a root down.
pub const MOST_DEPTH: usize = 1024;
pub const MOST_VIEWS: usize = 4096;
pub const MOST_LIGHTS: usize = 4096;

/// Placed primitives, each a draw of its own.
pub const MOST_PLACED: usize = 1 << 18;

/// Entries of a manifest's list.
const MOST_LISTED: usize = 1024;

/// Counts objects and values without reading them. What is no JSON at all is found by whoever reads it.
pub fn json(text: &[u8]) -> Result<(), Reason> {
    if text.len() > MOST_JSON {
        return Err(format!("its JSON has {} bytes; at most {MOST_JSON} are read", text.len()));
    }
    let (mut objects, mut values) = (0usize, 1usize);
    let mut bytes = text.iter();
    while let Some(byte) = bytes.next() {
        match byte {
            b'"' => while bytes.next().is_some_and(|b| *b != b'"' && (*b != b'\\' || bytes.next().is_some())) {},
            b'{' => (objects, values) = (objects + 1, values + 1),
            b'[' | b',' => values += 1,
            _ => {}
        }
    }
    if objects > MOST_OBJECTS {
        return Err(format!("its JSON has {objects} objects; at most {MOST_OBJECTS} are read"));
    }
    if values > MOST_VALUES {
        return Err(format!("its JSON has {values} values; at most {MOST_VALUES} are read"));
    }
    Ok(())
}

/// Names stand in sentences, and one name in many of them.
pub fn names(root: &Root) -> Result<(), Reason> {
    fn check<T>(what: &str, list: &[T], name: impl Fn(&T) -> &Option<String>) -> Result<(), Reason> {
        for (i, of) in list.iter().enumerate() {
            let length = name(of).as_ref().map_or(0, String::len);
            if length > LONGEST_NAME {
                return Err(format!("{what}[{i}].name has {length} bytes; at most {LONGEST_NAME} are read"));
            }
        }
        Ok(())
    }
    check("nodes", &root.nodes, |x| &x.name)?;
    check("meshes", &root.meshes, |x| &x.name)?;
    check("materials", &root.materials, |x| &x.name)?;
    check("textures", &root.textures, |x| &x.name)?;
    check("images", &root.images, |x| &x.name)?;
    check("cameras", &root.cameras, |x| &x.name)?;
    let lights = root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    check("lights", lights.map_or(&[], |l| &l.lights), |x| &x.name)
}

/// Each of a manifest's entries is looked for among all of its glTF's.
pub fn manifest(manifest: &Manifest) -> Result<(), Reason> {
    let m = manifest;
    for (what, count) in [
        ("views", m.views.len()),
        ("paths", m.paths.len()),
        ("lights", m.lights.len()),
        ("file_lights", m.file_lights.len()),
        ("materials", m.materials.len()),
        ("motion", m.motion.len()),
    ] {
        if count > MOST_LISTED {
            return Err(format!("`{what}` has {count} entries; at most {MOST_LISTED} are read"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_and_values_are_counted_outside_of_strings() {
        assert_eq!(json(br#"{"a": "{{{{,,,,\"{{", "b": [1, 2]}"#), Ok(()));
        let many = format!("[{}]", "{},".repeat(MOST_OBJECTS + 1));
        assert!(json(many.as_bytes()).expect_err("refused").contains("objects; at most 1048576"));
        let many = "0,".repeat(MOST_VALUES);
        assert!(json(many.as_bytes()).expect_err("refused").contains("values; at most 16777216"));
        // Within a string nothing counts, closed or not.
        let quoted = format!("\"{}", "{".repeat(MOST_OBJECTS + 1));
        assert_eq!(json(quoted.as_bytes()), Ok(()));
    }
}
