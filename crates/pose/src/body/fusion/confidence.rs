//! Detections with their scores, and the test that accepts them.

use evpose_core::SensorSize;
use glam::Vec2;
use serde::{Deserialize, Serialize};

use crate::PoseError;
use crate::body::{BODY_JOINTS, BodyJoint, BodyPoints, number};

/// Joints in pixels and their confidences, both in the order of networks.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ScoredPoints {
    /// Positions; none for joints that were not detected.
    pub points: BodyPoints,
    /// Confidences, 0 to 1.
    pub scores: [f32; BODY_JOINTS],
}

impl ScoredPoints {
    /// Decoded joints of an image of this size, in pixels; further joints are not detected.
    pub fn in_image(joints: &[BodyJoint], size: SensorSize) -> Self {
        let size_px = Vec2::new(size.width.into(), size.height.into());
        let mut pose = Self::default();
        for (k, joint) in joints.iter().enumerate().take(BODY_JOINTS) {
            pose.points[k] = joint.position.map(|relative| relative * size_px);
            pose.scores[k] = joint.score;
        }
        pose
    }
}

/// Scores above which joints and poses are accepted; 0 accepts all that have a score.
///
/// # Source
/// hpe-core, 0.4 for both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ConfidenceTest {
    /// Minimum score of a joint.
    pub joint: f32,
    /// Minimum mean score of head and shoulders of a pose.
    pub pose: f32,
}

impl Default for ConfidenceTest {
    fn default() -> Self {
        Self { joint: 0.4, pose: 0.4 }
    }
}

impl ConfidenceTest {
    /// The accepted joints: none of a rejected pose, nor any whose position is not finite.
    pub fn believed(&self, pose: &ScoredPoints) -> BodyPoints {
        let [a, b, c] =
            [number::HEAD, number::SHOULDER_R, number::SHOULDER_L].map(|k| pose.scores[k]);
        // NaN fails both comparisons, so that a score that is not a number is rejected.
        let is_pose_believed = (a + b + c) / 3.0 > self.pose;
        std::array::from_fn(|k| {
            let is_believed = is_pose_believed && pose.scores[k] > self.joint;
            pose.points[k].filter(|at| is_believed && at.is_finite())
        })
    }

    pub(super) fn validate(&self) -> Result<(), PoseError> {
        for (field, value) in [("confidence.joint", self.joint), ("confidence.pose", self.pose)] {
            // No score exceeds 1, so that a threshold of 1 would reject every pose.
            PoseError::unless((0.0..1.0).contains(&value), field, value, "from 0 to below 1")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(scores: [f32; BODY_JOINTS]) -> ScoredPoints {
        ScoredPoints { points: std::array::from_fn(|k| Some(Vec2::splat(k as f32))), scores }
    }

    #[test]
    fn a_joint_must_score_above_the_threshold() {
        let mut scores = [0.9; BODY_JOINTS];
        (scores[4], scores[5], scores[6]) = (0.4, 0.401, f32::NAN);
        let mut pose = pose(scores);
        pose.points[7] = Some(Vec2::new(f32::NAN, 1.0));
        pose.points[8] = None;
        let believed = ConfidenceTest::default().believed(&pose);
        let kept: Vec<usize> = (0..BODY_JOINTS).filter(|&k| believed[k].is_some()).collect();
        assert_eq!(kept, [0, 1, 2, 3, 5, 9, 10, 11, 12]);
        assert_eq!(believed[5], pose.points[5]);
    }

    #[test]
    fn a_pose_is_believed_by_its_head_and_shoulders() {
        let mut scores = [0.9; BODY_JOINTS];
        (scores[0], scores[1], scores[2]) = (0.1, 0.2, 0.89);
        assert_eq!(ConfidenceTest::default().believed(&pose(scores)), [None; BODY_JOINTS]);
        scores[2] = 0.95;
        let believed = ConfidenceTest::default().believed(&pose(scores));
        assert!(believed[0].is_none() && believed[1].is_none() && believed[2].is_some());
    }

    #[test]
    fn decoded_joints_are_in_pixels() {
        let found = BodyJoint { position: Some(Vec2::new(0.25, 0.5)), score: 0.8 };
        let pose = ScoredPoints::in_image(
            &[found, BodyJoint { position: None, score: 0.0 }],
            SensorSize { width: 640, height: 480 },
        );
        assert_eq!(pose.points[..3], [Some(Vec2::new(160.0, 240.0)), None, None]);
        assert_eq!(pose.scores[..3], [0.8, 0.0, 0.0]);
    }
}
