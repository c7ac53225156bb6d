//! Random access to the frames of an `.evc` file of any size.

use std::ops::Range;
use std::path::{Path, PathBuf};

use evpose_core::{EventStream, Micros, Polarity, SensorSize};

use super::scan::{EvcFault, Tally, marker_offset, tally};
use super::{EvcWindow, FRAME, NEW_FRAME, RECORD};
use crate::positional::PositionalFile;
use crate::{Columns, IoError};

/// Frames between two entries of the index: 10 MB of index for a published sequence of 11 hours,
/// and at most two such steps read beyond a window.
const INDEX_STEP: u64 = 32;
/// Bytes read at once while the index is made.
const BLOCK: usize = 1 << 20;
/// Frames read at once into a stream.
const FRAMES_AT_ONCE: u64 = 256;
/// Events after which columns are handed on, 13 bytes each: they stay in the first-level cache.
const FULL: usize = 2048;
/// Bytes checked at once: they stay in the first-level cache.
const RUN: usize = 1 << 13;

/// An open `.evc` file: validated, indexed, not held in memory.
///
/// Reads are positional, so many threads may share one reader.
#[derive(Debug)]
pub struct EvcReader {
    path: PathBuf,
    file: PositionalFile,
    sensor: SensorSize,
    /// Byte offset of the marker of every [`INDEX_STEP`]-th frame.
    index: Vec<u64>,
    frames: u64,
    /// Bytes of the whole frames.
    length: u64,
    tally: Tally,
}

