//! Writes records of five bytes.

use std::io::Write;
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, SensorSize};

use super::{OVERFLOW_ROW, PERIOD_US};
use crate::{EventSink, IoError};

struct RecordSink {
    path: PathBuf,
    file: AtomicFile,
    sensor: SensorSize,
    records: Vec<u8>,
}

/// Begins a file.
pub(super) fn create(path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    if sensor.width > 256 || sensor.height > OVERFLOW_ROW.into() {
        let reason = format!("records hold 256 columns and 240 rows, the sensor is {sensor}");
        return Err(IoError::unwritable(path, reason));
    }
    let file = AtomicFile::create(path).map_err(|e| IoError::file(path, "create", e))?;
    Ok(Box::new(RecordSink { path: path.to_owned(), file, sensor, records: Vec::new() }))
}

impl EventSink for RecordSink {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        if events.sensor() != self.sensor {
            let reason = format!("events of a sensor of {}, not {}", events.sensor(), self.sensor);
            return Err(IoError::unwritable(&self.path, reason));
        }
        // Events are in order, and on the sensor.
        let ends = [events.t().first(), events.t().last()];
        if let Some(t) = ends.into_iter().flatten().find(|t| !(0..PERIOD_US).contains(&t.0)) {
            let reason = format!("times are 0 to {} µs, an event is at {t}", PERIOD_US - 1);
            return Err(IoError::unwritable(&self.path, reason));
        }
        self.records.clear();
        for event in events.iter() {
            let [_, high, middle, low] = (event.t.0 as u32).to_be_bytes();
            let polarity = (event.polarity as u8) << 7;
            let record = [event.x as u8, event.y as u8, polarity | high, middle, low];
            self.records.extend_from_slice(&record);
        }
        self.file.write_all(&self.records).map_err(|e| IoError::file(&self.path, "write", e))
    }

    fn finish(self: Box<Self>) -> Result<(), IoError> {
        self.file.commit().map_err(|e| IoError::file(&self.path, "write", e))
    }
}
