//! `STEM.joints.npy`: the evaluated points of a hand beside its `.meta`, one row a millisecond. The twelve
//! parameters there cannot make every gesture; these are where the fingers are.
//!
//! A NumPy array of `<f4`, `[frames, 21, 3]` in C order: metres in the frame of the camera that records, x to
//! the right, y up, looking along -z, in the order of [`EVALUATION_JOINTS`]. Row `k` is the hand at the *end*
//! of frame `k`, as record `k` of the `.meta`.

use std::io::Write;
use std::path::{Path, PathBuf};

use evpose_core::AtomicFile;
use evpose_pose::EVALUATION_JOINTS;
use glam::Vec3;
use npyz::Order;

use crate::IoError;
use crate::npz::header_for;
use crate::positional::PositionalFile;

/// Ending of the file of joints, behind the stem of a recording and a dot.
pub const HAND_JOINTS_ENDING: &str = "joints.npy";

/// Count of points in a row.
const JOINTS: usize = EVALUATION_JOINTS.len();
/// Bytes of a row.
const ROW: usize = 4 * 3 * JOINTS;
/// Bytes in which a header ends that is not longer than any that is read.
const HEADER: usize = 10 + u16::MAX as usize;

/// An open `STEM.joints.npy`, not held in memory.
#[derive(Debug)]
pub struct JointsReader {
    path: PathBuf,
    file: PositionalFile,
    /// Byte of the first row.
    begin: u64,
    frames: u64,
}

impl JointsReader {
    /// Path of the joints beside a `.meta` or a recording whose name without ending is `stem`.
    pub fn path_of(stem: &Path) -> PathBuf {
        let mut name = stem.as_os_str().to_os_string();
        name.push(".");
        name.push(HAND_JOINTS_ENDING);
        PathBuf::from(name)
    }

    /// Opens a file.
    ///
    /// # Errors
    /// If it cannot be read, is no array of such points, or ends before its last row.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, IoError> {
        let path = path.as_ref().to_owned();
        let (file, size) =
            PositionalFile::open(&path).map_err(|e| IoError::file(&path, "open", e))?;
        let mut head = vec![0; HEADER.min(size as usize)];
        file.read_exact_at(&mut head, 0).map_err(|e| IoError::file(&path, "read", e))?;
        let mut rest = head.as_slice();
        let damaged = |byte: u64, reason: String| IoError::Damaged {
            path: path.clone(),
            byte,
            reason: reason.into(),
            events: 0,
        };
        let header =
            crate::npz::header(&mut rest).map_err(|fault| damaged(0, fault.to_string()))?;
        let begin = (head.len() - rest.len()) as u64;
        let (descr, shape) = (header.dtype().descr(), header.shape());
        let is_of_points = matches!(*shape, [_, joints, 3] if joints == JOINTS as u64)
            && header.order() == Order::C
            && descr.trim_matches('\'') == "<f4";
        if !is_of_points {
            let reason =
                format!("{descr} of {shape:?} is not <f4 of [frames, {JOINTS}, 3], row by row");
            return Err(damaged(0, reason));
        }
        let (frames, whole) = (shape[0], (size - begin) / ROW as u64);
        if whole < frames {
            let byte = begin + whole * ROW as u64;
            return Err(damaged(byte, format!("ends after {whole} of {frames} rows")));
        }
        Ok(Self { path, file, begin, frames })
    }

    /// Count of rows.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// The points of a frame, x, y and z in metres.
    ///
    /// # Errors
    /// If the row cannot be read, or a value is not finite.
    pub fn read(&self, frame: u64) -> Result<[[f32; 3]; JOINTS], IoError> {
        let mut bytes = [0; ROW];
        let offset = self.begin + frame * ROW as u64;
        let read = self.file.read_exact_at(&mut bytes, offset);
        read.map_err(|e| IoError::file(&self.path, "read", e))?;
        let (values, _) = bytes.as_chunks::<4>();
        let at = |index: usize| f32::from_le_bytes(values[index]);
        let points = std::array::from_fn(|k| std::array::from_fn(|axis| at(3 * k + axis)));
        if points.iter().flatten().any(|value: &f32| !value.is_finite()) {
            let reason = format!("a value of row {frame} is not finite").into();
            return Err(IoError::Damaged {
                path: self.path.clone(),
                byte: offset,
                reason,
                events: 0,
            });
        }
        Ok(points)
    }
}

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
        let shape = [frames, JOINTS as u64, 3];
        file.write_all(&header_for("'<f4'", &shape, &shape)).map_err(failed)?;
        Ok(Self { path, file, frames, written: 0 })
    }

    /// Appends the points of the next frame, in metres.
    ///
    /// # Errors
    /// If writing fails.
    pub fn frame(&mut self, points_m: &[Vec3; JOINTS]) -> Result<(), IoError> {
        let mut bytes = [0; 12 * JOINTS];
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
    use super::*;

    /// An array as NumPy writes it.
    fn array(descr: &str, shape: &str, values: &[f32]) -> Vec<u8> {
        let mut text =
            format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
        while !(10 + text.len() + 1).is_multiple_of(64) {
            text.push(' ');
        }
        text.push('\n');
        let length = (text.len() as u16).to_le_bytes();
        let head = [&b"\x93NUMPY\x01\x00"[..], &length, text.as_bytes()].concat();
        head.into_iter().chain(values.iter().flat_map(|value| value.to_le_bytes())).collect()
    }

    #[test]
    fn rows_are_read_back_and_damage_is_an_error_with_its_byte() {
        let directory = tempfile::tempdir().unwrap();
        let path = JointsReader::path_of(&directory.path().join("0003"));
        assert!(path.ends_with("0003.joints.npy"));
        let mut values: Vec<f32> = (0..2 * 63).map(|k| k as f32 / 8.0).collect();
        let bytes = array("<f4", "(2, 21, 3)", &values);
        std::fs::write(&path, &bytes).unwrap();
        let reader = JointsReader::open(&path).unwrap();
        assert_eq!(reader.frames(), 2);
        let second = reader.read(1).unwrap();
        assert_eq!((second[0], second[20]), ([7.875, 8.0, 8.125], [15.375, 15.5, 15.625]));
        assert!(reader.read(2).is_err());

        std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
        let error = JointsReader::open(&path).unwrap_err().to_string();
        assert!(error.contains("1 of 2 rows"), "{error}");
        for (descr, shape) in [("<f8", "(1, 21, 3)"), ("<f4", "(2, 3, 21)"), ("<f4", "(126,)")] {
            std::fs::write(&path, array(descr, shape, &values)).unwrap();
            assert!(JointsReader::open(&path).is_err(), "{descr} {shape}");
        }
        values[100] = f32::NAN;
        std::fs::write(&path, array("<f4", "(2, 21, 3)", &values)).unwrap();
        let reader = JointsReader::open(&path).unwrap();
        assert!(reader.read(0).is_ok() && reader.read(1).is_err());
    }

    fn points(frame: u64) -> [Vec3; JOINTS] {
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
