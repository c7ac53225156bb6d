//! FlatBuffers, read without trust: every offset is checked where it is followed.
//!
//! A table begins with the distance back to its list of slots; a slot holds the distance from the
//! table to the field, or 0 where the field has its default.
//!
//! # Source
//! <https://flatbuffers.dev/internals/>

/// A fault in a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Broken {
    /// Offset from the beginning of the buffer, its size included; its end for a fault beyond it.
    pub(super) at: usize,
    pub(super) reason: &'static str,
}

const OUTSIDE: &str = "an offset points outside of its FlatBuffer";

fn array<const N: usize>(bytes: &[u8], at: usize) -> Result<[u8; N], Broken> {
    let found = bytes.get(at..).and_then(|rest| rest.first_chunk());
    found.copied().ok_or(Broken { at: at.min(bytes.len()), reason: OUTSIDE })
}

fn u16_at(bytes: &[u8], at: usize) -> Result<usize, Broken> {
    array(bytes, at).map(|two| usize::from(u16::from_le_bytes(two)))
}

fn u32_at(bytes: &[u8], at: usize) -> Result<usize, Broken> {
    array(bytes, at).map(|four| u32::from_le_bytes(four) as usize)
}

/// The four letters that say what a buffer holds.
pub(super) fn identifier(bytes: &[u8]) -> Result<[u8; 4], Broken> {
    array(bytes, 8)
}

/// Whether a buffer is as long as its size says.
pub(super) fn is_whole(bytes: &[u8]) -> bool {
    bytes.split_first_chunk().is_some_and(|(size, rest)| {
        (1..=rest.len()).contains(&(u32::from_le_bytes(*size) as usize))
    })
}

/// A table of a buffer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Table<'a> {
    bytes: &'a [u8],
    at: usize,
    slots_at: usize,
    slots_length: usize,
}

/// A list in a buffer, whose elements need not all be there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vector<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Elements it should have.
    pub(super) count: usize,
}

impl<'a> Table<'a> {
    /// The outermost table of a buffer that begins with its size.
    pub(super) fn root(bytes: &'a [u8]) -> Result<Self, Broken> {
        Self::behind(bytes, 4)
    }

    /// The table that the offset at `at` points to.
    fn behind(bytes: &'a [u8], at: usize) -> Result<Self, Broken> {
        let at = at.saturating_add(u32_at(bytes, at)?);
        let back = i32::from_le_bytes(array(bytes, at)?);
        let slots_at = at.checked_add_signed(-(back as isize));
        let slots_at = slots_at.ok_or(Broken { at, reason: OUTSIDE })?;
        let slots_length = u16_at(bytes, slots_at)?;
        Ok(Self { bytes, at, slots_at, slots_length })
    }

    /// Offset of a field, unless it has its default.
    fn field(&self, slot: usize) -> Result<Option<usize>, Broken> {
        let slot = 4 + 2 * slot;
        if slot + 2 > self.slots_length {
            return Ok(None);
        }
        let distance = u16_at(self.bytes, self.slots_at.saturating_add(slot))?;
        Ok((distance > 0).then(|| self.at + distance))
    }

    fn scalar<const N: usize>(&self, slot: usize) -> Result<Option<[u8; N]>, Broken> {
        self.field(slot)?.map(|at| array(self.bytes, at)).transpose()
    }

    pub(super) fn i8(&self, slot: usize) -> Result<i8, Broken> {
        Ok(self.scalar(slot)?.map_or(0, i8::from_le_bytes))
    }

    pub(super) fn i16(&self, slot: usize) -> Result<i16, Broken> {
        Ok(self.scalar(slot)?.map_or(0, i16::from_le_bytes))
    }

    pub(super) fn i32(&self, slot: usize) -> Result<i32, Broken> {
        Ok(self.scalar(slot)?.map_or(0, i32::from_le_bytes))
    }

    pub(super) fn f32(&self, slot: usize) -> Result<f32, Broken> {
        Ok(self.scalar(slot)?.map_or(0.0, f32::from_le_bytes))
    }

    pub(super) fn i64(&self, slot: usize) -> Result<Option<i64>, Broken> {
        Ok(self.scalar(slot)?.map(i64::from_le_bytes))
    }

    /// Two scalars side by side.
    pub(super) fn pair(&self, slot: usize) -> Result<[i32; 2], Broken> {
        let eight = self.scalar::<8>(slot)?.unwrap_or_default();
        let halves = eight.as_chunks::<4>().0;
        Ok([i32::from_le_bytes(halves[0]), i32::from_le_bytes(halves[1])])
    }

    /// A list; one that is not there is empty.
    pub(super) fn vector(&self, slot: usize) -> Result<Vector<'a>, Broken> {
        let Some(field) = self.field(slot)? else {
            return Ok(Vector { bytes: &[], at: 0, count: 0 });
        };
        let at = field.saturating_add(u32_at(self.bytes, field)?);
        let count = u32_at(self.bytes, at)?;
        Ok(Vector { bytes: self.bytes, at: at + 4, count })
    }
}

impl<'a> Vector<'a> {
    /// The bytes of as many elements of `size` bytes as are there.
    pub(super) fn there(&self, size: usize) -> &'a [u8] {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let count = self.count.min(rest.len() / size);
        &rest[..count * size]
    }

    /// The bytes of all elements.
    pub(super) fn whole(&self, size: usize) -> Result<&'a [u8], Broken> {
        let there = self.there(size);
        // The count is that of an unknown file: it may be far beyond the bytes.
        match there.len() / size == self.count {
            true => Ok(there),
            false => Err(Broken {
                at: self.at.min(self.bytes.len()),
                reason: "a list is longer than its FlatBuffer",
            }),
        }
    }

    /// The tables that the elements point to.
    pub(super) fn tables(self) -> Result<impl Iterator<Item = Result<Table<'a>, Broken>>, Broken> {
        let count = self.whole(4)?.len() / 4;
        Ok((0..count).map(move |k| Table::behind(self.bytes, self.at + 4 * k)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn offsets_of_random_bytes_are_never_followed_outside(
            bytes in prop::collection::vec(0..40_u8, 0..120),
        ) {
            let mut faults = Vec::new();
            match Table::root(&bytes) {
                Ok(table) => for slot in 0..20 {
                    faults.extend(table.i8(slot).err());
                    faults.extend(table.i64(slot).err());
                    faults.extend(table.pair(slot).err());
                    match table.vector(slot) {
                        Ok(vector) => {
                            prop_assert!(vector.there(16).len() <= bytes.len());
                            match vector.tables() {
                                Ok(tables) => faults.extend(tables.filter_map(Result::err)),
                                Err(fault) => faults.push(fault),
                            }
                        }
                        Err(fault) => faults.push(fault),
                    }
                },
                Err(fault) => faults.push(fault),
            }
            prop_assert!(faults.iter().all(|fault| fault.at <= bytes.len()), "{faults:?}");
        }
    }

    #[test]
    fn a_table_before_the_beginning_is_refused() {
        // The table at 8 says that its slots are 100 bytes before it.
        let mut bytes = [0; 16];
        bytes[4] = 4;
        bytes[8] = 100;
        let fault = Table::root(&bytes).unwrap_err();
        assert_eq!(fault, Broken { at: 8, reason: OUTSIDE });
    }
}
