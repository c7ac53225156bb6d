//! What can be wrong with a MAT-file, or with what is asked of it.

use std::fmt;

use super::MatClass;

/// A byte of a MAT-file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MatPosition {
    /// The byte of the file; of a compressed element, where it begins.
    pub byte: usize,
    /// The byte of what the compressed element there holds, if that is meant.
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

/// A MAT-file that cannot be read, or that does not hold what is asked of it.
///
/// Paths are written as MATLAB takes them, which counts from one: `RELEASE.annolist(12).annorect`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MatError {
    /// No MAT-file.
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
    /// The file does not hold what its format says.
    #[error("{at}: {reason}")]
    Malformed {
        /// Where.
        at: MatPosition,
        /// What is wrong and what was expected.
        reason: String,
    },
    /// Arrays in arrays in arrays, more than any program writes.
    #[error("{at}: arrays are nested more than {limit} deep")]
    TooDeep {
        /// Where.
        at: MatPosition,
        /// How deep they may be.
        limit: usize,
    },
    /// More bytes than may be taken.
    #[error("byte {byte}: what is compressed here and before takes more than {limit} bytes")]
    TooLarge {
        /// The byte of the file.
        byte: usize,
        /// How many there may be.
        limit: u64,
    },
    /// A variable that is not in the file.
    #[error("there is no variable `{name}`: there are {known}")]
    NoVariable {
        /// Its name.
        name: String,
        /// Those that are there.
        known: String,
    },
    /// A field that is not in a structure.
    #[error("{path} has no field `{field}`: it has {known}")]
    NoField {
        /// The structure.
        path: String,
        /// Its name.
        field: String,
        /// Those that are there.
        known: String,
    },
    /// An element behind the last.
    #[error("{path} has no element {number}: it has {length}")]
    NoElement {
        /// The array.
        path: String,
        /// Which, from one.
        number: usize,
        /// How many it has.
        length: usize,
    },
    /// A value that is not of the kind that is asked for.
    #[error("{path}: expected {expected}, found {found}")]
    Kind {
        /// The value.
        path: String,
        /// What it should be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// An array of a class that is not read.
    #[error("{path} is {class}, which is not read: save its content as a plain array or structure")]
    Unsupported {
        /// The value.
        path: String,
        /// Of which class.
        class: MatClass,
    },
}
