//! Typed reads from a glTF's buffers, with every range checked: accessors of all component types, sparse ones and
//! normalised ones. Called by the readers of meshes, instances and materials.

use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

use super::budget::Budget;
use crate::scene::error::Reason;

/// The elements of an accessor, one after another; the components of each follow each other.
#[derive(Debug)]
pub struct Elements {
    /// Components of an element: from 1 for a scalar to 16 for a 4×4 matrix (column-major).
    pub width: usize,
    pub values: Vec<f32>,
}

/// The most elements of an accessor that is read. No scene needs more, and a sparse accessor without a buffer view may
/// claim any number in a few bytes.
pub const MOST_ELEMENTS: u64 = 1 << 25;

/// The most elements of an accessor that has no bytes behind it (glTF defines them as zeros).
const MOST_ZEROS: u64 = 1 << 22;

/// The document together with its buffers, in memory.
pub struct Buffers {
    pub root: Root,
    pub buffers: Vec<Vec<u8>>,
    /// What the elements that are read may still take. It is counted at each read, because many meshes may name the
    /// same accessor.
    pub budget: Budget,
}

impl Buffers {
    /// The bytes of a buffer view.
    pub fn view(&self, index: usize) -> Result<&[u8], Reason> {
        let view = self.root.buffer_views.get(index).ok_or_else(|| format!("bufferViews[{index}] does not exist"))?;
        let buffer = self.buffers.get(view.buffer.value());
        let buffer = buffer.ok_or_else(|| format!("bufferViews[{index}].buffer does not exist"))?;
        let start = view.byte_offset.map_or(0, |o| o.0);
        let end = start.checked_add(view.byte_length.0);
        let range = end.and_then(|end| Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?));
        range.and_then(|range| buffer.get(range)).ok_or_else(|| {
            format!(
                "bufferViews[{index}]: {} bytes from {start} run past the buffer's {} bytes",
                view.byte_length.0,
                buffer.len()
            )
        })
    }

    /// An accessor's numbers as `f32`. Normalised integers become fractions; all others keep their value.
    pub fn numbers<T>(&self, index: Index<T>, widths: &[usize]) -> Result<Elements, Reason> {
        let index = index.value();
        let accessor = self.accessor(index)?;
        let width = width(accessor).ok_or_else(|| format!("accessors[{index}].type is unknown"))?;
        if !widths.contains(&width) {
            return Err(format!("accessors[{index}] has {width} components an element; expected {widths:?}"));
        }
        let component = component(accessor).ok_or_else(|| format!("accessors[{index}].componentType is unknown"))?;
        let count = self.checked_count(index, accessor)? * width;
        self.budget.take(count as u64 * 4)?;
        let mut values = vec![0.0f32; count];
        self.fill(index, accessor, component, width, |at, value| values[at] = value)?;
        Ok(Elements { width, values })
    }

    /// An accessor's unsigned integers, exact: vertex indices and joint numbers.
    pub fn integers<T>(&self, index: Index<T>) -> Result<Vec<u32>, Reason> {
        let index = index.value();
        let accessor = self.accessor(index)?;
        let width = width(accessor).ok_or_else(|| format!("accessors[{index}].type is unknown"))?;
        let component = component(accessor).ok_or_else(|| format!("accessors[{index}].componentType is unknown"))?;
        if !matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(format!("accessors[{index}] must hold unsigned integers"));
        }
        let count = self.checked_count(index, accessor)?;
        self.budget.take((count * width) as u64 * 4)?;
        let Some(view) = accessor.buffer_view else { return Ok(vec![0; count * width]) };
        let size = component.size();
        let offset = accessor.byte_offset.map_or(0, |o| o.0);
        let stride = self.stride(view.value(), size * width);
        let bytes = self.span(index, view.value(), offset, stride, size * width, count)?;
        let mut out = Vec::with_capacity(count * width);
        for element in 0..count {
            for k in 0..width {
                let at = element * stride + k * size;
                out.push(match component {
                    ComponentType::U8 => u32::from(bytes[at]),
                    ComponentType::U16 => u32::from(u16::from_le_bytes([bytes[at], bytes[at + 1]])),
                    _ => u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]),
                });
            }
        }
        Ok(out)
    }

    fn accessor(&self, index: usize) -> Result<&Accessor, Reason> {
        self.root.accessors.get(index).ok_or_else(|| format!("accessors[{index}] does not exist"))
    }

    fn checked_count(&self, index: usize, accessor: &Accessor) -> Result<usize, Reason> {
        let count = accessor.count.0;
        if count > MOST_ELEMENTS {
            return Err(format!("accessors[{index}].count is {count}; at most {MOST_ELEMENTS} are read"));
        }
        if accessor.buffer_view.is_none() && count > MOST_ZEROS {
            return Err(format!(
                "accessors[{index}].count is {count}; without a bufferView at most {MOST_ZEROS} are read"
            ));
        }
        if let Some(view) = accessor.buffer_view {
            // This is checked before anything is allocated: a few bytes of JSON may claim gigabytes.
            let size = component(accessor).map_or(1, |c| c.size()) * width(accessor).unwrap_or(1);
            let stride = self.stride(view.value(), size);
            self.span(index, view.value(), accessor.byte_offset.map_or(0, |o| o.0), stride, size, count as usize)?;
        }
        Ok(count as usize)
    }

    fn stride(&self, view: usize, packed: usize) -> usize {
        let stride = self.root.buffer_views.get(view).and_then(|v| v.byte_stride.as_ref());
        stride.map_or(packed, |s| s.0).max(1)
    }

    /// The bytes of a buffer view from `offset` that hold `count` elements of `size` bytes, `stride` bytes apart.
    fn span(
        &self,
        index: usize,
        view: usize,
        offset: u64,
        stride: usize,
        size: usize,
        count: usize,
    ) -> Result<&[u8], Reason> {
        let bytes = self.view(view)?;
        let needed = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride).and_then(|n| n.checked_add(size)),
        };
        let range = usize::try_from(offset).ok().zip(needed).and_then(|(o, n)| Some(o..o.checked_add(n)?));
        range.and_then(|range| bytes.get(range)).ok_or_else(|| {
            format!(
                "accessors[{index}]: {count} elements from byte {offset} run past bufferViews[{view}] of {} bytes",
                bytes.len()
            )
        })
    }

    fn fill(
        &self,
        index: usize,
        accessor: &Accessor,
        component: ComponentType,
        width: usize,
        mut put: impl FnMut(usize, f32),
    ) -> Result<(), Reason> {
        let size = component.size();
        let count = accessor.count.0 as usize;
        if let Some(view) = accessor.buffer_view {
            let stride = self.stride(view.value(), size * width);
            let offset = accessor.byte_offset.map_or(0, |o| o.0);
            let bytes = self.span(index, view.value(), offset, stride, size * width, count)?;
            for element in 0..count {
                for k in 0..width {
                    let at = element * stride + k * size;
                    put(element * width + k, number(&bytes[at..at + size], component, accessor.normalized));
                }
            }
        }
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        let changed = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        let Checked::Valid(index_type) = &sparse.indices.component_type else {
            return Err(format!("accessors[{index}].sparse.indices.componentType is unknown"));
        };
        let index_size = index_type.0.size();
        let at = sparse.indices.buffer_view.value();
        let places = self.span(index, at, sparse.indices.byte_offset.0, index_size, index_size, changed)?;
        let at = sparse.values.buffer_view.value();
        let values = self.span(index, at, sparse.values.byte_offset.0, size * width, size * width, changed)?;
        for i in 0..changed {
            let element =
                places[i * index_size..(i + 1) * index_size].iter().rev().fold(0usize, |n, b| n << 8 | *b as usize);
            if element >= count {
                return Err(format!("accessors[{index}].sparse: index {element} is not below the count {count}"));
            }
            for k in 0..width {
                let at = (i * width + k) * size;
                put(element * width + k, number(&values[at..at + size], component, accessor.normalized));
            }
        }
        Ok(())
    }
}

fn width(accessor: &Accessor) -> Option<usize> {
    match &accessor.type_ {
        Checked::Valid(kind) => Some(Type::multiplicity(kind)),
        Checked::Invalid => None,
    }
}

fn component(accessor: &Accessor) -> Option<ComponentType> {
    match &accessor.component_type {
        Checked::Valid(kind) => Some(kind.0),
        Checked::Invalid => None,
    }
}

/// One little-endian component; `bytes` is as long as the component. Normalisation follows glTF 2.0 §3.11.
fn number(bytes: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let (value, most) = match component {
        ComponentType::F32 => return f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
        ComponentType::U32 => return u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) as f32,
        ComponentType::I8 => (f32::from(bytes[0] as i8), 127.0),
        ComponentType::U8 => (f32::from(bytes[0]), 255.0),
        ComponentType::I16 => (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
        ComponentType::U16 => (f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
    };
    if normalized { (value / most).max(-1.0) } else { value }
}
