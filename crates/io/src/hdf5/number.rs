//! Numeric columns in rows of bytes.

use hdf5_reader::{ByteOrder, Datatype};

/// Bytes of the rows of Prophesee's tables and of v2e's.
const USUAL: usize = 16;

/// Type of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// One number of every row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Number {
    kind: Kind,
    is_big_endian: bool,
    /// Offset in its row.
    pub(super) offset: usize,
}

/// Whether a column holds what it should; the places where it does not are looked for only then.
pub(super) type IsWhole = bool;

impl Number {
    /// The value type of an HDF5 type; none if it is not numeric. Booleans are numeric.
    pub(super) fn from_datatype(datatype: &Datatype, offset: usize) -> Option<Self> {
        use Kind::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
        let (kind, order) = match datatype {
            Datatype::FixedPoint { size, signed, byte_order } => {
                let kind = match (size, signed) {
                    (1, true) => I8,
                    (1, false) => U8,
                    (2, true) => I16,
                    (2, false) => U16,
                    (4, true) => I32,
                    (4, false) => U32,
                    (8, true) => I64,
                    (8, false) => U64,
                    _ => return None,
                };
                (kind, *byte_order)
            }
            Datatype::FloatingPoint { size: 4, byte_order } => (F32, *byte_order),
            Datatype::FloatingPoint { size: 8, byte_order } => (F64, *byte_order),
            // Booleans of h5py are enumerations of bytes.
            Datatype::Enum { base, .. } => return Self::from_datatype(base, offset),
            _ => return None,
        };
        Some(Self { kind, is_big_endian: order == ByteOrder::BigEndian, offset })
    }

    /// Bytes of the number.
    pub(super) fn size(self) -> usize {
        match self.kind {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::I64 | Kind::U64 | Kind::F64 => 8,
        }
    }

    /// Whether it may have a fraction.
    pub(super) fn is_real(self) -> bool {
        matches!(self.kind, Kind::F32 | Kind::F64)
    }

    /// Makes every value of `out` of the number in its row, the first of `rows` being its first.
    /// Values that are not integers, or beyond 63 bits, become -1, and the result is false.
    #[inline(always)]
    pub(super) fn whole<T>(
        self,
        rows: &[u8],
        row: usize,
        out: &mut [T],
        mut make: impl FnMut(i64) -> T,
    ) -> IsWhole {
        let mut is_whole = true;
        // A macro, since the functions differ in type alone.
        macro_rules! integers {
            ($type:ty) => {{
                let make = |value: $type| make(value.into());
                self.each(rows, row, out, <$type>::from_le_bytes, <$type>::from_be_bytes, make)
            }};
        }
        match self.kind {
            Kind::I8 => integers!(i8),
            Kind::U8 => integers!(u8),
            Kind::I16 => integers!(i16),
            Kind::U16 => integers!(u16),
            Kind::I32 => integers!(i32),
            Kind::U32 => integers!(u32),
            Kind::I64 => integers!(i64),
            Kind::U64 => self.each(rows, row, out, u64::from_le_bytes, u64::from_be_bytes, |v| {
                is_whole &= v <= i64::MAX as u64;
                make(i64::try_from(v).unwrap_or(-1))
            }),
            // Whole numbers are often stored as floats.
            Kind::F32 | Kind::F64 => self.floats(rows, row, out, |value| {
                let whole = value as i64;
                let is_this = whole as f64 == value;
                is_whole &= is_this;
                make(if is_this { whole } else { -1 })
            }),
        }
        is_whole
    }

    /// As [`Number::whole`], for values with a fraction.
    #[inline(always)]
    pub(super) fn floats<T>(
        self,
        rows: &[u8],
        row: usize,
        out: &mut [T],
        mut make: impl FnMut(f64) -> T,
    ) {
        if self.kind == Kind::F32 {
            let make = |value: f32| make(value.into());
            self.each(rows, row, out, f32::from_le_bytes, f32::from_be_bytes, make);
        } else {
            self.each(rows, row, out, f64::from_le_bytes, f64::from_be_bytes, make);
        }
    }

    /// Decodes the values of all `rows`.
    pub(super) fn values(self, rows: &[u8], row: usize) -> Vec<f64> {
        let mut out = vec![0.0; rows.len() / row];
        if self.is_real() {
            self.floats(rows, row, &mut out, |value| value);
        } else {
            self.whole(rows, row, &mut out, |value| value as f64);
        }
        out
    }

    /// Goes through the rows; `N` is the size of the number.
    #[inline(always)]
    fn each<const N: usize, V, T>(
        self,
        rows: &[u8],
        row: usize,
        out: &mut [T],
        little: impl Fn([u8; N]) -> V,
        big: impl Fn([u8; N]) -> V,
        mut make: impl FnMut(V) -> T,
    ) {
        let order = self.is_big_endian;
        let value = |bytes: [u8; N]| if order { big(bytes) } else { little(bytes) };
        // Three loops: adjacent values, rows of the usual size, and any others. A row size known at
        // compile time lets the first two become vectors.
        if row == N {
            let values = rows.as_chunks::<N>().0;
            out.iter_mut().zip(values).for_each(|(out, bytes)| *out = make(value(*bytes)));
        } else if row == USUAL {
            let rows = rows.as_chunks::<USUAL>().0;
            for (out, row) in out.iter_mut().zip(rows) {
                if let Some(bytes) = row.get(self.offset..).and_then(|rest| rest.first_chunk()) {
                    *out = make(value(*bytes));
                }
            }
        } else {
            for (out, row) in out.iter_mut().zip(rows.chunks_exact(row)) {
                if let Some(bytes) = row.get(self.offset..).and_then(|rest| rest.first_chunk()) {
                    *out = make(value(*bytes));
                }
            }
        }
    }
}
