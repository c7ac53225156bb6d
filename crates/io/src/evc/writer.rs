//! Writes `.evc` files frame by frame.

use std::io::Write;
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, Micros, Polarity, SensorSize};

use super::{FRAME, MARKER, encode};
use crate::IoError;

/// Ten days of frames. Later events are more likely to count from 1970 than from the start of the
/// recording, and would fill the disk with empty frames.
const MAX_FRAMES: i64 = 10 * 24 * 3_600_000;

/// Writes an `.evc` file, which appears under its name on [`EvcWriter::finish`].
#[derive(Debug)]
pub struct EvcWriter {
    path: PathBuf,
    file: AtomicFile,
    sensor: SensorSize,
    frames: u64,
    events: u64,
    /// The events of one frame as they came, and their bytes.
    frame: Vec<(u16, u8, Polarity)>,
    rows: Vec<(u16, u8, Polarity)>,
    bytes: Vec<u8>,
}

impl EvcWriter {
    /// Starts a file of events from `sensor`.
    ///
    /// # Errors
    /// If the file cannot be created or the sensor has more than 256 rows.
    pub fn create(path: impl AsRef<Path>, sensor: SensorSize) -> Result<Self, IoError> {
        let path = path.as_ref().to_owned();
        // A record holds its row in one byte.
        if sensor.height > 256 {
            return Err(IoError::SensorTooTall { path, sensor });
        }
        let file = AtomicFile::create(&path).map_err(|e| IoError::file(&path, "create", e))?;
        Ok(Self {
            path,
            file,
            sensor,
            frames: 0,
            events: 0,
            frame: Vec::new(),
            rows: Vec::new(),
            bytes: Vec::new(),
        })
    }

    /// Appends a frame that holds all of `events`, whatever their times.
    ///
    /// # Errors
    /// If an event lies outside the sensor of this file, or the disk is full.
    pub fn frame(&mut self, events: &EventStream) -> Result<(), IoError> {
        let columns = events.x().iter().zip(events.y()).zip(events.polarity());
        self.frame_of(columns.map(|((&x, &y), &polarity)| (x, y, polarity)))
    }

    /// Appends a frame of (column, row, polarity) in any order; they are written in the published
    /// one.
    ///
    /// # Errors
    /// As [`EvcWriter::frame`].
    pub fn frame_of(
        &mut self,
        events: impl IntoIterator<Item = (u16, u16, Polarity)>,
    ) -> Result<(), IoError> {
        self.frame.clear();
        for (x, y, polarity) in events {
            match u8::try_from(y) {
                // Rows are a byte in this format.
                Ok(row) if self.sensor.contains(x, y) => self.frame.push((x, row, polarity)),
                _ => {
                    let (frame, sensor) = (self.frames, self.sensor);
                    let reason = format!(
                        "frame {frame}: event at ({x}, {y}) is outside the {sensor} sensor"
                    );
                    return Err(IoError::unwritable(&self.path, reason));
                }
            }
        }
        self.sort();
        self.bytes.clear();
        self.bytes.extend_from_slice(&MARKER);
        self.bytes.extend(self.rows.iter().flat_map(|&(x, y, polarity)| encode(x, y, polarity)));
        self.file.write_all(&self.bytes).map_err(|e| IoError::file(&self.path, "write", e))?;
        self.frames += 1;
        self.events += self.frame.len() as u64;
        Ok(())
    }

    /// Puts the frame in the published order, bottom row first and from left to right, into `rows`.
    /// Events of one pixel keep the order they came in.
    fn sort(&mut self) {
        // Where each row begins: few events come out of order within one.
        let mut starts = [0; 257];
        for &(_, y, _) in &self.frame {
            starts[256 - usize::from(y)] += 1;
        }
        // Turned into the places at which rows begin.
        let mut start = 0;
        for begin in &mut starts {
            start += *begin;
            *begin = start;
        }
        self.rows.clear();
        // Every place is written to below.
        self.rows.resize(self.frame.len(), (0, 0, Polarity::Off));
        for &event in &self.frame {
            let place = &mut starts[255 - usize::from(event.1)];
            self.rows[*place] = event;
            *place += 1;
        }
        for row in self.rows.chunk_by_mut(|a, b| a.1 == b.1) {
            if !row.is_sorted_by_key(|event| event.0) {
                row.sort_by_key(|event| event.0);
            }
        }
    }

    /// Appends a recording whose time starts at `origin`: an event at `origin + t` goes to the
    /// frame `t / 1 ms` after those written so far. Frames without events are written too.
    ///
    /// # Errors
    /// If an event is earlier than `origin` or more than ten days later, lies outside the sensor,
    /// or the disk is full.
    pub fn stream(&mut self, events: &EventStream, origin: Micros) -> Result<(), IoError> {
        self.check_times(events, origin)?;
        let columns = events.x().iter().zip(events.y()).zip(events.polarity());
        let mut rest = events.t().iter().zip(columns).peekable();
        let mut frame = 0;
        while rest.peek().is_some() {
            let inside =
                std::iter::from_fn(|| rest.next_if(|&(&t, _)| frame_of(t, origin) <= frame));
            self.frame_of(inside.map(|(_, ((&x, &y), &polarity))| (x, y, polarity)))?;
            frame += 1;
        }
        Ok(())
    }

    /// Whether a recording whose time starts at `origin` fits.
    pub(super) fn check_times(&self, events: &EventStream, origin: Micros) -> Result<(), IoError> {
        if let (Some(&first), Some(&last)) = (events.t().first(), events.t().last())
            && (first < origin || frame_of(last, origin) > MAX_FRAMES)
        {
            return Err(self.cannot(format!(
                "events at {first} to {last} do not start at {origin}, or last for days"
            )));
        }
        Ok(())
    }

    pub(super) fn cannot(&self, reason: String) -> IoError {
        IoError::unwritable(&self.path, reason)
    }

    /// The sensor of the file.
    pub fn sensor(&self) -> SensorSize {
        self.sensor
    }

    /// Frames written so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Events written so far.
    pub fn events(&self) -> u64 {
        self.events
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// If no frame was written, or the disk is full.
    pub fn finish(self) -> Result<(), IoError> {
        if self.frames == 0 {
            return Err(IoError::unwritable(&self.path, "an .evc file has at least one frame"));
        }
        self.file.commit().map_err(|e| IoError::file(&self.path, "finish", e))
    }
}

/// The frame of a time, where `origin` begins frame 0.
fn frame_of(t: Micros, origin: Micros) -> i64 {
    t.0.saturating_sub(origin.0).div_euclid(FRAME.0)
}
