//! What can go wrong with a simulation.

use std::path::PathBuf;

use evpose_io::IoError;
use evpose_sensor::SensorError;

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
        source: std::io::Error,
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
    /// The sensor refuses its configuration.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// A sequence cannot be written.
    #[error(transparent)]
    Io(#[from] IoError),
}
