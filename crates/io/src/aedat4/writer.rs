//! Writes packets, and the data table behind them.

use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, Micros, SensorSize};

use super::build::Builder;
use super::compression::{Compression, deflate};
use super::header::{self, Stream, StreamKind};
use super::packet::{Aedat4Packet, Content};
use super::table::{self, Entry};
use super::{events, walk};
use crate::{EventSink, IoError};

/// Events in a packet: with what stands before them, one LZ4 block of 256 KiB.
const EVENTS: usize = 16_000;
/// Columns and rows that the format has room for.
const MAX_PIXELS: u16 = 1 << 15;

/// A file that is being written. It appears when it is finished; dropped before, it leaves none.
pub struct Writer {
    path: PathBuf,
    file: AtomicFile,
    compression: Compression,
    streams: Vec<Stream>,
    builder: Builder,
    packed: Vec<u8>,
    entries: Vec<Entry>,
    /// Bytes so far.
    at: u64,
}

impl Writer {
    /// Begins a file of these streams.
    ///
    /// # Errors
    /// If two streams have the same number, a sensor has more than 32,768 columns or rows, there is
    /// no compressor for the compression, or the file cannot be made.
    pub fn create(
        path: impl AsRef<Path>,
        compression: Compression,
        streams: &[Stream],
    ) -> Result<Self, IoError> {
        let path = path.as_ref();
        if !compression.is_writable() {
            let reason = format!("there is no compressor for {compression} here");
            return Err(IoError::unwritable(path, reason));
        }
        for (k, stream) in streams.iter().enumerate() {
            // Packets name their stream by its number alone.
            if streams[..k].iter().any(|other| other.id == stream.id) {
                let reason = format!("two streams of number {}", stream.id);
                return Err(IoError::unwritable(path, reason));
            }
            // Coordinates are signed 16 bits in this format.
            let is_large = |s: SensorSize| s.width > MAX_PIXELS || s.height > MAX_PIXELS;
            if let Some(size) = stream.size.filter(|&size| is_large(size)) {
                let reason = format!("a sensor of {size}, and rows and columns end at 32767");
                return Err(IoError::unwritable(path, reason));
            }
        }
        // Without the place of the table, which is known at the end.
        let header = header::bytes(compression, None, streams);
        let failed = |e| IoError::file(path, "create", e);
        let mut file = AtomicFile::create(path).map_err(failed)?;
        file.write_all(&header).map_err(failed)?;
        Ok(Self {
            path: path.to_owned(),
            file,
            compression,
            streams: streams.to_vec(),
            builder: Builder::default(),
            packed: Vec::new(),
            entries: Vec::new(),
            at: header.len() as u64,
        })
    }

    /// Appends a packet.
    ///
    /// # Errors
    /// If its stream is not there or holds something else, if the format cannot hold its content,
    /// or if writing fails.
    pub fn packet(&mut self, packet: &Aedat4Packet) -> Result<(), IoError> {
        let Aedat4Packet { stream, content } = packet;
        self.check(*stream, content.kind())?;
        if let Content::Events(columns) = content {
            self.check_pixels(&columns.x, &columns.y)?;
        }
        let bytes = content.encode(&mut self.builder);
        let bytes = bytes.map_err(|error| IoError::unwritable(&self.path, error.to_string()))?;
        deflate(self.compression, bytes, &mut self.packed)
            .map_err(|e| IoError::file(&self.path, "compress", e))?;
        self.append(*stream, content.extent())
    }

    /// Appends events, in packets of a size that is read fast.
    ///
    /// # Errors
    /// As [`Writer::packet`].
    pub fn events(&mut self, stream: i32, events: &EventStream) -> Result<(), IoError> {
        self.check(stream, StreamKind::Events)?;
        self.check_pixels(events.x(), events.y())?;
        // Packets of limited length: readers hold one at a time.
        for start in (0..events.len()).step_by(EVENTS) {
            let range = start..events.len().min(start + EVENTS);
            let t = &events.t()[range.clone()];
            let (x, y) = (&events.x()[range.clone()], &events.y()[range.clone()]);
            let bytes = events::encode(&mut self.builder, (t, x, y, &events.polarity()[range]));
            deflate(self.compression, bytes, &mut self.packed)
                .map_err(|e| IoError::file(&self.path, "compress", e))?;
            self.append(stream, (t.len(), t[0], t[t.len() - 1]))?;
        }
        Ok(())
    }

