//! Faults of `.meta` files.

use std::fmt;

use evpose_pose::PARAMETERS;

/// Maximal count of values of a record: a larger count is a corrupt file, not a reason to allocate.
pub(super) const MAX_VALUES: usize = 1 << 16;

/// A fault of a `.meta` file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MetaFault {
    /// The file ends inside the count.
    NoCount {
        /// Bytes of the count in the file, of four.
        bytes: u64,
    },
    /// A count that no label has.
    Count(i32),
    /// A record does not end with the magic bytes.
    Magic([u8; 2]),
    /// The file ends inside a record.
    Truncated {
        /// Bytes of the record in the file.
        bytes: u64,
        /// Bytes of a whole record.
        of: u64,
    },
    /// A value is not a number, or infinite.
    NotFinite {
        /// Index of the value in the record.
        value: usize,
    },
    /// Hands were asked for, and the records hold something else.
    NotAHand {
        /// Values of a record.
        values: usize,
    },
}

impl fmt::Display for MetaFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NoCount { bytes } => write!(f, "the file ends {bytes} bytes into the count"),
            Self::Count(n) => write!(f, "{n} values a record is not within 1 to {MAX_VALUES}"),
            Self::Magic([a, b]) => write!(f, "a record ends with {a}, {b} instead of 4, 13"),
            Self::Truncated { bytes, of } => {
                write!(f, "the file ends {bytes} bytes into a record of {of}")
            }
            Self::NotFinite { value } => write!(f, "value {value} of the record is not finite"),
            Self::NotAHand { values } => {
                write!(f, "records of {values} values are no hands, which have {PARAMETERS}")
            }
        }
    }
}
