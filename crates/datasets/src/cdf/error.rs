//! What can be wrong with a CDF file, or with what is asked of it.

/// A CDF file that cannot be read, or that does not hold what is asked of it.
///
/// Bytes count from the beginning of the file; of a compressed one, of what it decompresses to.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CdfError {
    /// No CDF file.
    #[error("this is no CDF file: it does not begin with CDF30001")]
    NotCdf,
    /// A CDF file of version 2.
    #[error(
        "this CDF file is of version 2, of which only 3 is read: NASA's `cdfconvert FILE NEW` makes one"
    )]
    Version2,
    /// The file does not hold what its format says.
    #[error("byte {byte}: {reason}")]
    Malformed {
        /// Where.
        byte: u64,
        /// What is wrong and what was expected.
        reason: String,
    },
    /// Something that the format knows and that is not read.
    #[error("byte {byte}: {what}, which is not read: {instead}")]
    Unsupported {
        /// Where.
        byte: u64,
        /// What it is.
        what: String,
        /// What is read.
        instead: &'static str,
    },
    /// More bytes than may be taken.
    #[error("byte {byte}: {what} takes more than {limit} bytes")]
    TooLarge {
        /// Where.
        byte: u64,
        /// What is so large.
        what: String,
        /// How many there may be.
        limit: u64,
    },
    /// A variable that is not in the file.
    #[error("there is no variable `{name}`: there are {known}")]
    NoVariable {
        /// Its name.
        name: String,
        /// Those that are there.
        known: String,
    },
}

impl CdfError {
    pub(super) fn malformed(byte: u64, reason: impl Into<String>) -> Self {
        Self::Malformed { byte, reason: reason.into() }
    }
}
