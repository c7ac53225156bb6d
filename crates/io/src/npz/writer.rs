//! Writes events as a NumPy archive.

use std::io::{self, Write};
use std::path::Path;

use evpose_core::{AtomicFile, EventStream};
use npyz::{AutoSerialize, WriteOptions, WriterBuilder};
use zip::write::{SimpleFileOptions, ZipWriter};

use crate::IoError;

/// Writes `events`, uncompressed as `numpy.savez` does.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, events: &EventStream) -> Result<(), IoError> {
    let failed = |e| IoError::file(path, "write", e);
    let mut file = AtomicFile::create(path).map_err(failed)?;
    write_arrays(&mut file, events).map_err(failed)?;
    file.commit().map_err(failed)
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

fn array<W: Write + io::Seek, T: AutoSerialize>(
    zip: &mut ZipWriter<W>,
    name: &str,
    shape: &[u64],
    values: impl IntoIterator<Item = T>,
) -> io::Result<()> {
    // Sizes are unknown when an entry begins, so each is written as if it passed 4 GiB.
    let options = SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Stored)
        .large_file(true);
    zip.start_file(npyz::npz::file_name_from_array_name(name), options)?;
    let buffered = io::BufWriter::with_capacity(1 << 16, zip);
    let mut npy = WriteOptions::new().default_dtype().shape(shape).writer(buffered).begin_nd()?;
    npy.extend(values)?;
    npy.finish()
}
