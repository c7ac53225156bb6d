//! Writes DAT files.

use std::io::Write;
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, SensorSize};

use super::{EVENT_CD, RECORD, counter};
use crate::time_stamp::WraparoundCounter;
use crate::{EventSink, IoError};

/// Sensors of the coordinates that records hold, 14 bits each.
const LARGEST: u16 = 1 << 14;

struct DatSink {
    path: PathBuf,
    file: AtomicFile,
    sensor: SensorSize,
    /// The counter of a reader, to check that it unwraps the stamps as they are meant.
    counter: WraparoundCounter,
    bytes: Vec<u8>,
}

/// Begins a file.
pub(super) fn create(path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    let SensorSize { width, height } = sensor;
    if width > LARGEST || height > LARGEST {
        let reason = format!("DAT holds sensors of up to 16384x16384, this one is {sensor}");
        return Err(IoError::unwritable(path, reason));
    }
    let file = AtomicFile::create(path).map_err(|e| IoError::file(path, "create", e))?;
    let header = format!(
        "% Data file containing CD events.\n% Version 2\n% Height {height}\n% Width {width}\n"
    );
    let mut bytes = header.into_bytes();
    bytes.extend([EVENT_CD, RECORD as u8]);
    Ok(Box::new(DatSink { path: path.to_owned(), file, sensor, counter: counter(), bytes }))
}

impl EventSink for DatSink {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        for event in events.iter() {
            let (t, x, y) = (event.t.0, event.x, event.y);
            if !self.sensor.contains(x, y) {
                let reason = format!("event at ({x}, {y}) of {}", self.sensor);
                return Err(IoError::unwritable(&self.path, reason));
            }
            // Readers unwrap 32 bits of time by the events before: a longer pause cannot be
            // written.
            if self.counter.advance_or_late((t as u32).into()) != t {
                let reason = format!("event at {t} µs: readers would take it for another time");
                return Err(IoError::unwritable(&self.path, reason));
            }
            let rest = u32::from(x) | u32::from(y) << 14 | (event.polarity as u32) << 28;
            self.bytes.extend((t as u32).to_le_bytes());
            self.bytes.extend(rest.to_le_bytes());
        }
        self.put()
    }

    fn finish(mut self: Box<Self>) -> Result<(), IoError> {
        self.put()?;
        self.file.commit().map_err(|e| IoError::file(&self.path, "finish", e))
    }
}

impl DatSink {
    fn put(&mut self) -> Result<(), IoError> {
        self.file.write_all(&self.bytes).map_err(|e| IoError::file(&self.path, "write", e))?;
        self.bytes.clear();
        Ok(())
    }
}
