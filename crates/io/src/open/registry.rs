//! The registry of formats.

use std::path::Path;

use evpose_core::{EventStream, SensorSize};

use super::Labels;
use crate::{EventSink, EventSource, Input, IoError, OpenOptions};

/// Opens a file for reading.
pub type Open = fn(Input, &OpenOptions) -> Result<Box<dyn EventSource>, IoError>;

/// Begins a file of events of a sensor.
pub type Create = fn(&Path, SensorSize) -> Result<Box<dyn EventSink>, IoError>;

/// A file format: one module of this crate, one line of [`FORMATS`].
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
    /// Opens a file for reading.
    pub open: Open,
    /// Begins a file of events of a sensor, where the format can be written.
    pub create: Option<Create>,
    /// Labels that lie beside a file, and what is odd about them.
    pub labels: fn(&Path, &dyn EventSource, &mut Vec<String>) -> Option<Labels>,
}

/// Every format, the first whose probe agrees is taken.
pub const FORMATS: &[Format] = &[
    crate::npz::FORMAT,
    crate::evc::FORMAT,
    crate::framed::FORMAT,
    crate::aedat4::FORMAT,
    crate::aedat2::FORMAT,
    crate::hdf5::FORMAT,
    // Lines that begin as those of text.
    crate::yarp::LOG,
    crate::text::FORMAT,
    crate::dat::FORMAT,
    crate::evt::EVT2,
    crate::evt::EVT21,
    crate::evt::EVT3,
    // Without marks of their own, and so behind all others.
    crate::yarp::BINARY,
    crate::nmnist::FORMAT,
];

/// Bytes that probes see.
pub(super) const HEAD: usize = 4096;

impl Format {
    /// Writes a whole recording.
    ///
    /// # Errors
    /// If the format cannot be written or cannot hold the recording, or if writing fails.
    pub fn write(&self, path: impl AsRef<Path>, events: &EventStream) -> Result<(), IoError> {
        let mut sink = self.create(path.as_ref(), events.sensor())?;
        sink.write(events)?;
        sink.finish()
    }

    /// Begins a file of events of a sensor.
    ///
    /// # Errors
    /// If the format cannot be written or has no room for the sensor, or if the file cannot be made.
    pub fn create(&self, path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
        let cannot = || {
            let others = FORMATS.iter().filter(|f| f.create.is_some()).map(|f| f.name);
            let others = others.collect::<Vec<_>>().join(", ");
            IoError::unwritable(path, format!("{} can only be read; write {others}", self.name))
        };
        (self.create.ok_or_else(cannot)?)(path, sensor)
    }
}

/// For formats without labels.
pub(crate) fn no_labels(_: &Path, _: &dyn EventSource, _: &mut Vec<String>) -> Option<Labels> {
    None
}

/// The format called `name`.
pub fn format_called(name: &str) -> Option<&'static Format> {
    FORMATS.iter().find(|format| format.name == name)
}

/// Begins a recording in the format that the name of its file says.
///
/// # Errors
/// As [`format_for`], and if the file cannot be created.
pub fn create(path: impl AsRef<Path>, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    let path = path.as_ref();
    match format_for(path)?.create {
        Some(create) => create(path, sensor),
        None => Err(IoError::unwritable(path, "a format that is only read".to_owned())),
    }
}

/// The format in which to write a file of this name.
///
/// # Errors
/// If names of no format that can be written end like it.
pub fn format_for(path: impl AsRef<Path>) -> Result<&'static Format, IoError> {
    let path = path.as_ref();
    let ending = path.extension().unwrap_or_default();
    let is_its = |format: &&Format| {
        format.create.is_some() && format.endings.iter().any(|end| ending == &end[1..])
    };
    let found = FORMATS.iter().find(is_its);
    found.ok_or_else(|| IoError::UnknownEnding { path: path.to_owned() })
}

/// The format of a file, by its content.
///
/// # Errors
/// If it cannot be read or is of no known format.
pub fn format_of(path: impl AsRef<Path>) -> Result<&'static Format, IoError> {
    let mut input = super::input(path.as_ref())?;
    of_head(&input.head(HEAD)?, &input.path)
}

pub(super) fn of_head(head: &[u8], path: &Path) -> Result<&'static Format, IoError> {
    let found = FORMATS.iter().find(|format| (format.probe)(head));
    found.ok_or_else(|| match crate::aedat4::other_version(head) {
        Some(version) => {
            let reason = format!("AEDAT {version} is not read: DV and jAER make AEDAT 4 of it");
            IoError::Damaged { path: path.to_owned(), byte: 0, reason: reason.into(), events: 0 }
        }
        None => IoError::UnknownFormat { path: path.to_owned() },
    })
}
