//! FlatBuffers, written front to back.
//!
//! Tables come before what they point to, so an offset is filled in when its target is written.
//! Everything is aligned to its own size, from the beginning of the buffer, as readers may insist.

/// A field of a table.
#[derive(Debug, Clone, Copy)]
pub(super) enum Field {
    Byte(i8),
    Short(i16),
    Int(i32),
    Long(i64),
    Float(f32),
    /// Two scalars side by side.
    Pair([i32; 2]),
    /// The list or string that is written next.
    Next,
}

impl Field {
    /// Its bytes, how many of them count, and to what they are aligned.
    fn bytes(self) -> ([u8; 8], usize, usize) {
        // One size for all, so that fields need no memory of their own.
        let mut eight = [0; 8];
        let mut put = |bytes: &[u8]| {
            eight[..bytes.len()].copy_from_slice(bytes);
            bytes.len()
        };
        let size = match self {
            Self::Byte(value) => put(&value.to_le_bytes()),
            Self::Short(value) => put(&value.to_le_bytes()),
            Self::Int(value) => put(&value.to_le_bytes()),
            Self::Long(value) => put(&value.to_le_bytes()),
            Self::Float(value) => put(&value.to_le_bytes()),
            Self::Pair(pair) => put(pair.map(i32::to_le_bytes).as_flattened()),
            Self::Next => size_of::<u32>(),
        };
        // FlatBuffers align a struct as its widest member: a pair to four, though eight bytes long.
        let align = if let Self::Pair(_) = self { size_of::<i32>() } else { size };
        (eight, size, align)
    }
}

/// A buffer that grows.
#[derive(Debug, Default)]
pub(super) struct Builder {
    bytes: Vec<u8>,
    /// Offset of the last list of slots, which tables of the same fields share.
    slots: std::ops::Range<usize>,
    slots_new: Vec<u8>,
}

impl Builder {
    /// Begins a buffer whose outermost table comes next, with what it holds in four letters.
    pub(super) fn begin(&mut self, identifier: [u8; 4]) {
        self.bytes.clear();
        self.slots = 0..0;
        self.bytes.extend_from_slice(&[0; 8]);
        self.bytes.extend_from_slice(&identifier);
    }

    fn pad(&mut self, align: usize) {
        self.bytes.resize(self.bytes.len().next_multiple_of(align), 0);
    }

    /// Writes at `from` how far it is from there to the end.
    fn point(&mut self, from: usize) {
        let distance = (self.bytes.len() - from) as u32;
        self.bytes[from..from + 4].copy_from_slice(&distance.to_le_bytes());
    }

    /// Writes the table that the offset at `from` points to, and returns where the offset of
    /// [`Field::Next`] is to be filled in.
    pub(super) fn table(&mut self, from: usize, fields: &[Field]) -> usize {
        // The memory of the list is used again, since a packet has a table for every sample.
        let mut slots = std::mem::take(&mut self.slots_new);
        slots.clear();
        slots.extend_from_slice(&(4 + 2 * fields.len() as u16).to_le_bytes());
        slots.extend_from_slice(&[0; 2]);
        let mut length = 4;
        for field in fields {
            let (_, size, align) = field.bytes();
            length = usize::next_multiple_of(length, align);
            slots.extend_from_slice(&(length as u16).to_le_bytes());
            length += size;
        }
        slots[2..4].copy_from_slice(&(length as u16).to_le_bytes());
        // Tables of one kind follow each other and share their list of slots, as flatbuffers' own
        // do.
        if self.bytes[self.slots.clone()] != slots[..] {
            self.pad(2);
            self.slots = self.bytes.len()..self.bytes.len() + slots.len();
            self.bytes.extend_from_slice(&slots);
        }
        self.slots_new = slots;
        self.pad(8);
        self.point(from);
        let (at, mut next) = (self.bytes.len(), 0);
        // A table begins with the distance back to its list of slots.
        let back = (at - self.slots.start) as i32;
        self.bytes.extend_from_slice(&back.to_le_bytes());
        for field in fields {
            let (bytes, size, align) = field.bytes();
            self.pad(align);
            if matches!(field, Field::Next) {
                next = self.bytes.len();
            }
            self.bytes.extend_from_slice(&bytes[..size]);
        }
        next
    }

    /// Writes the outermost table.
    pub(super) fn root(&mut self, fields: &[Field]) -> usize {
        self.table(4, fields)
    }

    /// Writes the beginning of a list that the offset at `from` points to; its `count` elements
    /// come next.
    pub(super) fn vector(&mut self, from: usize, count: usize, align: usize) -> &mut Vec<u8> {
        while !(self.bytes.len() + 4).is_multiple_of(align.max(4)) {
            self.bytes.push(0);
        }
        self.point(from);
        self.bytes.extend_from_slice(&(count as u32).to_le_bytes());
        &mut self.bytes
    }

    /// Writes a list of tables that the offset at `from` points to.
    pub(super) fn tables<const N: usize>(
        &mut self,
        from: usize,
        tables: impl ExactSizeIterator<Item = [Field; N]>,
    ) {
        let count = tables.len();
        let bytes = self.vector(from, count, 4);
        let first = bytes.len();
        bytes.resize(first + 4 * count, 0);
        for (k, fields) in tables.enumerate() {
            self.table(first + 4 * k, &fields);
        }
    }

    /// Writes the string that the offset at `from` points to.
    pub(super) fn string(&mut self, from: usize, text: &str) {
        let bytes = self.vector(from, text.len(), 4);
        bytes.extend_from_slice(text.as_bytes());
        bytes.push(0);
    }

    /// The finished buffer, behind its size.
    pub(super) fn finish(&mut self) -> &[u8] {
        self.pad(8);
        let size = (self.bytes.len() - 4) as u32;
        self.bytes[..4].copy_from_slice(&size.to_le_bytes());
        &self.bytes
    }
}
