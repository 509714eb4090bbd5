//! The compiled shaders, as the build script left them.

use sha2::{Digest, Sha256};

use crate::gpu::{Aligned, Shader};

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// Stages that no picture of the reference passes through: a change of them keeps stored references.
const OF_VIEWS: [&str; 17] = [
    "accumulate.comp",
    "backface.frag",
    "backface.vert",
    "depth_pyramid.comp",
    "lights.comp",
    "reproject.comp",
    "resolve.comp",
    "resolve_select.comp",
    "shading_reuse.comp",
    "shadow_map.frag",
    "shadow_map.vert",
    "shadows_mapped.comp",
    "shadows_reuse.comp",
    "shadows_reuse_ray_query.comp",
    "trace.comp",
    "trace_one_loop.comp",
    "trace_other_eye.comp",
];

/// SHA-256 (hex) over all shaders: part of every stimulus' address.
pub fn digest() -> String {
    digest_of(|_| true)
}

/// The same over those that a picture traced through the geometry alone may follow from.
pub fn digest_of_reference() -> String {
    digest_of(|name| {
        !OF_VIEWS.contains(&name) && !["ao_", "trace_geometry"].iter().any(|start| name.starts_with(start))
    })
}

fn digest_of(counts: impl Fn(&str) -> bool) -> String {
    let mut hash = Sha256::new();
    for shader in ALL.iter().filter(|s| counts(s.name)) {
        hash.update(shader.name.as_bytes());
        hash.update(shader.bytes);
    }
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_that_is_left_out_exists() {
        for name in OF_VIEWS {
            assert!(ALL.iter().any(|s| s.name == name), "{name}");
        }
        assert_ne!(digest(), digest_of_reference());
    }
}
