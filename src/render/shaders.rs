//! The compiled shaders, as the build script left them.

use std::borrow::Cow;

use sha2::{Digest, Sha256};

/// Words of SPIR-V.
pub struct Shader {
    pub name: &'static str,
    bytes: &'static [u8],
}

impl Shader {
    /// As Vulkan takes them.
    pub fn words(&self) -> Cow<'static, [u32]> {
        Cow::Borrowed(bytemuck::cast_slice(self.bytes))
    }
}

#[repr(C)]
struct Aligned<B: ?Sized> {
    _word: [u32; 0],
    bytes: B,
}

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
