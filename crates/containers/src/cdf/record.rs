//! Records: the units that a file is made of.

use crate::cdf::CdfError;

/// The format's codes of record types.
pub(crate) mod kind {
    pub(crate) const DESCRIPTION: u32 = 1;
    pub(crate) const GLOBAL: u32 = 2;
    pub(crate) const R_VARIABLE: u32 = 3;
    pub(crate) const INDEX: u32 = 6;
    pub(crate) const VALUES: u32 = 7;
    pub(crate) const Z_VARIABLE: u32 = 8;
    pub(crate) const COMPRESSED_FILE: u32 = 10;
    pub(crate) const COMPRESSION: u32 = 11;
    pub(crate) const COMPRESSED_VALUES: u32 = 13;
}

/// Bytes of the size and the kind that every record begins with.
const HEAD: usize = 12;

/// A record: its size, its kind, and big-endian fields.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Record<'a> {
    /// Its offset in the file.
    pub(crate) at: u64,
    pub(crate) kind: u32,
    /// The whole record, size and kind included.
    bytes: &'a [u8],
}

impl<'a> Record<'a> {
    /// Reads the record at `at`.
    pub(crate) fn at(file: &'a [u8], at: u64) -> Result<Self, CdfError> {
        let rest = usize::try_from(at).ok().and_then(|at| file.get(at..));
        let Some((rest, head)) = rest.and_then(|rest| Some((rest, rest.first_chunk::<HEAD>()?)))
        else {
            let reason =
                format!("a record is expected here, but the file has {} bytes", file.len());
            return Err(CdfError::malformed(at, reason));
        };
        let [a, b, c, d, e, f, g, h, kind @ ..] = *head;
        let size = u64::from_be_bytes([a, b, c, d, e, f, g, h]);
        // The size of a damaged record may reach beyond the file.
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

    /// Reads the record at `at`, which must be of `kind`.
    pub(crate) fn of_kind(file: &'a [u8], at: u64, kind: u32) -> Result<Self, CdfError> {
        let record = Self::at(file, at)?;
        if record.kind != kind {
            let reason = format!("a record of kind {kind} is expected, this is {}", record.kind);
            return Err(CdfError::malformed(at, reason));
        }
        Ok(record)
    }

    /// Returns `length` bytes from `from` on.
    pub(crate) fn bytes(&self, from: usize, length: usize) -> Result<&'a [u8], CdfError> {
        from.checked_add(length).and_then(|end| self.bytes.get(from..end)).ok_or_else(|| {
            let reason = format!(
                "a record of {} bytes, of which {from} to {} are needed",
                self.bytes.len(),
                from.saturating_add(length)
            );
            CdfError::malformed(self.at, reason)
        })
    }

    /// Returns all bytes from `from` on.
    pub(crate) fn rest(&self, from: usize) -> Result<&'a [u8], CdfError> {
        self.bytes(from, self.bytes.len().saturating_sub(from))
    }

    pub(crate) fn u32(&self, from: usize) -> Result<u32, CdfError> {
        let bytes = self.bytes(from, 4)?;
        Ok(bytes.iter().fold(0, |value, &byte| value << 8 | u32::from(byte)))
    }

    pub(crate) fn u64(&self, from: usize) -> Result<u64, CdfError> {
        Ok(u64::from(self.u32(from)?) << 32 | u64::from(self.u32(from + 4)?))
    }

    /// Reads an offset in the file; none for the null offset.
    pub(crate) fn offset(&self, from: usize) -> Result<Option<u64>, CdfError> {
        // Some writers set all bits of a null offset.
        Ok(Some(self.u64(from)?).filter(|offset| !matches!(*offset, 0 | u64::MAX)))
    }
}
