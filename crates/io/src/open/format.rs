//! Entries of the registry of formats.

use std::path::{Path, PathBuf};

use evpose_core::SensorSize;

use crate::{EventSink, EventSource, Input, IoError, OpenOptions};

/// Opens a file for reading.
pub type Open = fn(Input, &OpenOptions) -> Result<Box<dyn EventSource>, IoError>;

/// Begins a file of events of a sensor.
pub type Create = fn(&Path, SensorSize) -> Result<Box<dyn EventSink>, IoError>;

/// A file format: one module of this crate, one line of [`FORMATS`](crate::FORMATS).
#[derive(Debug, Clone, Copy)]
pub struct Format {
    /// Name on the command line and in reports.
    pub name: &'static str,
    /// Description in a line.
    pub summary: &'static str,
    /// Extensions of its files, the usual one first. Only writers go by them.
    pub endings: &'static [&'static str],
    /// Whether a file that begins with these bytes is of this format.
    pub probe: fn(&[u8]) -> bool,
    /// Opens a file for reading.
    pub open: Open,
    /// Begins a file of events of a sensor, where the format can be written.
    pub create: Option<Create>,
    /// Looks for labels beside a file, and appends warnings about them.
    pub labels: fn(&Path, &dyn EventSource, &mut Vec<String>) -> Option<Labels>,
}

/// A file of labels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Labels {
    /// Path of the label file.
    pub path: PathBuf,
    /// Count of records.
    pub records: u64,
    /// Values in a record.
    pub values: usize,
}

/// For formats without labels.
pub(crate) fn no_labels(_: &Path, _: &dyn EventSource, _: &mut Vec<String>) -> Option<Labels> {
    None
}
