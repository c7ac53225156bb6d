//! The registry of formats.

use std::path::Path;

use evpose_core::{EventStream, Registry, SensorSize, registry_entry};

use super::Format;
use super::stranger::describe;
use crate::source::unpacked;
use crate::{EventSink, IoError};

/// Every format, the first whose probe agrees is taken; those of other crates come last.
pub static FORMATS: Registry<Format> = Registry::new(&[
    &crate::npz::FORMAT,
    &crate::npz::NPY,
    &crate::evc::FORMAT,
    &crate::framed::FORMAT,
    &crate::aedat4::FORMAT,
    &crate::aedat2::FORMAT,
    &crate::aedat3::FORMAT,
    &crate::hdf5::FORMAT,
    &crate::es::FORMAT,
    &crate::ros::MCAP,
    &crate::ros::BAG,
    &crate::ros::SQLITE,
    // Lines that begin as those of text.
    &crate::yarp::LOG,
    &crate::text::CSV,
    &crate::text::FORMAT,
    &crate::dat::FORMAT,
    &crate::evt::EVT2,
    &crate::evt::EVT21,
    &crate::evt::EVT3,
    &crate::evt::EVT4,
    // Without marks of their own, and so behind all others.
    &crate::yarp::BINARY,
    &crate::nmnist::FORMAT,
]);

registry_entry!(Format, "format");

/// Bytes at the beginning of a file that probes inspect.
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
    /// If the format cannot be written or has no room for the sensor, or if the file cannot be
    /// made.
    pub fn create(&self, path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
        let cannot = || {
            let others = FORMATS.iter().filter(|f| f.create.is_some()).map(|f| f.name);
            let others = others.collect::<Vec<_>>().join(", ");
            IoError::unwritable(path, format!("{} can only be read; write {others}", self.name))
        };
        (self.create.ok_or_else(cannot)?)(path, sensor)
    }
}

/// Begins a recording in the format that the name of its file says.
///
/// # Errors
/// As [`format_for`], and if the file cannot be created.
pub fn create(path: impl AsRef<Path>, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    format_for(&path)?.create(path.as_ref(), sensor)
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
    FORMATS.iter().copied().find(is_its).ok_or_else(|| {
        let writable = FORMATS.iter().filter(|format| format.create.is_some());
        let known: Vec<&str> = writable.flat_map(|format| format.endings).copied().collect();
        IoError::UnknownEnding { path: path.to_owned(), known: known.join(", ") }
    })
}

/// The format of a file, by its content.
///
/// # Errors
/// If it cannot be read or is of no known format.
pub fn detect_format(path: impl AsRef<Path>) -> Result<&'static Format, IoError> {
    let mut input = unpacked(super::input(path.as_ref())?)?;
    detect(&input.head(HEAD)?, &input.path)
}

/// Returns the first format whose probe accepts the beginning of a file.
pub(super) fn detect(head: &[u8], path: &Path) -> Result<&'static Format, IoError> {
    let detected = FORMATS.iter().copied().find(|format| (format.probe)(head));
    // The commonest file that is not read deserves an answer of its own.
    detected.ok_or_else(|| match (crate::aedat4::other_version(head), describe(head)) {
        (Some(version), _) => {
            let reason = format!("AEDAT {version} is not read: DV and jAER make AEDAT 4 of it");
            IoError::damaged(path, 0, reason)
        }
        (None, Some((what, advice))) => {
            IoError::NoRecording { path: path.to_owned(), what, advice }
        }
        (None, None) => {
            let known = FORMATS.names().join(", ");
            IoError::UnknownFormat { path: path.to_owned(), known }
        }
    })
}
