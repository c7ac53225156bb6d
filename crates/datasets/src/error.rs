//! What can be wrong with a data set.

use std::path::PathBuf;

use evpose_cdf::CdfError;
use evpose_io::IoError;
use evpose_mat::MatError;
use evpose_sensor::SensorError;

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
    /// A CDF file cannot be read, or does not hold what is expected.
    #[error("{}: {source}", path.display())]
    Cdf {
        /// Which.
        path: PathBuf,
        /// Where and what.
        source: CdfError,
    },
    /// A sensor cannot be built, or not be shown the frames.
    #[error("{}: {source}", path.display())]
    Sensor {
        /// Where the frames are.
        path: PathBuf,
        /// Why not.
        source: SensorError,
    },
    /// A recording, a log or frames cannot be read.
    #[error(transparent)]
    Recording(#[from] IoError),
}

impl DatasetError {
    /// What is wrong with the CDF file at `path`.
    pub(crate) fn cdf(path: impl Into<PathBuf>) -> impl Fn(CdfError) -> Self {
        let path = path.into();
        move |source| Self::Cdf { path: path.clone(), source }
    }

    /// What is wrong with what the MAT-file at `path` holds.
    pub(crate) fn mat(path: impl Into<PathBuf>) -> impl Fn(MatError) -> Self {
        let path = path.into();
        move |source| Self::Mat { path: path.clone(), source }
    }

    /// What is wrong with the file at `path`.
    pub(crate) fn malformed(
        path: impl Into<PathBuf>,
        place: impl Into<String>,
        reason: impl Into<String>,
    ) -> Self {
        Self::Malformed { path: path.into(), place: place.into(), reason: reason.into() }
    }
}
