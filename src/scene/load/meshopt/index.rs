//! The two index codecs: triangles that share edges with earlier triangles, and plain sequences.

use super::{Cursor, unfold};
use crate::scene::error::Reason;

/// Length in bytes of the table of common vertex pairs at the end of a triangle stream.
const TABLE: usize = 16;

/// The last 16 values that were pushed; `get(0)` is the newest.
struct Recent<T> {
    values: [T; 16],
    next: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Recent<T> {
        Recent { values: [T::default(); 16], next: 0 }
    }

    fn push(&mut self, value: T) {
        self.values[self.next % 16] = value;
        self.next += 1;
    }

    fn get(&self, age: usize) -> T {
        self.values[self.next.wrapping_sub(1 + age) % 16]
    }
}

/// Writes `index` in 2 or 4 bytes. An index that does not fit loses its upper bytes; the later check against the number
/// of vertices finds it.
fn put(out: &mut [u8], stride: usize, at: usize, index: u32) {
    out[at * stride..(at + 1) * stride].copy_from_slice(&index.to_le_bytes()[..stride]);
}

struct Triangles<'a> {
    data: Cursor<'a>,
    edges: Recent<(u32, u32)>,
    vertices: Recent<u32>,
    /// The lowest index that has not been used yet.
    next: u32,
    /// The index that the next explicitly written index is relative to.
    last: u32,
}

impl Triangles<'_> {
    fn fresh(&mut self) -> u32 {
        let index = self.next;
        self.next = self.next.wrapping_add(1);
        index
    }

    fn written(&mut self) -> Result<u32, Reason> {
        self.last = self.last.wrapping_add(unfold(self.data.varint()?));
        Ok(self.last)
    }

    /// Decodes a triangle that shares one of the recent edges.
    fn on_edge(&mut self, edge: usize, code: u8) -> Result<[u32; 3], Reason> {
        let (a, b) = self.edges.get(edge);
        let c = match code {
            0 => self.fresh(),
            1..=12 => self.vertices.get(usize::from(code)),
            13 => {
                self.last = self.last.wrapping_sub(1);
                self.last
            }
            14 => {
                self.last = self.last.wrapping_add(1);
                self.last
            }
            _ => self.written()?,
        };
        if !(1..=12).contains(&code) {
            self.vertices.push(c);
        }
        self.edges.push((c, b));
        self.edges.push((a, c));
        Ok([a, b, c])
    }

    /// Decodes a triangle that shares no known edge. `pair` says where its second and third corner come from.
    fn apart(&mut self, pair: u8, first_written: bool, may_write: bool) -> Result<[u32; 3], Reason> {
        let a = if first_written { self.written()? } else { self.fresh() };
        let mut corner = |code: u8| -> Result<(u32, bool), Reason> {
            match code {
                0 => Ok((self.fresh(), true)),
                15 if may_write => Ok((self.written()?, true)),
                _ => Ok((self.vertices.get(usize::from(code) - 1), false)),
            }
        };
        let (b, b_is_new) = corner(pair >> 4)?;
        let (c, c_is_new) = corner(pair & 15)?;
        self.vertices.push(a);
        if b_is_new {
            self.vertices.push(b);
        }
        if c_is_new {
            self.vertices.push(c);
        }
        self.edges.push((b, a));
        self.edges.push((c, b));
        self.edges.push((a, c));
        Ok([a, b, c])
    }
}

/// Decodes `count` indices of a triangle list.
pub fn triangles(source: &[u8], count: usize, stride: usize, out: &mut [u8]) -> Result<(), Reason> {
    if source.first() != Some(&0xe1) {
        return Err("the bytes are not of the triangle codec, version 1".to_owned());
    }
    if !count.is_multiple_of(3) {
        return Err(format!("count is {count}, which is not a number of triangles"));
    }
    let faces = count / 3;
    if source.len() < 1 + faces + TABLE {
        return Err("the compressed bytes end too early".to_owned());
    }
    let codes = &source[1..1 + faces];
    let (data, table) = source[1 + faces..].split_at(source.len() - 1 - faces - TABLE);
    let mut state =
        Triangles { data: Cursor { bytes: data }, edges: Recent::new(), vertices: Recent::new(), next: 0, last: 0 };
    for (face, code) in codes.iter().enumerate() {
        let triangle = match (code >> 4, code & 15) {
            (15, low @ 0..=13) => state.apart(table[usize::from(low)], false, false)?,
            (15, low) => {
                let pair = state.data.byte()?;
                if pair == 0 {
                    state.next = 0;
                }
                state.apart(pair, low == 15, true)?
            }
            (edge, low) => state.on_edge(usize::from(edge), low)?,
        };
        for (corner, index) in triangle.into_iter().enumerate() {
            put(out, stride, face * 3 + corner, index);
        }
    }
    state.data.finish()
}

/// Decodes `count` indices, each relative to one of two running values.
pub fn sequence(source: &[u8], count: usize, stride: usize, out: &mut [u8]) -> Result<(), Reason> {
    if source.first() != Some(&0xd1) {
        return Err("the bytes are not of the sequence codec, version 1".to_owned());
    }
    // The stream ends with four bytes of padding, so that fast decoders can read ahead.
    let end = source.len().checked_sub(4).filter(|end| *end >= 1).ok_or("the compressed bytes end too early")?;
    let mut data = Cursor { bytes: &source[1..end] };
    let mut last = [0u32; 2];
    for at in 0..count {
        let value = data.varint()?;
        let last = &mut last[(value & 1) as usize];
        *last = last.wrapping_add(unfold(value >> 1));
        put(out, stride, at, *last);
    }
    data.finish()
}
