//! Decodes glTF images to RGBA8 textures. An image that is used both as colour and as data becomes two textures. Called
//! by the readers of materials.
//!
//! PNG and JPEG are read as in the core format, WebP by `EXT_texture_webp`, and KTX2 by `KHR_texture_basisu`.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::Cursor;
use std::sync::Arc;

use glam::Vec4;
use gltf::json::Root;
use gltf::json::texture::{MagFilter, Texture as JsonTexture, WrappingMode};
use gltf::json::validation::Checked;

use super::accessor::Buffers;
use super::basis;
use super::budget::Budget;
use super::files::Reader;
use super::limits::MOST_TEXEL_BYTES;
use crate::scene::error::Reason;
use crate::scene::{Texture, Wrap};

/// The longest side of an image: 16,384 texels is the most that Vulkan devices take.
const MOST_WIDE: u32 = 16384;

/// Extensions that name another image for a texture. The first one that is present is used, and the core format's image
/// if there is none.
const SOURCES: [&str; 2] = ["KHR_texture_basisu", "EXT_texture_webp"];

/// The texels of an image. It is cheap to clone.
#[derive(Debug, Clone)]
pub struct DecodedImage {
    pub width: u32,
    pub height: u32,
    pub rgba8: Arc<Vec<u8>>,
}

impl DecodedImage {
    /// The mean texel, 0 to 1. For an image that is read as colour (`srgb`) it is the mean in linear light.
    pub fn mean(&self, srgb: bool) -> Vec4 {
        let mut counts = [[0u64; 256]; 4];
        for texel in self.rgba8.chunks_exact(4) {
            (0..4).for_each(|k| counts[k][usize::from(texel[k])] += 1);
        }
        let texels = (self.rgba8.len() / 4).max(1) as f64;
        let mean = |k: usize| {
            let value = |byte: usize| if srgb && k < 3 { linear(byte as u8) } else { byte as f32 / 255.0 };
            let sum: f64 = (0..256).map(|byte| counts[k][byte] as f64 * f64::from(value(byte))).sum();
            (sum / texels) as f32
        };
        Vec4::new(mean(0), mean(1), mean(2), mean(3))
    }
}

/// The linear value of an sRGB byte, 0 to 1.
pub fn linear(byte: u8) -> f32 {
    let x = f32::from(byte) / 255.0;
    if x <= 0.04045 { x / 12.92 } else { libm::powf((x + 0.055) / 1.055, 2.4) }
}

/// The sRGB byte of a linear value.
pub fn encoded(x: f32) -> u8 {
    let x = x.clamp(0.0, 1.0);
    let y = if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * libm::powf(x, 1.0 / 2.4) - 0.055 };
    (y * 255.0).round() as u8
}

/// The textures that were asked for so far. Each image is decoded once.
pub struct Textures {
    pub list: Vec<Texture>,
    slots: BTreeMap<(usize, bool), usize>,
    images: BTreeMap<usize, DecodedImage>,
    budget: Budget,
}

/// A decoded image and its index in the document.
struct Image {
    source: usize,
    decoded: DecodedImage,
}

impl Textures {
    pub fn new(budget: Budget) -> Textures {
        Textures { list: Vec::new(), slots: BTreeMap::new(), images: BTreeMap::new(), budget }
    }

    /// The index in [`Textures::list`] of glTF texture `index`, read as colour (`srgb`) or as data.
    pub fn slot(&mut self, buffers: &Buffers, reader: &mut Reader, index: usize, srgb: bool) -> Result<usize, Reason> {
        if let Some(slot) = self.slots.get(&(index, srgb)) {
            return Ok(*slot);
        }
        let image = self.image(buffers, reader, index)?;
        let texture = &buffers.root.textures[index];
        let name = texture.name.clone().unwrap_or_else(|| label(&buffers.root, image.source));
        self.push(buffers, index, name, image.decoded, srgb);
        self.slots.insert((index, srgb), self.list.len() - 1);
        Ok(self.list.len() - 1)
    }

    /// The texels of glTF texture `index`, without making a texture of them.
    pub fn texels(&mut self, buffers: &Buffers, reader: &mut Reader, index: usize) -> Result<DecodedImage, Reason> {
        Ok(self.image(buffers, reader, index)?.decoded)
    }

    /// Adds a texture with texels that were computed at load. It is sampled like glTF texture `like`.
    pub fn made(
        &mut self,
        buffers: &Buffers,
        like: usize,
        name: String,
        texels: DecodedImage,
        srgb: bool,
    ) -> Result<usize, Reason> {
        self.budget.take(texels.rgba8.len() as u64)?;
        self.push(buffers, like, name, texels, srgb);
        Ok(self.list.len() - 1)
    }

