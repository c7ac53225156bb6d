//! Errors of configuring, running and recording a simulation.

use std::io;
use std::path::{Path, PathBuf};

use evpose_io::IoError;
use evpose_sensor::SensorError;

use crate::set::DigestMismatch;

/// Error of configuring, running or recording a simulation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// A value of the configuration is out of its range.
    #[error("simulation.{field} = {value}: {reason}")]
    Config {
        /// Path of the field, with dots.
        field: &'static str,
        /// Configured value.
        value: String,
        /// Violated constraint.
        reason: &'static str,
    },
    /// The TOML text is not a simulation configuration.
    #[error("not a simulation: {0}")]
    Toml(#[from] toml::de::Error),
    /// A file of ranges is malformed, or an entry does not fit the configuration.
    #[error("{}: {reason}", path.display())]
    Randomisation {
        /// The file of ranges.
        path: PathBuf,
        /// Defect of the file, with the field.
        reason: String,
    },
    /// The folder of backgrounds cannot be read.
    #[error("{}: cannot read the folder of backgrounds", path.display())]
    Folder {
        /// Path of the folder.
        path: PathBuf,
        /// Cause of the failure.
        source: io::Error,
    },
    /// The folder of backgrounds has no image files.
    #[error("{}: no .png, .jpg or .jpeg in the folder of backgrounds", path.display())]
    NoImages {
        /// Path of the folder.
        path: PathBuf,
    },
    /// A background image cannot be read.
    #[error("{}: cannot read the image", path.display())]
    Image {
        /// The image file.
        path: PathBuf,
        /// Cause of the failure.
        source: image::ImageError,
    },
    /// A file of texture coordinates does not fit its model.
    #[error("{}: {reason}", path.display())]
    TextureCoordinates {
        /// The file of texture coordinates.
        path: PathBuf,
        /// Defect of the file.
        reason: String,
    },
    /// A file of the skin model cannot be read.
    #[error("{}: {reason}", path.display())]
    SkinFile {
        /// The file of the skin model.
        path: PathBuf,
        /// Cause of the failure.
        reason: String,
    },
    /// The model of hand and arm cannot be read.
    #[error(transparent)]
    Model(#[from] evpose_body::files::ModelFileError),
    /// A folder of MakeHuman's files, or of captured motion, cannot be read.
    #[error(transparent)]
    Human(#[from] evpose_body::FolderError),
    /// The text file beside a sequence cannot be read or written.
    #[error("{}: {reason}", path.display())]
    SequenceInfo {
        /// The text file beside the sequence.
        path: PathBuf,
        /// Cause of the failure.
        reason: String,
    },
    /// The text is not a shard.
    #[error("`{text}` is no shard: write I/N with I from 1 to N, for example 3/64")]
    Shard {
        /// Rejected text.
        text: String,
    },
    /// The operating system refused access to a file of a set of sequences, or to its directory.
    #[error("{}: cannot {action}", path.display())]
    File {
        /// File that was refused.
        path: PathBuf,
        /// Attempted action, an infinitive.
        action: &'static str,
        /// Cause of the failure.
        source: io::Error,
    },
    /// A list of digests is malformed.
    #[error("{}: line {line}: {reason}", path.display())]
    Manifest {
        /// The list of digests.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// Defect of the file.
        reason: &'static str,
    },
    /// Files of a set of sequences differ from their digests.
    #[error(
        "{}: files not as recorded: {} ({files} have a digest){}", directory.display(), faults.len(),
        faults.iter().map(|fault| format!("\n  {fault}")).collect::<String>()
    )]
    Damaged {
        /// Path of the directory.
        directory: PathBuf,
        /// Number of files with a digest.
        files: usize,
        /// All files that differ.
        faults: Vec<DigestMismatch>,
    },
    /// No format that can be written has that name.
    #[error("simulation.format: no format `{name}` that can be written; there are {}", known.join(", "))]
    UnknownFormat {
        /// Configured name.
        name: String,
        /// Names of all formats that can be written.
        known: Vec<&'static str>,
    },
    /// There is no activity of that name.
    #[error("simulation.activities: unknown activity `{name}`; known: {}", known.join(", "))]
    UnknownActivity {
        /// Configured name.
        name: String,
        /// Names of all activities.
        known: Vec<&'static str>,
    },
    /// The model file is of a hand, not of a whole body.
    #[error("{}: people need a whole body (SMPL+H), not a hand", path.display())]
    NotABody {
        /// The model file.
        path: PathBuf,
    },
    /// A table of poses is malformed.
    #[error("{}: line {line}: {reason}", path.display())]
    Poses {
        /// The table of poses.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// Defect of the file.
        reason: String,
    },
    /// The sensor refuses its configuration.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// A sequence cannot be written.
    #[error(transparent)]
    Io(#[from] IoError),
}

impl SimError {
    pub(crate) fn file(path: &Path, action: &'static str, source: io::Error) -> Self {
        Self::File { path: path.to_owned(), action, source }
    }
}
