//! `EXT_meshopt_compression` and `KHR_meshopt_compression`: replaces compressed buffer views by plain ones. Called when
//! a document is read.
//!
//! The bitstream is small and specified in the text of the extensions, and no crate in pure Rust reads its second
//! version. So it is decoded here, with every length checked before anything is allocated.

mod filter;
mod index;
#[cfg(test)]
mod tests;
mod vertex;

use gltf::json::{Index, Root, buffer};
use serde::Deserialize;

use super::budget::Budget;
use crate::scene::error::Reason;

/// The names of the extensions. Both describe one format; the second extension adds the second vertex codec and the
/// colour filter.
pub const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// The extension's object in a buffer view.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct MeshoptExtension {
    buffer: usize,
    #[serde(default)]
    byte_offset: u64,
    byte_length: u64,
    byte_stride: usize,
    count: usize,
    mode: String,
    #[serde(default)]
    filter: Option<String>,
}

/// Whether the buffer only stands in for programs that do not have the extension. No buffer view that is read here
/// leads to it.
pub fn is_fallback(buffer: &buffer::Buffer) -> bool {
    let extension = buffer.extensions.as_ref().and_then(|e| NAMES.iter().find_map(|name| e.others.get(*name)));
    extension.and_then(|e| e.get("fallback")).and_then(serde_json::Value::as_bool).unwrap_or(false)
}

/// Decodes every compressed view into a buffer of its own and points the view at it.
pub fn unpack(root: &mut Root, buffers: &mut Vec<Vec<u8>>, budget: &Budget) -> Result<(), Reason> {
    for view in 0..root.buffer_views.len() {
        let others = root.buffer_views[view].extensions.as_ref().map(|e| &e.others);
        let Some((name, value)) = others.and_then(|o| NAMES.iter().find_map(|name| Some((*name, o.get(*name)?))))
        else {
            continue;
        };
        let at = |reason: Reason| format!("bufferViews[{view}]: {name}: {reason}");
        let packed = MeshoptExtension::deserialize(value).map_err(|error| at(error.to_string()))?;
        let bytes = decode(&packed, buffers, budget).map_err(at)?;
        let length = bytes.len() as u64;
        let buffer = Index::new(buffers.len() as u32);
        buffers.push(bytes);
        root.buffers.push(buffer::Buffer {
            byte_length: length.into(),
            name: None,
            uri: None,
            extensions: None,
            extras: Default::default(),
        });
        let view = &mut root.buffer_views[view];
        (view.buffer, view.byte_offset, view.byte_length) = (buffer, None, length.into());
    }
    Ok(())
}

fn decode(packed: &MeshoptExtension, buffers: &[Vec<u8>], budget: &Budget) -> Result<Vec<u8>, Reason> {
    let buffer = buffers.get(packed.buffer).ok_or_else(|| format!("buffers[{}] does not exist", packed.buffer))?;
    let end = packed.byte_offset.checked_add(packed.byte_length);
    let range = end.and_then(|end| Some(usize::try_from(packed.byte_offset).ok()?..usize::try_from(end).ok()?));
    let source = range.and_then(|range| buffer.get(range)).ok_or_else(|| {
        let (length, start) = (packed.byte_length, packed.byte_offset);
        format!("{length} bytes from {start} run past the buffer's {} bytes", buffer.len())
    })?;
    let (count, stride) = (packed.count, packed.byte_stride);
    let filter = packed.filter.as_deref().unwrap_or("NONE");
    let indices = packed.mode != "ATTRIBUTES";
    if indices && !(stride == 2 || stride == 4) {
        return Err(format!("byteStride is {stride}; indices take 2 or 4"));
    }
    if !(indices || (4..=256).contains(&stride) && stride.is_multiple_of(4)) {
        return Err(format!("byteStride is {stride}; attributes take a multiple of 4 up to 256"));
    }
    // The most bytes that a compressed byte can stand for. In the vertex codec, two bits can encode a group of 16
    // elements, so a byte encodes 64 elements, or a whole block at most.
    let most = if indices { source.len().saturating_mul(3) } else { source.len().saturating_mul(1024) / stride };
    if count > most {
        return Err(format!("count is {count}, more than {} compressed bytes can hold", source.len()));
    }
    budget.take((count * stride) as u64)?;
    let mut out = vec![0; count * stride];
    match packed.mode.as_str() {
        "ATTRIBUTES" => {
            vertex::decode(source, count, stride, &mut out)?;
            filter::apply(filter, stride, &mut out)?;
        }
        "TRIANGLES" => index::triangles(source, count, stride, &mut out)?,
        "INDICES" => index::sequence(source, count, stride, &mut out)?,
        mode => return Err(format!("mode `{mode}` is unknown")),
    }
    Ok(out)
}

/// Reads bytes from the front of a slice, and never past its end.
struct Cursor<'a> {
    bytes: &'a [u8],
}

impl<'a> Cursor<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], Reason> {
        let (head, rest) = self.bytes.split_at_checked(n).ok_or("the compressed bytes end too early")?;
        self.bytes = rest;
        Ok(head)
    }

    fn byte(&mut self) -> Result<u8, Reason> {
        Ok(self.take(1)?[0])
    }

    /// Reads a number of seven bits a byte, the lowest first. The top bit is set on all bytes but the last.
    fn varint(&mut self) -> Result<u32, Reason> {
        let mut value = 0u32;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err("a number takes more than five bytes".to_owned())
    }

    fn finish(&self) -> Result<(), Reason> {
        match self.bytes.len() {
            0 => Ok(()),
            left => Err(format!("{left} compressed bytes are left over")),
        }
    }
}

/// Maps unsigned numbers back to signed ones (zigzag coding): 0, −1, 1, −2, …
fn unfold(v: u32) -> u32 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}
