//! Decoding of the values of a variable: its index of records, and the order of dimensions.

use std::borrow::Cow;

use crate::cdf::file::Variable;
use crate::cdf::record::{Record, kind};
use crate::cdf::{CdfArray, CdfError, CdfFile, compression};
use crate::number::{NumberKind, row_major};

/// Maximal depth of nested indices; no program writes more.
const MAX_INDEX_DEPTH: usize = 8;

/// Reads all records of a variable and decodes them.
pub(crate) fn decode(
    file: &CdfFile,
    variable: &Variable,
    (kind, size): (NumberKind, usize),
) -> Result<CdfArray, CdfError> {
    if let Some(at) = variable.compression {
        compression::check(&file.bytes, at)?;
    }
    let record_bytes = variable.values_per_record * size as u64;
    let mut records =
        StoredRecords { file: &file.bytes, variable, record_bytes, bytes: Vec::new(), next: 0 };
    if let Some(index) = variable.index.filter(|_| variable.records > 0) {
        records.read_index(index, 0)?;
    }
    if records.next != variable.records {
        return Err(records.missing(variable.at));
    }
    let values = records.bytes.chunks_exact(size);
    let mut values: Vec<f64> =
        values.map(|bytes| kind.decode(bytes, file.order).as_f64()).collect();
    let sizes: Vec<usize> = variable.sizes.iter().map(|&size| size as usize).collect();
    // Column-major values are reordered, so that callers know one order only.
    if !file.is_row_major {
        let records = values.chunks_exact((variable.values_per_record as usize).max(1));
        values = records.flat_map(|record| row_major(record, &sizes)).collect();
    }
    // The limit of a variable keeps the count within any machine's memory.
    Ok(CdfArray { records: variable.records as usize, sizes, values })
}

/// Records of a variable, collected in order as they are stored.
struct StoredRecords<'a> {
    file: &'a [u8],
    variable: &'a Variable,
    record_bytes: u64,
    bytes: Vec<u8>,
    /// Index of the next record.
    next: u64,
}

impl StoredRecords<'_> {
    /// Reads the records that the index at `at` and those linked behind it list.
    fn read_index(&mut self, at: u64, depth: usize) -> Result<(), CdfError> {
        let (mut next, mut visited) = (Some(at), 0);
        while let Some(at) = next {
            let index = Record::of_kind(self.file, at, kind::INDEX)?;
            visited += 1;
            // An index has 28 bytes at least: more of them than fit into the file are a circle.
            if depth > MAX_INDEX_DEPTH || visited * 28 > self.file.len() {
                return Err(CdfError::malformed(at, "an index that leads back to itself"));
            }
            let [entries, used] = [index.u32(20)? as usize, index.u32(24)? as usize];
            if used > entries {
                let reason = format!("an index of {entries} entries, {used} of them used");
                return Err(CdfError::malformed(at, reason));
            }
            // Three lists one behind the other: first records, last records, places.
            for entry in 0..used {
                let first = index.u32(28 + 4 * entry)?;
                let last = index.u32(28 + 4 * entries + 4 * entry)?;
                let offset = index.u64(28 + 8 * entries + 8 * entry)?;
                self.read_entry(at, first.into(), last.into(), offset, depth)?;
            }
            next = index.offset(12)?;
        }
        Ok(())
    }

    fn read_entry(
        &mut self,
        index: u64,
        first: u64,
        last: u64,
        offset: u64,
        depth: usize,
    ) -> Result<(), CdfError> {
        // Records may be allocated beyond those in use.
        let end = (last + 1).min(self.variable.records);
        if first >= end {
            return Ok(());
        }
        // Records come in order: one that is missing leaves a gap here.
        if first != self.next {
            return Err(self.missing(index));
        }
        let record = Record::at(self.file, offset)?;
        // The limit of a variable's values keeps the product from overflowing.
        let (used, allocated) = ((end - first) * self.record_bytes, (last + 1 - first));
        let bytes = match record.kind {
            kind::INDEX => return self.read_index(offset, depth + 1),
            kind::VALUES => Cow::Borrowed(record.bytes(12, used as usize)?),
            kind::COMPRESSED_VALUES => {
                let length = usize::try_from(record.u64(16)?).unwrap_or(usize::MAX);
                let allocated = allocated.saturating_mul(self.record_bytes);
                let bytes = compression::inflate(record.bytes(24, length)?, allocated, offset)?;
                Cow::Owned(bytes)
            }
            kind => {
                let reason =
                    format!("values of `{}` are expected, kind {kind}", self.variable.name);
                return Err(CdfError::malformed(offset, reason));
            }
        };
        self.bytes.extend(&bytes[..used as usize]);
        self.next = end;
        Ok(())
    }

    fn missing(&self, byte: u64) -> CdfError {
        let Variable { name, records, .. } = self.variable;
        let reason = format!("record {} of the {records} of `{name}` is not there", self.next);
        CdfError::malformed(byte, reason)
    }
}
