//! Reads environment maps from the bytes of `.hdr` (Radiance) and `.exr` files. It is called by the scene loader, and
//! by the reader of pictures for the head of an OpenEXR file.

use std::io::Cursor;

use exr::meta::MetaData;
use exr::meta::attribute::ChannelDescription;
use exr::meta::header::Header;

use crate::scene::Equirect;
use crate::scene::error::Reason;

/// Maps that are wider are averaged down to this width. That is finer than a pixel of any reflection, and takes 4 MiB
/// for each channel.
const MOST_WIDTH: u32 = 2048;

/// The most texels of a map that is read. No panorama has more, and a header of a few bytes may claim any size.
const MOST_TEXELS: u64 = 1 << 27;

/// The most samples of a file that is read: more than 24 channels of 16 million pixels. A header of a few bytes may
/// claim any number.
pub const MOST_SAMPLES: u64 = 1 << 29;

/// The most bytes that a byte of an OpenEXR file can unpack to, rounded up. PXR24 unpacks the most: it keeps three
/// bytes of four and packs them with Deflate, at most 1032 to 1.
const MOST_UNPACKED_OF_BYTE: u64 = 1400;

/// Reads the head of an OpenEXR file, be it a picture or a map, and checks it. This comes before the pixels are read,
/// because a reader allocates what the head claims.
///
/// # Errors
/// The file is not OpenEXR, or it claims more samples than are read or than a file of its size can hold.
pub fn exr_head(bytes: &[u8]) -> Result<MetaData, Reason> {
    let head = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|error| error.to_string())?;
    let flat = || head.headers.iter().filter(|h| !h.deep);
    let area = |h: &Header| h.layer_size.area() as u64;
    let samples = |h: &Header| area(h).saturating_mul(h.channels.list.len() as u64);
    let claimed = flat().map(samples).fold(0, u64::saturating_add);
    if claimed > MOST_SAMPLES {
        return Err(format!("it claims {claimed} samples, and at most {MOST_SAMPLES} are read"));
    }
    // A colour channel may be subsampled: one sample then stands for several pixels.
    let of_channel = |h: &Header, c: &ChannelDescription| {
        area(h) / c.sampling.area().max(1) as u64 * c.sample_type.bytes_per_sample() as u64
    };
    let unpacked: u64 = flat().flat_map(|h| h.channels.list.iter().map(move |c| of_channel(h, c))).sum();
    if unpacked / MOST_UNPACKED_OF_BYTE > bytes.len() as u64 {
        return Err(format!(
            "it claims {unpacked} bytes of samples, more than a file of {} bytes can hold",
            bytes.len()
        ));
    }
    Ok(head)
}

/// The largest height over width of a map. A panorama is twice as wide as it is tall. The blur works on a map that was
/// reduced to a width of 128, but a narrower map is not reduced, and its whole height would count for each of 512
/// directions.
const MOST_HEIGHT_TO_WIDTH: u32 = 4;

/// Decodes a map. The first bytes decide which of the two formats it is.
pub fn decode(bytes: &[u8]) -> Result<Equirect, Reason> {
    let map = if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) { decode_exr(bytes)? } else { decode_hdr(bytes)? };
    if map.width == 0 || map.height == 0 {
        return Err("the map has no pixels, or too many".to_owned());
    }
    if map.height > map.width.saturating_mul(MOST_HEIGHT_TO_WIDTH) {
        let (width, height) = (map.width, map.height);
        return Err(format!(
            "the map is {width} × {height} texels; a panorama is twice as wide as tall, and at most {MOST_HEIGHT_TO_WIDTH} times \
             as tall as wide is read"
        ));
    }
    let height = (u64::from(map.height) * u64::from(MOST_WIDTH) / u64::from(map.width)).max(1) as u32;
    Ok(map.downsample(MOST_WIDTH, height))
}

