//! Output of MoveNet, the network of Google for one person.

use glam::Vec2;

use super::coco::{COCO_KEYPOINTS, joints_of_coco};
use super::{BODY_JOINTS, BodyJoint};

/// Values of an output of MoveNet: `[1, 1, 17, 3]`.
pub const MOVENET_VALUES: usize = 3 * COCO_KEYPOINTS;

/// The thirteen joints, in the order of networks, of an output of MoveNet's single-pose models:
/// row, column and score of COCO's 17 keypoints, positions relative to the square input. A keypoint
/// whose score is below `min_score`, or that is not finite, is not detected. The head is made as
/// [`joints_of_coco`] says.
///
/// # Source
/// Model card of *MoveNet.SinglePose*, Google, 2021.
pub fn movenet_joints(output: &[f32; MOVENET_VALUES], min_score: f32) -> [BodyJoint; BODY_JOINTS] {
    let keypoint = |index: usize| {
        let [y, x, score] = [0, 1, 2].map(|part| output[3 * index + part]);
        let is_detected = score >= min_score && x.is_finite() && y.is_finite();
        BodyJoint {
            position: is_detected.then_some(Vec2::new(x, y)),
            score: if is_detected { score } else { 0.0 },
        }
    };
    joints_of_coco(&std::array::from_fn(keypoint))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::number;

    #[test]
    fn rows_come_before_columns_and_low_scores_are_not_detected() {
        let mut output = [0.0; MOVENET_VALUES];
        // Ears at (0.40, 0.20) and (0.44, 0.22), the left wrist, a right ankle that is not sure.
        output[9..15].copy_from_slice(&[0.20, 0.40, 0.8, 0.22, 0.44, 0.6]);
        output[27..30].copy_from_slice(&[0.55, 0.30, 0.9]);
        output[48..51].copy_from_slice(&[0.9, 0.5, 0.05]);
        let joints = movenet_joints(&output, 0.1);
        let head = joints[number::HEAD];
        assert!(head.position.unwrap_or_default().distance(Vec2::new(0.42, 0.21)) < 1e-6);
        assert!((head.score - 0.7).abs() < 1e-6);
        assert_eq!(joints[number::WRIST_L].position, Some(Vec2::new(0.30, 0.55)));
        assert_eq!(joints[number::ANKLE_R], BodyJoint { position: None, score: 0.0 });
        output[28] = f32::NAN;
        assert_eq!(movenet_joints(&output, 0.1)[number::WRIST_L].position, None);
    }
}
