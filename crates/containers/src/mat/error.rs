//! Errors of MAT-files and of requests for their values.

use std::fmt;

use crate::mat::MatClass;

/// A byte of a MAT-file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MatPosition {
    /// Byte of the file; of a compressed element, its beginning.
    pub byte: usize,
    /// Byte within the inflated content of the compressed element there, if that is meant.
    pub inflated_byte: Option<usize>,
}

impl fmt::Display for MatPosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.inflated_byte {
            None => write!(f, "byte {}", self.byte),
            Some(inside) => {
                write!(f, "byte {inside} of what is compressed at byte {}", self.byte)
            }
        }
    }
}

/// A MAT-file that cannot be read, or that does not hold the requested value.
///
/// Paths are written as MATLAB takes them, which counts from one: `RELEASE.annolist(12).annorect`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MatError {
    /// Not a MAT-file.
    #[error("this is no MAT-file: it has no header of 128 bytes that ends in `IM` or `MI`")]
    NotMat,
    /// A MAT-file of version 7.3, which is an HDF5 file.
    #[error(
        "this MAT-file is of version 7.3 (HDF5), of which only 5 to 7.2 are read: in MATLAB, \
         `s = load('FILE.mat'); save('NEW.mat', '-struct', 's', '-v7')` saves it so"
    )]
    Version73,
    /// A MAT-file of version 4.
    #[error(
        "this MAT-file is of version 4, of which only 5 to 7.2 are read: in MATLAB, \
         `s = load('FILE.mat'); save('NEW.mat', '-struct', 's', '-v7')` saves it so"
    )]
    Version4,
    /// Bytes that violate the format.
    #[error("{at}: {reason}")]
    Malformed {
        /// Position of the fault.
        at: MatPosition,
        /// The fault, and the expected content.
        reason: String,
    },
    /// Arrays nested deeper than any program writes.
    #[error("{at}: arrays are nested more than {limit} deep")]
    TooDeep {
        /// Position of the innermost array.
        at: MatPosition,
        /// Maximal depth.
        limit: usize,
    },
    /// Inflated content beyond the limit.
    #[error("byte {byte}: what is compressed here and before takes more than {limit} bytes")]
    TooLarge {
        /// Byte of the file.
        byte: usize,
        /// Maximal count of inflated bytes.
        limit: u64,
    },
    /// A request for a variable that the file lacks.
    #[error("there is no variable `{name}`: there are {known}")]
    NoVariable {
        /// The requested name.
        name: String,
        /// Names of the variables of the file.
        known: String,
    },
    /// A request for a field that the structure lacks.
    #[error("{path} has no field `{field}`: it has {known}")]
    NoField {
        /// Path of the structure.
        path: String,
        /// The requested name.
        field: String,
        /// Names of the fields of the structure.
        known: String,
    },
    /// A request for an element behind the last.
    #[error("{path} has no element {position}: it has {length}")]
    NoElement {
        /// Path of the array.
        path: String,
        /// The requested element, counted from one.
        position: usize,
        /// Count of elements of the array.
        length: usize,
    },
    /// A value of another kind than requested.
    #[error("{path}: expected {expected}, found {actual}")]
    Kind {
        /// Path of the value.
        path: String,
        /// Requested kind.
        expected: &'static str,
        /// Class and dimensions of the value.
        actual: String,
    },
    /// An array of a class whose content is not read.
    #[error("{path} is {class}, which is not read: save its content as a plain array or structure")]
    Unsupported {
        /// Path of the value.
        path: String,
        /// Class of the array.
        class: MatClass,
    },
}
