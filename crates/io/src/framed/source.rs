//! Files of a stream.

use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, SensorSize};

use super::decoder::FramedDecoder;
use super::layout::{HEADER, sensor_of};
use super::writer::FramedWriter;
use crate::{BlockSource, EventSink, EventSource, Header, Input, IoError, OpenOptions};

/// Opens a file. What is no packet is damage, unless it is to be salvaged.
pub(super) fn open(
    mut input: Input,
    options: &OpenOptions,
) -> Result<Box<dyn EventSource>, IoError> {
    let head = input.head(HEADER)?;
    let Some(head) = head.first_chunk() else {
        return Err(IoError::damaged(&input.path, head.len() as u64, "the header is cut"));
    };
    let damage = |(byte, reason)| IoError::damaged(&input.path, byte, reason);
    let sensor = sensor_of(head).map_err(damage)?;
    let header = Header { sensor: Some(sensor), ..Header::default() };
    // A damaged packet ends a file, unless the packets behind it are wanted.
    let decoder = match options.salvage {
        true => FramedDecoder::lenient(),
        false => FramedDecoder::strict(),
    };
    Ok(Box::new(BlockSource::new(input, HEADER as u64, header, decoder)))
}

struct Sink {
    path: PathBuf,
    writer: FramedWriter<AtomicFile>,
}

/// Begins a file.
pub(super) fn create(path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    let file = AtomicFile::create(path).map_err(|e| IoError::file(path, "create", e))?;
    let writer = FramedWriter::begin(path, file, sensor)?;
    Ok(Box::new(Sink { path: path.to_owned(), writer }))
}

impl EventSink for Sink {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        self.writer.push(events)
    }

    fn finish(self: Box<Self>) -> Result<(), IoError> {
        let Self { path, writer } = *self;
        writer.into_inner().commit().map_err(|e| IoError::file(&path, "finish", e))
    }
}
