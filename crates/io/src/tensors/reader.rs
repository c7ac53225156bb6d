//! Reads stacks.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use evpose_core::Micros;
use npyz::Order;
use zip::ZipArchive;
use zip::result::ZipError;

use super::{FRAMES, TIMES, VALUE_TYPE};
use crate::IoError;
use crate::npz::{NpzFault, header};

/// Bytes that are read at a time: memory grows with what is there, not with what a header claims.
const PIECE: u64 = 1 << 16;

/// A stack, or one window, in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct TensorStack {
    /// Windows, channels, rows and columns; without windows in a file of one.
    pub shape: Vec<u64>,
    /// All values, in C order.
    pub values: Vec<f32>,
    /// The ends of the windows, of archives.
    pub ends: Option<Vec<Micros>>,
}

impl TensorStack {
    /// Reads a `.npy` file, or an archive of `frames` and `t_us`.
    ///
    /// # Errors
    /// If the file cannot be read, is cut, or holds something else.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, IoError> {
        let path = path.as_ref();
        let file = File::open(path).map_err(|e| IoError::file(path, "open", e))?;
        let fault = |array: &str, (fault, values)| IoError::Npz {
            path: path.to_owned(),
            array: array.to_owned(),
            byte: 0,
            fault,
            values,
        };
        let mut zip = match ZipArchive::new(BufReader::new(file)) {
            Ok(zip) => zip,
            Err(ZipError::Io(error)) => return Err(IoError::file(path, "read", error)),
            // No archive: an array, read from the start of the file.
            Err(_) => {
                let file = File::open(path).map_err(|e| IoError::file(path, "open", e))?;
                let (shape, values) = array(BufReader::new(file), VALUE_TYPE, f32::from_le_bytes)
                    .map_err(|found| fault(FRAMES, found))?;
                return Ok(Self { shape, values, ends: None });
            }
        };
        let mut entry = |name: &'static str| {
            let unreadable = |reason| fault(name, (NpzFault::Unreadable(reason), 0));
            let entry = zip.by_name(&npyz::npz::file_name_from_array_name(name));
            let mut bytes = Vec::new();
            let mut entry = entry.map_err(|e| unreadable(e.to_string()))?;
            entry.read_to_end(&mut bytes).map_err(|e| unreadable(e.to_string()))?;
            Ok(bytes)
        };
        let (frames, times) = (entry(FRAMES)?, entry(TIMES)?);
        let (shape, values) = array(frames.as_slice(), VALUE_TYPE, f32::from_le_bytes)
            .map_err(|found| fault(FRAMES, found))?;
        let ends = array(times.as_slice(), "'<i8'", |bytes| Micros(i64::from_le_bytes(bytes)));
        let (_, ends) = ends.map_err(|found| fault(TIMES, found))?;
        // As many ends as windows, or something is of another file.
        if shape.first() != Some(&(ends.len() as u64)) {
            return Err(fault(TIMES, (NpzFault::Shape, ends.len())));
        }
        Ok(Self { shape, values, ends: Some(ends) })
    }
}

/// An array of one type in C order: its shape and its values. A fault comes with the number of
/// values before it.
fn array<T, const BYTES: usize>(
    mut bytes: impl Read,
    descr: &str,
    value: fn([u8; BYTES]) -> T,
) -> Result<(Vec<u64>, Vec<T>), (NpzFault, usize)> {
    let header = header(&mut bytes).map_err(|fault| (fault, 0))?;
    if header.dtype().descr() != descr {
        return Err((NpzFault::Type(header.dtype().descr()), 0));
    }
    // Other orders would be a transposed stack.
    if header.order() != Order::C {
        return Err((NpzFault::Shape, 0));
    }
    let count = header.shape().iter().product::<u64>();
    let (mut values, mut piece) = (Vec::new(), Vec::new());
    while (values.len() as u64) < count {
        // In pieces: the count of a broken header must not decide how much memory is taken.
        let wanted = (count - values.len() as u64).min(PIECE / BYTES as u64) * BYTES as u64;
        piece.clear();
        let read = bytes.by_ref().take(wanted).read_to_end(&mut piece);
        values.extend(piece.as_chunks::<BYTES>().0.iter().map(|chunk| value(*chunk)));
        let is_cut = (piece.len() as u64) < wanted;
        let end = || io::Error::from(io::ErrorKind::UnexpectedEof);
        if let Some(error) = read.err().or_else(|| is_cut.then(end)) {
            return Err((NpzFault::Unreadable(error.to_string()), values.len()));
        }
    }
    // More than the shape says means that the shape is wrong.
    match bytes.read(&mut [0]) {
        Ok(0) => Ok((header.shape().to_vec(), values)),
        _ => Err((NpzFault::Trailing, values.len())),
    }
}
