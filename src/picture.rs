//! Reads and writes stereo pictures. Linear radiance is stored as multi-view OpenEXR, and what a display shows as a PNG
//! with both eyes side by side. The commands, `compare` and the displays call it; it needs no graphics card.

use std::fmt::Display;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use cyclopean_analysis::files::{self, MOST_DATA, WriteError};
use exr::prelude as exr_io;
use exr::prelude::{
    AnyChannel, AnyChannels, FlatSamples, Image, Layer, LayerAttributes, ReadChannels as _, ReadLayers as _,
    WritableImage,
};

use crate::scene::Eye;
use crate::scene::environment::file::{MOST_SAMPLES, exr_head};

/// Linear Rec. 709 colours of both eyes, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct StereoPicture {
    pub width: u32,
    pub height: u32,
    /// The pixels of the left and of the right eye, row-major.
    pub eyes: [Vec<[f32; 3]>; 2],
}

impl StereoPicture {
    /// The pixels by eye.
    pub fn eyes(&self) -> [&[[f32; 3]]; 2] {
        self.eyes.each_ref().map(Vec::as_slice)
    }
}

/// A picture could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("cannot read {}: {reason}", path.display())]
    Read { path: PathBuf, reason: String },
    #[error("cannot encode {}: {reason}", path.display())]
    Encode { path: PathBuf, reason: String },
}

/// Names of the views by eye. The first is the file's default view.
const VIEWS: [&str; 2] = ["left", "right"];

/// One part of a multi-view file: the colour, or a named layer beside it.
pub struct Part<'a> {
    /// The layer's name, such as `reflection`. It is empty for the colour.
    pub layer: &'a str,
    pub picture: &'a StereoPicture,
}

/// The name of a channel by OpenEXR's convention for several views. The colour of the default view has bare names
/// (`R`), that of the other view `view.channel`, and a layer `layer.view.channel`.
fn channel_name(layer: &str, eye: Eye, channel: &str) -> String {
    let view = VIEWS[eye.layer()];
    match (layer, eye) {
        ("", Eye::Left) => channel.to_owned(),
        ("", Eye::Right) => format!("{view}.{channel}"),
        (layer, _) => format!("{layer}.{view}.{channel}"),
    }
}

/// Writes a multi-view EXR with 32-bit floats and lossless compression. All parts must have the same size.
///
/// # Errors
/// [`PictureError`] naming the file.
pub fn write_exr(path: &Path, parts: &[Part<'_>]) -> Result<(), PictureError> {
    let encode = |reason: String| PictureError::Encode { path: path.to_owned(), reason };
    let first = parts.first().ok_or_else(|| encode("no picture".to_owned()))?.picture;
    let size = exr_io::Vec2(first.width as usize, first.height as usize);
    let mut list = exr_io::SmallVec::new();
    for part in parts {
        for eye in Eye::BOTH {
            for (c, name) in ["R", "G", "B"].iter().enumerate() {
                let samples = part.picture.eyes[eye.layer()].iter().map(|t| t[c]).collect();
                let name = channel_name(part.layer, eye, name);
                list.push(AnyChannel::new(exr_io::Text::new_or_panic(&name), FlatSamples::F32(samples)));
            }
        }
    }
    let encoding = exr_io::Encoding::SMALL_LOSSLESS;
    let views = VIEWS.iter().map(exr_io::Text::new_or_panic).collect();
    let attributes = LayerAttributes { multi_view_names: Some(views), ..LayerAttributes::default() };
    let image = Image::from_layer(Layer::new(size, attributes, encoding, AnyChannels::sort(list)));
    let mut bytes = Cursor::new(Vec::new());
    // With one thread the same pictures give the same bytes every time.
    image.write().non_parallel().to_buffered(&mut bytes).map_err(|e| encode(e.to_string()))?;
    Ok(files::write_bytes(path, bytes.get_ref())?)
}

/// The most bytes of an EXR file: the most samples at four bytes each, and room for the head. Compression only makes a
/// file smaller.
const MOST_BYTES: u64 = 4 * MOST_SAMPLES + MOST_DATA;

/// Reads the bytes of an EXR file and parses its head.
fn exr_bytes(path: &Path) -> Result<(Vec<u8>, exr::meta::MetaData), PictureError> {
    let fail = |reason: &dyn Display| PictureError::Read { path: path.to_owned(), reason: reason.to_string() };
    let bytes = files::read(path, MOST_BYTES).map_err(|e| fail(&e))?;
    let head = exr_head(&bytes).map_err(|e| fail(&e))?;
    Ok((bytes, head))
}

/// Reads a PNG as RGBA bytes, such as a stimulus's two eyes side by side.
///
/// # Errors
/// [`PictureError::Read`] when the file cannot be read, is no PNG, or would unpack to more than 512 MiB.
pub fn read_png(path: &Path) -> Result<image::RgbaImage, PictureError> {
    let fail = |reason: &dyn Display| PictureError::Read { path: path.to_owned(), reason: reason.to_string() };
    let bytes = files::read(path, MOST_DATA).map_err(|e| fail(&e))?;
    // The crate's default limit applies: 512 MiB of decoded data.
    let decoded = image::ImageReader::with_format(Cursor::new(bytes), image::ImageFormat::Png).decode();
    Ok(decoded.map_err(|e| fail(&e))?.into_rgba8())
}

/// The width and height of a PNG. Only its head is read.
///
/// # Errors
/// [`PictureError::Read`] when the file is no PNG.
pub fn png_size(path: &Path) -> Result<(u32, u32), PictureError> {
    let fail = |reason: &dyn Display| PictureError::Read { path: path.to_owned(), reason: reason.to_string() };
    let file = std::io::BufReader::new(files::open(path).map_err(|e| fail(&e))?);
    image::ImageReader::with_format(file, image::ImageFormat::Png).into_dimensions().map_err(|e| fail(&e))
}

/// Reads one part of both views: the colour where `layer` is empty, otherwise the layer of that name (`reflection`).
///
/// # Errors
/// [`PictureError::Read`] when the file cannot be read, is no EXR, or lacks a channel.
pub fn read_exr(path: &Path, layer: &str) -> Result<StereoPicture, PictureError> {
    let fail = |reason: String| PictureError::Read { path: path.to_owned(), reason };
    let (bytes, _) = exr_bytes(path)?;
    let image = exr_io::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| fail(e.to_string()))?;
    let data = &image.layer_data;
    let (width, height) = (data.size.0, data.size.1);
    let mut eyes = [Vec::new(), Vec::new()];
    for eye in Eye::BOTH {
        let mut texels = vec![[0.0f32; 3]; width * height];
        for (c, channel) in ["R", "G", "B"].iter().enumerate() {
            let name = channel_name(layer, eye, channel);
            let found = data.channel_data.list.iter().find(|a| a.name.eq_case_insensitive(&name));
            let found = found.ok_or_else(|| fail(format!("it has no channel `{name}`")))?;
            for (texel, value) in texels.iter_mut().zip(found.sample_data.values_as_f32()) {
                texel[c] = value;
            }
        }
        eyes[eye.layer()] = texels;
    }
    Ok(StereoPicture { width: width as u32, height: height as u32, eyes })
}

