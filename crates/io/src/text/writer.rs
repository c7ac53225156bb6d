//! Writes a recording line by line.

use std::io::Write;
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, SensorSize};

use crate::{EventSink, IoError};

struct TextSink {
    path: PathBuf,
    file: AtomicFile,
    lines: Vec<u8>,
}

/// Begins a file of `width height` and then `t x y p` lines, times in whole microseconds.
pub(super) fn create(path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    let file = AtomicFile::create(path).map_err(|e| IoError::file(path, "create", e))?;
    let lines = format!("{} {}\n", sensor.width, sensor.height).into_bytes();
    Ok(Box::new(TextSink { path: path.to_owned(), file, lines }))
}

impl EventSink for TextSink {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        let failed = |e| IoError::file(&self.path, "write", e);
        for event in events.iter() {
            let polarity = event.polarity as u8;
            writeln!(self.lines, "{} {} {} {polarity}", event.t.0, event.x, event.y)
                .map_err(failed)?;
        }
        self.file.write_all(&self.lines).map_err(failed)?;
        self.lines.clear();
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), IoError> {
        let failed = |e| IoError::file(&self.path, "write", e);
        self.file.write_all(&self.lines).map_err(failed)?;
        self.file.commit().map_err(failed)
    }
}
