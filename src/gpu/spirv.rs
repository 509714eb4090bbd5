//! A compiled shader. `build.rs` writes lists of them, which `render::shaders` and the displays include.

use std::borrow::Cow;

/// A shader's name and its SPIR-V.
pub struct Shader {
    pub name: &'static str,
    pub bytes: &'static [u8],
}

impl Shader {
    /// The SPIR-V as the words that Vulkan takes.
    pub fn words(&self) -> Cow<'static, [u32]> {
        Cow::Borrowed(bytemuck::cast_slice(self.bytes))
    }
}

/// Bytes at an address that is aligned to words.
#[repr(C)]
pub struct Aligned<B: ?Sized> {
    pub _word: [u32; 0],
    pub bytes: B,
}