/// Whether an EXR file has this layer. An empty name asks for the colour.
///
/// # Errors
/// [`PictureError::Read`] when the file is no EXR.
pub fn has_layer(path: &Path, layer: &str) -> Result<bool, PictureError> {
    let (_, meta) = exr_bytes(path)?;
    let name = channel_name(layer, Eye::Left, "R");
    let mut channels = meta.headers.iter().flat_map(|h| &h.channels.list);
    Ok(channels.any(|c| c.name.eq_case_insensitive(&name)))
}

/// Writes both eyes side by side, the left eye on the left, as an 8-bit sRGB PNG. `eyes` are RGBA bytes, rows from the
/// top; alpha is dropped.
///
/// # Errors
/// [`PictureError`] naming the file.
pub fn write_side_by_side(path: &Path, width: u32, height: u32, eyes: [&[u8]; 2]) -> Result<(), PictureError> {
    let (w, h) = (width as usize, height as usize);
    let mut rgb = Vec::with_capacity(w * h * 2 * 3);
    for y in 0..h {
        for eye in eyes {
            for texel in eye[y * w * 4..(y + 1) * w * 4].chunks_exact(4) {
                rgb.extend_from_slice(&texel[..3]);
            }
        }
    }
    write_png(path, 2 * width, height, &rgb)
}

/// Encodes RGB bytes, rows from the top, as an 8-bit sRGB PNG and gives its bytes. `path` is only the name in an error.
///
/// # Errors
/// [`PictureError::Encode`].
pub fn encode_png(path: &Path, width: u32, height: u32, rgb: &[u8]) -> Result<Vec<u8>, PictureError> {
    let mut bytes = Cursor::new(Vec::new());
    let (color, format) = (image::ExtendedColorType::Rgb8, image::ImageFormat::Png);
    image::write_buffer_with_format(&mut bytes, rgb, width, height, color, format)
        .map_err(|e| PictureError::Encode { path: path.to_owned(), reason: e.to_string() })?;
    Ok(bytes.into_inner())
}

fn write_png(path: &Path, width: u32, height: u32, rgb: &[u8]) -> Result<(), PictureError> {
    Ok(files::write_bytes(path, &encode_png(path, width, height, rgb)?)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient(width: u32, height: u32, offset: f32) -> StereoPicture {
        let eye = |e: f32| (0..width * height).map(|i| [i as f32 + offset, e, 0.25]).collect();
        StereoPicture { width, height, eyes: [eye(0.0), eye(1.0)] }
    }

    #[test]
    fn what_is_written_is_read_back_to_the_bit() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.exr");
        let (color, reflection) = (gradient(7, 5, 0.1), gradient(7, 5, 100.5));
        let parts = [Part { layer: "", picture: &color }, Part { layer: "reflection", picture: &reflection }];
        write_exr(&path, &parts).expect("written");
        assert_eq!(read_exr(&path, "").expect("read"), color);
        assert_eq!(read_exr(&path, "reflection").expect("read"), reflection);
        assert_eq!(["", "reflection", "nothing"].map(|l| has_layer(&path, l).expect("read")), [true, true, false]);
        let error = read_exr(&path, "nothing").expect_err("no such layer").to_string();
        assert!(error.contains("nothing.left.R"), "{error}");
    }

    #[test]
    fn side_by_side_puts_the_left_eye_left() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.png");
        let (left, right) = ([10u8, 20, 30, 255].repeat(6), [200u8, 100, 50, 255].repeat(6));
        write_side_by_side(&path, 3, 2, [&left, &right]).expect("written");
        let read = image::open(&path).expect("a PNG").to_rgb8();
        assert_eq!(read.dimensions(), (6, 2));
        assert_eq!(read.get_pixel(2, 1).0, [10, 20, 30]);
        assert_eq!(read.get_pixel(3, 1).0, [200, 100, 50]);
    }
}
