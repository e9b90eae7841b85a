//! Positions and indices out of buffers.

use std::borrow::Cow;

use radgrad_core::DVec3;

use super::document::{Document, Fault};
use super::{buffer, document};
use crate::error::Error;
use crate::messages::quoted;
use crate::reading::Budget;

/// The document, buffers and budget that accessors refer to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accessors<'a> {
    pub(super) document: &'a Document,
    pub(super) buffers: &'a [Cow<'a, [u8]>],
    pub(super) budget: &'a Budget,
}

/// Component types of glTF, by their number.
const UNSIGNED_BYTE: u64 = 5121;
const UNSIGNED_SHORT: u64 = 5123;
const UNSIGNED_INT: u64 = 5125;
const FLOAT: u64 = 5126;

impl Accessors<'_> {
    /// Three floats each, widened, finite or not; an error comes with its member.
    pub(super) fn positions(&self, index: usize) -> Result<Vec<DVec3>, Fault> {
        let elements = self.elements(index, "VEC3", &[(FLOAT, 12)])?;
        let read = elements.map(|bytes| {
            let (components, _) = bytes.as_chunks::<4>();
            DVec3::from([0, 1, 2].map(|axis| f64::from(f32::from_le_bytes(components[axis]))))
        });
        Ok(read.collect())
    }

    /// Two floats each, or two fractions of the largest integer; an error comes with its member.
    pub(super) fn coordinates(&self, index: usize) -> Result<Vec<[f64; 2]>, Fault> {
        let types = [(FLOAT, 8), (UNSIGNED_BYTE, 2), (UNSIGNED_SHORT, 4)];
        let elements = self.elements(index, "VEC2", &types)?;
        let number = |bytes: &[u8]| match *bytes {
            [byte] => f64::from(byte) / 255.0,
            [low, high] => f64::from(u16::from_le_bytes([low, high])) / 65535.0,
            [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => 0.0,
        };
        Ok(elements.map(|bytes| [number(&bytes[..bytes.len() / 2]), number(&bytes[bytes.len() / 2..])]).collect())
    }

    /// Integers below `count`; an error comes with its member.
    pub(super) fn indices(&self, index: usize, count: usize) -> Result<Vec<usize>, Fault> {
        let types = [(UNSIGNED_BYTE, 1), (UNSIGNED_SHORT, 2), (UNSIGNED_INT, 4)];
        let elements = self.elements(index, "SCALAR", &types)?;
        let value = |bytes: &[u8]| bytes.iter().rev().fold(0_usize, |value, &byte| value << 8 | usize::from(byte));
        let indices: Vec<usize> = elements.map(value).collect();
        match indices.iter().find(|&&value| value >= count) {
            None => Ok(indices),
            Some(&value) => Err((member(index), document::no_such("vertex", value, count))),
        }
    }

    /// The bytes of each element of an accessor of a certain shape and one of some types, given with their sizes.
    fn elements(&self, index: usize, shape: &str, types: &[(u64, usize)]) -> Result<impl Iterator<Item = &[u8]>, Fault> {
        let Some(accessor) = self.document.accessors.get(index) else {
            return Err((member(index), document::no_such("accessor", index, self.document.accessors.len())));
        };
        let refuse = |error| Err((member(index), error));
        if accessor.sparse.is_some() {
            let what = "a sparse accessor".to_owned();
            return refuse(Error::Unsupported { what, instead: "export without sparse accessors" });
        }
        let size = types.iter().find(|(name, _)| *name == accessor.component_type).map(|(_, size)| *size);
        let (Some(size), true) = (size, accessor.shape == shape) else {
            let types = types.iter().map(|(name, _)| name.to_string()).collect::<Vec<_>>().join(" or ");
            let given = format!("{} of component type {}", quoted(Some(&accessor.shape)), accessor.component_type);
            return refuse(Error::expected(format!("{shape} of component type {types}"), given));
        };
        let Some(view_index) = accessor.buffer_view else {
            return refuse(Error::expected("a `bufferView`", "none"));
        };
        let view = buffer::view(self.document, self.buffers, view_index)?;
        let stride = self.document.buffer_views[view_index].byte_stride.unwrap_or(size);
        let needed = match accessor.count.checked_sub(1) {
            None => Some(0),
            Some(before) => {
                before.checked_mul(stride).and_then(|n| n.checked_add(size)).and_then(|n| n.checked_add(accessor.byte_offset))
            }
        };
        if stride < size || needed.is_none_or(|needed| needed > view.len()) {
            let given = format!("{} elements of {size} bytes, {stride} apart, from {}", accessor.count, accessor.byte_offset);
            return refuse(Error::expected(format!("elements within the {} bytes of the buffer view", view.len()), given));
        }
        // Each node with a mesh reads its vertices again.
        self.budget.take_many("vertices of nodes", accessor.count, size_of::<DVec3>()).map_err(|error| (member(index), error))?;
        let start = accessor.byte_offset;
        Ok((0..accessor.count).map(move |i| &view[start + i * stride..][..size]))
    }
}

fn member(accessor: usize) -> String {
    format!("accessors[{accessor}]")
}
