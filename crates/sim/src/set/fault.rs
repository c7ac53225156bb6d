//! Differences between a set of sequences and its digests.

use std::path::PathBuf;

/// A file that differs from its digest.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{} {kind}", path.display())]
pub struct DigestMismatch {
    /// Path of the file.
    pub path: PathBuf,
    /// Kind of the difference.
    pub kind: MismatchKind,
}

/// Kind of difference between a file and its digest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MismatchKind {
    /// The file does not exist.
    #[error("is missing")]
    Missing,
    /// The file has other contents.
    #[error("is not what was recorded")]
    Changed,
    /// The file has no digest, and readers would take it for a sequence of the set.
    #[error("has no digest: unfinished, or not of this set")]
    Unlisted,
}