    fn image(&mut self, buffers: &Buffers, reader: &mut Reader, index: usize) -> Result<Image, Reason> {
        let texture = buffers.root.textures.get(index).ok_or_else(|| format!("textures[{index}] does not exist"))?;
        let source = source(texture, buffers.root.images.len()).map_err(|what| format!("textures[{index}] {what}"))?;
        let decoded = match self.images.entry(source) {
            Entry::Occupied(found) => found.into_mut(),
            Entry::Vacant(place) => {
                let decoded = decode(buffers, reader, source).and_then(|decoded| {
                    self.budget.take(decoded.rgba8.len() as u64)?;
                    Ok(decoded)
                });
                place.insert(decoded.map_err(|reason| format!("{}: {reason}", label(&buffers.root, source)))?)
            }
        };
        Ok(Image { source, decoded: decoded.clone() })
    }

    fn push(&mut self, buffers: &Buffers, like: usize, name: String, image: DecodedImage, srgb: bool) {
        let texture = buffers.root.textures.get(like);
        let sampler = texture.and_then(|t| t.sampler).and_then(|s| buffers.root.samplers.get(s.value()));
        let wrap = |mode: Option<&Checked<WrappingMode>>| match mode {
            Some(Checked::Valid(WrappingMode::ClampToEdge)) => Wrap::Clamp,
            Some(Checked::Valid(WrappingMode::MirroredRepeat)) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        self.list.push(Texture {
            name,
            width: image.width,
            height: image.height,
            rgba8: image.rgba8,
            srgb,
            wrap_u: wrap(sampler.map(|s| &s.wrap_s)),
            wrap_v: wrap(sampler.map(|s| &s.wrap_t)),
            nearest: matches!(sampler.and_then(|s| s.mag_filter.as_ref()), Some(Checked::Valid(MagFilter::Nearest))),
        });
    }
}

/// The index of the image that a texture shows.
fn source(texture: &JsonTexture, images: usize) -> Result<usize, Reason> {
    let others = texture.extensions.as_ref().map(|e| &e.others);
    let named = others.and_then(|o| SOURCES.iter().find_map(|name| o.get(*name)?.get("source")?.as_u64()));
    let source = named.and_then(|n| usize::try_from(n).ok()).unwrap_or(texture.source.value());
    if source < images {
        return Ok(source);
    }
    let names: Vec<&str> = others.iter().flat_map(|o| o.keys()).map(String::as_str).collect();
    Err(match names.as_slice() {
        [] => "has no image".to_owned(),
        names => format!("has no image that is read; it has {}", names.join(", ")),
    })
}

fn label(root: &Root, index: usize) -> String {
    let image = root.images.get(index);
    let name = image.and_then(|i| i.name.as_deref().or(i.uri.as_deref())).filter(|n| !n.starts_with("data:"));
    let name = name.map(|name| name.chars().take(200).collect::<String>());
    name.map_or_else(|| format!("images[{index}]"), |name| format!("image `{name}`"))
}

fn decode(buffers: &Buffers, reader: &mut Reader, index: usize) -> Result<DecodedImage, Reason> {
    let image = buffers.root.images.get(index).ok_or("does not exist")?;
    let bytes = match (&image.uri, image.buffer_view) {
        (Some(uri), _) => reader.read(uri)?,
        (None, Some(view)) => buffers.view(view.value())?.to_vec(),
        (None, None) => return Err("has neither a uri nor a bufferView".to_owned()),
    };
    // The bytes decide about the format, not the name: exporters write wrong media types.
    if basis::is_ktx2(&bytes) {
        let (width, height, texels) = basis::decode(&bytes, MOST_WIDE)?;
        return Ok(DecodedImage { width, height, rgba8: Arc::new(texels) });
    }
    let mut decoder = image::ImageReader::new(Cursor::new(&bytes))
        .with_guessed_format()
        .map_err(|error| format!("cannot be decoded: {error}"))?;
    decoder.limits(limits());
    let decoded = decoder.decode().map_err(|error| format!("cannot be decoded: {error}"))?.into_rgba8();
    let (width, height) = decoded.dimensions();
    if width == 0 || height == 0 {
        return Err("has no pixels".to_owned());
    }
    Ok(DecodedImage { width, height, rgba8: Arc::new(decoded.into_raw()) })
}

fn limits() -> image::Limits {
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MOST_WIDE);
    limits.max_image_height = Some(MOST_WIDE);
    limits.max_alloc = Some(MOST_TEXEL_BYTES);
    limits
}
