//! Writes RAW files.

use std::io::Write;
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, SensorSize};

use super::EncodeError;
use crate::{EventSink, IoError};

/// Sensors of the coordinates that words hold, 11 bits each.
const LARGEST: u16 = 2048;

/// Turns events into the words of an encoding.
pub trait WordEncoder: Sized {
    /// The encoding as the header calls it: the value of `evt`, and that of `format` without the
    /// size of the sensor.
    const NAMES: (&'static str, &'static str);

    /// An encoder of the events of a sensor of at most 2048 by 2048 pixels.
    fn new(sensor: SensorSize) -> Self;

    /// Appends the words of `events`, which go on from those before.
    ///
    /// # Errors
    /// If an event has a time that the encoding does not hold.
    fn encode(&mut self, events: &EventStream, words: &mut Vec<u8>) -> Result<(), EncodeError>;
}

struct WordSink<E> {
    path: PathBuf,
    file: AtomicFile,
    sensor: SensorSize,
    encoder: E,
    words: Vec<u8>,
}

/// Begins a file of the words of an encoder.
pub(super) fn create<E: WordEncoder + 'static>(
    path: &Path,
    sensor: SensorSize,
) -> Result<Box<dyn EventSink>, IoError> {
    let SensorSize { width, height } = sensor;
    let (evt, format) = E::NAMES;
    // A coordinate has 11 bits.
    if width > LARGEST || height > LARGEST {
        let reason = format!("EVT {evt} holds sensors of up to 2048x2048, this one is {sensor}");
        return Err(IoError::unwritable(path, reason));
    }
    let file = AtomicFile::create(path).map_err(|e| IoError::file(path, "create", e))?;
    let header = format!(
        "% evt {evt}\n% format {format};height={height};width={width}\n\
         % geometry {width}x{height}\n% end\n"
    );
    let (path, encoder) = (path.to_owned(), E::new(sensor));
    Ok(Box::new(WordSink { path, file, sensor, encoder, words: header.into_bytes() }))
}

impl<E: WordEncoder> EventSink for WordSink<E> {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        if let Some(event) = events.iter().find(|event| !self.sensor.contains(event.x, event.y)) {
            let reason = format!("event at ({}, {}) of {}", event.x, event.y, self.sensor);
            return Err(IoError::unwritable(&self.path, reason));
        }
        let encoded = self.encoder.encode(events, &mut self.words);
        encoded.map_err(|error| IoError::unwritable(&self.path, error.to_string()))?;
        self.put()
    }

    fn finish(mut self: Box<Self>) -> Result<(), IoError> {
        self.put()?;
        self.file.commit().map_err(|e| IoError::file(&self.path, "finish", e))
    }
}

impl<E> WordSink<E> {
    fn put(&mut self) -> Result<(), IoError> {
        self.file.write_all(&self.words).map_err(|e| IoError::file(&self.path, "write", e))?;
        self.words.clear();
        Ok(())
    }
}
