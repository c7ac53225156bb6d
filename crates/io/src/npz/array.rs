//! One numeric array, column by column, without trusting its header.

use std::io::{self, Read};

use npyz::{DType, NpyHeader, Order};

use super::NpzFault;
use super::column::{Column, Kind, Rows};
use crate::fill::fill_to_fault;
use crate::source::max_unpacked;

/// NumPy writes 128 bytes, more for records. A longer header is no recording's.
const LONGEST_HEADER: u16 = 4096;
/// Brackets around anything in a header: a dictionary, a list, a field, its shape, and some to
/// spare.
const MAX_BRACKETS: usize = 8;
/// Columns that an array of events may have.
const MIN_COLUMNS: u64 = 4;
const MAX_COLUMNS: u64 = 16;
/// Bytes that are taken at a time.
const PIECE: usize = 1 << 16;

/// An array: one column, or several beside each other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    /// Names of the fields of a record; none of a plain array.
    pub(super) names: Vec<String>,
    /// Its columns.
    pub(super) columns: Vec<Column>,
}

/// Takes an array, piece by piece, so that memory grows with the data rather than with what the
/// header claims, and with neither beyond `room`, which is less by the bytes of the array then. A
/// fault comes with the number of values before it.
pub(super) fn read(mut entry: impl Read, room: &mut Room) -> Result<Array, (NpzFault, usize)> {
    let header = header(&mut entry).map_err(|fault| (fault, 0))?;
    let layout = Layout::from_header(&header).map_err(|fault| (fault, 0))?;
    let mut columns: Vec<Column> =
        layout.fields.iter().map(|(_, kind)| Column::with_kind(*kind)).collect();
    let length = layout.length;
    let bytes = layout.rows.saturating_mul(length as u64);
    room.take(bytes).map_err(|fault| (fault, 0))?;
    // A piece is at least a row, however long.
    let most = (PIECE / length).max(1) as u64;
    let (mut piece, mut before) = (vec![0; most as usize * length], 0);
    while before < layout.rows {
        let piece = &mut piece[..most.min(layout.rows - before) as usize * length];
        let (filled, failed) = fill_to_fault(&mut entry, piece);
        // A cut row is not read; those before it are.
        let whole = filled / length;
        let rows = Rows { bytes: &piece[..whole * length], length };
        for (column, (at, kind)) in columns.iter_mut().zip(&layout.fields) {
            let extended = column.extend(*kind, &rows, *at);
            extended.map_err(|(fault, fits)| (fault, before as usize + fits))?;
        }
        before += whole as u64;
        if filled < piece.len() {
            let end = || io::ErrorKind::UnexpectedEof.into();
            return Err((unreadable(&failed.unwrap_or_else(end)), before as usize));
        }
    }
    // The archive compares its checksum only where an entry ends.
    match entry.read(&mut [0]) {
        Ok(0) => {}
        Ok(_) => return Err((NpzFault::Trailing, layout.rows as usize)),
        Err(e) => return Err((unreadable(&e), 0)),
    }
    // A column-major table was read as one column, which is divided here.
    match (layout.is_one_after_another, columns.as_slice()) {
        (true, [all]) => Ok(Array { names: layout.names, columns: all.apart(layout.of_each) }),
        _ => Ok(Array { names: layout.names, columns }),
    }
}

/// The bytes that the arrays of an archive may unpack to.
#[derive(Debug)]
pub(super) struct Room {
    limit: u64,
    taken: u64,
}

impl Room {
    /// That of a file of `length` bytes.
    pub(super) fn of_file(length: u64) -> Self {
        Self { limit: max_unpacked(length), taken: 0 }
    }

    fn take(&mut self, bytes: u64) -> Result<(), NpzFault> {
        self.taken = self.taken.saturating_add(bytes);
        match self.taken <= self.limit {
            true => Ok(()),
            false => Err(NpzFault::TooLarge { bytes: self.taken, limit: self.limit }),
        }
    }
}

/// How the values of an array lie in the file.
struct Layout {
    names: Vec<String>,
    /// Places in a row, and types, of its values.
    fields: Vec<(usize, Kind)>,
    /// Bytes of a row, those between and behind its values included.
    length: usize,
    rows: u64,
    /// Whether columns lie one behind the other, of so many values each.
    is_one_after_another: bool,
    of_each: usize,
}

