//! Writes events as columns of an HDF5 file in DSEC's layout: `events/{t,x,y,p}`, `t_offset` and
//! `ms_to_idx`.
//!
//! Chunks of all columns are written as they fill; the structure comes behind them, and the
//! superblock, which says where it is, at the end. Attributes of the root group state the sensor.

use std::io::{Seek as _, SeekFrom, Write};
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, SensorSize};
use hdf5_reader::checksum::fletcher32;

use super::chunk_index::ChunkIndex;
use super::ms_index::MsIndex;
use super::object::{IntegerType, ObjectHeader, SUPERBLOCK, superblock};
use crate::{EventSink, IoError};

/// Bytes of the checksum behind a chunk.
const SUM: u32 = 4;
/// Events of a chunk; a shorter recording has one chunk, of its own length.
const CHUNK_ROWS: usize = 1 << 16;
/// The columns: name and type.
const COLUMNS: [(&str, IntegerType); 4] = [
    ("t", IntegerType { bytes: 8, is_signed: true }),
    ("x", IntegerType { bytes: 2, is_signed: false }),
    ("y", IntegerType { bytes: 2, is_signed: false }),
    ("p", IntegerType { bytes: 1, is_signed: false }),
];
/// Type of the entries of the index.
const INDEX: IntegerType = IntegerType { bytes: 8, is_signed: false };

struct Hdf5Sink {
    path: PathBuf,
    file: AtomicFile,
    sensor: SensorSize,
    /// The events that do not fill a chunk yet.
    pending: EventStream,
    /// Events written in whole chunks.
    written: u64,
    /// Bytes written.
    length: u64,
    /// Of the chunks of each column.
    addresses: [Vec<u64>; 4],
    /// First event of every millisecond, and the addresses of its chunks.
    ms_index: MsIndex,
    ms_addresses: Vec<u64>,
}

/// Begins a file.
pub(super) fn create(path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    let failed = |e| IoError::file(path, "write", e);
    let mut file = AtomicFile::create(path).map_err(failed)?;
    // Room only: it holds addresses that are known at the end.
    file.write_all(&[0; SUPERBLOCK]).map_err(failed)?;
    Ok(Box::new(Hdf5Sink {
        path: path.to_owned(),
        file,
        sensor,
        pending: EventStream::empty(sensor),
        written: 0,
        length: SUPERBLOCK as u64,
        addresses: Default::default(),
        ms_index: MsIndex::default(),
        ms_addresses: Vec::new(),
    }))
}

impl EventSink for Hdf5Sink {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        let (t, x, y, polarity) = (events.t(), events.x(), events.y(), events.polarity());
        // Rows are counted from the start of the file: those that wait for their chunk come first.
        self.ms_index.push(t, self.written + self.pending.len() as u64);
        self.write_index(CHUNK_ROWS)?;
        let mut from = 0;
        while from < events.len() {
            // Chunks of HDF5 have one size; what does not fill one waits for the next call.
            let to = events.len().min(from + CHUNK_ROWS - self.pending.len());
            let taken = self.pending.extend_columns(
                &t[from..to],
                &x[from..to],
                &y[from..to],
                &polarity[from..to],
            );
            taken.map_err(|fault| IoError::unwritable(&self.path, fault.to_string()))?;
            from = to;
            if self.pending.len() == CHUNK_ROWS {
                self.write_chunks(CHUNK_ROWS)?;
            }
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), IoError> {
        let rows = self.written + self.pending.len() as u64;
        // A short recording is one chunk of its size, instead of a whole one padded with zeros.
        let chunk_rows = if self.written > 0 { CHUNK_ROWS } else { self.pending.len().max(1) };
        if !self.pending.is_empty() {
            self.write_chunks(chunk_rows)?;
        }
        // Datasets first: a group holds their addresses.
        let mut group = ObjectHeader::group();
        for (place, (name, kind)) in COLUMNS.into_iter().enumerate() {
            let addresses = std::mem::take(&mut self.addresses[place]);
            group = group.link(name, self.dataset(kind, rows, chunk_rows, addresses)?);
        }
        let events = self.append(&group.into_bytes())?;
        // Times are stored less this offset, as DSEC's are.
        let offset = ObjectHeader::scalar(self.ms_index.offset_us());
        let offset = self.append(&offset.into_bytes())?;
        let mut root = ObjectHeader::group()
            .link("events", events)
            .link("t_offset", offset)
            .attribute("width", self.sensor.width.into())
            .attribute("height", self.sensor.height.into());
        let entries = self.ms_index.entries();
        if entries > 0 {
            let is_short = self.ms_addresses.is_empty();
            let chunk_rows = if is_short { entries as usize } else { CHUNK_ROWS };
            if !self.ms_index.pending.is_empty() {
                // Padded, since a chunk is stored whole.
                self.ms_index.pending.resize(chunk_rows, 0);
                self.write_index(chunk_rows)?;
            }
            let addresses = std::mem::take(&mut self.ms_addresses);
            root = root.link("ms_to_idx", self.dataset(INDEX, entries, chunk_rows, addresses)?);
        }
        let root = self.append(&root.into_bytes())?;
        // The superblock comes last: it points to the root, whose address is known now.
        let begin = superblock(self.length, root);
        let failed = |e| IoError::file(&self.path, "write", e);
        self.file.seek(SeekFrom::Start(0)).map_err(failed)?;
        self.file.write_all(&begin).map_err(failed)?;
        self.file.commit().map_err(failed)
    }
}

