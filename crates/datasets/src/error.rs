//! Errors of data sets.

use std::path::PathBuf;

use evpose_containers::cdf::CdfError;
use evpose_containers::mat::MatError;
use evpose_io::IoError;
use evpose_sensor::SensorError;

/// A data set that cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// A file cannot be read or written.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// File that was refused.
        path: PathBuf,
        /// The failed action, an infinitive.
        action: &'static str,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A file that violates its format.
    #[error("{}: {place}: {reason}", path.display())]
    Malformed {
        /// File that violates its format.
        path: PathBuf,
        /// The field, the line or the byte.
        place: String,
        /// The fault, and the expected content.
        reason: String,
    },
    /// A MAT-file cannot be read, or does not hold what is expected.
    #[error("{}: {source}", path.display())]
    Mat {
        /// The MAT-file.
        path: PathBuf,
        /// The error, with its position.
        source: MatError,
    },
    /// A CDF file cannot be read, or does not hold what is expected.
    #[error("{}: {source}", path.display())]
    Cdf {
        /// The CDF file.
        path: PathBuf,
        /// The error, with its position.
        source: CdfError,
    },
    /// A sensor cannot be built, or not be shown the frames.
    #[error("{}: {source}", path.display())]
    Sensor {
        /// The folder of the frames.
        path: PathBuf,
        /// Error of the sensor model.
        source: SensorError,
    },
    /// A recording, a log or frames cannot be read.
    #[error(transparent)]
    Recording(#[from] IoError),
}

impl DatasetError {
    /// Adds the path of the file to errors of CDF files.
    pub(crate) fn cdf(path: impl Into<PathBuf>) -> impl Fn(CdfError) -> Self {
        let path = path.into();
        move |source| Self::Cdf { path: path.clone(), source }
    }

    /// Adds the path of the file to errors of MAT-files.
    pub(crate) fn mat(path: impl Into<PathBuf>) -> impl Fn(MatError) -> Self {
        let path = path.into();
        move |source| Self::Mat { path: path.clone(), source }
    }

    /// Adds the path of the file, the line and the column to errors of JSON.
    pub fn json(path: impl Into<PathBuf>) -> impl FnOnce(serde_json::Error) -> Self {
        let path = path.into();
        move |error| {
            let place = format!("line {} column {}", error.line(), error.column());
            let reason = error.to_string();
            // It ends with the place.
            let reason = reason.split(" at line ").next().unwrap_or_default();
            Self::malformed(path, place, reason)
        }
    }

    /// Adds path and action to an error of the file system.
    pub(crate) fn io(
        path: impl Into<PathBuf>,
        action: &'static str,
    ) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::Io { path, action, source }
    }

    /// The error for a fault in the file at `path`.
    pub(crate) fn malformed(
        path: impl Into<PathBuf>,
        place: impl Into<String>,
        reason: impl Into<String>,
    ) -> Self {
        Self::Malformed { path: path.into(), place: place.into(), reason: reason.into() }
    }
}
