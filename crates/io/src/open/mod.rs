//! Files opened by their content.

mod beside;
mod extent;
mod format;
mod info;
mod outside;
mod registry;
mod sensor;
mod stranger;
mod whole;
mod windows;

use std::path::{Path, PathBuf};

use evpose_core::{EventStream, SensorSize};

pub use beside::{recordings_by_stem, writable_format};
pub(crate) use extent::believed;
pub(crate) use format::no_labels;
pub use format::{Create, Format, Labels, Open};
pub use info::{Info, info};
pub use outside::OutsideCount;
pub use registry::{FORMATS, create, detect_format, format_for};
pub use sensor::find_sensor;
pub use windows::Windows;

use crate::npz::EVIMO;
use crate::source::{OrderedSource, unpacked};
use crate::{ColumnNames, EventSource, Input, IoError, OpenOptions};

/// Formats whose units and columns may be stated.
const OF_COLUMNS: [&str; 5] = ["text", "csv", "npz", "npy", "hdf5"];

/// A whole recording in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Name of the format it was read from.
    pub format: &'static str,
    /// The events.
    pub stream: EventStream,
    /// Count of events outside the sensor, which were left out.
    pub outside: usize,
    /// Origin of the size of the sensor.
    pub sensor_origin: SensorOrigin,
    /// Remarks on the content, in sentences without a full stop.
    pub remarks: Vec<String>,
}

/// Origin of the size of a sensor.
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

/// Reads a whole recording of any format.
///
/// # Errors
/// If the file cannot be read, is of no known format, or breaks its format.
pub fn open(path: impl AsRef<Path>) -> Result<Recording, IoError> {
    open_as(path, &OpenOptions::default())
}

/// As [`open`], with the size of the sensor for files that do not state it.
///
/// # Errors
/// As [`open`].
pub fn open_with(path: impl AsRef<Path>, sensor: Option<SensorSize>) -> Result<Recording, IoError> {
    open_as(path, &OpenOptions { sensor, ..OpenOptions::default() })
}

/// As [`open`], with options for files that leave a choice.
///
/// # Errors
/// As [`open`].
pub fn open_as(path: impl AsRef<Path>, options: &OpenOptions) -> Result<Recording, IoError> {
    read_as(input(path.as_ref())?, options)
}

/// As [`open_as`], from a file that is open already, or from memory.
///
/// # Errors
/// As [`open`].
pub fn read_as(input: Input, options: &OpenOptions) -> Result<Recording, IoError> {
    let path = input.path.clone();
    let (format, mut source) = source(input, options)?;
    whole::read(&path, format.name, source.as_mut(), options)
}

/// Opens a file of any format as a source of events.
///
/// # Errors
/// If it cannot be read, is of no known format, or its beginning breaks its format.
pub fn source(
    input: Input,
    options: &OpenOptions,
) -> Result<(&'static Format, Box<dyn EventSource>), IoError> {
    let path = input.path.clone();
    let (format, source) = unordered(input, options)?;
    // A unit that the format itself states would be overruled in silence.
    let is_stated = options.time_unit.is_some() || options.columns != ColumnNames::default();
    if is_stated && !OF_COLUMNS.contains(&format.name) {
        let name = format.name;
        let reason =
            format!("{name} states units and columns: --time-unit and --columns are for tables");
        return Err(IoError::Stream { path, reason });
    }
    if options.topic.is_some() && !crate::ros::NAMES.contains(&format.name) {
        let reason = format!("{} has no topics: --topic is for recordings of ROS", format.name);
        return Err(IoError::Stream { path, reason });
    }
    for sensor in source.header().sensor.iter().chain(&options.sensor) {
        believed(&path, *sensor)?;
    }
    Ok((format, OrderedSource::open(source, path, options)?))
}

/// As [`source()`], with events in the order of the file.
pub(crate) fn unordered(
    input: Input,
    options: &OpenOptions,
) -> Result<(&'static Format, Box<dyn EventSource>), IoError> {
    let mut input = unpacked(input)?;
    let head = input.head(registry::HEAD)?;
    let format = registry::detect(&head, &input.path)?;
    let source = (format.open)(input, options)?;
    Ok((format, source))
}

/// Opens a file, the log in a folder of YARP's, the arrays in one of EVIMO2's, or the first file of a bag
/// that is a folder.
///
/// # Errors
/// If it is not there, or is no regular file.
pub fn input(path: &Path) -> Result<Input, IoError> {
    if crate::ros::folder::is_bag(path) {
        return crate::ros::folder::first(path);
    }
    let arrays = format!("{}.npy", EVIMO[0]);
    let in_folder = ["data.log", "binaryevents.log", &arrays].map(|name| path.join(name));
    let inside: Option<&PathBuf> = in_folder.iter().find(|file| file.is_file());
    Input::file(inside.map_or(path, PathBuf::as_path))
}

#[cfg(test)]
mod tests;
