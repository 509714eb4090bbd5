//! `KHR_texture_basisu`: decodes KTX2 files of Basis Universal to RGBA8. Called by the image loader.
//!
//! The transcoder trusts some numbers of the container without checking them. Therefore the container is checked here,
//! and the transcoder is shown only what it needs.

use basisu::{DecodeFlags, TargetFormat, Transcoder};

use super::limits::MOST_TEXEL_BYTES;
use crate::scene::error::Reason;

const MAGIC: &[u8; 12] = b"\xABKTX 20\xBB\r\n\x1A\n";

/// Where the level index begins, and the length of an entry in bytes: offset, length, uncompressed length.
const LEVELS: usize = 80;
const LEVEL: usize = 24;

/// The two colour models of the data format descriptor that the extension allows.
const ETC1S: u8 = 163;
const UASTC: u8 = 166;

pub fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Width, height and the RGBA8 texels of the largest level; no side may be longer than `most_wide`.
pub fn decode(bytes: &[u8], most_wide: u32) -> Result<(u32, u32, Vec<u8>), Reason> {
    let broken = |what: &str| format!("cannot be decoded: KTX2: {what}");
    let early = || broken("the file ends too early");
    let word = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let long = |at: usize| Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let field = |at: usize| word(at).ok_or_else(early);
    let inside = |start: u64, length: u64| start.checked_add(length).is_some_and(|end| end <= bytes.len() as u64);
    let [width, height, depth, layers, faces, levels, packing] =
        [field(20)?, field(24)?, field(28)?, field(32)?, field(36)?, field(40)?, field(44)?];
    if width == 0 || height == 0 || width > most_wide || height > most_wide {
        return Err(broken(&format!("{width} × {height} texels; 1 to {most_wide} a side are read")));
    }
    if depth != 0 || layers > 1 || faces != 1 {
        return Err(broken("it is not a plain two-dimensional picture"));
    }
    if !(1..=15).contains(&levels) {
        return Err(broken(&format!("{levels} levels")));
    }
    if packing > 2 {
        return Err(broken(&format!("supercompression {packing} is not one that KHR_texture_basisu allows")));
    }
    let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
    for level in 0..levels as usize {
        let at = LEVELS + level * LEVEL;
        let [start, length, unpacked] = [0, 8, 16].map(|k| long(at + k).unwrap_or(u64::MAX));
        if !inside(start, length) {
            return Err(early());
        }
        // Both codecs use at most 16 bytes for a block of 4 × 4 texels.
        if unpacked > blocks * 16 {
            return Err(broken(&format!("level {level} claims {unpacked} bytes for {width} × {height} texels")));
        }
    }
    if !inside(long(64).ok_or_else(early)?, long(72).ok_or_else(early)?) {
        return Err(early());
    }
    let model = field(48)?.checked_add(12).and_then(|at| bytes.get(at as usize));
    if !matches!(model, Some(&(ETC1S | UASTC))) {
        return Err(broken("it holds neither ETC1S nor UASTC, the two that KHR_texture_basisu allows"));
    }
    if u64::from(width) * u64::from(height) * 4 > MOST_TEXEL_BYTES {
        return Err(broken(&format!("{width} × {height} texels are more than {} MiB", MOST_TEXEL_BYTES >> 20)));
    }
    // The key/value data is not needed here, so the transcoder does not see it.
    let mut bytes = bytes.to_vec();
    bytes[56..64].fill(0);
    let refused = |error: basisu::Error| broken(&format!("{error:?}"));
    let transcoder = Transcoder::new(&bytes).map_err(refused)?;
    let texels = transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(refused)?;
    if texels.len() as u64 != u64::from(width) * u64::from(height) * 4 {
        return Err(broken("the texels do not fill the picture"));
    }
    Ok((width, height, texels))
}
