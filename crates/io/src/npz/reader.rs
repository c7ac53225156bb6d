//! Reads events out of a NumPy archive.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use evpose_core::{Event, EventStreamBuilder, Micros, Polarity, SensorSize};
use zip::ZipArchive;

use super::{ARRAYS, NpzFault, array};
use crate::{IoError, Recording, SensorOrigin};

/// Reads an archive. Events outside the sensor or out of order are left out and counted.
///
/// # Errors
/// If the file cannot be read, an array is missing, or an array holds something else than the
/// integers it should.
pub fn read(path: &Path) -> Result<Recording, IoError> {
    let mut archive = Archive::open(path)?;
    let missing: Vec<_> = ARRAYS.into_iter().filter(|name| !archive.has(name)).collect();
    if !missing.is_empty() {
        let found = archive.names();
        return Err(IoError::MissingArrays { path: path.to_owned(), missing, found });
    }
    let sensor = SensorSize { width: archive.scalar("width")?, height: archive.scalar("height")? };
    // A coordinate that fits no sensor becomes one that lies outside every sensor.
    let coordinate = |value| Some(u16::try_from(value).unwrap_or(u16::MAX));
    let (t, _) = archive.values("t", |value| Some(Micros(value)))?;
    let x = archive.column("x", t.len(), coordinate)?;
    let y = archive.column("y", t.len(), coordinate)?;
    let polarity = archive.column("p", t.len(), |value| match value {
        0 => Some(Polarity::Off),
        1 => Some(Polarity::On),
        _ => None,
    })?;
    let mut builder = EventStreamBuilder::new(sensor);
    for (((t, x), y), polarity) in t.into_iter().zip(x).zip(y).zip(polarity) {
        builder.push(Event { t, x, y, polarity });
    }
    let (stream, rejected) = builder.finish();
    Ok(Recording { format: "npz", stream, rejected, sensor_origin: SensorOrigin::Stated })
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

    fn has(&self, array: &str) -> bool {
        self.zip.index_for_name(&npyz::npz::file_name_from_array_name(array)).is_some()
    }

    fn names(&self) -> Vec<String> {
        let entries = self.zip.file_names_raw().map(|name| String::from_utf8_lossy(name));
        let mut names: Vec<_> = entries
            .filter_map(|name| npyz::npz::array_name_from_file_name(&name).map(str::to_owned))
            .collect();
        names.sort();
        names
    }

    fn scalar(&mut self, name: &'static str) -> Result<u16, IoError> {
        let positive = |value| u16::try_from(value).ok().filter(|&n| n > 0);
        let (values, byte) = self.values(name, positive)?;
        match values[..] {
            [value] => Ok(value),
            _ => Err(self.fault(name, byte, NpzFault::Shape, values.len())),
        }
    }

    /// An array as long as `t`, which has `length` values.
    fn column<T>(
        &mut self,
        name: &'static str,
        length: usize,
        convert: impl Fn(i64) -> Option<T>,
    ) -> Result<Vec<T>, IoError> {
        let (values, byte) = self.values(name, convert)?;
        if values.len() == length {
            return Ok(values);
        }
        let fault = NpzFault::Length { got: values.len(), of: length };
        Err(self.fault(name, byte, fault, values.len().min(length)))
    }

    /// An array and where its data begin.
    fn values<T>(
        &mut self,
        name: &'static str,
        convert: impl Fn(i64) -> Option<T>,
    ) -> Result<(Vec<T>, u64), IoError> {
        let (byte, values) = {
            match self.zip.by_name(&npyz::npz::file_name_from_array_name(name)) {
                Ok(entry) => (entry.data_start().unwrap_or(0), array::read(entry, convert)),
                Err(e) => (0, Err((NpzFault::Unreadable(e.to_string()), 0))),
            }
        };
        let values = values.map_err(|(fault, read)| self.fault(name, byte, fault, read))?;
        Ok((values, byte))
    }

    fn fault(&self, array: &'static str, byte: u64, fault: NpzFault, values: usize) -> IoError {
        IoError::Npz { path: self.path.to_owned(), array, byte, fault, values }
    }
}
