//! Errors of a glTF file, with its path.

use std::path::Path;

use crate::files::{FieldFault, ModelFileError};

/// Constructor of errors about one file.
pub(super) struct Faults<'a> {
    pub(super) path: &'a Path,
}

impl Faults<'_> {
    /// The file is not a hand.
    pub(super) fn not_a_model(&self, reason: &str) -> ModelFileError {
        ModelFileError::NotAModel { path: self.path.to_owned(), reason: reason.to_owned() }
    }

    /// A field is malformed.
    pub(super) fn in_field(&self, field: &'static str, fault: FieldFault) -> ModelFileError {
        ModelFileError::Field { path: self.path.to_owned(), field, fault }
    }
}
