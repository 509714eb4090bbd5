//! A compiled shader, as the build script leaves it.

use std::borrow::Cow;

/// Words of SPIR-V.
pub struct Shader {
    pub name: &'static str,
    pub bytes: &'static [u8],
}

impl Shader {
    /// As Vulkan takes them.
    pub fn words(&self) -> Cow<'static, [u32]> {
        Cow::Borrowed(bytemuck::cast_slice(self.bytes))
    }
}

/// Bytes that begin at a word's address.
#[repr(C)]
pub struct Aligned<B: ?Sized> {
    pub _word: [u32; 0],
    pub bytes: B,
}
