//! A format of poses.

use std::path::Path;

use evpose_core::atomic_write;

use super::pose::PoseSequence;
use crate::IoError;

/// Writes a file of poses.
pub(super) type Write = fn(&Path, &PoseSequence) -> Result<(), IoError>;

/// A format of poses. Adding one is a file with its `FORMAT` and a line of [`POSE_FORMATS`](super::POSE_FORMATS).
#[derive(Debug)]
pub struct PoseFormat {
    /// Name, as `--format` takes it.
    pub name: &'static str,
    /// Content in a few words.
    pub summary: &'static str,
    /// Whether a file is of this format, by its first bytes.
    pub(super) detect: fn(&[u8]) -> bool,
    /// Reads the content of a file.
    pub(super) read: fn(&Path, &[u8]) -> Result<PoseSequence, IoError>,
    /// Writes a file, where the format is written.
    pub(super) write: Option<Write>,
}

impl PoseFormat {
    /// Whether it can be written.
    pub fn is_written(&self) -> bool {
        self.write.is_some()
    }
}

/// Writes a text under its name when it is whole.
pub(super) fn write_text(path: &Path, text: &str) -> Result<(), IoError> {
    atomic_write(path, text.as_bytes()).map_err(|source| IoError::file(path, "write", source))
}

/// The fault of a line.
pub(super) fn row_fault(path: &Path, line: u64, byte: u64, reason: String, rows: usize) -> IoError {
    IoError::Row { path: path.to_owned(), line, byte, reason, rows: rows as u64 }
}
