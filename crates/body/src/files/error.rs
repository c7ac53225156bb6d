//! What can be wrong with a file of a body model, and what to do about it.

use std::io;
use std::path::PathBuf;

use evpose_pickle::{ArrayError, PickleError};

/// A file of a body model that cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelFileError {
    /// The operating system refused.
    #[error("{}: cannot read", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// It is too long for a model.
    #[error("{}: {bytes} bytes; files of hand and body models have up to {most}", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Its length.
        bytes: u64,
        /// The length that is read.
        most: u64,
    },
    /// It is of another kind.
    #[error(
        "{}: no model of a hand or body ({reason}); expected MANO_RIGHT.pkl, MANO_LEFT.pkl, \
         SMPLH_male.pkl, SMPLH_female.pkl, or the same arrays in an .npz file", path.display()
    )]
    NotAModel {
        /// The file.
        path: PathBuf,
        /// What speaks against it.
        reason: String,
    },
    /// A pickle, the format of `.pkl` files, is damaged or cut off.
    #[error("{}: the file has {bytes} bytes; if it is cut off, copy it again", path.display())]
    Pickle {
        /// The file.
        path: PathBuf,
        /// Its length.
        bytes: usize,
        /// What is wrong, and where.
        source: PickleError,
    },
    /// A NumPy archive is damaged or cut off.
    #[error(
        "{}: byte {byte}: {reason}; if the file is cut off, copy it again", path.display()
    )]
    Archive {
        /// The file.
        path: PathBuf,
        /// Where it was noticed; the end of the file if its directory, at the end, is missing.
        byte: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// It lacks something no model does without.
    #[error("{}: no field `{field}`: {why} (found: {})", path.display(), found.join(", "))]
    Missing {
        /// The file.
        path: PathBuf,
        /// What is missing.
        field: &'static str,
        /// What it is for.
        why: &'static str,
        /// What is there.
        found: Vec<String>,
    },
    /// A field does not hold what it should.
    #[error("{}: field `{field}`: {fault}", path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// The field.
        field: &'static str,
        /// What is wrong with it.
        fault: FieldFault,
    },
}

/// What is wrong with a field.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldFault {
    /// It is no array of numbers, or a damaged one.
    #[error(transparent)]
    Array(#[from] ArrayError),
    /// It has other lengths.
    #[error("of shape {found:?}, expected {expected}")]
    Shape {
        /// What this model should have.
        expected: String,
        /// What it has.
        found: Vec<usize>,
    },
    /// A number that is none, or too large.
    #[error("value {index} is {value}, which is no length, weight or angle")]
    Value {
        /// Its place, row by row.
        index: usize,
        /// The number.
        value: f64,
    },
    /// A number of a vertex that does not exist.
    #[error("value {index} is {value}, expected a whole number from 0 to {last}")]
    Index {
        /// Its place, row by row.
        index: usize,
        /// The number.
        value: f64,
        /// The last that exists.
        last: usize,
    },
    /// Weights of a vertex that do not make a whole.
    #[error("the weights of vertex {vertex} have sum {sum}, expected 1")]
    Sum {
        /// The vertex.
        vertex: usize,
        /// Their sum.
        sum: f64,
    },
    /// Joints that hang together in another way.
    #[error("joint {joint} hangs on another joint than in the published model")]
    Tree {
        /// The joint.
        joint: usize,
    },
}
