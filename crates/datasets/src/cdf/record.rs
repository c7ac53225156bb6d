//! Records: what a file is made of.

use super::CdfError;

/// What records are.
pub(super) mod kind {
    pub(in super::super) const DESCRIPTION: u32 = 1;
    pub(in super::super) const GLOBAL: u32 = 2;
    pub(in super::super) const R_VARIABLE: u32 = 3;
    pub(in super::super) const INDEX: u32 = 6;
    pub(in super::super) const VALUES: u32 = 7;
    pub(in super::super) const Z_VARIABLE: u32 = 8;
    pub(in super::super) const COMPRESSED_FILE: u32 = 10;
    pub(in super::super) const COMPRESSION: u32 = 11;
    pub(in super::super) const COMPRESSED_VALUES: u32 = 13;
}

/// Bytes of the size and the kind that every record begins with.
const HEAD: usize = 12;

/// A record: its size, its kind, and numbers with the highest byte first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Record<'a> {
    /// Where it is in the file.
    pub(super) at: u64,
    pub(super) kind: u32,
    /// All of it, its size and kind included.
    bytes: &'a [u8],
}

impl<'a> Record<'a> {
    /// The record at `at`.
    pub(super) fn at(file: &'a [u8], at: u64) -> Result<Self, CdfError> {
        let rest = usize::try_from(at).ok().and_then(|at| file.get(at..));
        let Some((rest, head)) = rest.and_then(|rest| Some((rest, rest.first_chunk::<HEAD>()?)))
        else {
            let reason =
                format!("a record is expected here, but the file has {} bytes", file.len());
            return Err(CdfError::malformed(at, reason));
        };
        let [a, b, c, d, e, f, g, h, kind @ ..] = *head;
        let size = u64::from_be_bytes([a, b, c, d, e, f, g, h]);
        let bytes = usize::try_from(size).ok().and_then(|size| rest.get(..size));
        match bytes.filter(|bytes| bytes.len() >= HEAD) {
            Some(bytes) => Ok(Self { at, kind: u32::from_be_bytes(kind), bytes }),
            None => {
                let left = rest.len();
                let reason = format!("a record of {size} bytes where {left} are left");
                Err(CdfError::malformed(at, reason))
            }
        }
    }

    /// The record at `at`, which is of this kind.
    pub(super) fn of_kind(file: &'a [u8], at: u64, kind: u32) -> Result<Self, CdfError> {
        let record = Self::at(file, at)?;
        if record.kind != kind {
            let reason = format!("a record of kind {kind} is expected, this is {}", record.kind);
            return Err(CdfError::malformed(at, reason));
        }
        Ok(record)
    }

    /// So many bytes from `from` on.
    pub(super) fn bytes(&self, from: usize, length: usize) -> Result<&'a [u8], CdfError> {
        from.checked_add(length).and_then(|end| self.bytes.get(from..end)).ok_or_else(|| {
            let reason = format!(
                "a record of {} bytes, of which {from} to {} are needed",
                self.bytes.len(),
                from.saturating_add(length)
            );
            CdfError::malformed(self.at, reason)
        })
    }

    /// All bytes from `from` on.
    pub(super) fn rest(&self, from: usize) -> Result<&'a [u8], CdfError> {
        self.bytes(from, self.bytes.len().saturating_sub(from))
    }

    pub(super) fn u32(&self, from: usize) -> Result<u32, CdfError> {
        let bytes = self.bytes(from, 4)?;
        Ok(bytes.iter().fold(0, |number, &byte| number << 8 | u32::from(byte)))
    }

    pub(super) fn u64(&self, from: usize) -> Result<u64, CdfError> {
        Ok(u64::from(self.u32(from)?) << 32 | u64::from(self.u32(from + 4)?))
    }

    /// A place in the file; none where there is nothing.
    pub(super) fn place(&self, from: usize) -> Result<Option<u64>, CdfError> {
        // Some writers mark nothing with all bits set.
        Ok(Some(self.u64(from)?).filter(|place| !matches!(*place, 0 | u64::MAX)))
    }
}
