//! Poses of Human3.6M on the images of its cameras.

use std::path::Path;

use glam::Vec2;

use super::{H36M_JOINTS, H36mPose};
use crate::DatasetError;
use crate::open::open_cdf;

/// Reads the poses of a clip, one a frame: a CDF file with a variable `Pose` of 64 values a frame.
///
/// # Errors
/// If the file cannot be read or holds something else.
pub fn read_poses(path: &Path) -> Result<Vec<H36mPose>, DatasetError> {
    const VALUES: usize = 2 * H36M_JOINTS;
    let pose = open_cdf(path)?.values("Pose").map_err(DatasetError::cdf(path))?;
    let (frames, rest) = pose.values.as_chunks::<VALUES>();
    if pose.sizes.last() != Some(&VALUES) || !rest.is_empty() {
        let actual = format!("{} records of {:?}", pose.records, pose.sizes);
        let reason = format!("{VALUES} values a frame are expected, these are {actual}");
        return Err(DatasetError::malformed(path, "Pose", reason));
    }
    let joint = |frame: &[f64; VALUES], joint: usize| {
        Vec2::new(frame[2 * joint] as f32, frame[2 * joint + 1] as f32)
    };
    Ok(frames.iter().map(|frame| std::array::from_fn(|k| joint(frame, k))).collect())
}
