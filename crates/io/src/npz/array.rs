//! One numeric array, column by column, without trusting its header.

use std::io::{self, Read};

use npyz::{DType, Endianness, NpyHeader, Order, TypeChar, TypeStr};

use super::NpzFault;
use crate::fill::fill_to_fault;

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

/// A column of values, of the types that events have as they lie in the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Column {
    /// `u1` and `bool`.
    Bytes(Vec<u8>),
    /// `u2`.
    Short(Vec<u16>),
    /// All other integers.
    Whole(Vec<i64>),
    /// Values that need not be integers.
    Real(Vec<f64>),
}

/// An array: one column, or several beside each other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    /// Names of the fields of a record; none of a plain array.
    pub(super) names: Vec<String>,
    /// Its columns.
    pub(super) columns: Vec<Column>,
}

impl Column {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Bytes(values) => values.len(),
            Self::Short(values) => values.len(),
            Self::Whole(values) => values.len(),
            Self::Real(values) => values.len(),
        }
    }

    /// A value as a number that is not exact beyond 2^53.
    pub(super) fn real(&self, k: usize) -> f64 {
        match self {
            Self::Bytes(values) => f64::from(values[k]),
            Self::Short(values) => f64::from(values[k]),
            Self::Whole(values) => values[k] as f64,
            Self::Real(values) => values[k],
        }
    }

    /// A value as an integer, if it is one.
    pub(super) fn whole(&self, k: usize) -> Option<i64> {
        match self {
            Self::Bytes(values) => Some(values[k].into()),
            Self::Short(values) => Some(values[k].into()),
            Self::Whole(values) => Some(values[k]),
            Self::Real(values) => {
                let value = values[k];
                (value.fract() == 0.0 && value.abs() < 9e15).then_some(value as i64)
            }
        }
    }

    fn with_kind(kind: Kind) -> Self {
        match (kind.letter, kind.bytes) {
            (TypeChar::Float, _) => Self::Real(Vec::new()),
            (TypeChar::Uint | TypeChar::Bool, 1) => Self::Bytes(Vec::new()),
            (TypeChar::Uint, 2) => Self::Short(Vec::new()),
            _ => Self::Whole(Vec::new()),
        }
    }

    /// Takes the value of every row that begins `at` so many bytes. A fault comes with the number
    /// of values before it.
    fn extend(&mut self, kind: Kind, rows: &Rows, at: usize) -> Result<(), (NpzFault, usize)> {
        match kind.bytes {
            1 => self.extend_by::<1>(kind, rows, at),
            2 => self.extend_by::<2>(kind, rows, at),
            4 => self.extend_by::<4>(kind, rows, at),
            _ => self.extend_by::<8>(kind, rows, at),
        }
    }

    #[inline(always)]
    fn extend_by<const BYTES: usize>(
        &mut self,
        kind: Kind,
        rows: &Rows,
        at: usize,
    ) -> Result<(), (NpzFault, usize)> {
        // A column by itself is copied, which rows of a length that is not known are not.
        if rows.length == BYTES {
            return self.extend_with(kind, rows.bytes.as_chunks::<BYTES>().0.iter().copied());
        }
        let values = rows.bytes.chunks_exact(rows.length);
        self.extend_with(kind, values.map(|row| *row[at..].first_chunk().unwrap_or(&[0; BYTES])))
    }

    #[inline(always)]
    fn extend_with<const BYTES: usize>(
        &mut self,
        kind: Kind,
        values: impl ExactSizeIterator<Item = [u8; BYTES]>,
    ) -> Result<(), (NpzFault, usize)> {
        if kind.is_big {
            self.extend_ordered(
                kind,
                values.map(|mut value| {
                    value.reverse();
                    value
                }),
            )
        } else {
            self.extend_ordered(kind, values)
        }
    }

    /// Takes values whose first byte is the lowest.
    #[inline(always)]
    fn extend_ordered<const BYTES: usize>(
        &mut self,
        kind: Kind,
        values: impl ExactSizeIterator<Item = [u8; BYTES]>,
    ) -> Result<(), (NpzFault, usize)> {
        let raw = values.map(|value| {
            let mut wide = [0; 8];
            wide[..BYTES].copy_from_slice(&value);
            u64::from_le_bytes(wide)
        });
        match self {
            Self::Bytes(values) => values.extend(raw.map(|raw| raw as u8)),
            Self::Short(values) => values.extend(raw.map(|raw| raw as u16)),
            Self::Real(values) if BYTES == 4 => {
                values.extend(raw.map(|raw| f64::from(f32::from_bits(raw as u32))));
            }
            Self::Real(values) => values.extend(raw.map(f64::from_bits)),
            Self::Whole(values) if kind.letter == TypeChar::Int => {
                // The sign is in the first bit of as many bytes as there are.
                let unused = 64 - 8 * BYTES as u32;
                values.extend(raw.map(|raw| (raw << unused) as i64 >> unused));
            }
            Self::Whole(values) => {
                let before = values.len();
                values.extend(raw.map(|raw| raw as i64));
                if let Some(fits) = values[before..].iter().position(|value| *value < 0) {
                    let fault = NpzFault::Unreadable("a value beyond 64 bits".to_owned());
                    return Err((fault, fits));
                }
            }
        }
        Ok(())
    }

    /// A column of values as columns that lie one behind the other, of `of_each` values.
    fn apart(&self, of_each: usize) -> Vec<Self> {
        match self {
            Self::Bytes(values) => parts(values, of_each, Self::Bytes),
            Self::Short(values) => parts(values, of_each, Self::Short),
            Self::Whole(values) => parts(values, of_each, Self::Whole),
            Self::Real(values) => parts(values, of_each, Self::Real),
        }
    }
}

