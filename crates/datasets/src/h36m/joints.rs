//! The joints of Human3.6M, and those of them that are labelled here.

use evpose_pose::body::{BODY_JOINTS, BodyPoints, network_from_file};
use glam::Vec2;

/// Joints of a pose of Human3.6M.
pub const H36M_JOINTS: usize = 32;

/// A pose of Human3.6M on the image of a camera, in pixels.
pub type H36mPose = [Vec2; H36M_JOINTS];

/// Head, shoulders, elbows, hips, hands, knees and feet among them, in the order of files.
///
/// # Source
/// hpe-core, `datasets/h36m/utils/parsing.py`.
const FILE_FROM_H36M: [usize; BODY_JOINTS] = [14, 25, 17, 26, 18, 6, 1, 27, 19, 2, 7, 3, 8];

/// The thirteen joints of a pose, in the order of networks.
pub fn body_points(pose: &H36mPose) -> BodyPoints {
    network_from_file(&FILE_FROM_H36M.map(|joint| Some(pose[joint])))
}

#[cfg(test)]
mod tests {
    use evpose_pose::body::number;

    use super::*;

    #[test]
    fn joints_are_those_that_human_3_6m_calls_so() {
        let pose = std::array::from_fn(|joint| Vec2::splat(joint as f32));
        let points = body_points(&pose).map(|point| point.map_or(-1.0, |point| point.x));
        for (joint, want) in [
            (number::HEAD, 14.0),
            (number::SHOULDER_L, 17.0),
            (number::WRIST_R, 27.0),
            (number::HIP_L, 6.0),
            (number::HIP_R, 1.0),
            (number::ANKLE_L, 8.0),
        ] {
            assert_eq!(points[joint], want, "{joint}");
        }
    }
}
