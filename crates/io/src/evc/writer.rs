//! Writes `.evc` files frame by frame.

use std::cmp::Reverse;
use std::io::Write;
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, Micros, Polarity, SensorSize};

use super::{FRAME, MARKER, encode};
use crate::IoError;

/// Ten days of frames. Later events are more likely to count from 1970 than from the start of the
/// recording, and would fill the disk with empty frames.
const MOST_FRAMES: i64 = 10 * 24 * 3_600_000;

/// Writes an `.evc` file, which appears under its name on [`EvcWriter::finish`].
#[derive(Debug)]
pub struct EvcWriter {
    path: PathBuf,
    file: AtomicFile,
    sensor: SensorSize,
    frames: u64,
    events: u64,
    /// The events of one frame while they are sorted.
    frame: Vec<(u16, u8, Polarity)>,
}

impl EvcWriter {
    /// Starts a file of events from `sensor`.
    ///
    /// # Errors
    /// If the file cannot be created or the sensor has more than 256 rows.
    pub fn create(path: impl AsRef<Path>, sensor: SensorSize) -> Result<Self, IoError> {
        let path = path.as_ref().to_owned();
        if sensor.height > 256 {
            return Err(IoError::SensorTooTall { path, sensor });
        }
        let file = AtomicFile::create(&path).map_err(|e| IoError::file(&path, "create", e))?;
        Ok(Self { path, file, sensor, frames: 0, events: 0, frame: Vec::new() })
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
        // Stable, so that events of one pixel keep the order they came in.
        self.frame.sort_by_key(|&(x, y, _)| (Reverse(y), x));
        let mut write = |bytes: &[u8]| {
            self.file.write_all(bytes).map_err(|e| IoError::file(&self.path, "write", e))
        };
        write(&MARKER)?;
        for &(x, y, polarity) in &self.frame {
            write(&encode(x, y, polarity))?;
        }
        self.frames += 1;
        self.events += self.frame.len() as u64;
        Ok(())
    }

    /// Appends a recording whose time starts at `origin`: an event at `origin + t` goes to the
    /// frame `t / 1 ms` after those written so far. Frames without events are written too.
    ///
    /// # Errors
    /// If an event is earlier than `origin` or more than ten days later, lies outside the sensor, or
    /// the disk is full.
    pub fn stream(&mut self, events: &EventStream, origin: Micros) -> Result<(), IoError> {
        let frame_of = |t: Micros| t.0.saturating_sub(origin.0).div_euclid(FRAME.0);
        if let (Some(&first), Some(&last)) = (events.t().first(), events.t().last())
            && (first < origin || frame_of(last) > MOST_FRAMES)
        {
            let reason =
                format!("events at {first} to {last} do not start at {origin}, or last for days");
            return Err(IoError::unwritable(&self.path, reason));
        }
        let columns = events.x().iter().zip(events.y()).zip(events.polarity());
        let mut rest = events.t().iter().zip(columns).peekable();
        let mut frame = 0;
        while rest.peek().is_some() {
            let inside = std::iter::from_fn(|| rest.next_if(|&(&t, _)| frame_of(t) <= frame));
            self.frame_of(inside.map(|(_, ((&x, &y), &polarity))| (x, y, polarity)))?;
            frame += 1;
        }
        Ok(())
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
