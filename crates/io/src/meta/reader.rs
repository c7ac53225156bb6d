//! Random access to the records of a `.meta` file.

use std::ops::Range;
use std::path::{Path, PathBuf};

use evpose_pose::{HandParams, PARAMETERS};

use super::fault::{MAX_VALUES, MetaFault};
use super::{HEADER, MAGIC};
use crate::IoError;
use crate::positional::PositionalFile;

/// Bytes that are read at once.
const READ_BYTES: u64 = 1 << 18;

/// An open `.meta` file, not held in memory.
///
/// Opening checks the count and the size; reading a record checks its magic bytes.
#[derive(Debug)]
pub struct MetaReader {
    path: PathBuf,
    file: PositionalFile,
    values: usize,
    records: u64,
}

impl MetaReader {
    /// Opens a file.
    ///
    /// # Errors
    /// If the file cannot be read, its count is out of range, or it ends inside a record.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, IoError> {
        let (reader, fault) = Self::open_prefix(path)?;
        fault.map_or(Ok(reader), Err)
    }

    /// Opens what can be read of a truncated file: its whole records, and the fault.
    ///
    /// # Errors
    /// If the file cannot be read at all or has no valid count.
    pub fn open_prefix(path: impl AsRef<Path>) -> Result<(Self, Option<IoError>), IoError> {
        let path = path.as_ref().to_owned();
        let (file, size) =
            PositionalFile::open(&path).map_err(|e| IoError::file(&path, "open", e))?;
        let mut reader = Self { path, file, values: 0, records: 0 };
        if size < HEADER {
            return Err(reader.fault(0, 0, MetaFault::NoCount { bytes: size }));
        }
        let mut count = [0; HEADER as usize];
        reader.read_at(&mut count, 0)?;
        let count = i32::from_le_bytes(count);
        match usize::try_from(count) {
            Ok(values) if (1..=MAX_VALUES).contains(&values) => reader.values = values,
            _ => return Err(reader.fault(0, 0, MetaFault::Count(count))),
        }
        let of = reader.record_bytes();
        let (records, bytes) = ((size - HEADER) / of, (size - HEADER) % of);
        reader.records = records;
        // A file that is cut within a record keeps those before it.
        let fault = (bytes > 0).then(|| {
            reader.fault(reader.offset(records), records, MetaFault::Truncated { bytes, of })
        });
        Ok((reader, fault))
    }

    /// Path of the file that is read.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Values in a record.
    pub fn values(&self) -> usize {
        self.values
    }

    /// Count of records: the frames of the `.evc` file beside it.
    pub fn records(&self) -> u64 {
        self.records
    }

    /// Reads record `k` into `values`.
    ///
    /// # Errors
    /// If there is no such record, it cannot be read, or its magic bytes are wrong.
    pub fn read_record(&self, k: u64, values: &mut Vec<f64>) -> Result<(), IoError> {
        values.clear();
        self.for_each(k..k.saturating_add(1), |_, record| {
            values.extend(record);
            Ok(())
        })
    }

    /// Reads the hand of record `k`.
    ///
    /// # Errors
    /// As [`MetaReader::read_record`]; if the records are no hands or a value is not finite.
    pub fn read_hand(&self, k: u64) -> Result<HandParams, IoError> {
        let hands = self.read_hands(k..k.saturating_add(1))?;
        hands.first().map(|&hand| HandParams::from_f64(hand)).ok_or_else(|| self.missing(k, k + 1))
    }

    /// Reads the 12 parameters of each of `records`, in the published order.
    ///
    /// # Errors
    /// As [`MetaReader::read_hand`].
    pub fn read_hands(&self, records: Range<u64>) -> Result<Vec<[f64; PARAMETERS]>, IoError> {
        if self.values != PARAMETERS {
            return Err(self.fault(0, 0, MetaFault::NotAHand { values: self.values }));
        }
        let mut hands = Vec::new();
        self.for_each(records, |k, record| {
            let mut hand = [0.0; PARAMETERS];
            for (value, (slot, parameter)) in hand.iter_mut().zip(record).enumerate() {
                if !parameter.is_finite() {
                    let byte = self.offset(k) + 8 * value as u64;
                    return Err(self.fault(byte, k, MetaFault::NotFinite { value }));
                }
                *slot = parameter;
            }
            hands.push(hand);
            Ok(())
        })?;
        Ok(hands)
    }

    /// Calls `visit` with the index and the values of each of `records`.
    fn for_each(
        &self,
        records: Range<u64>,
        mut visit: impl FnMut(u64, &mut dyn Iterator<Item = f64>) -> Result<(), IoError>,
    ) -> Result<(), IoError> {
        if records.start > records.end || records.end > self.records {
            return Err(self.missing(records.start, records.end));
        }
        let size = self.record_bytes() as usize;
        // Many records a read, however small they are.
        let at_once = (READ_BYTES / size as u64).max(1);
        let mut bytes = Vec::new();
        let mut start = records.start;
        while start < records.end {
            let end = records.end.min(start + at_once);
            bytes.resize((end - start) as usize * size, 0);
            self.read_at(&mut bytes, self.offset(start))?;
            for (k, record) in (start..end).zip(bytes.chunks_exact(size)) {
                let (values, magic) = record.split_at(8 * self.values);
                // The mark behind each record shows a file that is cut or shifted.
                if magic != MAGIC {
                    let byte = self.offset(k) + values.len() as u64;
                    return Err(self.fault(byte, k, MetaFault::Magic([magic[0], magic[1]])));
                }
                visit(k, &mut values.as_chunks::<8>().0.iter().map(|&v| f64::from_le_bytes(v)))?;
            }
            start = end;
        }
        Ok(())
    }

    fn record_bytes(&self) -> u64 {
        (8 * self.values + MAGIC.len()) as u64
    }

    fn offset(&self, record: u64) -> u64 {
        HEADER + record * self.record_bytes()
    }

    fn read_at(&self, bytes: &mut [u8], offset: u64) -> Result<(), IoError> {
        self.file.read_exact_at(bytes, offset).map_err(|e| IoError::file(&self.path, "read", e))
    }

    fn missing(&self, start: u64, end: u64) -> IoError {
        IoError::NoSuchFrames { path: self.path.clone(), start, end, available: self.records }
    }

    fn fault(&self, byte: u64, records: u64, fault: MetaFault) -> IoError {
        IoError::Meta { path: self.path.clone(), byte, fault, records }
    }
}
