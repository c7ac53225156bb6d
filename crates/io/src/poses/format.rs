//! A format of poses.

use std::io::Write as _;
use std::path::Path;

use evpose_core::AtomicFile;
use evpose_pose::JointFrame;

use super::pose::{PoseKind, PoseSequence, TimedPose};
use crate::IoError;

/// Poses that are made while they are written, so that a long recording does not hold them all.
pub type PoseIterator<'a> = &'a mut dyn Iterator<Item = TimedPose>;

/// Writes a file of poses of a kind, with the frame of positions in metres where it is known.
pub(super) type Write =
    fn(&Path, PoseKind, Option<JointFrame>, PoseIterator<'_>) -> Result<(), IoError>;

/// A format of poses. Adding one is a file with its `FORMAT` and a line of [`POSE_FORMATS`](super::POSE_FORMATS).
#[derive(Debug)]
pub struct PoseFormat {
    /// Name, as `--format` takes it.
    pub name: &'static str,
    /// Content in a few words.
    pub summary: &'static str,
    /// Endings of names, in lower case, that stand for it.
    pub endings: &'static [&'static str],
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

/// Writes lines, each with its end, under the name of the file when it is whole.
pub(super) fn write_lines(path: &Path, lines: impl Iterator<Item = String>) -> Result<(), IoError> {
    let write = || {
        let mut file = AtomicFile::create(path)?;
        for line in lines {
            file.write_all(line.as_bytes())?;
        }
        file.commit()
    };
    write().map_err(|source| IoError::file(path, "write", source))
}

/// A header or a row that is none of poses.
#[derive(Debug, thiserror::Error)]
pub(super) enum RowFault {
    #[error("column `{0}` occurs twice")]
    Twice(String),
    #[error("no columns of a pose, such as `head_u_px` or `wrist_u_px`")]
    NoPose,
    #[error("column `{name}`: no such joint of {}; there are {}", .kind.subject(), .kind.joint_names().join(", "))]
    NoSuchJoint { name: String, kind: PoseKind },
    #[error("no column `{0}`")]
    NoColumn(String),
    #[error("{count} columns where {expected} are expected")]
    Columns { count: usize, expected: usize },
    #[error("`{0}` is no time in microseconds")]
    NoTime(String),
    #[error("`{0}` is no number")]
    NoNumber(String),
    #[error("no `t_us` in whole microseconds")]
    NoWholeTime,
    #[error("no `joints`")]
    NoJoints,
    #[error("no joint `{0}` of {kind}", kind = .1.subject())]
    NoJoint(String, PoseKind),
    #[error("{0}: no object")]
    NoObject(String),
    #[error("params: no `{0}`")]
    NoParameter(&'static str),
}

/// The fault of a line.
pub(super) fn row_fault(path: &Path, line: u64, byte: u64, reason: String, rows: usize) -> IoError {
    IoError::Row { path: path.to_owned(), line, byte, reason, rows: rows as u64 }
}
