//! The registry of formats, and files opened by what is in them.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use evpose_core::{Event, EventStream, Rejected, SensorSize};

use crate::{Info, IoError};

/// A whole recording in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Name of the format it was read from.
    pub format: &'static str,
    /// The events.
    pub stream: EventStream,
    /// Events of the file that broke a rule and were left out.
    pub rejected: Rejected,
    /// Events that stood behind later ones and were put where they belong.
    pub sorted: usize,
    /// How the size of the sensor is known.
    pub sensor_origin: SensorOrigin,
}

/// How the size of a sensor is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorOrigin {
    /// The file states it.
    Stated,
    /// The caller gave it.
    Given,
    /// The format's usual sensor.
    Assumed,
    /// The smallest that holds every event.
    Inferred,
}

/// A file format: one file of this crate, one line of [`FORMATS`].
#[derive(Debug, Clone, Copy)]
pub struct Format {
    /// Name on the command line and in reports.
    pub name: &'static str,
    /// What it is, in a line.
    pub summary: &'static str,
    /// How names of its files end, the usual one first. Only writers go by it.
    pub endings: &'static [&'static str],
    /// Whether a file that begins with these bytes is of this format.
    pub probe: fn(&[u8]) -> bool,
    /// Reads a whole file, from the given sensor where the file does not state one.
    pub read: fn(&Path, Option<SensorSize>) -> Result<Recording, IoError>,
    /// Writes a whole recording.
    pub write: fn(&Path, &EventStream) -> Result<(), IoError>,
    /// Describes a file.
    pub info: fn(&Path, Option<SensorSize>) -> Result<Info, IoError>,
}

/// Every format, the first whose probe agrees is taken.
pub const FORMATS: &[Format] = &[crate::npz::FORMAT, crate::evc::FORMAT, crate::text::FORMAT];

/// The format called `name`.
pub fn format_called(name: &str) -> Option<&'static Format> {
    FORMATS.iter().find(|format| format.name == name)
}

/// The format in which to write a file of this name.
///
/// # Errors
/// If names of no format end like it.
pub fn format_for(path: impl AsRef<Path>) -> Result<&'static Format, IoError> {
    let path = path.as_ref();
    let ending = path.extension().unwrap_or_default();
    let found = FORMATS.iter().find(|format| format.endings.iter().any(|end| ending == &end[1..]));
    found.ok_or_else(|| IoError::UnknownEnding { path: path.to_owned() })
}

/// The format of a file, by its content.
///
/// # Errors
/// If it cannot be read or is of no known format.
pub fn format_of(path: impl AsRef<Path>) -> Result<&'static Format, IoError> {
    let path = path.as_ref();
    let mut head = Vec::new();
    File::open(path)
        .and_then(|file| file.take(4096).read_to_end(&mut head))
        .map_err(|e| IoError::file(path, "open", e))?;
    let found = FORMATS.iter().find(|format| (format.probe)(&head));
    found.ok_or_else(|| IoError::UnknownFormat { path: path.to_owned() })
}

/// Reads a whole recording of any format.
///
/// # Errors
/// If the file cannot be read, is of no known format, or breaks its format.
pub fn open(path: impl AsRef<Path>) -> Result<Recording, IoError> {
    open_with(path, None)
}

/// As [`open`], with the size of the sensor for files that do not state it.
///
/// # Errors
/// As [`open`].
pub fn open_with(path: impl AsRef<Path>, sensor: Option<SensorSize>) -> Result<Recording, IoError> {
    let path = path.as_ref();
    (format_of(path)?.read)(path, sensor)
}

/// Describes a recording of any format.
///
/// # Errors
/// As [`open`].
pub fn info(path: impl AsRef<Path>, sensor: Option<SensorSize>) -> Result<Info, IoError> {
    let path = path.as_ref();
    (format_of(path)?.info)(path, sensor)
}

/// The smallest sensor that holds all events which fit any.
pub(crate) fn smallest(events: &[Event]) -> SensorSize {
    let inside = || events.iter().filter(|e| e.x < u16::MAX && e.y < u16::MAX);
    let width = inside().map(|e| e.x + 1).max().unwrap_or(1);
    let height = inside().map(|e| e.y + 1).max().unwrap_or(1);
    SensorSize { width, height }
}

#[cfg(test)]
mod tests;