fn parts<T: Clone>(values: &[T], of_each: usize, column: fn(Vec<T>) -> Column) -> Vec<Column> {
    values.chunks(of_each.max(1)).map(|part| column(part.to_vec())).collect()
}

/// Whole rows of an array.
struct Rows<'a> {
    bytes: &'a [u8],
    /// Bytes of a row.
    length: usize,
}

/// Storage type of values.
#[derive(Debug, Clone, Copy)]
struct Kind {
    letter: TypeChar,
    bytes: usize,
    is_big: bool,
}

impl Kind {
    fn from_type(kind: &TypeStr) -> Option<Self> {
        let (letter, bytes) = (kind.type_char(), kind.num_bytes()?);
        let is_known = match letter {
            TypeChar::Int | TypeChar::Uint => [1, 2, 4, 8].contains(&bytes),
            TypeChar::Float => [4, 8].contains(&bytes),
            TypeChar::Bool => bytes == 1,
            _ => false,
        };
        is_known.then_some(Self { letter, bytes, is_big: kind.endianness() == Endianness::Big })
    }
}

/// Takes an array, piece by piece, so that memory grows with the data rather than with what the
/// header claims. A fault comes with the number of values before it.
pub(super) fn read(mut entry: impl Read) -> Result<Array, (NpzFault, usize)> {
    let header = header(&mut entry).map_err(|fault| (fault, 0))?;
    let layout = Layout::from_header(&header).map_err(|fault| (fault, 0))?;
    let mut columns: Vec<Column> =
        layout.kinds.iter().map(|kind| Column::with_kind(*kind)).collect();
    let length: usize = layout.kinds.iter().map(|kind| kind.bytes).sum();
    let most = (PIECE / length).max(1) as u64;
    let (mut piece, mut before) = (vec![0; most as usize * length], 0);
    while before < layout.rows {
        let piece = &mut piece[..most.min(layout.rows - before) as usize * length];
        let (filled, failed) = fill_to_fault(&mut entry, piece);
        let whole = filled / length;
        let rows = Rows { bytes: &piece[..whole * length], length };
        let mut at = 0;
        for (column, kind) in columns.iter_mut().zip(&layout.kinds) {
            let extended = column.extend(*kind, &rows, at);
            extended.map_err(|(fault, fits)| (fault, before as usize + fits))?;
            at += kind.bytes;
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
    match (layout.is_one_after_another, columns.as_slice()) {
        (true, [all]) => Ok(Array { names: layout.names, columns: all.apart(layout.of_each) }),
        _ => Ok(Array { names: layout.names, columns }),
    }
}

/// How the values of an array lie in the file.
struct Layout {
    names: Vec<String>,
    /// Of the values of a row.
    kinds: Vec<Kind>,
    rows: u64,
    /// Whether columns lie one behind the other, of so many values each.
    is_one_after_another: bool,
    of_each: usize,
}

impl Layout {
    fn from_header(header: &NpyHeader) -> Result<Self, NpzFault> {
        let dtype = header.dtype();
        let unfit = || NpzFault::Type(dtype.descr());
        let (mut names, mut kinds) = (Vec::new(), Vec::new());
        match &dtype {
            DType::Plain(kind) => kinds.push(Kind::from_type(kind).ok_or_else(unfit)?),
            DType::Record(fields) => {
                for field in fields {
                    let DType::Plain(kind) = &field.dtype else { return Err(unfit()) };
                    kinds.push(Kind::from_type(kind).ok_or_else(unfit)?);
                    names.push(field.name.clone());
                }
            }
            DType::Array(..) => return Err(unfit()),
        }
        // A record of no fields has no bytes: any number of them would be there.
        if kinds.is_empty() {
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
            [rows, columns] if (1..*of_events.start()).contains(&columns) => {
                (rows, columns, header.order() == Order::Fortran)
            }
            _ => return Err(NpzFault::Shape),
        };
        let of_each = usize::try_from(rows).map_err(|_| NpzFault::Shape)?;
        if is_one_after_another {
            // All values in a row of one, to be taken apart when they are there.
            let rows = rows.checked_mul(columns).ok_or(NpzFault::Shape)?;
            return Ok(Self { names, kinds, rows, is_one_after_another, of_each });
        }
        if names.is_empty() {
            kinds = vec![kinds[0]; columns as usize];
        }
        Ok(Self { names, kinds, rows, is_one_after_another, of_each })
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
    NpyHeader::from_reader(bytes.as_slice()).map_err(|e| unreadable(&e))
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
