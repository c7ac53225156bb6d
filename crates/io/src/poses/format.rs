//! The registry of formats of poses.

use std::io::Read as _;
use std::path::Path;

use evpose_core::atomic_write;

use super::{PoseSequence, hpe_core, json, live_json, skeletons, table};
use crate::IoError;

/// Bytes of a file from which its format is detected: a header line.
const SNIFFED_BYTES: usize = 1 << 14;

/// The log in a folder of YARP.
const LOG: &str = "data.log";

/// A format of poses. Adding one is a file with its `FORMAT` and a line of [`POSE_FORMATS`].
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
    pub(super) write: Option<fn(&Path, &PoseSequence) -> Result<(), IoError>>,
}

impl PoseFormat {
    /// Whether it can be written.
    pub fn is_written(&self) -> bool {
        self.write.is_some()
    }
}

/// The formats of poses; the first one is the default.
pub static POSE_FORMATS: &[&PoseFormat] =
    &[&table::FORMAT, &json::FORMAT, &live_json::FORMAT, &hpe_core::FORMAT, &skeletons::FORMAT];

/// The format called `name`.
pub fn pose_format_by_name(name: &str) -> Option<&'static PoseFormat> {
    POSE_FORMATS.iter().copied().find(|format| format.name == name)
}

/// Reads poses in any format, which is detected. Of YARP, the folder or the `data.log` in it.
///
/// # Errors
/// If the file cannot be read, is of no known format, or violates it.
pub fn read_poses(path: &Path) -> Result<PoseSequence, IoError> {
    let file = if path.is_dir() { &path.join(LOG) } else { path };
    let failed = |source| IoError::file(file, "read", source);
    let mut bytes = Vec::new();
    std::fs::File::open(file).map_err(failed)?.read_to_end(&mut bytes).map_err(failed)?;
    poses_from(file, &bytes)
}

/// As [`read_poses`], from the content of a file.
///
/// # Errors
/// As [`read_poses`].
pub fn poses_from(path: &Path, bytes: &[u8]) -> Result<PoseSequence, IoError> {
    let start = &bytes[..bytes.len().min(SNIFFED_BYTES)];
    let format = POSE_FORMATS.iter().find(|format| (format.detect)(start));
    let Some(format) = format else {
        let known: Vec<&str> = POSE_FORMATS.iter().map(|format| format.name).collect();
        return Err(IoError::UnknownFormat { path: path.to_owned(), known: known.join(", ") });
    };
    (format.read)(path, bytes)
}

/// Writes poses in a format.
///
/// # Errors
/// If the format is only read or has no place for such poses, or the file cannot be written. It has
/// its name only when it is whole.
pub fn write_poses(
    path: &Path,
    sequence: &PoseSequence,
    format: &PoseFormat,
) -> Result<(), IoError> {
    match format.write {
        Some(write) => write(path, sequence),
        None => Err(IoError::unwritable(path, format!("poses are not written as {}", format.name))),
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
