//! Errors of reading a body model file, with their remedies.

use std::io;
use std::path::PathBuf;

use evpose_containers::pickle::{ArrayError, PickleError};

/// Error of reading a body model file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelFileError {
    /// The operating system refused access.
    #[error("{}: cannot read", path.display())]
    File {
        /// File that was refused.
        path: PathBuf,
        /// Cause of the failure.
        source: io::Error,
    },
    /// The file is too large for a model.
    #[error("{}: {bytes} bytes; files of hand and body models have up to {max}", path.display())]
    TooLong {
        /// File that is too large.
        path: PathBuf,
        /// Size of the file.
        bytes: u64,
        /// Largest size that is read.
        max: u64,
    },
    /// The file is not a body model.
    #[error(
        "{}: no model of a hand or body ({reason}); expected MANO_RIGHT.pkl, MANO_LEFT.pkl, \
         SMPLH_male.pkl, SMPLH_female.pkl, or the same arrays in an .npz file", path.display()
    )]
    NotAModel {
        /// File that should be a model.
        path: PathBuf,
        /// Evidence against it.
        reason: String,
    },
    /// A pickle, the format of `.pkl` files, is damaged or cut off.
    #[error("{}: the file has {bytes} bytes; if it is cut off, copy it again", path.display())]
    Pickle {
        /// Path of the pickle.
        path: PathBuf,
        /// Size of the file.
        bytes: usize,
        /// Defect and its position.
        source: PickleError,
    },
    /// A NumPy archive is damaged or cut off.
    #[error(
        "{}: byte {byte}: {reason}; if the file is cut off, copy it again", path.display()
    )]
    Archive {
        /// The archive of arrays.
        path: PathBuf,
        /// Position of the defect; the end of the file if the central directory is missing.
        byte: u64,
        /// Defect.
        reason: String,
    },
    /// A required field is missing.
    #[error("{}: no field `{field}`: {why} (available: {})", path.display(), available.join(", "))]
    Missing {
        /// File without the field.
        path: PathBuf,
        /// The missing field.
        field: &'static str,
        /// Purpose of the field.
        why: &'static str,
        /// Fields of the file.
        available: Vec<String>,
    },
    /// A field is malformed.
    #[error("{}: field `{field}`: {fault}", path.display())]
    Field {
        /// File that the field is in.
        path: PathBuf,
        /// Name of the malformed field.
        field: &'static str,
        /// Defect of the field.
        fault: FieldFault,
    },
}

/// Defect of a field.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldFault {
    /// Not a numeric array, or a damaged one.
    #[error(transparent)]
    Array(#[from] ArrayError),
    /// Wrong shape.
    #[error("of shape {actual:?}, expected {expected}")]
    Shape {
        /// Shape that this model requires.
        expected: String,
        /// Shape of the array.
        actual: Vec<usize>,
    },
    /// A value that is not finite or too large.
    #[error("value {index} is {value}, which is no length, weight or angle")]
    Value {
        /// Row-major index of the value.
        index: usize,
        /// Value as it is in the file.
        value: f64,
    },
    /// An index of a vertex that does not exist.
    #[error("value {index} is {value}, expected a whole number from 0 to {last}")]
    Index {
        /// Row-major index of the value.
        index: usize,
        /// Index as it is in the file.
        value: f64,
        /// Largest valid index.
        last: usize,
    },
    /// Skin weights of a vertex that do not sum to one.
    #[error("the weights of vertex {vertex} have sum {sum}, expected 1")]
    Sum {
        /// Index of the vertex.
        vertex: usize,
        /// Their sum.
        sum: f64,
    },
    /// A kinematic tree other than the published one.
    #[error("joint {joint} hangs on another joint than in the published model")]
    Tree {
        /// Index of the joint in the kinematic tree.
        joint: usize,
    },
}
