//! Arrays of a NumPy archive, without trusting what their headers claim.
//!
//! # Source
//! `numpy/lib/format.py`: the magic bytes, a version, the length of the header, the header as text
//! of a Python dictionary, then the values.

use std::io::{Cursor, Read};

use evpose_containers::pickle::{Array, ArrayError, Element, Pickle, Sparse};
use zip::ZipArchive;
use zip::result::ZipError;

const MAGIC: &[u8] = b"\x93NUMPY";
/// NumPy writes 128 bytes.
const MAX_HEADER_BYTES: usize = 1 << 16;
/// Bytes of an unpacked array. The largest of the published models has 76 million.
const MAX_ARRAY_BYTES: usize = 128 << 20;

/// An archive in memory.
pub(super) struct Archive {
    zip: ZipArchive<Cursor<Vec<u8>>>,
}

/// Header of an `.npy` entry, before its values.
struct Header {
    element: String,
    is_column_major: bool,
    shape: Vec<usize>,
}

impl Archive {
    /// # Errors
    /// If the archive has no directory.
    pub(super) fn open(bytes: Vec<u8>) -> Result<Self, ZipError> {
        Ok(Self { zip: ZipArchive::new(Cursor::new(bytes))? })
    }

    /// Names of its arrays, in order.
    pub(super) fn names(&self) -> Vec<String> {
        let names = self.zip.file_names_raw().map(|name| String::from_utf8_lossy(name));
        let mut names: Vec<String> =
            names.filter_map(|name| name.strip_suffix(".npy").map(str::to_owned)).collect();
        names.sort();
        names
    }

    /// An array; none if there is none of this name.
    pub(super) fn array(&mut self, name: &str) -> Option<Result<Array, ArrayError>> {
        let bytes = match self.entry(name)? {
            Ok(bytes) => bytes,
            Err(error) => return Some(Err(error)),
        };
        Some(header(&bytes).and_then(|(header, values)| {
            if header.element.contains('O') {
                return Err(ArrayError::Objects);
            }
            let element = Element::parse(&header.element)
                .ok_or_else(|| ArrayError::Type(header.element.chars().take(80).collect()))?;
            Array::from_bytes(header.shape, element, header.is_column_major, values)
        }))
    }

    /// A sparse matrix that was stored as a Python object; none if it is something else.
    pub(super) fn sparse(&mut self, name: &str) -> Option<Result<Sparse, ArrayError>> {
        let bytes = self.entry(name)?.ok()?;
        let (header, values) = header(&bytes).ok()?;
        if !header.element.contains('O') {
            return None;
        }
        let Ok(pickle) = Pickle::read(values, 0) else {
            return Some(Err(ArrayError::Damaged("its pickled object cannot be read")));
        };
        let object = *Array::objects(&pickle, pickle.root())?.first()?;
        Sparse::read(&pickle, object)
    }

    fn entry(&mut self, name: &str) -> Option<Result<Vec<u8>, ArrayError>> {
        let entry = self.zip.by_name(&format!("{name}.npy")).ok()?;
        let mut bytes = Vec::new();
        let read = entry.take(MAX_ARRAY_BYTES as u64 + 1).read_to_end(&mut bytes);
        Some(match read {
            Ok(length) if length <= MAX_ARRAY_BYTES => Ok(bytes),
            Ok(_) => Err(ArrayError::Damaged("it unpacks to more than 128 MiB")),
            Err(_) => Err(ArrayError::Damaged("its compressed data are cut off or changed")),
        })
    }
}

fn header(bytes: &[u8]) -> Result<(Header, &[u8]), ArrayError> {
    const NONE: ArrayError = ArrayError::Damaged("no header of a NumPy array");
    let rest = bytes.strip_prefix(MAGIC).ok_or(NONE)?;
    let (length, rest) = match rest {
        // Version 1 has lengths of two bytes, later ones of four.
        [1, _, a, b, rest @ ..] => (u32::from_le_bytes([*a, *b, 0, 0]), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]), rest),
        _ => return Err(NONE),
    };
    let length = length as usize;
    // No header of a model's array is that long: the length is damaged.
    if length > MAX_HEADER_BYTES {
        return Err(NONE);
    }
    let (text, values) = rest.split_at_checked(length).ok_or(NONE)?;
    let text = std::str::from_utf8(text).map_err(|_| NONE)?;
    let header = parse(text).ok_or(NONE)?;
    Ok((header, values))
}

/// `{'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }`
fn parse(text: &str) -> Option<Header> {
    let after = |key: &str| {
        let (_, rest) = text.split_once(&format!("'{key}'"))?;
        Some(rest.trim_start().strip_prefix(':')?.trim_start())
    };
    let (element, _) = after("descr")?.strip_prefix('\'')?.split_once('\'')?;
    // Written as Python prints it, not as JSON.
    let order = after("fortran_order")?;
    let is_column_major = order.starts_with("True");
    if !is_column_major && !order.starts_with("False") {
        return None;
    }
    let (shape, _) = after("shape")?.strip_prefix('(')?.split_once(')')?;
    let lengths = shape.split(',').map(str::trim).filter(|length| !length.is_empty());
    // Python 2 wrote long integers with an L.
    let shape = lengths.map(|length| length.trim_end_matches('L').parse().ok());
    Some(Header {
        element: element.to_owned(),
        is_column_major,
        shape: shape.collect::<Option<_>>()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_read_as_numpy_writes_them() {
        let header = parse("{'descr': '>f4', 'fortran_order': True, 'shape': (16L, 778L), }  \n");
        let header = header.map(|h| (h.element, h.is_column_major, h.shape));
        assert_eq!(header, Some((">f4".to_owned(), true, vec![16, 778])));
        let scalar = parse("{'descr': '<i8', 'fortran_order': False, 'shape': (), }");
        assert_eq!(scalar.map(|h| h.shape), Some(vec![]));
        let record = "{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (3,), }";
        assert!(parse(record).is_none());
    }
}
