//! Data elements: a type, a length and bytes.

use super::class::ByteOrder;
use super::{MatError, MatPosition};

/// Type of an array.
pub(super) const MATRIX: u32 = 14;
/// Type of a compressed element.
pub(super) const COMPRESSED: u32 = 15;

/// Where the bytes that are read come from, to tell where something is wrong.
#[derive(Debug, Clone, Copy)]
pub(super) enum Origin {
    /// They begin at this byte of the file.
    File { start: usize },
    /// They are what the compressed element at this byte of the file holds.
    Inflated { element: usize },
}

impl Origin {
    pub(super) fn position(self, at: usize) -> MatPosition {
        match self {
            Self::File { start } => MatPosition { byte: start + at, inflated_byte: None },
            Self::Inflated { element } => MatPosition { byte: element, inflated_byte: Some(at) },
        }
    }

    pub(super) fn malformed(self, at: usize, reason: impl Into<String>) -> MatError {
        MatError::Malformed { at: self.position(at), reason: reason.into() }
    }
}

/// An element: its type, and which bytes are its data.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element {
    /// Type of the data.
    pub(super) kind: u32,
    /// Where its tag begins.
    pub(super) tag: usize,
    /// Where its data begin.
    pub(super) start: usize,
    /// How many bytes of data.
    pub(super) length: usize,
}

impl Element {
    pub(super) fn end(&self) -> usize {
        self.start + self.length
    }
}

/// Reads the elements between two bytes, one behind the other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reader<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) order: ByteOrder,
    pub(super) origin: Origin,
    pub(super) at: usize,
    pub(super) end: usize,
}

impl<'a> Reader<'a> {
    /// The same bytes from `start` to `end`, which must lie within them.
    pub(super) fn within(&self, start: usize, end: usize) -> Self {
        Self { at: start, end, ..*self }
    }

    pub(super) fn data(&self, element: &Element) -> &'a [u8] {
        &self.bytes[element.start..element.end()]
    }

    fn word(&self, at: usize) -> Option<u32> {
        let bytes = self.bytes.get(at..at.checked_add(4)?)?;
        Some(self.order.u32(bytes.try_into().ok()?))
    }

    /// The next element, which is `what`; the reader then stands behind it and what fills it up to eight
    /// bytes.
    pub(super) fn element(&mut self, what: &str) -> Result<Element, MatError> {
        let tag = self.at;
        let malformed = |reason: String| Err(self.origin.malformed(tag, reason));
        let left = self.end - self.at;
        let (Some(first), Some(second), 8..) = (self.word(tag), self.word(tag + 4), left) else {
            return malformed(format!("{what} is expected, {left} bytes are left"));
        };
        // Up to four bytes of data stand in the tag itself, their number in its upper half.
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
        // Compressed elements are not filled up, and the last element of an array need not be.
        let filled = match (small, element.kind) {
            (0, COMPRESSED) => element.length,
            (0, _) => element.length.next_multiple_of(8),
            _ => 0,
        };
        self.at = (tag + 8 + filled).min(self.end);
        Ok(element)
    }
}
