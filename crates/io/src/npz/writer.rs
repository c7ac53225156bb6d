//! Writes events as a NumPy archive.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use evpose_core::{AtomicFile, EventStream, SensorSize};
use npyz::{AutoSerialize, WriteOptions, WriterBuilder};
use zip::write::{SimpleFileOptions, ZipWriter};

use crate::{EventSink, IoError};

/// Gathers all events: an archive holds one column after the other.
struct NpzSink {
    path: PathBuf,
    events: EventStream,
}

/// Begins an archive.
pub(super) fn create(path: &Path, sensor: SensorSize) -> Result<Box<dyn EventSink>, IoError> {
    Ok(Box::new(NpzSink { path: path.to_owned(), events: EventStream::empty(sensor) }))
}

impl EventSink for NpzSink {
    fn write(&mut self, events: &EventStream) -> Result<(), IoError> {
        let (t, x, y, polarity) = (events.t(), events.x(), events.y(), events.polarity());
        let taken = self.events.extend_columns(t, x, y, polarity);
        taken.map_err(|fault| IoError::unwritable(&self.path, fault.to_string()))
    }

    fn finish(self: Box<Self>) -> Result<(), IoError> {
        let failed = |e| IoError::file(&self.path, "write", e);
        let mut file = AtomicFile::create(&self.path).map_err(failed)?;
        write_arrays(&mut file, &self.events).map_err(failed)?;
        file.commit().map_err(failed)
    }
}

fn write_arrays(file: &mut AtomicFile, events: &EventStream) -> io::Result<()> {
    let mut zip = ZipWriter::new_stream(file);
    let length = &[events.len() as u64];
    array(&mut zip, "t", length, events.t().iter().map(|t| t.0))?;
    array(&mut zip, "x", length, events.x().iter().copied())?;
    array(&mut zip, "y", length, events.y().iter().copied())?;
    array(&mut zip, "p", length, events.polarity().iter().map(|&p| p as u8))?;
    array(&mut zip, "width", &[], [i64::from(events.sensor().width)])?;
    array(&mut zip, "height", &[], [i64::from(events.sensor().height)])?;
    zip.finish()?.flush()
}

/// Begins an array of an archive, uncompressed as `numpy.savez` writes it.
pub(crate) fn start_array<W: Write + io::Seek>(
    zip: &mut ZipWriter<W>,
    name: &str,
) -> io::Result<()> {
    // Sizes are unknown when an entry begins, so each is written as if it passed 4 GiB.
    let options = SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Stored)
        .large_file(true);
    Ok(zip.start_file(npyz::npz::file_name_from_array_name(name), options)?)
}

fn array<W: Write + io::Seek, T: AutoSerialize>(
    zip: &mut ZipWriter<W>,
    name: &str,
    shape: &[u64],
    values: impl IntoIterator<Item = T>,
) -> io::Result<()> {
    start_array(zip, name)?;
    let buffered = io::BufWriter::with_capacity(1 << 16, zip);
    let mut npy = WriteOptions::new().default_dtype().shape(shape).writer(buffered).begin_nd()?;
    npy.extend(values)?;
    npy.finish()
}
