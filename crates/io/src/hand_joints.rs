//! The joints of recorded hands, `STEM.joints.npy` beside `STEM.meta`: one row each millisecond.
//!
//! An array of NumPy, `f32`, `[frames, 21, 3]`, in C order: the evaluated points in the order of
//! [`EVALUATION_JOINTS`], in metres in the frame of the camera that records: x right, y up, looking
//! along -z. Row k belongs to record k of the `.meta`. The twelve parameters there move all
//! fingers together; these are where the fingers are.

use std::io::Write;
use std::path::PathBuf;

use evpose_core::AtomicFile;
use evpose_pose::EVALUATION_JOINTS;
use glam::Vec3;

use crate::IoError;
use crate::npz::header_for;

/// Ending of the file, without the first dot.
pub const HAND_JOINTS_ENDING: &str = "joints.npy";
/// Points of a hand.
const POINTS: usize = EVALUATION_JOINTS.len();

/// Writes joints frame by frame. The file appears when it is finished.
#[derive(Debug)]
pub struct HandJointsWriter {
    path: PathBuf,
    file: AtomicFile,
    frames: u64,
    written: u64,
}

impl HandJointsWriter {
    /// Begins a file of `frames` frames.
    ///
    /// # Errors
    /// If it cannot be created.
    pub fn create(path: impl Into<PathBuf>, frames: u64) -> Result<Self, IoError> {
        let path = path.into();
        let failed = |e| IoError::file(&path, "create", e);
        let mut file = AtomicFile::create(&path).map_err(failed)?;
        let shape = [frames, POINTS as u64, 3];
        file.write_all(&header_for("'<f4'", &shape, &shape)).map_err(failed)?;
        Ok(Self { path, file, frames, written: 0 })
    }

    /// Appends the points of the next frame, in metres.
    ///
    /// # Errors
    /// If writing fails.
    pub fn frame(&mut self, points_m: &[Vec3; POINTS]) -> Result<(), IoError> {
        let mut bytes = [0; 12 * POINTS];
        let values = points_m.iter().flat_map(|point_m| point_m.to_array());
        for (slot, value) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(values) {
            *slot = value.to_le_bytes();
        }
        self.written += 1;
        self.file.write_all(&bytes).map_err(|e| IoError::file(&self.path, "write", e))
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// If frames are missing or too many, or writing fails.
    pub fn finish(self) -> Result<(), IoError> {
        let Self { path, file, frames, written } = self;
        if written != frames {
            return Err(IoError::unwritable(&path, format!("{written} of {frames} frames")));
        }
        file.commit().map_err(|e| IoError::file(&path, "write", e))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::JointsReader;

    fn points(frame: u64) -> [Vec3; POINTS] {
        std::array::from_fn(|k| Vec3::new(frame as f32, k as f32 * 0.01, -0.5))
    }

    #[test]
    fn joints_are_read_back_and_lie_as_numpy_has_them() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("0000.joints.npy");
        let mut writer = HandJointsWriter::create(&path, 3).unwrap();
        (0..3).for_each(|frame| writer.frame(&points(frame)).unwrap());
        writer.finish().unwrap();
        let reader = JointsReader::open(&path).unwrap();
        for frame in 0..3 {
            assert_eq!(reader.read(frame).unwrap().map(Vec3::from_array), points(frame));
        }
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(bytes.len(), 128 + 3 * 21 * 3 * 4);
        // Frame 2, point 5, y.
        let at = 128 + 4 * ((2 * 21 + 5) * 3 + 1);
        assert_eq!(bytes[at..at + 4], (5.0 * 0.01_f32).to_le_bytes());
    }

    #[test]
    fn frames_that_are_missing_are_refused() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("0000.joints.npy");
        let writer = HandJointsWriter::create(&path, 3).unwrap();
        let message = writer.finish().unwrap_err().to_string();
        assert!(message.contains("0 of 3 frames"), "{message}");
    }
}