fn decode_hdr(bytes: &[u8]) -> Result<Equirect, Reason> {
    let decoder = image::codecs::hdr::HdrDecoder::new(Cursor::new(bytes))
        .map_err(|error| format!("neither Radiance HDR nor OpenEXR: {error}"))?;
    let (width, height) = image::ImageDecoder::dimensions(&decoder);
    // This is checked before the texels are allocated.
    if u64::from(width) * u64::from(height) > MOST_TEXELS {
        return Err(format!("Radiance HDR: {width} × {height} texels; at most {MOST_TEXELS} are read"));
    }
    let image =
        image::DynamicImage::from_decoder(decoder).map_err(|error| format!("Radiance HDR: {error}"))?.into_rgb32f();
    let (width, height) = image.dimensions();
    Ok(Equirect { width, height, texels: image.pixels().map(|p| p.0).collect() })
}

fn decode_exr(bytes: &[u8]) -> Result<Equirect, Reason> {
    use exr::prelude::{ReadChannels, ReadLayers, read};
    exr_head(bytes).map_err(|reason| format!("OpenEXR: {reason}"))?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| {
                let fits = (size.width() as u64).saturating_mul(size.height() as u64) <= MOST_TEXELS;
                // A map that is too large is left empty here; the caller refuses it.
                let (width, height) = if fits { (size.width(), size.height()) } else { (0, 0) };
                Equirect { width: width as u32, height: height as u32, texels: vec![[0.0; 3]; width * height] }
            },
            |map: &mut Equirect, at, (r, g, b, _): (f32, f32, f32, f32)| {
                if let Some(texel) = map.texels.get_mut(at.y() * map.width as usize + at.x()) {
                    *texel = [r, g, b];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| format!("OpenEXR: {error}"))?;
    Ok(image.layer_data.channel_data.pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exr_and_hdr_decode_and_noise_is_refused() {
        let pixel = |x: usize, y: usize| (x as f32, y as f32, 0.5);
        let mut exr = Cursor::new(Vec::new());
        use exr::prelude::{Image, SpecificChannels, WritableImage};
        let image =
            Image::from_channels((8, 4), SpecificChannels::rgb(|p: exr::math::Vec2<usize>| pixel(p.x(), p.y())));
        image.write().non_parallel().to_buffered(&mut exr).expect("written");
        let map = decode(exr.get_ref()).expect("decoded");
        assert_eq!((map.width, map.height), (8, 4));
        assert_eq!(map.texels[8 + 3], [3.0, 1.0, 0.5]);
        let mut hdr = Vec::new();
        let pixels: Vec<image::Rgb<f32>> = (0..32).map(|i| image::Rgb([i as f32, 1.0, 0.25])).collect();
        image::codecs::hdr::HdrEncoder::new(&mut hdr).encode(&pixels, 8, 4).expect("written");
        let map = decode(&hdr).expect("decoded");
        assert!((map.texels[31][0] - 31.0).abs() < 0.2);
        let mut tall = Vec::new();
        image::codecs::hdr::HdrEncoder::new(&mut tall).encode(&pixels[..20], 2, 10).expect("written");
        assert!(decode(&tall).expect_err("a narrow map").contains("2 × 10 texels"));
        assert!(decode(b"nothing of the kind").is_err());
        assert!(decode(&exr.get_ref()[..60]).is_err());
    }
    #[test]
    fn a_black_map_is_read_however_small_its_file_and_a_claim_without_samples_is_not() {
        use Compression::{B44A, PIZ, PXR24, RLE, ZIP1, ZIP16};
        use exr::prelude::{Compression, Encoding, Image, Layer, LayerAttributes, SpecificChannels, WritableImage};
        for compression in [RLE, ZIP1, ZIP16, PIZ, PXR24, B44A] {
            let encoding = Encoding { compression, ..Encoding::UNCOMPRESSED };
            let black = SpecificChannels::rgb(|_: exr::math::Vec2<usize>| (0.0f32, 0.0f32, 0.0f32));
            let layer = Layer::new((1024, 512), LayerAttributes::default(), encoding, black);
            let mut bytes = Cursor::new(Vec::new());
            Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).expect("written");
            let whole = bytes.into_inner();
            assert_eq!(decode(&whole).map(|map| map.width), Ok(1024), "{compression:?}: {} bytes", whole.len());
            let refused = exr_head(&whole[..1000]).expect_err("a head alone");
            assert!(refused.contains("more than a file of 1000 bytes can hold"), "{refused}");
        }
    }
}
