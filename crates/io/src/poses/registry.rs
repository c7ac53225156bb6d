//! The registry of formats of poses.

use std::io::Read as _;
use std::path::Path;

use evpose_core::{Registry, bytes_without_bom, registry_entry};
use evpose_pose::JointFrame;

use super::format::{PoseFormat, PoseIterator};
use super::pose::{PoseKind, PoseSequence};
use super::{hpe_core, json, parquet, skeletons, table};
use crate::IoError;

/// Bytes of a file from which its format is detected: a header line.
const SNIFFED_BYTES: usize = 1 << 14;

/// The log in a folder of YARP.
const LOG: &str = "data.log";

/// The formats of poses; the first one is the default.
pub static POSE_FORMATS: Registry<PoseFormat> = Registry::new(&[
    &table::FORMAT,
    &json::ARRAY,
    &json::LINES,
    &parquet::FORMAT,
    &hpe_core::FORMAT,
    &skeletons::FORMAT,
]);

registry_entry!(PoseFormat, "format of poses");

/// The format for a file of this name: that of its ending, and the first one for a name without an ending,
/// as pipes have.
///
/// # Errors
/// If the ending is that of no format.
pub fn pose_format_of(path: &Path) -> Result<&'static PoseFormat, IoError> {
    let Some(ending) = path.extension() else { return Ok(POSE_FORMATS[0]) };
    let ending = ending.to_string_lossy().to_lowercase();
    let is_ours = |format: &&&PoseFormat| format.endings.contains(&&*ending);
    POSE_FORMATS.iter().find(is_ours).copied().ok_or_else(|| {
        let named = POSE_FORMATS.iter().flat_map(|format| {
            format.endings.iter().map(|ending| format!(".{ending} ({})", format.name))
        });
        let known = named.collect::<Vec<_>>().join(", ");
        IoError::UnknownEnding { path: path.to_owned(), known }
    })
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
    let length = bytes.len();
    let bytes = bytes_without_bom(bytes);
    let start = &bytes[..bytes.len().min(SNIFFED_BYTES)];
    let format = POSE_FORMATS.iter().find(|format| (format.detect)(start));
    let Some(format) = format else {
        let known = POSE_FORMATS.names().join(", ");
        return Err(IoError::UnknownFormat { path: path.to_owned(), known });
    };
    // Faults are at bytes of the file.
    (format.read)(path, bytes).map_err(|fault| fault.behind_bytes((length - bytes.len()) as u64))
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
    let PoseSequence { kind, frame, ref poses } = *sequence;
    write_poses_from(path, kind, frame, &mut poses.iter().cloned(), format)
}

/// As [`write_poses`], of poses that are made while they are written.
///
/// # Errors
/// As [`write_poses`].
pub fn write_poses_from(
    path: &Path,
    kind: PoseKind,
    frame: Option<JointFrame>,
    poses: PoseIterator<'_>,
    format: &PoseFormat,
) -> Result<(), IoError> {
    match format.write {
        Some(write) => write(path, kind, frame, poses),
        None => {
            let PoseFormat { name, summary, .. } = format;
            let reason = format!("poses are not written as {name}: {summary}");
            Err(IoError::unwritable(path, reason))
        }
    }
}
