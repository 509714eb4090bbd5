//! How many parts a scene may have. The limits are checked before the file's text is parsed: a part of three bytes
//! becomes a structure of hundreds, and every message about a part contains its name.

use gltf::json::Root;

use crate::scene::error::Reason;
use crate::scene::manifest::Manifest;

/// The most bytes of one decoded image. The crate for PNG and JPEG has the same limit.
pub const MOST_TEXEL_BYTES: u64 = 512 << 20;

/// The most bytes of a glTF's JSON. Large data belongs into a `.bin` or a `.glb`.
const MOST_JSON: usize = 512 << 20;
const MOST_OBJECTS: usize = 1 << 20;
const MOST_VALUES: usize = 1 << 24;

/// In bytes.
const LONGEST_NAME: usize = 4096;

/// The most levels of the node tree, counted from a root.
pub const MOST_DEPTH: usize = 1024;
pub const MOST_VIEWS: usize = 4096;
pub const MOST_LIGHTS: usize = 4096;

/// The most placed primitives. Each is a draw call of its own.
pub const MOST_PLACED: usize = 1 << 18;

/// The most entries of a list in a manifest.
const MOST_LISTED: usize = 1024;

/// Counts the objects and values of a JSON text without parsing it. Text that is not JSON at all is left for the parser
/// to find.
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

/// Checks the lengths of names, because names stand in messages, and one name may stand in many of them.
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

/// Checks the lengths of a manifest's lists, because each entry is looked up among all parts of its glTF.
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
        // Nothing inside a string is counted, whether the string is closed or not.
        let quoted = format!("\"{}", "{".repeat(MOST_OBJECTS + 1));
        assert_eq!(json(quoted.as_bytes()), Ok(()));
    }
}
