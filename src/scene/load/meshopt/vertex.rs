//! The vertex codec, versions 0 and 1. Each byte of an element has a plane of its own, which holds the differences to
//! the element before.

use super::{Cursor, unfold};
use crate::scene::error::Reason;

/// The most elements that a block holds. Wide elements have smaller blocks.
const MOST_IN_BLOCK: usize = 256;
/// The number of elements whose differences share one bit width.
const GROUP: usize = 16;

/// The bits of a difference, chosen by the group's two header bits: in version 0, then in version 1 with control 0 and
/// with control 1.
const WIDTHS: [[u8; 4]; 3] = [[0, 2, 4, 8], [0, 1, 2, 4], [1, 2, 4, 8]];

/// Decodes `count` elements of `stride` bytes (a multiple of 4 up to 256) into `out`, which has their size.
pub fn decode(source: &[u8], count: usize, stride: usize, out: &mut [u8]) -> Result<(), Reason> {
    let version = match source.first() {
        Some(0xa0) => 0,
        Some(0xa1) => 1,
        _ => return Err("the bytes are not of the vertex codec, version 0 or 1".to_owned()),
    };
    // The tail of the stream: the element that stands before the first one and, in version 1, a mode for each four
    // bytes of an element.
    let tail = stride + if version == 0 { 0 } else { stride / 4 };
    let padded = tail.max(if version == 0 { 32 } else { 24 });
    if source.len() < 1 + padded {
        return Err("the compressed bytes end too early".to_owned());
    }
    let tail = &source[source.len() - tail..];
    let mut previous = tail[..stride].to_vec();
    let modes = &tail[stride..];
    let mut data = Cursor { bytes: &source[1..source.len() - padded] };
    let in_block = (8192 / stride / GROUP * GROUP).min(MOST_IN_BLOCK);
    let mut planes = vec![[0u8; MOST_IN_BLOCK]; stride];
    for block in out[..count * stride].chunks_mut(in_block * stride) {
        let elements = block.len() / stride;
        let control = if version == 0 { &[] } else { data.take(stride / 4)? };
        for (k, plane) in planes.iter_mut().enumerate() {
            let control = control.get(k / 4).map(|bits| bits >> (k % 4 * 2) & 3);
            read_plane(&mut data, control, elements, plane)?;
        }
        for (i, element) in block.chunks_exact_mut(stride).enumerate() {
            for word in 0..stride / 4 {
                let at = word * 4;
                let delta = [0, 1, 2, 3].map(|k| planes[at + k][i]);
                let before = [0, 1, 2, 3].map(|k| previous[at + k]);
                let now = advance(modes.get(word).copied().unwrap_or(0), before, delta)?;
                previous[at..at + 4].copy_from_slice(&now);
                element[at..at + 4].copy_from_slice(&now);
            }
        }
    }
    data.finish()
}

/// Reads the differences of one byte over a block. `control` is given only in version 1.
fn read_plane(
    data: &mut Cursor,
    control: Option<u8>,
    elements: usize,
    plane: &mut [u8; MOST_IN_BLOCK],
) -> Result<(), Reason> {
    let widths = match control {
        None => WIDTHS[0],
        Some(2) => {
            plane.fill(0);
            return Ok(());
        }
        Some(3) => {
            plane[..elements].copy_from_slice(data.take(elements)?);
            return Ok(());
        }
        Some(control) => WIDTHS[1 + usize::from(control)],
    };
    let groups = elements.div_ceil(GROUP);
    let header = data.take(groups.div_ceil(4))?;
    for (g, group) in plane.chunks_exact_mut(GROUP).take(groups).enumerate() {
        let bits = widths[usize::from(header[g / 4] >> (g % 4 * 2) & 3)];
        read_group(data, bits, group)?;
    }
    Ok(())
}

/// Reads sixteen differences of `bits` bits each. The largest value is an escape: the difference follows as a byte of
/// its own.
fn read_group(data: &mut Cursor, bits: u8, group: &mut [u8]) -> Result<(), Reason> {
    match bits {
        0 => group.fill(0),
        8 => group.copy_from_slice(data.take(GROUP)?),
        _ => {
            let packed = data.take(usize::from(bits) * GROUP / 8)?;
            let (per_byte, escape) = (8 / usize::from(bits), (1u8 << bits) - 1);
            for (i, value) in group.iter_mut().enumerate() {
                let place = i % per_byte;
                // Single bits are stored lowest first, wider values highest first.
                let place = if bits == 1 { place } else { per_byte - 1 - place };
                *value = packed[i / per_byte] >> (place * usize::from(bits)) & escape;
                if *value == escape {
                    *value = data.byte()?;
                }
            }
        }
    }
    Ok(())
}

/// The next four bytes of an element from the four before: differences are added to bytes or to 16-bit numbers, or 32
/// bits are rotated and XORed.
fn advance(mode: u8, before: [u8; 4], delta: [u8; 4]) -> Result<[u8; 4], Reason> {
    match mode & 3 {
        0 => Ok([0, 1, 2, 3].map(|k| before[k].wrapping_add(unfold(u32::from(delta[k])) as u8))),
        1 => {
            let half = |k: usize| {
                let delta = unfold(u32::from(u16::from_le_bytes([delta[k], delta[k + 1]]))) as u16;
                u16::from_le_bytes([before[k], before[k + 1]]).wrapping_add(delta).to_le_bytes()
            };
            let ([a, b], [c, d]) = (half(0), half(2));
            Ok([a, b, c, d])
        }
        2 => {
            let turned = u32::from_le_bytes(delta).rotate_right(u32::from(mode >> 4));
            Ok((u32::from_le_bytes(before) ^ turned).to_le_bytes())
        }
        _ => Err("a channel's mode is unknown".to_owned()),
    }
}