    /// Writes the data table and gives the file its name.
    ///
    /// # Errors
    /// If writing fails.
    pub fn finish(mut self) -> Result<(), IoError> {
        let bytes = table::encode(&mut self.builder, &self.entries);
        let header = header::bytes(self.compression, Some(self.at), &self.streams);
        let mut write = || {
            deflate(self.compression, bytes, &mut self.packed)?;
            self.file.write_all(&self.packed)?;
            // The header is as long with the place of the table as without, so that it is
            // overwritten.
            self.file.seek(SeekFrom::Start(0))?;
            self.file.write_all(&header)
        };
        write().map_err(|e| IoError::file(&self.path, "write", e))?;
        self.file.commit().map_err(|e| IoError::file(&self.path, "write", e))
    }

    fn check(&self, id: i32, kind: StreamKind) -> Result<(), IoError> {
        match self.streams.iter().find(|stream| stream.id == id) {
            Some(stream) if stream.kind == kind => Ok(()),
            Some(stream) => {
                let reason = format!("{kind} in stream {id}, which holds {}", stream.kind);
                Err(IoError::unwritable(&self.path, reason))
            }
            None => Err(IoError::unwritable(&self.path, format!("the file has no stream {id}"))),
        }
    }

    fn check_pixels(&self, x: &[u16], y: &[u16]) -> Result<(), IoError> {
        match x.iter().chain(y).max() {
            Some(&largest) if largest >= MAX_PIXELS => {
                let reason = format!("an event in column or row {largest}: they end at 32767");
                Err(IoError::unwritable(&self.path, reason))
            }
            _ => Ok(()),
        }
    }

    /// Appends what is packed.
    fn append(
        &mut self,
        stream: i32,
        (elements, first, last): (usize, Micros, Micros),
    ) -> Result<(), IoError> {
        // The format stores sizes as signed integers of 32 bits.
        let Ok(size) = i32::try_from(self.packed.len()) else {
            return Err(IoError::unwritable(&self.path, "a packet of more than 2 GiB"));
        };
        let mut write = || {
            self.file.write_all(&stream.to_le_bytes())?;
            self.file.write_all(&size.to_le_bytes())?;
            self.file.write_all(&self.packed)
        };
        write().map_err(|e| IoError::file(&self.path, "write", e))?;
        // Entries of the data table point behind the head of a packet.
        let body = self.at + walk::HEAD;
        self.at = body + self.packed.len() as u64;
        let (body, elements) = (body as i64, elements as i64);
        self.entries.push(Entry { body, stream, size, elements, first, last });
        Ok(())
    }
}

/// Number of the one stream of a recording.
const STREAM: i32 = 0;

struct Sink {
    writer: Writer,
    /// Events that wait until a packet is full.
    pending: EventStream,
}

/// Begins a file of one stream of events, with LZ4.
pub(super) fn create(path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    let stream = Stream {
        id: STREAM,
        kind: StreamKind::Events,
        name: "events".to_owned(),
        source: "evpose".to_owned(),
        size: Some(sensor),
    };
    let writer = Writer::create(path, Compression::default(), &[stream])?;
    Ok(Box::new(Sink { writer, pending: EventStream::empty(sensor) }))
}

impl EventSink for Sink {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        // Large streams need no copy: they are packets as they are.
        if self.pending.is_empty() && events.len() >= EVENTS {
            return self.writer.events(STREAM, events);
        }
        for event in events.iter() {
            self.pending
                .push(event)
                .map_err(|fault| IoError::unwritable(&self.writer.path, fault.to_string()))?;
            if self.pending.len() == EVENTS {
                self.writer.events(STREAM, &self.pending)?;
                self.pending.clear();
            }
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), IoError> {
        self.writer.events(STREAM, &self.pending)?;
        self.writer.finish()
    }
}
