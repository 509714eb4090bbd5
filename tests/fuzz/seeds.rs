//! Makes the seeds that cannot be written by hand: `cargo test --test all make_seeds -- --ignored`.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use exr::prelude::*;
use serde_json::json;

use super::{files, root, targets};

fn put(target: &str, name: &str, bytes: &[u8]) {
    let folder = root().join("fuzz/seeds").join(target);
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join(name), bytes).expect("a seed");
}

#[test]
#[ignore = "writes into the repository"]
fn make_seeds() {
    pictures();
    packed_pictures();
    journals();
}

/// The value of a channel at a pixel of the pictures of 8 × 4 pixels, which can be compressed a little.
fn value(x: usize, y: usize, channel: usize) -> f32 {
    (x / 2 + y * channel) as f32 * 0.25
}

/// Makes OpenEXR files with different compressions, types and layouts, a Radiance HDR file and a PNG.
fn pictures() {
    let size = Vec2(8, 4);
    let samples = |channel: usize| (0..32).map(move |i| value(i % 8, i / 8, channel));
    let names = ["R", "G", "B", "right.R", "right.G", "right.B"];
    let channels = |kind: usize| {
        let list = names.iter().enumerate().map(|(c, name)| {
            let samples = match kind {
                0 => FlatSamples::F32(samples(c).collect()),
                1 => FlatSamples::F16(samples(c).map(f16::from_f32).collect()),
                _ => FlatSamples::U32(samples(c).map(|x| (x * 4.0) as u32).collect()),
            };
            AnyChannel::new(*name, samples)
        });
        AnyChannels::sort(list.collect())
    };
    let lines = |compression| Encoding { compression, ..Encoding::UNCOMPRESSED };
    let tiles = |compression| Encoding { blocks: Blocks::Tiles(Vec2(4, 4)), ..lines(compression) };
    for (name, encoding, kind) in [
        ("plain", lines(Compression::Uncompressed), 0),
        ("rle", lines(Compression::RLE), 1),
        ("zip1", lines(Compression::ZIP1), 0),
        ("zip16", lines(Compression::ZIP16), 2),
        ("piz", lines(Compression::PIZ), 1),
        ("pxr24", lines(Compression::PXR24), 0),
        ("b44", lines(Compression::B44), 1),
        ("b44a", lines(Compression::B44A), 1),
        ("tiles", tiles(Compression::ZIP16), 0),
        ("tiles-piz", tiles(Compression::PIZ), 1),
    ] {
        let layer = Layer::new(size, LayerAttributes::default(), encoding, channels(kind));
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).expect("written");
        put("exr", &format!("{name}.exr"), bytes.get_ref());
    }
    let mut bytes = Cursor::new(Vec::new());
    let pixel = |p: Vec2<usize>| (value(p.0, p.1, 0), value(p.0, p.1, 1), value(p.0, p.1, 2), 1.0_f32);
    let map = Image::from_channels(size, SpecificChannels::rgba(pixel));
    map.write().non_parallel().to_buffered(&mut bytes).expect("written");
    put("exr", "map.exr", bytes.get_ref());
    let mut hdr = Vec::new();
    let pixels: Vec<image::Rgb<f32>> = (0..32).map(|i| image::Rgb([value(i % 8, i / 8, 1), 1.0, 0.25])).collect();
    image::codecs::hdr::HdrEncoder::new(&mut hdr).encode(&pixels, 8, 4).expect("written");
    put("exr", "map.hdr", &hdr);
    let png = image::RgbImage::from_fn(8, 4, |x, y| image::Rgb([(x * 30) as u8, (y * 60) as u8, 7]));
    let mut bytes = Cursor::new(Vec::new());
    png.write_to(&mut bytes, image::ImageFormat::Png).expect("written");
    put("exr", "sbs.png", bytes.get_ref());
}

/// Makes GLB files of a textured square, with the texture in each format that can be read.
fn packed_pictures() {
    let checks = image::RgbaImage::from_fn(8, 8, |x, y| image::Rgba([if (x ^ y) & 2 == 0 { 250 } else { 20 }; 4]));
    let encoded = |format| {
        let mut bytes = Cursor::new(Vec::new());
        let rgb = image::DynamicImage::ImageRgba8(checks.clone()).into_rgb8();
        match format {
            image::ImageFormat::Jpeg => rgb.write_to(&mut bytes, format).map(drop).expect("written"),
            _ => checks.write_to(&mut bytes, format).map(drop).expect("written"),
        }
        bytes.into_inner()
    };
    put("glb", "png.glb", &square(&encoded(image::ImageFormat::Png), None));
    put("glb", "jpeg.glb", &square(&encoded(image::ImageFormat::Jpeg), None));
    put("glb", "webp-lossless.glb", &square(&encoded(image::ImageFormat::WebP), Some("EXT_texture_webp")));
    let data = root().join("tests/data");
    for name in ["etc1s.ktx2", "uastc.ktx2", "uastc-zstd.ktx2"] {
        let bytes = std::fs::read(data.join(name)).expect("a picture");
        put("glb", &format!("{name}.glb"), &square(&bytes, Some("KHR_texture_basisu")));
    }
}

fn square(picture: &[u8], extension: Option<&str>) -> Vec<u8> {
    let corners: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];
    let mut blob: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    blob.extend([0, 1, 2, 0, 2, 3, 0, 0]);
    let at = blob.len();
    blob.extend_from_slice(picture);
    blob.resize(blob.len().next_multiple_of(4), 0);
    let texture = match extension {
        Some(name) => json!({ "extensions": { name: { "source": 0 } } }),
        None => json!({ "source": 0 }),
    };
    let root = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 2 }, "indices": 1, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [texture],
        "images": [{ "bufferView": 2, "mimeType": "image/png" }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR" },
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC2" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 6 },
            { "buffer": 0, "byteOffset": at, "byteLength": picture.len() },
        ],
        "buffers": [{ "byteLength": blob.len() }],
        "extensionsUsed": extension.iter().collect::<Vec<_>>(),
    });
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let word = |n: usize| (n as u32).to_le_bytes();
    let length = 12 + 8 + text.len() + 8 + blob.len();
    let (json_chunk, blob_chunk) = (word(text.len()), word(blob.len()));
    [b"glTF", &word(2)[..], &word(length), &json_chunk, b"JSON", &text, &blob_chunk, b"BIN\0", &blob].concat()
}

/// Makes journals of the sessions that the seeds of the target `replay` describe.
fn journals() {
    for (path, bytes) in files(&root().join("fuzz/seeds/replay")) {
        let journal = targets::journal_of(&bytes).expect("a session");
        if journal.len() < 20_000 {
            put("journal", &name_of(&path).with_extension("jsonl").to_string_lossy(), &journal);
        }
    }
}

fn name_of(path: &Path) -> PathBuf {
    path.file_name().map(PathBuf::from).expect("a name")
}
