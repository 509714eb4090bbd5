//! The shaders that `build.rs` compiled (without those of `shaders/display/`), and digests of them.

use sha2::{Digest, Sha256};

use crate::gpu::{Aligned, Shader};

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// SHA-256 (hex) over all shaders. It is part of every stimulus' address.
pub fn digest() -> String {
    digest_of(|_| true)
}

/// The same over the shaders on which a picture of the reference may depend: all except those whose head says
/// `// Reference: never.` When only those change, stored references stay valid.
pub fn digest_of_reference() -> String {
    digest_of(|name| !OF_VIEWS.contains(&name))
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
    fn the_reference_passes_through_its_own_stages() {
        let is_of_views = |name: &str| OF_VIEWS.contains(&name);
        for name in ["trace.comp", "shadows_reuse.comp", "shadows_reuse_ray_query.comp", "ao_filter_listed.comp"] {
            assert!(is_of_views(name), "{name}");
        }
        for name in ["path_trace.comp", "shadows.comp", "shadows_ray_query.comp", "gbuffer.frag", "composite.comp"] {
            assert!(!is_of_views(name) && ALL.iter().any(|s| s.name == name), "{name}");
        }
        assert_ne!(digest(), digest_of_reference());
    }
}
