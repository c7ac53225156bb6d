//! What can be wrong with the inputs of the workflow.

use std::path::{Path, PathBuf};

use evpose_io::IoError;
use evpose_sensor::SensorError;

/// An input that cannot be compared, or a model that cannot be simulated.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GapError {
    /// The scene cannot be used.
    #[error("scene: {0}")]
    Scene(String),
    /// The recording cannot be used.
    #[error("recording: {0}")]
    Recording(String),
    /// The sensor model cannot be built or shown the scene.
    #[error("sensor model: {0}")]
    Sensor(#[from] SensorError),
    /// A file of events or frames cannot be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A file cannot be read.
    #[error("{}: cannot be read", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// A recording has no frames that could be its scene.
    #[error(
        "{}: {problem}: give the light that it saw (--scene DIR), or compare it alone (--scene none)",
        path.display()
    )]
    NoFrames {
        /// The file.
        path: PathBuf,
        /// What there is instead.
        problem: String,
    },
    /// The frames of a recording cannot be its scene.
    #[error("frames of {}: {problem}", path.display())]
    Frames {
        /// The file.
        path: PathBuf,
        /// What is wrong with them.
        problem: String,
    },
    /// A file is not the JSON it should be.
    #[error("{}: {problem}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        problem: String,
    },
    /// A field of a JSON file is missing or means nothing.
    #[error("{}: field `{field}`: {problem}", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// The field, with those it lies in.
        field: String,
        /// What is wrong with it.
        problem: String,
    },
}

impl GapError {
    pub(crate) fn json(path: &Path, problem: impl Into<String>) -> Self {
        Self::Json { path: path.to_owned(), problem: problem.into() }
    }
}
