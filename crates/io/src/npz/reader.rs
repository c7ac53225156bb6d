//! Events out of a NumPy archive, or out of a single array.

use std::io::BufReader;
use std::path::{Path, PathBuf};

use evpose_core::SensorSize;
use zip::ZipArchive;

use super::NpzFault;
use super::array::{self, Array, Room};
use super::column::Column;
use super::events::{Named, REQUIRED, Read};
use crate::names::{Places, places};
use crate::source::CUT;
use crate::{Columns, EventSource, Header, Input, IoError, MemorySource, OpenOptions, ReadSeek};

/// The arrays of EVIMO2's second version: times, columns beside rows, and polarities, in one archive
/// or as files of these names beside each other.
pub(crate) const EVIMO: [&str; 3] = ["dataset_events_t", "dataset_events_xy", "dataset_events_p"];
/// One array that holds all events.
const EVENTS: &str = "events";
/// The sensor.
const SIZE: [&str; 2] = ["width", "height"];

/// Reads an archive.
///
/// # Errors
/// If the file cannot be read, an array is missing, or an array holds something else than it
/// should.
pub(super) fn open(input: Input, options: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let mut archive = Archive::open(input)?;
    let names = archive.names();
    let is_there = |name: &str| names.iter().any(|found| found == name);
    let of_columns = places(&names.iter().map(String::as_str), &options.columns);
    // Arrays of columns come first; a table is for archives without them.
    let table = table(&names).filter(|_| of_columns.is_err());
    if EVIMO.iter().all(|name| is_there(name)) {
        let arrays = EVIMO.map(|name| archive.array(name).map(|(array, _)| array));
        return of_evimo(&archive.path, arrays, options);
    }
    let mut missing: Vec<&'static str> = Vec::new();
    if let (None, Err(absent)) = (table, &of_columns) {
        missing.extend(absent.iter().map(|what| REQUIRED[*what]));
    }
    // Other programs state no size; half of one is a fault.
    let stated = SIZE.map(is_there);
    if stated[0] != stated[1] {
        missing.push(if stated[0] { SIZE[1] } else { SIZE[0] });
    }
    if !missing.is_empty() {
        return Err(IoError::MissingArrays { path: archive.path, missing, present: names });
    }
    let sensor = match stated[0] {
        true => Some(SensorSize { width: archive.size("width")?, height: archive.size("height")? }),
        false => None,
    };
    let (columns, remark) = match (table, of_columns) {
        (None, Ok(found)) => archive.columns(&names, found, options)?,
        (Some(name), _) => {
            let (table, byte) = archive.array(name)?;
            of_table(table, options, |found| fault(&archive.path, name, byte, found))?
        }
        (None, Err(_)) => (Columns::new(), None),
    };
    let header = Header { sensor, ..Header::default() };
    Ok(Box::new(MemorySource::new(header, columns, remark.into_iter().collect())))
}

/// Reads a file that is one array.
///
/// # Errors
/// If the file cannot be read, or the array holds something else than events.
pub(super) fn open_array(
    input: Input,
    options: &OpenOptions,
) -> Result<Box<dyn EventSource>, IoError> {
    let stem = input.path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    if let Some(which) = stem.and_then(|stem| EVIMO.iter().position(|name| *name == stem)) {
        let path = input.path.clone();
        let mut given = Some(input);
        // The given file is open already; the other two lie beside it.
        let arrays = [0, 1, 2].map(|k| {
            let beside = path.with_file_name(format!("{}.npy", EVIMO[k]));
            let given = given.take_if(|_| k == which);
            let input = given.map_or_else(|| Input::file(&beside), Ok)?;
            let mut room = Room::of_file(input.length);
            array::read(input.bytes, &mut room).map_err(|found| fault(&beside, EVIMO[k], 0, found))
        });
        return of_evimo(&path, arrays, options);
    }
    let Input { path, bytes, length } = input;
    let of_events = |found| fault(&path, EVENTS, 0, found);
    let mut room = Room::of_file(length);
    let table = array::read(bytes, &mut room).map_err(of_events)?;
    let (columns, remark) = of_table(table, options, of_events)?;
    Ok(Box::new(MemorySource::new(Header::default(), columns, remark.into_iter().collect())))
}

