//! Data elements: a type, a length and bytes.

use crate::mat::{MatError, MatPosition};
use crate::number::ByteOrder;

/// Type of an array.
pub(crate) const MATRIX: u32 = 14;
/// Type of a compressed element.
pub(crate) const COMPRESSED: u32 = 15;

/// Origin of the bytes that are read, for positions in error messages.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Origin {
    /// Plain bytes that begin at this byte of the file.
    File { start: usize },
    /// Inflated content of the compressed element at this byte of the file.
    Inflated { element: usize },
}

impl Origin {
    pub(crate) fn position(self, at: usize) -> MatPosition {
        match self {
            Self::File { start } => MatPosition { byte: start + at, inflated_byte: None },
            Self::Inflated { element } => MatPosition { byte: element, inflated_byte: Some(at) },
        }
    }

    pub(crate) fn malformed(self, at: usize, reason: impl Into<String>) -> MatError {
        MatError::Malformed { at: self.position(at), reason: reason.into() }
    }
}

/// A data element: its type and the range of its data.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Element {
    /// Data type.
    pub(crate) kind: u32,
    /// Offset of its tag.
    pub(crate) tag: usize,
    /// Offset of its data.
    pub(crate) start: usize,
    /// Bytes of data.
    pub(crate) length: usize,
}

impl Element {
    pub(crate) fn end(&self) -> usize {
        self.start + self.length
    }
}

/// A cursor over consecutive data elements.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reader<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) order: ByteOrder,
    pub(crate) origin: Origin,
    pub(crate) at: usize,
    pub(crate) end: usize,
}

impl<'a> Reader<'a> {
    /// A cursor over the same bytes from `start` to `end`, which must lie within them.
    pub(crate) fn within(&self, start: usize, end: usize) -> Self {
        Self { at: start, end, ..*self }
    }

    pub(crate) fn data(&self, element: &Element) -> &'a [u8] {
        &self.bytes[element.start..element.end()]
    }

    fn word(&self, at: usize) -> Option<u32> {
        let bytes = self.bytes.get(at..at.checked_add(4)?)?;
        Some(self.order.u32(bytes.try_into().ok()?))
    }

    /// Reads the next element and advances past it and its padding to eight bytes; `what` names the
    /// expected element in errors.
    pub(crate) fn element(&mut self, what: &str) -> Result<Element, MatError> {
        let tag = self.at;
        let malformed = |reason: String| Err(self.origin.malformed(tag, reason));
        let left = self.end - self.at;
        let (Some(first), Some(second), 8..) = (self.word(tag), self.word(tag + 4), left) else {
            return malformed(format!("{what} is expected, {left} bytes are left"));
        };
        // Small data element: up to four bytes of data stand in the tag itself, their length in its
        // upper half.
        let small = (first >> 16) as usize;
        let element = match small {
            0 => Element { kind: first, tag, start: tag + 8, length: second as usize },
            1..=4 => Element { kind: first & 0xffff, tag, start: tag + 4, length: small },
            _ => return malformed(format!("{what} is expected, this is no tag: {first:#010x}")),
        };
        if small == 0 && element.length > left - 8 {
            let (length, left) = (element.length, left - 8);
            return malformed(format!("{what} of {length} bytes, but {left} are left"));
        }
        // Compressed elements have no padding, and the last element of an array need not have any.
        let padded = match (small, element.kind) {
            (0, COMPRESSED) => element.length,
            (0, _) => element.length.next_multiple_of(8),
            _ => 0,
        };
        self.at = (tag + 8 + padded).min(self.end);
        Ok(element)
    }
}
