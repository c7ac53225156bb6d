//! Poses of Human3.6M on the images of its cameras.

use std::path::Path;

use glam::Vec2;

use super::{H36M_JOINTS, H36mPose};
use crate::DatasetError;
use crate::cdf::CdfFile;

/// Reads the poses of a clip, one a frame: a CDF file with a variable `Pose` of 64 numbers a frame.
///
/// # Errors
/// If the file cannot be read or holds something else.
pub fn read_poses(path: &Path) -> Result<Vec<H36mPose>, DatasetError> {
    const NUMBERS: usize = 2 * H36M_JOINTS;
    let pose = CdfFile::open(path)?.numbers("Pose").map_err(DatasetError::cdf(path))?;
    let (frames, rest) = pose.values.as_chunks::<NUMBERS>();
    if pose.sizes.last() != Some(&NUMBERS) || !rest.is_empty() {
        let found = format!("{} records of {:?}", pose.records, pose.sizes);
        let reason = format!("{NUMBERS} numbers a frame are expected, these are {found}");
        return Err(DatasetError::malformed(path, "Pose", reason));
    }
    let joint = |frame: &[f64; NUMBERS], joint: usize| {
        Vec2::new(frame[2 * joint] as f32, frame[2 * joint + 1] as f32)
    };
    Ok(frames.iter().map(|frame| std::array::from_fn(|k| joint(frame, k))).collect())
}
