//! Files: the header, and the variables one behind the other.

use std::io::{self, Read};

use flate2::read::ZlibDecoder;

use crate::mat::element::{COMPRESSED, MATRIX, Origin, Reader};
use crate::mat::tree::{Tree, read_tree};
use crate::mat::{MatError, MatValue};
use crate::number::ByteOrder;

const HEADER_BYTES: usize = 128;
/// Default limit of the inflated bytes of all variables, against archives that expand without end: a
/// quarter of a gigabyte, and more only for files that inflate by no more than a factor of 64.
const INFLATED_LIMIT: u64 = 1 << 28;
const INFLATED_RATIO: u64 = 64;

/// A MAT-file of version 5 to 7.2 in memory.
#[derive(Debug)]
pub struct MatFile {
    variables: Vec<Variable>,
}

/// A variable: the tree of its arrays, and the bytes that they refer to.
#[derive(Debug)]
pub(crate) struct Variable {
    pub(crate) name: String,
    pub(crate) bytes: Vec<u8>,
    pub(crate) order: ByteOrder,
    pub(crate) tree: Tree,
}

impl MatFile {
    /// Parses the bytes of a file; compressed variables may inflate to 256 MiB, or to 64 times the
    /// bytes of the file if that is more.
    ///
    /// # Errors
    /// As [`Self::parse_within`].
    pub fn parse(bytes: &[u8]) -> Result<Self, MatError> {
        Self::parse_within(bytes, INFLATED_LIMIT.max(INFLATED_RATIO * bytes.len() as u64))
    }

    /// Parses the bytes of a file whose compressed variables may inflate to `inflated_limit` bytes.
    ///
    /// # Errors
    /// If a byte violates the format, or the inflated content exceeds the limit.
    pub fn parse_within(bytes: &[u8], inflated_limit: u64) -> Result<Self, MatError> {
        let order = header(bytes)?;
        let origin = Origin::File { start: 0 };
        let mut reader = Reader { bytes, order, origin, at: HEADER_BYTES, end: bytes.len() };
        let mut variables = Vec::new();
        // One limit for all variables together, since many small ones add up.
        let mut left = inflated_limit;
        while reader.at < reader.end {
            let element = reader.element("a variable")?;
            let data = reader.data(&element);
            let (bytes, origin) = match element.kind {
                MATRIX => (
                    bytes[element.tag..element.end()].to_vec(),
                    Origin::File { start: element.tag },
                ),
                COMPRESSED => {
                    let bytes = inflate(data, left).map_err(|error| {
                        let reason = format!("cannot be decompressed: {error}");
                        reader.origin.malformed(element.tag, reason)
                    })?;
                    left = left
                        .checked_sub(bytes.len() as u64)
                        .ok_or(MatError::TooLarge { byte: element.tag, limit: inflated_limit })?;
                    (bytes, Origin::Inflated { element: element.tag })
                }
                kind => {
                    let reason = format!("a variable is expected, this is of type {kind}");
                    return Err(reader.origin.malformed(element.tag, reason));
                }
            };
            let variable = variable(bytes, order, origin)?;
            // A variable without a name is MATLAB's own subsystem data, which objects refer to.
            if !variable.name.is_empty() {
                variables.push(variable);
            }
        }
        Ok(Self { variables })
    }

    /// Names of the variables, in the order of the file.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.variables.iter().map(|variable| variable.name.as_str())
    }

    /// Returns the variable `name`.
    ///
    /// # Errors
    /// If the file has no such variable.
    pub fn variable(&self, name: &str) -> Result<MatValue<'_>, MatError> {
        // The last one, as in MATLAB, should there be several.
        let last = self.variables.iter().rev().find(|variable| variable.name == name);
        last.map(MatValue::root).ok_or_else(|| MatError::NoVariable {
            name: name.to_owned(),
            known: crate::mat::value::list(self.names()),
        })
    }
}

fn header(bytes: &[u8]) -> Result<ByteOrder, MatError> {
    // MATLAB puts 512 bytes of its own before HDF5's.
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    if bytes.starts_with(HDF5) || bytes.get(512..).is_some_and(|bytes| bytes.starts_with(HDF5)) {
        return Err(MatError::Version73);
    }
    let Some(header) = bytes.first_chunk::<HEADER_BYTES>() else {
        return Err(if is_version_4(bytes) { MatError::Version4 } else { MatError::NotMat });
    };
    // Two letters in the order of the machine show the order of the bytes.
    let (order, major) = match header[124..] {
        [_, major, b'I', b'M'] => (ByteOrder::Little, major),
        [major, _, b'M', b'I'] => (ByteOrder::Big, major),
        _ if is_version_4(bytes) => return Err(MatError::Version4),
        _ => return Err(MatError::NotMat),
    };
    match major {
        1 => Ok(order),
        2 => Err(MatError::Version73),
        _ => Err(MatError::NotMat),
    }
}

/// Whether `bytes` begin with a header of version 4: type, rows, columns, complex
/// flag, length of the name.
fn is_version_4(bytes: &[u8]) -> bool {
    let Some(header) = bytes.first_chunk::<20>() else { return false };
    let (words, _) = header.as_chunks::<4>();
    [ByteOrder::Little, ByteOrder::Big].into_iter().any(|order| {
        let word = |i: usize| order.u32(words[i]);
        let kind = word(0);
        // Thousands: the machine; hundreds: nothing; tens: the storage; ones: the class.
        let is_kind = kind < 5000 && kind / 100 % 10 == 0 && kind / 10 % 10 <= 5 && kind % 10 <= 2;
        is_kind && word(3) <= 1 && (1..=64).contains(&word(4))
    })
}

/// Inflates a compressed element; at most one byte more than `limit`, so that the caller sees an
/// excess.
fn inflate(data: &[u8], limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut decoder = ZlibDecoder::new(data).take(limit.saturating_add(1));
    decoder.read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn variable(bytes: Vec<u8>, order: ByteOrder, origin: Origin) -> Result<Variable, MatError> {
    let mut reader = Reader { bytes: &bytes, order, origin, at: 0, end: bytes.len() };
    let element = reader.element("a variable")?;
    if reader.at != reader.end {
        return Err(origin.malformed(reader.at, "nothing is expected behind the variable"));
    }
    let (name, tree) = read_tree(reader, &element)?;
    Ok(Variable { name, bytes, order, tree })
}