impl EvcReader {
    /// Opens a file recorded at 240x180, the size of the published data.
    ///
    /// # Errors
    /// If the file cannot be read, or at the first byte that breaks the format.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, IoError> {
        Self::open_with(path, SensorSize::DAVIS240C)
    }

    /// Opens a file recorded with `sensor`, which the file itself does not state.
    ///
    /// # Errors
    /// As [`EvcReader::open`].
    pub fn open_with(path: impl AsRef<Path>, sensor: SensorSize) -> Result<Self, IoError> {
        let (reader, fault) = Self::open_prefix(path, sensor)?;
        fault.map_or(Ok(reader), Err)
    }

    /// Opens what can be read of a faulty file: the whole frames before its first fault, and the
    /// fault.
    ///
    /// # Errors
    /// If the file cannot be read at all.
    pub fn open_prefix(
        path: impl AsRef<Path>,
        sensor: SensorSize,
    ) -> Result<(Self, Option<IoError>), IoError> {
        let path = path.as_ref().to_owned();
        let (file, size) =
            PositionalFile::open(&path).map_err(|e| IoError::file(&path, "open", e))?;
        let (index, length) = (Vec::new(), 0);
        let tally = Tally::default();
        let mut reader = Self { path, file, sensor, index, frames: 0, length, tally };
        let fault = reader.scan(size)?;
        Ok((reader, fault))
    }

    /// Makes the index; the fault, if any, ends the part that can be read.
    fn scan(&mut self, size: u64) -> Result<Option<IoError>, IoError> {
        // A small file needs no whole block.
        let mut block = vec![0; BLOCK.min(usize::try_from(size).unwrap_or(BLOCK))];
        let mut fault = (size == 0).then_some((0, EvcFault::Empty));
        let mut offset = 0;
        let whole_records = size - size % RECORD as u64;
        while fault.is_none() && offset < whole_records {
            let length = (whole_records - offset).min(BLOCK as u64) as usize;
            self.read_at(&mut block[..length], offset)?;
            // Without a marker first, no event has a time.
            if offset == 0 && block[3] != NEW_FRAME {
                fault = Some((0, EvcFault::NoMarker { polarity: block[3] }));
                break;
            }
            // In runs that stay in the cache, since a faulty one is read several times.
            for run in block[..length].chunks(RUN) {
                let (good, found) = match tally(run, self.sensor) {
                    Ok(tally) => (tally, None),
                    Err((record, found)) => {
                        let good = &run[..record * RECORD];
                        let at = offset + good.len() as u64;
                        // Faultless by construction, so the default is never taken.
                        (tally(good, self.sensor).unwrap_or_default(), Some((at, found)))
                    }
                };
                self.index_run(run, offset, good);
                if found.is_some() {
                    fault = found;
                    break;
                }
                offset += run.len() as u64;
            }
        }
        // A fault that was found comes before the cut.
        if fault.is_none() && whole_records < size {
            let bytes = (size - whole_records) as usize;
            fault = Some((whole_records, EvcFault::Truncated { bytes }));
        }
        self.length = whole_records;
        // Frames before the fault can be read all the same.
        let Some((byte, found)) = fault else { return Ok(None) };
        self.keep_whole_frames_before(byte)?;
        Ok(Some(self.fault(byte, found)))
    }

    /// Takes account of a run of valid records at `offset`.
    fn index_run(&mut self, run: &[u8], offset: u64, counts: Tally) {
        let after = self.frames + counts.markers;
        while self.index.len() as u64 * INDEX_STEP < after {
            let wanted = self.index.len() as u64 * INDEX_STEP;
            // Counts of the run are known: it is searched again only where it holds an indexed
            // frame.
            let Some(at) = marker_offset(run, wanted - self.frames) else { break };
            self.index.push(offset + at as u64);
        }
        self.frames = after;
        self.tally.add(counts);
    }

    /// Drops the frame that a fault at `byte` has broken.
    fn keep_whole_frames_before(&mut self, byte: u64) -> Result<(), IoError> {
        self.length = byte;
        let Some(broken) = self.frames.checked_sub(1) else { return Ok(()) };
        self.length = self.frame_offset(broken)?;
        self.frames = broken;
        self.index.truncate(broken.div_ceil(INDEX_STEP) as usize);
        // The counts may include events of the broken frame.
        self.tally = Tally::default();
        let mut window = EvcWindow::new();
        for start in (0..broken).step_by(1 << 12) {
            let end = broken.min(start + (1 << 12));
            self.read_frames(start..end, &mut window)?;
            let bytes = &window.bytes[window.inside.clone()];
            self.tally.add(tally(bytes, self.sensor).unwrap_or_default());
        }
        Ok(())
    }

    /// Path of the recording.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The sensor the events are from.
    pub fn sensor(&self) -> SensorSize {
        self.sensor
    }

    /// Number of frames of 1 ms.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Number of events.
    pub fn events(&self) -> u64 {
        self.length / RECORD as u64 - self.frames
    }

    /// Number of ON events.
    pub fn on_events(&self) -> u64 {
        self.tally.on
    }

    /// Reads `frames` into `window`, replacing what it held.
    ///
    /// # Errors
    /// If the file does not have these frames, cannot be read, or has changed since it was opened.
    pub fn read_frames(&self, frames: Range<u64>, window: &mut EvcWindow) -> Result<(), IoError> {
        window.frames = 0..0;
        window.inside = 0..0;
        if frames.start > frames.end || frames.end > self.frames {
            return Err(IoError::NoSuchFrames {
                path: self.path.clone(),
                start: frames.start,
                end: frames.end,
                available: self.frames,
            });
        }
        if frames.is_empty() {
            return Ok(());
        }
        // The index knows every so many frames; the markers in between are searched for in what was
        // read.
        let from = self.indexed_offset(frames.start / INDEX_STEP);
        let last = self.indexed_offset(frames.end / INDEX_STEP);
        let to = self.indexed_offset(frames.end.div_ceil(INDEX_STEP));
        window.bytes.resize((to - from) as usize, 0);
        self.read_at(&mut window.bytes, from)?;
        let tail = (last - from) as usize;
        let start = marker_offset(&window.bytes, frames.start % INDEX_STEP).unwrap_or(tail);
        let end = match frames.end % INDEX_STEP {
            0 => tail,
            rest => marker_offset(&window.bytes[tail..], rest)
                .map_or(window.bytes.len(), |after_tail| tail + after_tail),
        };
        let inside = start..end.max(start);
        match tally(&window.bytes[inside.clone()], self.sensor) {
            // The file may have been written to since it was indexed.
            Ok(tally) if tally.markers == frames.end - frames.start => {}
            _ => return Err(self.fault(from, EvcFault::Changed)),
        }
        window.inside = inside;
        window.frames = frames;
        Ok(())
    }

    /// Reads `frames` as a stream: the events of frame `k` at `k` milliseconds.
    ///
    /// # Errors
    /// As [`EvcReader::read_frames`].
    pub fn read_stream(&self, frames: Range<u64>) -> Result<EventStream, IoError> {
        let mut stream = EventStream::empty(self.sensor);
        if frames == (0..self.frames) {
            stream.reserve(usize::try_from(self.events()).unwrap_or(0));
        }
        self.read_into(frames, &mut EvcWindow::new(), &mut stream)?;
        Ok(stream)
    }

    /// Appends `frames` to `stream`, as [`EvcReader::read_stream`] does, using the memory of
    /// `window`.
    ///
    /// # Errors
    /// As [`EvcReader::read_frames`], and if the stream is later than the frames or of a smaller
    /// sensor.
    pub fn read_into(
        &self,
        frames: Range<u64>,
        window: &mut EvcWindow,
        stream: &mut EventStream,
    ) -> Result<(), IoError> {
        let mut columns = Columns::default();
        // In parts: frames of a whole file need not fit in memory as records.
        let mut start = frames.start;
        loop {
            let end = frames.end.min(start + FRAMES_AT_ONCE);
            self.read_frames(start..end, window)?;
            let mut records = window.records();
            let mut frame = start;
            // The first record of a frame is its marker.
            while let [_, events @ ..] = records {
                let count = events.iter().position(|r| r[3] == NEW_FRAME).unwrap_or(events.len());
                let (events, rest) = events.split_at(count);
                let t = Micros(frame as i64 * FRAME.0);
                columns.t.resize(columns.len() + count, t);
                columns
                    .x
                    .extend(events.iter().map(|&[low, high, ..]| u16::from_le_bytes([low, high])));
                columns.y.extend(events.iter().map(|&[_, _, y, _]| u16::from(y)));
                columns.polarity.extend(events.iter().map(|&[.., p]| Polarity::from_on(p == 1)));
                records = rest;
                frame += 1;
                if columns.len() >= FULL || records.is_empty() {
                    let Columns { t, x, y, polarity } = &columns;
                    stream.extend_columns(t, x, y, polarity).map_err(|fault| IoError::Stream {
                        path: self.path.clone(),
                        reason: fault.to_string(),
                    })?;
                    columns.clear();
                }
            }
            if end >= frames.end {
                return Ok(());
            }
            start = end;
        }
    }

    /// Byte offset of an entry of the index; the end of the frames after the last.
    fn indexed_offset(&self, entry: u64) -> u64 {
        self.index.get(entry as usize).copied().unwrap_or(self.length)
    }

    fn frame_offset(&self, frame: u64) -> Result<u64, IoError> {
        let from = self.indexed_offset(frame / INDEX_STEP);
        let to = self.indexed_offset(frame / INDEX_STEP + 1);
        let mut bytes = vec![0; (to - from) as usize];
        self.read_at(&mut bytes, from)?;
        let at = marker_offset(&bytes, frame % INDEX_STEP);
        Ok(from + at.ok_or_else(|| self.fault(from, EvcFault::Changed))? as u64)
    }

    fn read_at(&self, bytes: &mut [u8], offset: u64) -> Result<(), IoError> {
        self.file.read_exact_at(bytes, offset).map_err(|e| IoError::file(&self.path, "read", e))
    }

    fn fault(&self, byte: u64, fault: EvcFault) -> IoError {
        let (path, frames) = (self.path.clone(), self.frames);
        let events = (self.length / RECORD as u64).saturating_sub(frames);
        IoError::Evc { path, byte, fault, frames, events }
    }
}
