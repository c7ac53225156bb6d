//! What can go wrong with a simulation.

use std::io;
use std::path::{Path, PathBuf};

use evpose_io::IoError;
use evpose_sensor::SensorError;

use crate::set::Fault;

/// A simulation that cannot be set up or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// A value of the configuration that makes no sense.
    #[error("simulation.{field} = {value}: {reason}")]
    Config {
        /// The field, with dots.
        field: &'static str,
        /// What it is set to.
        value: String,
        /// What it should be.
        reason: &'static str,
    },
    /// A configuration that is not one.
    #[error("not a simulation: {0}")]
    Toml(#[from] toml::de::Error),
    /// The folder of backgrounds cannot be read.
    #[error("{}: cannot read the folder of backgrounds", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// The folder of backgrounds holds no picture.
    #[error("{}: no .png, .jpg or .jpeg in the folder of backgrounds", path.display())]
    NoPictures {
        /// The folder.
        path: PathBuf,
    },
    /// A background picture cannot be read.
    #[error("{}: cannot read the picture", path.display())]
    Picture {
        /// The picture.
        path: PathBuf,
        /// Why not.
        source: image::ImageError,
    },
    /// A file of texture coordinates that is not one of its model.
    #[error("{}: {reason}", path.display())]
    TextureCoordinates {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A file of the skin model that cannot be read.
    #[error("{}: {reason}", path.display())]
    SkinFile {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// The model of hand and arm cannot be read.
    #[error(transparent)]
    Model(#[from] evpose_body::files::ModelFileError),
    /// The text file beside a sequence cannot be read or written.
    #[error("{}: {reason}", path.display())]
    SequenceInfo {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// A part of a run that is none.
    #[error("`{text}` is no shard: write I/N with I from 1 to N, for example 3/64")]
    Shard {
        /// What was given.
        text: String,
    },
    /// A file of a set of sequences, or their directory, that the operating system refused.
    #[error("{}: cannot {action}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What was tried, an infinitive.
        action: &'static str,
        /// Why not.
        source: io::Error,
    },
    /// A list of digests that is damaged.
    #[error("{}: line {line}: {reason}", path.display())]
    Manifest {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// Files of a set of sequences are not as they were recorded.
    #[error(
        "{}: files not as recorded: {} ({files} have a digest){}", directory.display(), faults.len(),
        faults.iter().map(|fault| format!("\n  {fault}")).collect::<String>()
    )]
    Damaged {
        /// The directory.
        directory: PathBuf,
        /// Files with a digest.
        files: usize,
        /// Every file that is not as it should be.
        faults: Vec<Fault>,
    },
    /// An activity that nobody does.
    #[error("simulation.activities: nobody knows how to do `{name}`; there are {}", known.join(", "))]
    UnknownActivity {
        /// What was written.
        name: String,
        /// What there is.
        known: Vec<&'static str>,
    },
    /// A model file of something else than a whole body.
    #[error("{}: people need a whole body (SMPL+H), not a hand", path.display())]
    NotABody {
        /// The file.
        path: PathBuf,
    },
    /// A table of poses that is damaged.
    #[error("{}: line {line}: {reason}", path.display())]
    Poses {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it.
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
