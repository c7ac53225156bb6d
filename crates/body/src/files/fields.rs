//! Named arrays of a model file, whichever of the two formats it has.

use std::path::{Path, PathBuf};

use evpose_containers::pickle::{Array, ArrayError, Pickle, PickleValue, Sparse};

use super::npz::Archive;
use super::{FieldFault, ModelFileError};

/// Magic bytes of a zip archive, and of an empty one.
const ZIP: [&[u8]; 2] = [b"PK\x03\x04", b"PK\x05\x06"];
/// Largest number of fields in a message.
const MAX_LISTED: usize = 24;

/// Named arrays of a file.
pub(super) struct Fields {
    path: PathBuf,
    source: Source,
}

enum Source {
    Pickle(Pickle),
    Archive(Archive),
}

impl Fields {
    /// Opens a file, with the format detected by content.
    pub(super) fn open(path: &Path, bytes: Vec<u8>) -> Result<Self, ModelFileError> {
        let length = bytes.len();
        let source = if ZIP.iter().any(|begin| bytes.starts_with(begin)) {
            let archive = Archive::open(bytes).map_err(|error| ModelFileError::Archive {
                path: path.to_owned(),
                byte: length as u64,
                reason: error.to_string(),
            })?;
            Source::Archive(archive)
        } else {
            let pickle = Pickle::read(&bytes, 0).map_err(|source| ModelFileError::Pickle {
                path: path.to_owned(),
                bytes: length,
                source,
            })?;
            if !matches!(pickle.node(pickle.root()), PickleValue::Dict(_)) {
                let reason = "a pickle, but no dictionary of arrays".to_owned();
                return Err(ModelFileError::NotAModel { path: path.to_owned(), reason });
            }
            Source::Pickle(pickle)
        };
        Ok(Self { path: path.to_owned(), source })
    }

    /// Name of the format.
    pub(super) fn format(&self) -> &'static str {
        match self.source {
            Source::Pickle(_) => "Python pickle",
            Source::Archive(_) => "NumPy archive",
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the fields; control characters, which a terminal would act on, replaced.
    pub(super) fn names(&self) -> Vec<String> {
        let names = match &self.source {
            Source::Archive(archive) => archive.names(),
            Source::Pickle(pickle) => {
                let entries = pickle.entries(pickle.root()).iter();
                entries.filter_map(|(key, _)| pickle.text(*key).map(str::to_owned)).collect()
            }
        };
        let clean = |name: String| {
            let plain = name.chars().map(|c| if c.is_control() { '?' } else { c });
            plain.take(40).collect()
        };
        names.into_iter().take(MAX_LISTED).map(clean).collect()
    }

    /// An array that may be missing.
    pub(super) fn optional(
        &mut self,
        field: &'static str,
    ) -> Result<Option<Array>, ModelFileError> {
        let array = match &mut self.source {
            Source::Archive(archive) => archive.array(field),
            Source::Pickle(pickle) => {
                pickle.get(pickle.root(), field).map(|id| Array::read(pickle, id))
            }
        };
        array.transpose().map_err(|error| self.fault(field, error))
    }

    /// A required array; `why` is its purpose.
    pub(super) fn required(
        &mut self,
        field: &'static str,
        why: &'static str,
    ) -> Result<Array, ModelFileError> {
        let array = self.optional(field)?;
        array.ok_or_else(|| self.missing(field, why))
    }

    /// A sparse matrix; none if the field is missing or something else.
    pub(super) fn sparse(&mut self, field: &'static str) -> Result<Option<Sparse>, ModelFileError> {
        let sparse = match &mut self.source {
            Source::Archive(archive) => archive.sparse(field),
            Source::Pickle(pickle) => {
                pickle.get(pickle.root(), field).and_then(|id| Sparse::read(pickle, id))
            }
        };
        sparse.transpose().map_err(|error: ArrayError| self.fault(field, error))
    }

    pub(super) fn missing(&self, field: &'static str, why: &'static str) -> ModelFileError {
        ModelFileError::Missing { path: self.path.clone(), field, why, available: self.names() }
    }

    pub(super) fn fault(
        &self,
        field: &'static str,
        fault: impl Into<FieldFault>,
    ) -> ModelFileError {
        ModelFileError::Field { path: self.path.clone(), field, fault: fault.into() }
    }
}
