//! The compiled shaders, as the build script left them.

use sha2::{Digest, Sha256};

use crate::gpu::{Aligned, Shader};

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// SHA-256 (hex) over all of them: part of every stimulus' address.
pub fn digest() -> String {
    let mut hash = Sha256::new();
    for shader in ALL {
        hash.update(shader.name.as_bytes());
        hash.update(shader.bytes);
    }
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}
