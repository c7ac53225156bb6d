//! Events as a NumPy archive, the format every Python tool reads and writes.
//!
//! | array | type written | types read | meaning |
//! |---|---|---|---|
//! | `t` | `i64` | any integer | microseconds, ascending |
//! | `x`, `y` | `u16` | any integer | column from the left, row from the top |
//! | `p` | `u8` | any integer, `bool` | 1 = ON, 0 = OFF |
//! | `width`, `height` | `i64`, a scalar | any integer | the sensor in pixels |

mod array;
mod reader;
mod writer;

use std::fmt;

pub use reader::read;
pub use writer::write;

use crate::Format;

/// The archive's entry in the registry of formats.
pub(crate) const FORMAT: Format = Format {
    name: "npz",
    summary: "NumPy archive: t, x, y, p, width, height",
    endings: &[".npz"],
    probe: |head| head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06"),
    read: |path, _sensor| read(path),
    write,
    info: crate::info::of_stream,
};

/// The arrays of an archive.
const ARRAYS: [&str; 6] = ["t", "x", "y", "p", "width", "height"];

/// What is wrong with an array.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NpzFault {
    /// Its header or its compressed data cannot be read.
    Unreadable(String),
    /// A column has several dimensions, or a scalar several values.
    Shape,
    /// Its numbers are no integers.
    Type(String),
    /// A value without a meaning.
    Value(i64),
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
            Self::Type(dtype) => write!(f, "numbers of type {dtype} are no integers"),
            Self::Value(value) => write!(f, "the value {value} has no meaning"),
            Self::Trailing => f.write_str("more data than its shape says"),
            Self::Length { got, of } => write!(f, "{got} values, but `t` has {of}"),
        }
    }
}

#[cfg(test)]
mod tests;
