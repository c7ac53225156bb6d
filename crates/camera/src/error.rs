//! Errors of reading calibrations.

use std::io;
use std::path::PathBuf;

/// Error of reading or naming a calibration.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// The file cannot be read.
    #[error("{}: cannot read the calibration", path.display())]
    File {
        /// File that was refused.
        path: PathBuf,
        /// Cause of the failure.
        source: io::Error,
    },
    /// The file is no calibration.
    #[error("{}: {reason}", path.display())]
    Malformed {
        /// File that violates its format.
        path: PathBuf,
        /// Defect of the file, with the field.
        reason: String,
    },
    /// Values are those of no camera.
    #[error("{reason}")]
    Invalid {
        /// The fault, with its field.
        reason: String,
    },
    /// The text is neither a file, nor a camera's name, nor a field of view.
    #[error(
        "no camera `{text}`: expected a calibration file (OpenCV's, ROS's, kalibr's, DSEC's or rpg's .yaml, OpenCV's .xml, \
         dv-processing's .json, this project's .toml), a vertical field of view such as 45deg, or one \
         of {}", known.join(", ")
    )]
    Unknown {
        /// Rejected text.
        text: String,
        /// Names of cameras.
        known: Vec<&'static str>,
    },
}
