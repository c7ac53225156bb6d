//! Errors of the workflow's inputs.

use std::path::{Path, PathBuf};

use evpose_io::IoError;
use evpose_sensor::SensorError;

/// An input that cannot be compared, or a model that cannot be simulated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GapError {
    /// The scene is invalid.
    #[error("scene: {0}")]
    Scene(String),
    /// The recording is invalid.
    #[error("recording: {0}")]
    Recording(String),
    /// The sensor model cannot be built or simulated on the scene.
    #[error("sensor model: {0}")]
    Sensor(#[from] SensorError),
    /// A file of events or frames cannot be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A file cannot be read.
    #[error("{}: cannot be read", path.display())]
    File {
        /// File that was refused.
        path: PathBuf,
        /// The I/O error.
        source: std::io::Error,
    },
    /// A recording has no frames that could be its scene.
    #[error(
        "{}: {problem}: give the light that it saw (--scene DIR), or compare it alone (--scene none)",
        path.display()
    )]
    NoFrames {
        /// Path of the recording.
        path: PathBuf,
        /// Description of the file's contents.
        problem: String,
    },
    /// The frames of a recording cannot be its scene.
    #[error("frames of {}: {problem}", path.display())]
    Frames {
        /// Path of the recording.
        path: PathBuf,
        /// Description of the problem.
        problem: String,
    },
    /// A file is not valid JSON of the expected form.
    #[error("{}: {problem}", path.display())]
    Json {
        /// The JSON file.
        path: PathBuf,
        /// Description of the problem, with its position.
        problem: String,
    },
    /// A field of a JSON file is missing or invalid.
    #[error("{}: field `{field}`: {problem}", path.display())]
    Field {
        /// File that the field is in.
        path: PathBuf,
        /// Path of the field, with its parents.
        field: String,
        /// Description of the problem.
        problem: String,
    },
}

impl GapError {
    pub(crate) fn json(path: &Path, problem: impl Into<String>) -> Self {
        Self::Json { path: path.to_owned(), problem: problem.into() }
    }
}
