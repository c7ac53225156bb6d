//! Faults of NumPy arrays.

/// A fault of an array.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NpzFault {
    /// Its header or its compressed data cannot be read.
    #[error("{0}")]
    Unreadable(String),
    /// A column has several dimensions, or a scalar several values.
    #[error("not the shape of a column, or of a scalar")]
    Shape,
    /// Values that are not numeric.
    #[error("values of type {0}, expected integers, f4, f8 or bool")]
    Type(String),
    /// A value without a meaning.
    #[error("the value {0} has no meaning")]
    Value(i64),
    /// A value that should be an integer, or of a size that fits.
    #[error("{0} should be an integer")]
    Real(String),
    /// Columns or fields that cannot be assigned to those of events, with the reason.
    #[error("{0}")]
    Columns(String),
    /// It unpacks to more than archives may.
    #[error(
        "it unpacks to {bytes} bytes, and an archive of this length to {limit} at most: unpack it, or \
         split it"
    )]
    TooLarge {
        /// Bytes that it and the arrays before it unpack to.
        bytes: u64,
        /// Bytes that they may.
        limit: u64,
    },
    /// There is more than its shape says.
    #[error("more data than its shape says")]
    Trailing,
    /// Its length differs from that of `t`.
    #[error("{got} values, but `t` has {of}")]
    Length {
        /// Values it has.
        got: usize,
        /// Values of `t`.
        of: usize,
    },
}
