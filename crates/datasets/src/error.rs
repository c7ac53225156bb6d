//! What can be wrong with a data set.

use std::path::PathBuf;

use crate::mat::MatError;

/// A data set that cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// A file cannot be read or written.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// Why not.
        source: std::io::Error,
    },
    /// A file does not hold what its format says.
    #[error("{}: {place}: {reason}", path.display())]
    Malformed {
        /// Which.
        path: PathBuf,
        /// The field, the line or the byte.
        place: String,
        /// What is wrong and what was expected.
        reason: String,
    },
    /// A MAT-file cannot be read, or does not hold what is expected.
    #[error("{}: {source}", path.display())]
    Mat {
        /// Which.
        path: PathBuf,
        /// Where and what.
        source: MatError,
    },
}

impl DatasetError {
    /// What is wrong with the file at `path`.
    pub(crate) fn malformed(
        path: impl Into<PathBuf>,
        place: impl Into<String>,
        reason: impl Into<String>,
    ) -> Self {
        Self::Malformed { path: path.into(), place: place.into(), reason: reason.into() }
    }
}
