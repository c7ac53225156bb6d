//! Reads events out of a NumPy archive, or out of a single array.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use evpose_core::{Event, SensorSize};
use zip::ZipArchive;

use super::array::{self, Array, Column};
use super::events::{Columns, REQUIRED, called};
use super::{ARRAY, NpzFault};
use crate::order::{Ordered, ordered};
use crate::{IoError, Recording, SensorOrigin};

/// One array that holds all events.
const EVENTS: &str = "events";
/// The sensor.
const SIZE: [&str; 2] = ["width", "height"];

/// Reads an archive or an array, with `sensor` where it does not state its own. Events outside the
/// sensor, and single ones out of order, are left out and counted.
///
/// # Errors
/// If the file cannot be read, an array is missing, or an array holds something else than it
/// should.
pub fn read(path: &Path, sensor: Option<SensorSize>) -> Result<Recording, IoError> {
    let mut head = [0; ARRAY.len()];
    let mut file = File::open(path).map_err(|e| IoError::file(path, "open", e))?;
    if file.read_exact(&mut head).is_ok() && head == *ARRAY {
        return recording(of_array(path)?, None, sensor);
    }
    let mut archive = Archive::open(path)?;
    let names = archive.names();
    let is_there = |name: &str| names.iter().any(|found| found == name);
    let of_columns = [0, 1, 2, 3].map(|what| called(what, &names.iter().map(String::as_str)));
    let is_table = is_there(EVENTS) && of_columns.iter().any(Option::is_none);
    let mut missing: Vec<&'static str> = Vec::new();
    if !is_table {
        let absent = REQUIRED.into_iter().zip(of_columns).filter(|(_, name)| name.is_none());
        missing.extend(absent.map(|(required, _)| required));
    }
    // Other programs state no size; half of one is a fault.
    let stated = SIZE.map(is_there);
    if stated[0] != stated[1] {
        missing.push(if stated[0] { SIZE[1] } else { SIZE[0] });
    }
    if !missing.is_empty() {
        return Err(IoError::MissingArrays { path: path.to_owned(), missing, found: names });
    }
    let size = match stated[0] {
        true => Some(SensorSize { width: archive.size("width")?, height: archive.size("height")? }),
        false => None,
    };
    let events = if is_table { archive.table()? } else { archive.columns(of_columns)? };
    recording(events, size, sensor)
}

fn recording(
    events: Vec<Event>,
    stated: Option<SensorSize>,
    given: Option<SensorSize>,
) -> Result<Recording, IoError> {
    let (sensor, sensor_origin) = match (stated, given) {
        (Some(stated), _) => (stated, SensorOrigin::Stated),
        (None, Some(given)) => (given, SensorOrigin::Given),
        (None, None) => (crate::open::smallest(&events), SensorOrigin::Inferred),
    };
    let Ordered { stream, rejected, sorted } = ordered(sensor, events);
    Ok(Recording { format: "npz", stream, rejected, sorted, sensor_origin })
}

/// A file that is one array of events.
fn of_array(path: &Path) -> Result<Vec<Event>, IoError> {
    let file = File::open(path).map_err(|e| IoError::file(path, "open", e))?;
    let fault = |fault, values| IoError::Npz {
        path: path.to_owned(),
        array: EVENTS.to_owned(),
        byte: 0,
        fault,
        values,
    };
    let table = array::read(file).map_err(|(what, values)| fault(what, values))?;
    let columns = Columns::of_table(&table).map_err(|what| fault(what, 0))?;
    columns.events().map_err(|(_, what, values)| fault(what, values))
}

struct Archive<'a> {
    path: &'a Path,
    zip: ZipArchive<BufReader<File>>,
}

impl<'a> Archive<'a> {
    fn open(path: &'a Path) -> Result<Self, IoError> {
        let file = File::open(path).map_err(|e| IoError::file(path, "open", e))?;
        let length = file.metadata().map_err(|e| IoError::file(path, "read", e))?.len();
        let zip = ZipArchive::new(BufReader::new(file)).map_err(|e| IoError::NotAnArchive {
            path: path.to_owned(),
            byte: length,
            reason: e.to_string(),
        })?;
        Ok(Self { path, zip })
    }

    fn names(&self) -> Vec<String> {
        let entries = self.zip.file_names_raw().map(|name| String::from_utf8_lossy(name));
        let mut names: Vec<_> = entries
            .filter_map(|name| npyz::npz::array_name_from_file_name(&name).map(str::to_owned))
            .collect();
        names.sort();
        names
    }

    /// A positive number of pixels.
    fn size(&mut self, name: &str) -> Result<u16, IoError> {
        let (array, byte) = self.array(name)?;
        let value = match array.columns.as_slice() {
            [column] if column.len() == 1 => column.whole(0),
            _ => return Err(self.fault(name, byte, NpzFault::Shape, 0)),
        };
        let pixels = value.and_then(|value| u16::try_from(value).ok()).filter(|n| *n > 0);
        pixels.ok_or_else(|| self.fault(name, byte, NpzFault::Value(value.unwrap_or(0)), 0))
    }

    /// Events whose times, columns, rows and polarities are arrays of these names.
    fn columns(&mut self, names: [Option<&str>; 4]) -> Result<Vec<Event>, IoError> {
        let mut found = Vec::new();
        for name in names.into_iter().flatten() {
            let (array, byte) = self.array(name)?;
            let mut columns = array.columns;
            match (columns.pop(), columns.is_empty()) {
                (Some(column), true) => found.push((name, byte, column)),
                _ => return Err(self.fault(name, byte, NpzFault::Shape, 0)),
            }
        }
        let columns: Vec<&Column> = found.iter().map(|(_, _, column)| column).collect();
        let columns: [&Column; 4] = columns.try_into().map_err(|_| {
            let (path, missing) = (self.path.to_owned(), REQUIRED.to_vec());
            IoError::MissingArrays { path, missing, found: Vec::new() }
        })?;
        Columns(columns).events().map_err(|(what, fault, values)| {
            let (name, byte, _) = &found[what];
            self.fault(name, *byte, fault, values)
        })
    }

    /// Events that are the rows of one array.
    fn table(&mut self) -> Result<Vec<Event>, IoError> {
        let (table, byte) = self.array(EVENTS)?;
        let columns =
            Columns::of_table(&table).map_err(|fault| self.fault(EVENTS, byte, fault, 0))?;
        columns.events().map_err(|(_, fault, values)| self.fault(EVENTS, byte, fault, values))
    }

    /// An array and where its data begin.
    fn array(&mut self, name: &str) -> Result<(Array, u64), IoError> {
        let (byte, array) = {
            match self.zip.by_name(&npyz::npz::file_name_from_array_name(name)) {
                Ok(entry) => (entry.data_start().unwrap_or(0), array::read(entry)),
                Err(e) => (0, Err((NpzFault::Unreadable(e.to_string()), 0))),
            }
        };
        let array = array.map_err(|(fault, read)| self.fault(name, byte, fault, read))?;
        Ok((array, byte))
    }

    fn fault(&self, array: &str, byte: u64, fault: NpzFault, values: usize) -> IoError {
        IoError::Npz { path: self.path.to_owned(), array: array.to_owned(), byte, fault, values }
    }
}