impl Hdf5Sink {
    /// Writes the index and the header of a dataset, and returns the address of the latter.
    fn dataset(
        &mut self,
        kind: IntegerType,
        rows: u64,
        chunk_rows: usize,
        addresses: Vec<u64>,
    ) -> Result<u64, IoError> {
        let index = ChunkIndex {
            chunk_rows: chunk_rows as u64,
            chunk_bytes: chunk_rows as u32 * u32::from(kind.bytes) + SUM,
            addresses,
        };
        let (nodes, root) = index.nodes(self.length);
        self.append(&nodes)?;
        self.append(&ObjectHeader::dataset(kind, rows, chunk_rows as u32, root).into_bytes())
    }

    /// Writes whole chunks of the index of milliseconds.
    fn write_index(&mut self, chunk_rows: usize) -> Result<(), IoError> {
        let mut pending = std::mem::take(&mut self.ms_index.pending);
        let mut chunks = pending.chunks_exact(chunk_rows);
        for chunk in &mut chunks {
            let bytes: Vec<u8> = chunk.iter().flat_map(|entry| entry.to_le_bytes()).collect();
            let address = self.append_chunk(bytes)?;
            self.ms_addresses.push(address);
        }
        let rest = chunks.remainder().len();
        pending.drain(..pending.len() - rest);
        self.ms_index.pending = pending;
        Ok(())
    }

    /// Writes the pending events as a chunk of each column, zeros behind them up to `chunk_rows`.
    fn write_chunks(&mut self, chunk_rows: usize) -> Result<(), IoError> {
        let events = std::mem::replace(&mut self.pending, EventStream::empty(self.sensor));
        let offset_us = self.ms_index.offset_us();
        let columns: [Vec<u8>; 4] = [
            events.t().iter().flat_map(|t| t.0.wrapping_sub(offset_us).to_le_bytes()).collect(),
            events.x().iter().flat_map(|x| x.to_le_bytes()).collect(),
            events.y().iter().flat_map(|y| y.to_le_bytes()).collect(),
            events.polarity().iter().map(|&p| p as u8).collect(),
        ];
        for (place, mut column) in columns.into_iter().enumerate() {
            // HDF5 has no shorter last chunk; the number of rows says where the column ends.
            column.resize(chunk_rows * usize::from(COLUMNS[place].1.bytes), 0);
            let address = self.append_chunk(column)?;
            self.addresses[place].push(address);
        }
        self.written += events.len() as u64;
        Ok(())
    }

    /// Appends a chunk with its checksum; returns the address.
    fn append_chunk(&mut self, mut chunk: Vec<u8>) -> Result<u64, IoError> {
        chunk.extend(fletcher32(&chunk).to_le_bytes());
        self.append(&chunk)
    }

    /// Appends to the file; returns the address.
    fn append(&mut self, bytes: &[u8]) -> Result<u64, IoError> {
        self.file.write_all(bytes).map_err(|e| IoError::file(&self.path, "write", e))?;
        let address = self.length;
        self.length += bytes.len() as u64;
        Ok(address)
    }
}
