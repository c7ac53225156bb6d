//! Events as a NumPy archive, the format every Python tool reads and writes.
//!
//! | array | type written | also read | meaning |
//! |---|---|---|---|
//! | `t` | `i64`, microseconds | any integer; `f4`, `f8` in seconds | ascending |
//! | `x`, `y` | `u16` | any number without a fraction | column from the left, row from the top |
//! | `p` | `u8` | any number, `bool` | 1 = ON, 0 or -1 = OFF |
//! | `width`, `height` | `i64`, a scalar | any integer; may both be missing | the sensor in pixels |
//!
//! Other programs call the arrays `ts`, `xs`, `ys`, `ps`, or `timestamps` and `polarity`, or have one
//! array `events`: of records with such fields, or of four columns in the order `t x y p`, `x y t p`,
//! `x y p t` or `t p x y`, told by what is in them. A single such array in an `.npy` file is read as
//! well. Times that are floating-point numbers without any fraction are microseconds.

mod array;
mod events;
mod reader;
mod writer;

use std::fmt;

pub(crate) use array::header;
#[cfg(feature = "hdf5")]
pub(crate) use events::{ORDERS, REQUIRED, called};

use crate::open::{Format, no_labels};

/// The archive's entry in the registry of formats.
pub(crate) const FORMAT: Format = Format {
    name: "npz",
    summary: "NumPy archive: t, x, y, p, width, height",
    endings: &[".npz"],
    probe: |head| {
        [b"PK\x03\x04", b"PK\x05\x06"].iter().any(|begin| head.starts_with(*begin))
            || head.starts_with(ARRAY)
    },
    open: reader::open,
    create: Some(writer::create),
    labels: no_labels,
};

/// How a single array begins.
const ARRAY: &[u8; 6] = b"\x93NUMPY";

/// What is wrong with an array.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NpzFault {
    /// Its header or its compressed data cannot be read.
    Unreadable(String),
    /// A column has several dimensions, or a scalar several values.
    Shape,
    /// Its values are no numbers.
    Type(String),
    /// A value without a meaning.
    Value(i64),
    /// A value that should be an integer, or of a size that fits.
    Real(String),
    /// The columns or fields of an event cannot be told, with the reason.
    Columns(String),
    /// There is more than its shape says.
    Trailing,
    /// Its length differs from that of `t`.
    Length {
        /// Values it has.
        got: usize,
        /// Values of `t`.
        of: usize,
    },
}

impl fmt::Display for NpzFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(why) => f.write_str(why),
            Self::Shape => f.write_str("not the shape of a column, or of a scalar"),
            Self::Type(dtype) => {
                write!(f, "values of type {dtype}, expected integers, f4, f8 or bool")
            }
            Self::Value(value) => write!(f, "the value {value} has no meaning"),
            Self::Real(value) => write!(f, "{value} should be an integer"),
            Self::Columns(why) => f.write_str(why),
            Self::Trailing => f.write_str("more data than its shape says"),
            Self::Length { got, of } => write!(f, "{got} values, but `t` has {of}"),
        }
    }
}

#[cfg(test)]
mod tests;
