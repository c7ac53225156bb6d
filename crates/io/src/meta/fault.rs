//! Faults of `.meta` files.

use evpose_pose::PARAMETERS;

/// Maximal count of values of a record: a larger count is a corrupt file, not a reason to allocate.
pub(super) const MAX_VALUES: usize = 1 << 16;

/// A fault of a `.meta` file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MetaFault {
    /// The file ends inside the count.
    #[error("the file ends {bytes} bytes into the count")]
    NoCount {
        /// Bytes of the count in the file, of four.
        bytes: u64,
    },
    /// A count that no label has.
    #[error("{0} values a record is not within 1 to {max}", max = MAX_VALUES)]
    Count(i32),
    /// A record does not end with the magic bytes.
    #[error("a record ends with {}, {} instead of 4, 13", .0[0], .0[1])]
    Magic([u8; 2]),
    /// The file ends inside a record.
    #[error("the file ends {bytes} bytes into a record of {of}")]
    Truncated {
        /// Bytes of the record in the file.
        bytes: u64,
        /// Bytes of a whole record.
        of: u64,
    },
    /// A value is not a number, or infinite.
    #[error("value {value} of the record is not finite")]
    NotFinite {
        /// Index of the value in the record.
        value: usize,
    },
    /// Hands were asked for, and the records hold something else.
    #[error("records of {values} values are no hands, which have {}", PARAMETERS)]
    NotAHand {
        /// Values of a record.
        values: usize,
    },
}
