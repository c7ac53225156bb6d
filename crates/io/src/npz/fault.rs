//! Faults of NumPy arrays.

use std::fmt;

/// A fault of an array.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NpzFault {
    /// Its header or its compressed data cannot be read.
    Unreadable(String),
    /// A column has several dimensions, or a scalar several values.
    Shape,
    /// Values that are not numeric.
    Type(String),
    /// A value without a meaning.
    Value(i64),
    /// A value that should be an integer, or of a size that fits.
    Real(String),
    /// Columns or fields that cannot be assigned to those of events, with the reason.
    Columns(String),
    /// It unpacks to more than archives may.
    TooLarge {
        /// Bytes that it and the arrays before it unpack to.
        bytes: u64,
        /// Bytes that they may.
        limit: u64,
    },
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
            Self::TooLarge { bytes, limit } => write!(
                f,
                "it unpacks to {bytes} bytes, and an archive of this length to {limit} at most: \
                 unpack it, or split it"
            ),
            Self::Trailing => f.write_str("more data than its shape says"),
            Self::Length { got, of } => write!(f, "{got} values, but `t` has {of}"),
        }
    }
}
