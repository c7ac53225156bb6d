//! Writes events as one structured NumPy array.

use std::io::{Seek as _, SeekFrom, Write};
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, SensorSize};

use super::header_writer::header_for;
use crate::{EventSink, IoError};

/// The type of a record.
const RECORD_TYPE: &str = "[('t', '<i8'), ('x', '<u2'), ('y', '<u2'), ('p', '|u1')]";
/// Bytes of a record: a time in 8, column and row in 2 each, a polarity in 1.
const RECORD: usize = 13;

/// Writes records as they come; their count is entered at the end.
struct NpySink {
    path: PathBuf,
    file: AtomicFile,
    records: Vec<u8>,
    count: u64,
}

/// Begins an array of records `t`, `x`, `y`, `p`. It has no room for the size of the sensor.
pub(super) fn create(path: &Path, _: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    let failed = |e| IoError::file(path, "write", e);
    let mut file = AtomicFile::create(path).map_err(failed)?;
    file.write_all(&header(0)).map_err(failed)?;
    Ok(Box::new(NpySink { path: path.to_owned(), file, records: Vec::new(), count: 0 }))
}

/// The header of an array of `count` records, equally long for every count.
fn header(count: u64) -> Vec<u8> {
    header_for(RECORD_TYPE, &[count], &[u64::MAX])
}

impl EventSink for NpySink {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        self.records.clear();
        self.records.reserve(RECORD * events.len());
        for event in events.iter() {
            self.records.extend_from_slice(&event.t.0.to_le_bytes());
            self.records.extend_from_slice(&event.x.to_le_bytes());
            self.records.extend_from_slice(&event.y.to_le_bytes());
            self.records.push(event.polarity as u8);
        }
        self.count += events.len() as u64;
        self.file.write_all(&self.records).map_err(|e| IoError::file(&self.path, "write", e))
    }

    fn finish(mut self: Box<Self>) -> Result<(), IoError> {
        let failed = |e| IoError::file(&self.path, "write", e);
        self.file.seek(SeekFrom::Start(0)).map_err(failed)?;
        self.file.write_all(&header(self.count)).map_err(failed)?;
        self.file.commit().map_err(failed)
    }
}
