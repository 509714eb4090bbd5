//! Resolves the textures of one material while it is read, and collects the notes about them.

use glam::{Mat3, Vec3, Vec4};
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::texture::Info;

use crate::scene::TextureRef;
use crate::scene::error::Reason;
use crate::scene::load::accessor::Buffers;
use crate::scene::load::files::Reader;
use crate::scene::load::image::Textures;

/// What is needed to read one material: the sources that it reads from, and the lists that it adds to.
pub struct Slots<'a> {
    pub buffers: &'a Buffers,
    pub reader: &'a mut Reader,
    pub textures: &'a mut Textures,
    /// What had to be left out or approximated, without the material's name.
    pub notes: &'a mut Vec<String>,
}

impl Slots<'_> {
    /// The texture that `info` names, read as colour (`srgb`) or as data.
    pub fn texture(&mut self, info: &Info, srgb: bool) -> Result<TextureRef, Reason> {
        let texture = self.textures.slot(self.buffers, self.reader, info.index.value(), srgb)?;
        let (uv_set, transform) = self.mapping(info);
        Ok(TextureRef { texture, uv_set, transform })
    }

    /// As [`Slots::texture`], for a slot that may be empty.
    pub fn optional(&mut self, info: &Option<Info>, srgb: bool) -> Result<Option<TextureRef>, Reason> {
        info.as_ref().map(|info| self.texture(info, srgb)).transpose()
    }

    /// The UV set and the transform that `info` asks for.
    pub fn mapping(&mut self, info: &Info) -> (u32, Mat3) {
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        self.placed(info.tex_coord, transform)
    }

    /// As [`Slots::mapping`], for a texture slot whose own UV set is `tex_coord`.
    pub fn placed(&mut self, tex_coord: u32, transform: Option<&TextureTransform>) -> (u32, Mat3) {
        let set = transform.and_then(|t| t.tex_coord).unwrap_or(tex_coord);
        (self.known_set(set), matrix(transform))
    }

    /// The mean texel of a texture that is not sampled here and that only its mean stands in for; white when the slot
    /// is empty.
    pub fn mean(&mut self, info: &Option<Info>, srgb: bool) -> Result<Vec4, Reason> {
        let Some(info) = info else { return Ok(Vec4::ONE) };
        Ok(self.textures.texels(self.buffers, self.reader, info.index.value())?.mean(srgb))
    }

    fn known_set(&mut self, set: u32) -> u32 {
        if set > 1 {
            self.notes.push(format!("TEXCOORD_{set} is not read; TEXCOORD_0 stands in"));
            return 0;
        }
        set
    }
}

/// The matrix of a texture transform: uv' = T(offset) · R(rotation) · S(scale), as the extension defines it.
fn matrix(transform: Option<&TextureTransform>) -> Mat3 {
    let Some(t) = transform else { return Mat3::IDENTITY };
    let (sin, cos) = t.rotation.0.sin_cos();
    let [sx, sy] = t.scale.0;
    let matrix = Mat3::from_cols(
        Vec3::new(cos * sx, -sin * sx, 0.0),
        Vec3::new(sin * sy, cos * sy, 0.0),
        Vec3::new(t.offset.0[0], t.offset.0[1], 1.0),
    );
    if matrix.is_finite() { matrix } else { Mat3::IDENTITY }
}
