//! Differences between a set of sequences and its digests.

use std::fmt;
use std::path::PathBuf;

/// A file that differs from its digest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DigestMismatch {
    /// Path of the file.
    pub path: PathBuf,
    /// Kind of the difference.
    pub kind: MismatchKind,
}

/// Kind of difference between a file and its digest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MismatchKind {
    /// The file does not exist.
    Missing,
    /// The file has other contents.
    Changed,
    /// The file has no digest, and readers would take it for a sequence of the set.
    Unlisted,
}

impl fmt::Display for DigestMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let problem = match self.kind {
            MismatchKind::Missing => "is missing",
            MismatchKind::Changed => "is not what was recorded",
            MismatchKind::Unlisted => "has no digest: unfinished, or not of this set",
        };
        write!(f, "{} {problem}", self.path.display())
    }
}
