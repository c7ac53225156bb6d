//! Columns of numeric values, of the types that events have.

use npyz::{Endianness, TypeChar, TypeStr};

use super::NpzFault;

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
                // Beyond 9e15, about 2^53, floats do not distinguish neighbouring integers.
                (value.fract() == 0.0 && value.abs() < 9e15).then_some(value as i64)
            }
        }
    }

    pub(super) fn with_kind(kind: Kind) -> Self {
        match (kind.letter, kind.bytes) {
            (TypeChar::Float, _) => Self::Real(Vec::new()),
            (TypeChar::Uint | TypeChar::Bool, 1) => Self::Bytes(Vec::new()),
            (TypeChar::Uint, 2) => Self::Short(Vec::new()),
            _ => Self::Whole(Vec::new()),
        }
    }

    /// Takes the value of every row that begins `at` so many bytes. A fault comes with the number
    /// of values before it.
    pub(super) fn extend(
        &mut self,
        kind: Kind,
        rows: &Rows,
        at: usize,
    ) -> Result<(), (NpzFault, usize)> {
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
        // The order of bytes is decided here, outside the loop over values.
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
        // Widened to 64 bits: one loop serves all lengths.
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
                // Unsigned values of the upper half became negative.
                if let Some(fits) = values[before..].iter().position(|value| *value < 0) {
                    let fault = NpzFault::Unreadable("a value beyond 64 bits".to_owned());
                    return Err((fault, fits));
                }
            }
        }
        Ok(())
    }

    /// A column of values as columns that lie one behind the other, of `of_each` values.
    pub(super) fn apart(&self, of_each: usize) -> Vec<Self> {
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
pub(super) struct Rows<'a> {
    pub(super) bytes: &'a [u8],
    /// Bytes of a row.
    pub(super) length: usize,
}

/// Storage type of values.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kind {
    letter: TypeChar,
    pub(super) bytes: usize,
    is_big: bool,
}

impl Kind {
    pub(super) fn from_type(kind: &TypeStr) -> Option<Self> {
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
