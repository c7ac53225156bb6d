//! Errors of CDF files and of requests for their values.

/// A CDF file that cannot be read, or that does not hold the requested variable.
///
/// Bytes count from the beginning of the file; of a compressed one, of what it decompresses to.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CdfError {
    /// Not a CDF file.
    #[error("this is no CDF file: it does not begin with CDF30001")]
    NotCdf,
    /// A CDF file of version 2.
    #[error(
        "this CDF file is of version 2, of which only 3 is read: NASA's `cdfconvert FILE NEW` makes one"
    )]
    Version2,
    /// Bytes that violate the format.
    #[error("byte {byte}: {reason}")]
    Malformed {
        /// Byte of the fault.
        byte: u64,
        /// The fault, and the expected content.
        reason: String,
    },
    /// A feature of the format that is not read.
    #[error("byte {byte}: {what}, which is not read: {instead}")]
    Unsupported {
        /// Byte of the fault.
        byte: u64,
        /// Name of the feature.
        what: String,
        /// The supported alternative.
        instead: &'static str,
    },
    /// Content beyond the limit.
    #[error("byte {byte}: {what} takes more than {limit} bytes")]
    TooLarge {
        /// Byte of the fault.
        byte: u64,
        /// The content that is too large.
        what: String,
        /// Maximal count of bytes.
        limit: u64,
    },
    /// A request for a variable that the file lacks.
    #[error("there is no variable `{name}`: there are {known}")]
    NoVariable {
        /// The requested name.
        name: String,
        /// Names of the variables of the file.
        known: String,
    },
}

impl CdfError {
    pub(crate) fn malformed(byte: u64, reason: impl Into<String>) -> Self {
        Self::Malformed { byte, reason: reason.into() }
    }
}
