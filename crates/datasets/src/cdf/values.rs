//! The values of a variable: where they are, and in which order.

use std::borrow::Cow;

use super::file::Variable;
use super::kind::NumberKind;
use super::record::{Record, kind};
use super::{CdfArray, CdfError, CdfFile, compression};

/// Indices of indices of indices, more than any program writes.
const DEEPEST: usize = 8;

pub(super) fn numbers(
    file: &CdfFile,
    variable: &Variable,
    kind: NumberKind,
) -> Result<CdfArray, CdfError> {
    if let Some(at) = variable.compression {
        compression::check(&file.bytes, at)?;
    }
    let record_bytes = variable.of_each * kind.size() as u64;
    let mut stored =
        Stored { file: &file.bytes, variable, record_bytes, bytes: Vec::new(), next: 0 };
    if let Some(index) = variable.index.filter(|_| variable.records > 0) {
        stored.read_index(index, 0)?;
    }
    if stored.next != variable.records {
        return Err(stored.missing(variable.at));
    }
    let values = stored.bytes.chunks_exact(kind.size()).map(|bytes| kind.number(bytes, file.order));
    let mut values: Vec<f64> = values.collect();
    if !file.is_row_major {
        values = row_major(&values, &variable.sizes, variable.of_each as usize);
    }
    let sizes = variable.sizes.iter().map(|&size| size as usize).collect();
    // The limit of a variable keeps them within any machine's memory.
    Ok(CdfArray { records: variable.records as usize, sizes, values })
}

/// Records as they are stored, one behind the other.
struct Stored<'a> {
    file: &'a [u8],
    variable: &'a Variable,
    record_bytes: u64,
    bytes: Vec<u8>,
    /// The record that comes next.
    next: u64,
}

impl Stored<'_> {
    /// Reads what the index at `at` and those behind it list.
    fn read_index(&mut self, at: u64, depth: usize) -> Result<(), CdfError> {
        let (mut next, mut visited) = (Some(at), 0);
        while let Some(at) = next {
            let index = Record::of_kind(self.file, at, kind::INDEX)?;
            visited += 1;
            if depth > DEEPEST || visited * 28 > self.file.len() {
                return Err(CdfError::malformed(at, "an index that leads back to itself"));
            }
            let [entries, used] = [index.u32(20)? as usize, index.u32(24)? as usize];
            if used > entries {
                let reason = format!("an index of {entries} entries, {used} of them used");
                return Err(CdfError::malformed(at, reason));
            }
            for entry in 0..used {
                let first = index.u32(28 + 4 * entry)?;
                let last = index.u32(28 + 4 * entries + 4 * entry)?;
                let place = index.u64(28 + 8 * entries + 8 * entry)?;
                self.read_entry(at, first.into(), last.into(), place, depth)?;
            }
            next = index.place(12)?;
        }
        Ok(())
    }

    fn read_entry(
        &mut self,
        index: u64,
        first: u64,
        last: u64,
        place: u64,
        depth: usize,
    ) -> Result<(), CdfError> {
        // Records may be allotted beyond those that are used.
        let end = (last + 1).min(self.variable.records);
        if first >= end {
            return Ok(());
        }
        if first != self.next {
            return Err(self.missing(index));
        }
        let record = Record::at(self.file, place)?;
        // Records of a variable are limited, so that this cannot run over.
        let (used, allotted) = ((end - first) * self.record_bytes, (last + 1 - first));
        let bytes = match record.kind {
            kind::INDEX => return self.read_index(place, depth + 1),
            kind::VALUES => Cow::Borrowed(record.bytes(12, used as usize)?),
            kind::COMPRESSED_VALUES => {
                let length = usize::try_from(record.u64(16)?).unwrap_or(usize::MAX);
                let allotted = allotted.saturating_mul(self.record_bytes);
                let bytes = compression::inflate(record.bytes(24, length)?, allotted, place)?;
                Cow::Owned(bytes)
            }
            kind => {
                let reason =
                    format!("values of `{}` are expected, kind {kind}", self.variable.name);
                return Err(CdfError::malformed(place, reason));
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

/// Records whose first dimension runs first, with the last one first.
fn row_major(values: &[f64], sizes: &[u32], of_each: usize) -> Vec<f64> {
    let (mut strides, mut stride) = (Vec::with_capacity(sizes.len()), 1);
    for &size in sizes {
        strides.push(stride);
        stride *= size as usize;
    }
    let place = |mut index: usize| {
        let mut place = 0;
        for (&size, stride) in sizes.iter().zip(&strides).rev() {
            place += index % size as usize * stride;
            index /= size as usize;
        }
        place
    };
    let records = values.chunks_exact(of_each.max(1));
    records.flat_map(|record| (0..of_each).map(move |index| record[place(index)])).collect()
}
