//! Writes a recording line by line.

use std::io::Write;
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, Event, EventStream, SensorSize};

use super::digits::{REACH, put};
use crate::{EventSink, IoError};

/// Bytes that are gathered before they are written.
const GATHERED: usize = 1 << 16;
/// Longer than any line: a sign, 19 digits, twice 5 digits, a polarity, and what separates them.
const LINE: usize = 35 + REACH;

struct TextSink {
    path: PathBuf,
    file: AtomicFile,
    lines: Vec<u8>,
    /// Bytes of `lines` that are to be written.
    filled: usize,
    separator: u8,
}

/// Begins a file of `width height` and then `t x y p` lines, times in whole microseconds.
pub(super) fn create(path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    begin(path, &format!("{} {}\n", sensor.width, sensor.height), b' ')
}

/// Begins a table of `t,x,y,p` lines below their names, times in whole microseconds. It has no place
/// for the size of the sensor.
pub(super) fn create_csv(path: &Path, _: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    begin(path, "t,x,y,p\n", b',')
}

fn begin(path: &Path, first: &str, separator: u8) -> Result<Box<dyn EventSink>, IoError> {
    let file = AtomicFile::create(path).map_err(|e| IoError::file(path, "create", e))?;
    let mut lines = vec![0; GATHERED];
    lines[..first.len()].copy_from_slice(first.as_bytes());
    Ok(Box::new(TextSink { path: path.to_owned(), file, lines, filled: first.len(), separator }))
}

impl EventSink for TextSink {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        for event in events.iter() {
            // A line is only begun where the longest one fits.
            if self.lines.len() - self.filled < LINE {
                self.pass_on()?;
            }
            self.filled += line(&mut self.lines[self.filled..], event, self.separator);
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<(), IoError> {
        self.pass_on()?;
        self.file.commit().map_err(|e| IoError::file(&self.path, "write", e))
    }
}

impl TextSink {
    fn pass_on(&mut self) -> Result<(), IoError> {
        let written = self.file.write_all(&self.lines[..self.filled]);
        self.filled = 0;
        written.map_err(|e| IoError::file(&self.path, "write", e))
    }
}

/// Writes a line at the beginning of `room`; returns its length.
#[inline(always)]
fn line(room: &mut [u8], event: Event, separator: u8) -> usize {
    let room = &mut room[..LINE];
    // Written always, and written over by the digits of a time that is not negative.
    room[0] = b'-';
    let mut at = put(room, usize::from(event.t.0 < 0), event.t.0.unsigned_abs());
    for number in [event.x, event.y] {
        room[at] = separator;
        at = put(room, at + 1, number.into());
    }
    let end = [separator, b'0' + event.polarity as u8, b'\n'];
    room[at..at + 3].copy_from_slice(&end);
    at + 3
}