impl Layout {
    fn from_header(header: &NpyHeader) -> Result<Self, NpzFault> {
        let dtype = header.dtype();
        let unfit = || NpzFault::Type(dtype.descr());
        let (mut names, mut fields, mut length) = (Vec::new(), Vec::new(), 0_usize);
        match &dtype {
            DType::Plain(kind) => {
                let kind = Kind::from_type(kind).ok_or_else(unfit)?;
                fields.push((0, kind));
                length = kind.bytes;
            }
            DType::Record(all) => {
                for field in all {
                    let DType::Plain(kind) = &field.dtype else { return Err(unfit()) };
                    let bytes = kind.num_bytes().ok_or_else(unfit)?;
                    // Padding of aligned records has no name.
                    if !field.name.is_empty() {
                        fields.push((length, Kind::from_type(kind).ok_or_else(unfit)?));
                        names.push(field.name.clone());
                    }
                    length = length.checked_add(bytes).filter(|n| *n <= PIECE).ok_or_else(unfit)?;
                }
            }
            DType::Array(..) => return Err(unfit()),
        }
        // A record of no fields has no bytes: any number of them would be there.
        if fields.is_empty() || length == 0 {
            return Err(unfit());
        }
        let plain = |rows: u64| (rows, 1, false);
        let of_events = MIN_COLUMNS..=MAX_COLUMNS;
        let (rows, columns, is_one_after_another) = match *header.shape() {
            [] => plain(1),
            [rows] => plain(rows),
            // A column that was given a second dimension.
            [1, rows] | [rows, 1] => plain(rows),
            _ if !names.is_empty() => return Err(NpzFault::Shape),
            [rows, columns] if of_events.contains(&columns) => {
                (rows, columns, header.order() == Order::Fortran)
            }
            [columns, rows] if of_events.contains(&columns) => {
                (rows, columns, header.order() == Order::C)
            }
            // Narrow tables hold a part of each event, as the columns and rows of EVIMO do.
            [rows, columns] if (1..*of_events.start()).contains(&columns) => {
                (rows, columns, header.order() == Order::Fortran)
            }
            _ => return Err(NpzFault::Shape),
        };
        let of_each = usize::try_from(rows).map_err(|_| NpzFault::Shape)?;
        if is_one_after_another {
            // All values in a row of one, to be taken apart when they are there.
            let rows = rows.checked_mul(columns).ok_or(NpzFault::Shape)?;
            return Ok(Self { names, fields, length, rows, is_one_after_another, of_each });
        }
        if names.is_empty() {
            let (_, kind) = fields[0];
            fields = (0..columns as usize).map(|column| (column * kind.bytes, kind)).collect();
            length = columns as usize * kind.bytes;
        }
        Ok(Self { names, fields, length, rows, is_one_after_another, of_each })
    }
}

/// The header, if it is short and one that NumPy writes.
///
/// The parser behind it multiplies the sizes of a shape whatever they are, and calls itself for
/// every bracket: what it is given is looked at before.
///
/// # Errors
/// Whatever is wrong with it.
pub(crate) fn header(entry: &mut impl Read) -> Result<NpyHeader, NpzFault> {
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
    let shape = text
        .split_once("'shape':")
        .and_then(|(_, rest)| rest.split_once('('))
        .and_then(|(_, rest)| rest.split_once(')'))
        .ok_or_else(|| NpzFault::Unreadable("no shape in the NPY header".to_owned()))?
        .0;
    // A second shape, or one that is spelt otherwise, would be the parser's.
    if text.matches("shape").count() > 1 || text.contains('\\') || is_deep(&text) {
        return Err(NpzFault::Unreadable("an NPY header as NumPy writes none".to_owned()));
    }
    let sizes = shape.split(',').map(str::trim).filter(|size| !size.is_empty());
    // Some products leave out the first sizes, and so a zero among them.
    let whole = sizes.map(|size| size.parse().ok()).try_fold(1u64, |all, size: Option<u64>| {
        size.and_then(|size| all.checked_mul(size.max(1)))
    });
    whole.ok_or(NpzFault::Shape)?;
    let text = without_titles(&text);
    let mut plain = b"\x93NUMPY\x01\x00".to_vec();
    plain.extend((text.len() as u16).to_le_bytes());
    plain.extend(text.as_bytes());
    NpyHeader::from_reader(plain.as_slice()).map_err(|e| unreadable(&e))
}

/// A header in which a field with a title, `(('polarity', 'p'), '|b1')`, has its name alone: the
/// parser knows no titles.
fn without_titles(header: &str) -> String {
    let mut plain = header.to_owned();
    while let Some(begin) = plain.find("(('")
        && let Some(length) = plain[begin..].find("'), ")
        && let Some(name) = plain[begin..begin + length].rsplit('\'').next().map(str::to_owned)
    {
        plain.replace_range(begin..begin + length + 2, &format!("('{name}'"));
    }
    plain
}

/// Whether brackets stand in brackets deeper than those of records in a list in a dictionary.
fn is_deep(text: &str) -> bool {
    let mut depth = 0_usize;
    text.bytes().any(|byte| {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        depth > MAX_BRACKETS
    })
}

fn unreadable(error: &io::Error) -> NpzFault {
    NpzFault::Unreadable(error.to_string())
}
