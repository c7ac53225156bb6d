//! Writes a recording line by line.

use std::io::Write;
use std::path::Path;

use evpose_core::{AtomicFile, EventStream};

use crate::IoError;

/// Writes `width height` and then `t x y p` lines, times in whole microseconds.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, events: &EventStream) -> Result<(), IoError> {
    let failed = |e| IoError::file(path, "write", e);
    let mut file = AtomicFile::create(path).map_err(failed)?;
    let sensor = events.sensor();
    writeln!(file, "{} {}", sensor.width, sensor.height).map_err(failed)?;
    for event in events.iter() {
        let polarity = event.polarity as u8;
        writeln!(file, "{} {} {} {polarity}", event.t.0, event.x, event.y).map_err(failed)?;
    }
    file.commit().map_err(failed)
}