/// Events of which two arrays are columns and one has column and row.
fn of_evimo(
    path: &Path,
    arrays: [Result<Array, IoError>; 3],
    options: &OpenOptions,
) -> Result<Box<dyn EventSource>, IoError> {
    let [t, xy, p] = arrays;
    let columns: Vec<Column> =
        [t?.columns, xy?.columns, p?.columns].into_iter().flatten().collect();
    let of_array = |(what, found, values): (usize, _, _)| {
        fault(path, EVIMO[[0, 1, 1, 2][what]], 0, (found, values))
    };
    let columns = columns.try_into().map_err(|_| of_array((1, NpzFault::Shape, 0)))?;
    let named = Named { columns, unit: options.time_unit };
    let (columns, remark) = named.events().map_err(of_array)?;
    // Of the Samsung DVS, the Prophesee and the DAVIS346 of the rig, nothing says which.
    Ok(Box::new(MemorySource::new(Header::default(), columns, remark.into_iter().collect())))
}

/// The name of the array that holds all events: the usual one, or that of the only array beside the
/// size of the sensor.
fn table(names: &[String]) -> Option<&str> {
    let mut arrays = names.iter().map(String::as_str).filter(|name| !SIZE.contains(name));
    match (names.iter().any(|name| name == EVENTS), arrays.next(), arrays.next()) {
        (true, ..) => Some(EVENTS),
        (false, only, None) => only,
        _ => None,
    }
}

/// Events that are the rows of one array.
fn of_table(
    table: Array,
    options: &OpenOptions,
    fault: impl Fn((NpzFault, usize)) -> IoError,
) -> Result<Read, IoError> {
    let columns = Named::of_table(table, options).map_err(|found| fault((found, 0)))?;
    columns.events().map_err(|(_, found, values)| fault((found, values)))
}

/// The error of an array whose data begin at `byte`: damage where these cannot be unpacked or end early.
fn fault(path: &Path, array: &str, byte: u64, (fault, values): (NpzFault, usize)) -> IoError {
    match fault {
        NpzFault::Unreadable(reason) => {
            let reason = format!("array `{array}`, {values} values from there: {reason}");
            IoError::damaged(path, byte, reason)
        }
        fault => {
            let (path, array) = (path.to_owned(), array.to_owned());
            IoError::Npz { path, array, byte, fault, values }
        }
    }
}

struct Archive {
    path: PathBuf,
    /// Bytes of the file.
    length: u64,
    room: Room,
    zip: ZipArchive<BufReader<Box<dyn ReadSeek>>>,
}

impl Archive {
    fn open(input: Input) -> Result<Self, IoError> {
        let Input { path, length, bytes } = input;
        // The directory of an archive is at its end.
        let damaged = |e| IoError::damaged(&path, length, format!("zip: {e}: {CUT}"));
        let zip = ZipArchive::new(BufReader::new(bytes)).map_err(damaged)?;
        Ok(Self { path, length, room: Room::of_file(length), zip })
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
    fn columns(
        &mut self,
        names: &[String],
        Places { places, unit }: Places,
        options: &OpenOptions,
    ) -> Result<Read, IoError> {
        let names = places.map(|place| names[place].as_str());
        let mut byte = [0; 4];
        let mut columns = [const { Column::Bytes(Vec::new()) }; 4];
        for (what, name) in names.into_iter().enumerate() {
            let (array, begin) = self.array(name)?;
            byte[what] = begin;
            let mut found = array.columns;
            // An array of several columns cannot be one of the four.
            columns[what] = match (found.pop(), found.is_empty()) {
                (Some(column), true) => column,
                _ => return Err(self.fault(name, begin, NpzFault::Shape, 0)),
            };
        }
        Named { columns, unit: options.time_unit.or(unit) }
            .events()
            .map_err(|(what, fault, values)| self.fault(names[what], byte[what], fault, values))
    }

    /// An array and where its data begin.
    fn array(&mut self, name: &str) -> Result<(Array, u64), IoError> {
        let (byte, array) = {
            match self.zip.by_name(&npyz::npz::file_name_from_array_name(name)) {
                // A broken list may name a place that no file of this length has.
                Ok(entry) => {
                    let byte = entry.data_start().unwrap_or(0).min(self.length);
                    (byte, array::read(entry, &mut self.room))
                }
                Err(e) => (0, Err((NpzFault::Unreadable(e.to_string()), 0))),
            }
        };
        let array = array.map_err(|found| fault(&self.path, name, byte, found))?;
        Ok((array, byte))
    }

    fn fault(&self, array: &str, byte: u64, cause: NpzFault, values: usize) -> IoError {
        fault(&self.path, array, byte, (cause, values))
    }
}
