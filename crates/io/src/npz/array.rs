//! One integer array out of an archive, without trusting its header.

use std::io::{self, BufReader, Cursor, Read};

use npyz::{NpyFile, NpyReader};

use super::NpzFault;

/// NumPy writes 128 bytes. A longer header is none of its integer arrays.
const LONGEST_HEADER: u16 = 1024;

/// Takes an array, value by value, so that memory grows with the data rather than with what the
/// header claims. A fault comes with the number of values before it.
pub(super) fn read<T>(
    entry: impl Read,
    convert: impl Fn(i64) -> Option<T>,
) -> Result<Vec<T>, (NpzFault, usize)> {
    let mut entry = BufReader::with_capacity(1 << 16, entry);
    let header = header(&mut entry).map_err(|fault| (fault, 0))?;
    let mut values = Vec::new();
    let npy = NpyFile::new(Cursor::new(header).chain(&mut entry))
        .map_err(|e| (NpzFault::Unreadable(e.to_string()), 0))?;
    for value in integers(npy).map_err(|fault| (fault, 0))? {
        let value = value.map_err(|e| (unreadable(&e), values.len()))?;
        match convert(value) {
            Some(converted) => values.push(converted),
            None => return Err((NpzFault::Value(value), values.len())),
        }
    }
    // The archive compares its checksum only where an entry ends.
    match entry.read(&mut [0]) {
        Ok(0) => Ok(values),
        Ok(_) => Err((NpzFault::Trailing, values.len())),
        Err(e) => Err((unreadable(&e), 0)),
    }
}

/// The header's bytes, if they are few and describe at most one dimension.
fn header(entry: &mut impl Read) -> Result<Vec<u8>, NpzFault> {
    let mut bytes = vec![0; 10];
    entry.read_exact(&mut bytes).map_err(|e| unreadable(&e))?;
    if !bytes.starts_with(b"\x93NUMPY\x01\x00") {
        return Err(NpzFault::Unreadable("no NPY header of version 1".to_owned()));
    }
    let length = u16::from_le_bytes([bytes[8], bytes[9]]);
    if length > LONGEST_HEADER {
        return Err(NpzFault::Unreadable(format!("an NPY header of {length} bytes")));
    }
    bytes.resize(10 + usize::from(length), 0);
    entry.read_exact(&mut bytes[10..]).map_err(|e| unreadable(&e))?;
    let text = String::from_utf8_lossy(&bytes[10..]);
    let dimensions = text
        .split_once("'shape':")
        .and_then(|(_, rest)| rest.split_once('('))
        .and_then(|(_, rest)| rest.split_once(')'))
        .map(|(shape, _)| shape.split(',').filter(|size| !size.trim().is_empty()).count());
    match dimensions {
        None => Err(NpzFault::Unreadable("no shape in the NPY header".to_owned())),
        Some(0 | 1) => Ok(bytes),
        Some(_) => Err(NpzFault::Shape),
    }
}

type Integers<'a> = Box<dyn Iterator<Item = io::Result<i64>> + 'a>;

fn integers<'a, R: Read + 'a>(npy: NpyFile<R>) -> Result<Integers<'a>, NpzFault> {
    fn widen<'a, T, R>(values: NpyReader<T, R>) -> Integers<'a>
    where
        T: npyz::Deserialize + 'a,
        i64: TryFrom<T>,
        R: Read + 'a,
    {
        let too_large = |_| io::Error::new(io::ErrorKind::InvalidData, "a value beyond 64 bits");
        Box::new(values.map(move |value| i64::try_from(value?).map_err(too_large)))
    }
    macro_rules! first_that_fits {
        ($npy:expr, $($integer:ty),+) => {{
            let npy = $npy;
            $(let npy = match npy.try_data::<$integer>() {
                Ok(values) => return Ok(widen(values)),
                Err(npy) => npy,
            };)+
            Err(NpzFault::Type(npy.dtype().descr()))
        }};
    }
    first_that_fits!(npy, i64, i32, i16, i8, u64, u32, u16, u8, bool)
}

fn unreadable(error: &io::Error) -> NpzFault {
    NpzFault::Unreadable(error.to_string())
}
